/* SPDX-License-Identifier: Apache-2.0 */
/* Printing the comparison, and holding it to the bars. */
#include "peer_report.h"

#include <math.h>

/* The bar for calls of so many builds, and of more up to the next bar. */
static const struct recording_bar {
    uint32_t builds;
    double most_overhead; /* nanoseconds a build */
    double least_lead;    /* over the peer */
} recording_bars[] = {{1, 300, 16}, {10, 170, 16}, {100, 120, 25}};
static const double most_growth = 1.3; /* of the overhead a build, from GROWTH_FROM to GROWTH_TO */
static const double least_speedup = 1.7; /* of two threads over one */
static const double least_kept = 0.95;   /* of what two threads reach by four: nothing is lost */
enum { GROWTH_FROM = 1000, GROWTH_TO = 100000 };

const char *contender_name(enum contender contender)
{
    static const char *const names[CONTENDERS] = {"no layer",  "parameters", "state",
                                                  "execution", "content",    "Khronos"};
    return names[contender];
}

void peer_report_open(struct peer_report *report)
{
    *report = (struct peer_report){.with_bars = true, .at_reference = NAN};
    setvbuf(stdout, NULL, _IOLBF, 0); /* figures come slowly */
}

static void hold(struct peer_report *report, const char *what, double value, bool met)
{
    if (!report->with_bars)
        return;
    if (isnan(value)) {
        report->unmeasured++;
        return;
    }
    report->bars++;
    report->missed += !met;
    if (!met)
        printf("  MISSED: %s", what);
}

static void print_cells(const double values[CONTENDERS])
{
    for (int c = 0; c < CONTENDERS; c++) {
        if (isnan(values[c]))
            printf("  %10s", "-");
        else
            printf("  %10.1f", values[c]);
    }
}

static void print_heads(const char *first)
{
    printf("%10s", first);
    for (int c = 0; c < CONTENDERS; c++)
        printf("  %10s", contender_name((enum contender)c));
}

/* ---- recording */

void peer_report_scene(struct peer_report *report, const char *scene)
{
    report->at_reference = NAN;
    printf("\nRecording, %s: CPU ns a build that each adds\n\n", scene);
    print_heads("builds");
    printf("  %19s\n", "Khronos / execution");
}

static void hold_recording(struct peer_report *report, uint32_t builds, double overhead,
                           double lead)
{
    const struct recording_bar *bar = recording_bars;
    char what[64];
    for (size_t i = 0; i < sizeof(recording_bars) / sizeof(recording_bars[0]); i++)
        if (recording_bars[i].builds <= builds)
            bar = &recording_bars[i];
    snprintf(what, sizeof(what), "at most %g ns", bar->most_overhead);
    hold(report, what, overhead, overhead <= bar->most_overhead);
    snprintf(what, sizeof(what), "a lead of %g at least", bar->least_lead);
    hold(report, what, lead, lead >= bar->least_lead);
}

void peer_report_recording(struct peer_report *report, const char *scene, uint32_t builds,
                           const struct figures *figures)
{
    double added[CONTENDERS] = {figures->of[NO_LAYER]};
    for (int c = NO_LAYER + 1; c < CONTENDERS; c++)
        added[c] = figures->of[c] - figures->of[NO_LAYER];
    double lead = added[PEER] / added[EXECUTION];
    printf("%10u", builds);
    print_cells(added);
    printf(isnan(lead) ? "  %19s" : "  %.0s%19.1f", "-", lead);

    if (builds < GROWTH_TO)
        hold_recording(report, builds, added[EXECUTION], lead);
    if (builds == GROWTH_FROM)
        report->at_reference = added[EXECUTION];
    double growth = added[EXECUTION] / report->at_reference;
    if (builds == GROWTH_TO)
        hold(report, "at most 1.3 times that of 1000", growth, growth <= most_growth);
    putchar('\n');
}

/* ---- submissions */

void peer_report_submissions(void)
{
    printf("\nSubmitting, and waiting: CPU ns a build of the thread that does\n\n");
    print_heads("builds");
    putchar('\n');
}

void peer_report_submission(struct peer_report *report, uint32_t builds,
                            const struct figures *first, const struct figures *again)
{
    printf("%10u", builds);
    print_cells(first->of);
    printf("  the first time\n%10s", "");
    print_cells(again->of);
    printf("  once more\n");
}

/* ---- threads */

static void print_speedups(const struct figures figures[THREAD_COUNTS], uint32_t i, uint32_t factor)
{
    printf("%10u", 1u << i);
    for (int c = 0; c < CONTENDERS; c++) {
        double speedup = factor * figures[0].of[c] / figures[i].of[c];
        printf(isnan(speedup) ? "  %10s" : "  %.0s%10.2f", "-", speedup);
    }
}

/* By the wall clock, unless not even recording without a layer gets that far: then the machine is
 * busy, and CPU time tells what threads would reach that don't wait for each other, `factor` times
 * as many on cores of their own. */
static void hold_threads(struct peer_report *report, const char *what, const struct figures wall[2],
                         const struct figures cpu[2], double factor, double least)
{
    bool is_idle = wall[0].of[NO_LAYER] / wall[1].of[NO_LAYER] >= least;
    double reached = is_idle ? wall[0].of[EXECUTION] / wall[1].of[EXECUTION]
                             : factor * cpu[0].of[EXECUTION] / cpu[1].of[EXECUTION];
    hold(report, what, reached, reached >= least);
    if (report->with_bars && !is_idle)
        printf("  by CPU time: %.2f", reached);
}

void peer_report_threads(struct peer_report *report, uint32_t builds,
                         const struct figures wall[THREAD_COUNTS],
                         const struct figures cpu[THREAD_COUNTS])
{
    printf("\nThreads that record side by side: times the builds a second of one thread\n\n");
    print_heads("threads");
    putchar('\n');
    for (uint32_t i = 0; i < THREAD_COUNTS; i++) {
        print_speedups(wall, i, 1);
        if (i == 1)
            hold_threads(report, "two reach at least 1.7", &wall[0], &cpu[0], 2, least_speedup);
        if (i == 2)
            hold_threads(report, "no less than two", &wall[1], &cpu[1], 1, least_kept);
        printf("\n");
    }
    printf("\nThe same if each had a core of its own, by CPU time\n\n");
    for (uint32_t i = 0; i < THREAD_COUNTS; i++) {
        print_speedups(cpu, i, 1u << i);
        putchar('\n');
    }
}

bool peer_report_close(struct peer_report *report)
{
    if (report->with_bars)
        printf("\nbars: %u of %u met, %u could not be measured here\n",
               report->bars - report->missed, report->bars, report->unmeasured);
    return report->missed == 0;
}
