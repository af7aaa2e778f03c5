/* SPDX-License-Identifier: Apache-2.0 */
/* Printing the figures, and holding them to the bars. */
#include "report.h"

#include <errno.h>
#include <string.h>

#include "tests/tools/fail.h"

static const double most_overhead = 500; /* nanoseconds a build, from BAR_FROM builds a call up */
static const double most_growth = 1.5;   /* of the overhead a build from GROWTH_FROM to GROWTH_TO */
static const double most_memory = 512;   /* bytes a recorded build */
enum { BAR_FROM = 100, GROWTH_FROM = 1000, GROWTH_TO = 10000 };

void report_open(struct report *report, const char *csv_path)
{
    *report = (struct report){.time_bars = true, .memory_bars = true};
    /* Rows come slowly: show each when it is there, also through a pipe. */
    setvbuf(stdout, NULL, _IOLBF, 0);
    if (!csv_path)
        return;
    report->csv = fopen(csv_path, "w");
    if (!report->csv)
        tool_fail("%s: %s", csv_path, strerror(errno));
    fprintf(report->csv, "figure,driver,buffers,order,builds_per_call,without,with,layer,spread\n");
}

static void write_csv(struct report *report, const char *figure, const struct row *row)
{
    if (report->csv)
        fprintf(report->csv, "%s,%s,%s,%s,%u,%.1f,%.1f,%.1f,%.1f\n", figure, row->driver,
                row->buffers, row->order, row->builds_per_call, row->without, row->with,
                row->with - row->without, row->spread);
}

static void print_bar(struct report *report, const char *what, double value, double most)
{
    bool met = value <= most;
    report->bars++;
    report->missed += !met;
    printf("  %s at most %g: %s", what, most, met ? "met" : "MISSED");
}

/* ---- time */

void report_time_head(uint32_t samples)
{
    printf("CPU ns a build of recording, medians of %u samples in turn\n\n", samples);
    printf("%-8s  %-8s  %-8s  %11s  %8s  %8s  %8s  %6s  %8s  %6s\n", "driver", "buffers", "order",
           "builds/call", "without", "with", "overhead", "+-", "ratio", "growth");
}

void report_time_series(struct report *report)
{
    report->reference = 0;
}

void report_time(struct report *report, const struct row *row)
{
    double overhead = row->with - row->without;
    bool grows = row->builds_per_call > GROWTH_FROM && report->reference > 0;
    double growth = grows ? overhead / report->reference : 0;

    printf("%-8s  %-8s  %-8s  %11u  %8.1f  %8.1f  %8.1f  %6.1f  %8.1f", row->driver, row->buffers,
           row->order, row->builds_per_call, row->without, row->with, overhead, row->spread,
           row->with / row->without);
    if (grows)
        printf("  %6.2f", growth);
    else
        printf("  %6s", "");
    if (report->time_bars && row->builds_per_call >= BAR_FROM)
        print_bar(report, "overhead", overhead, most_overhead);
    if (report->time_bars && grows && row->builds_per_call == GROWTH_TO)
        print_bar(report, "growth", growth, most_growth);
    putchar('\n');
    if (row->builds_per_call == GROWTH_FROM)
        report->reference = overhead;
    write_csv(report, "time_ns", row);
}

/* ---- memory */

void report_memory_head(uint32_t builds)
{
    printf("\nBytes a build that stay allocated while %u are recorded in one command buffer\n\n",
           builds);
    printf("%-8s  %-8s  %11s  %8s  %8s  %8s\n", "driver", "buffers", "builds/call", "without",
           "with", "layer");
}

void report_memory(struct report *report, const struct row *row)
{
    double layer = row->with - row->without;
    printf("%-8s  %-8s  %11u  %8.1f  %8.1f  %8.1f", row->driver, row->buffers, row->builds_per_call,
           row->without, row->with, layer);
    if (report->memory_bars)
        print_bar(report, "layer", layer, most_memory);
    putchar('\n');
    write_csv(report, "memory_bytes", row);
}

bool report_close(struct report *report)
{
    if (report->csv && fclose(report->csv) != 0)
        tool_fail("the CSV file could not be written: %s", strerror(errno));
    if (report->bars)
        printf("\nbars: %u of %u met\n", report->bars - report->missed, report->bars);
    return report->missed == 0;
}
