/* SPDX-License-Identifier: Apache-2.0 */
/* Plays each case on each command that it fits; with --submitted, the cases about the data of
 * builds by command buffers, in every variant that fits (submitted.c). Results are lines of
 * tab-separated values: platform, case, command, id, fired|silent|failed; at a level that is asked
 * for, unseen where it can't see what is broken. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/player/calls/judge.h"

enum { CASES_MAX = 2000, PLAYS_MAX = 20000, SETUPS_MAX = 2000 };

struct planned_play {
    struct call_play play;
    uint32_t setup;
};

struct run {
    struct tally *tally;
    struct fixture fixture;
    struct report report;
    struct test_case cases[CASES_MAX];
    size_t case_count;
    struct planned_play plays[PLAYS_MAX];
    struct setup setups[SETUPS_MAX]; /* in the order of the plays that begin with them */
    uint32_t play_count, setup_count;
};

static char current_name[256];

/* ---- output ---- */

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/* A finding that the layer misses may crash the driver: say in which case. */
static void crash(int number)
{
    static const char text[] = "[  FAILED  ] crashed in ";
    ssize_t written = write(STDOUT_FILENO, text, sizeof(text) - 1);
    written += write(STDOUT_FILENO, current_name, strlen(current_name));
    written += write(STDOUT_FILENO, "\n", 1);
    (void)written;
    signal(number, SIG_DFL);
    raise(number);
}

static void catch_crashes(void)
{
    signal(SIGSEGV, crash);
    signal(SIGBUS, crash);
    signal(SIGFPE, crash);
}
#else
static void catch_crashes(void) {}
#endif

static void write_results(const struct run *run, const struct call_play *play)
{
    const bool has_passed = run->report.outcome == OUTCOME_PASSED;
    enum rule rules[2 * CASE_RULES];
    const uint32_t count = judge_rules(play, rules);
    for (uint32_t i = 0; i < count && run->report.outcome != OUTCOME_SKIPPED; i++)
        tally_note(run->tally, current_name, play->command,
                   rule_infos[rules[i]].vuid[play->command],
                   !has_passed                     ? SIGHT_FAILED
                   : play->is_repaired             ? SIGHT_SILENT
                   : judge_expects(play, rules[i]) ? SIGHT_FIRED
                                                   : SIGHT_UNSEEN);
}

/* ---- which plays ---- */

/* Rules about structures have ids for every command, also for the one that does not take them. */
static bool is_asked_by_nv(const struct rule_info *info)
{
    return info->subject != NULL &&
           (strcmp(info->subject, "call") == 0 || strncmp(info->subject, "nv_", 3) == 0);
}

static bool fits_command(const struct test_case *test_case, enum build_command command)
{
    if (test_case->has_pointers || test_case->is_for_contents)
        return false;
    if ((test_case->refused & UINT64_C(1) << command) != 0)
        return true;
    if (test_case->commands != 0)
        return (test_case->commands & UINT64_C(1) << command) != 0;
    for (uint32_t i = 0; i < test_case->rule_count; i++) {
        const struct rule_info *info = &rule_infos[test_case->rules[i]];
        if (info->vuid[command] == VUID_NONE)
            return false;
        if (command == COMMAND_NV && !is_asked_by_nv(info))
            return false;
    }
    return command < COMMAND_NV || test_case->rule_count > 0;
}

/* Bad data that lower levels say nothing of. */
static bool is_silent_below_content(const struct test_case *test_case)
{
    bool is_about_content = false;
    for (uint32_t i = 0; i < test_case->rule_count; i++)
        is_about_content =
            is_about_content || rule_infos[test_case->rules[i]].level == LEVEL_CONTENT;
    return is_about_content && test_case->silent && test_case->forms[0].setup.level == NULL;
}

static bool fits_level(const struct test_case *test_case, const char *level)
{
    return level == NULL || level_named(level) < LEVEL_CONTENT ||
           (!test_case->below_content && !is_silent_below_content(test_case));
}

/* Rules about geometries are asked of both arrays. */
static bool wants_pointers(const struct test_case *test_case)
{
    static const char *const subjects[] = {"geometry", "address",       "range", "motion_triangles",
                                           "spheres",  "swept_spheres", "dense"};
    for (uint32_t i = 0; i < test_case->rule_count && !test_case->keep_arrays; i++) {
        const char *subject = rule_infos[test_case->rules[i]].subject;
        for (size_t j = 0; subject != NULL && j < sizeof(subjects) / sizeof(subjects[0]); j++)
            if (strcmp(subject, subjects[j]) == 0)
                return true;
    }
    return false;
}

static void print_program(struct report *report, const struct call_play *play)
{
    static struct program program;
    program_make(&program, play->test_case->source, play->test_case->variant, play->is_repaired);
    report_program(report, &program, program.line_count - 1);
}

static void play_one(struct run *run, const struct call_play *play)
{
    snprintf(current_name, sizeof(current_name), "%s%s/%s%s%s%s%s", play->test_case->name,
             play->is_muted ? "+muted" : "",
             play->variant ? play->variant->name : command_word(play->command),
             play->geometry_pointers && !play->variant ? "+ppGeometries" : "",
             play->level != NULL ? "@" : "", play->level != NULL ? play->level : "",
             play->is_repaired && !play->test_case->silent ? " (repaired)" : "");
    if (!tally_starts(run->tally, current_name))
        return;
    judge_play(play, &run->fixture, &run->report);
    write_results(run, play);
    if (run->report.outcome == OUTCOME_FAILED)
        print_program(&run->report, play);
    tally_count(run->tally, current_name, &run->report);
}

/* If calls are skipped, a device may keep what a case would have destroyed, so that it is used for
 * the cases of one file that follow each other alone. */
static uint32_t find_setup(struct run *run, const struct setup *setup)
{
    const uint32_t first = run->tally->fails && run->setup_count ? run->setup_count - 1 : 0;
    for (uint32_t i = first; i < run->setup_count; i++)
        if (judge_is_same_setup(&run->setups[i], setup))
            return i;
    if (run->setup_count == SETUPS_MAX)
        abort();
    run->setups[run->setup_count] = *setup;
    return run->setup_count++;
}

static void plan(struct run *run, const struct call_play *play)
{
    if (play->variant && !variant_fits(play))
        return;
    const struct setup setup = judge_setup(play);
    if (run->play_count == PLAYS_MAX)
        abort();
    run->plays[run->play_count++] =
        (struct planned_play){.play = *play, .setup = find_setup(run, &setup)};
}

/* Whether the message of the first rule names others, which have messages if that rule is muted. */
static bool names_others(const struct call_play *play)
{
    const struct test_case *test_case = play->test_case;
    bool names = false;
    for (uint32_t i = 0; i < test_case->name_count; i++)
        names |= rule_id(test_case->names[i], play->command) != NULL;
    return names && !judge_is_refused(play) && rule_id(test_case->rules[0], play->command) != NULL;
}

/* Plans the repaired program, and the broken one. */
static void plan_both(struct run *run, struct call_play play)
{
    for (int broken = 0; broken < 2 - play.test_case->silent; broken++) {
        play.is_repaired = !broken;
        plan(run, &play);
    }
}

static void plan_form(struct run *run, struct call_play play)
{
    plan_both(run, play);
    play.is_muted = names_others(&play);
    if (play.is_muted)
        plan_both(run, play);
}

static void plan_all_forms(struct run *run, const struct test_case *test_case)
{
    for (enum build_command command = COMMAND_DEVICE; command < COMMAND_COUNT; command++) {
        struct call_play play = {.platform = &run->tally->platform,
                                 .test_case = test_case,
                                 .command = command,
                                 .level = run->tally->level};
        if (!fits_command(test_case, command) || !fits_level(test_case, run->tally->level))
            continue;
        plan_form(run, play);
        if (wants_pointers(test_case) && command == COMMAND_DEVICE) {
            play.geometry_pointers = true;
            plan_form(run, play);
        }
    }
}

/* Whether the case is about data of inputs: only level content reads them. */
static bool is_about_inputs(const struct test_case *test_case)
{
    const char *level = test_case->forms[0].setup.level;
    return level != NULL && strcmp(level, "content") == 0 && !test_case->is_for_the_call;
}

static void plan_all_variants(struct run *run, const struct test_case *test_case)
{
    for (uint32_t i = 0; i < variant_count && is_about_inputs(test_case); i++) {
        plan_form(run, (struct call_play){.platform = &run->tally->platform,
                                          .test_case = test_case,
                                          .command = variants[i].command,
                                          .geometry_pointers = variants[i].geometry_pointers,
                                          .variant = &variants[i]});
    }
}

static void plan_all(struct run *run)
{
    for (size_t i = 0; i < run->case_count; i++)
        (run->tally->submits ? plan_all_variants : plan_all_forms)(run, &run->cases[i]);
}

/* One setup after the other: each change is an instance and a device, which take most of the time.
 */
static void play_all(struct run *run)
{
    for (uint32_t setup = 0; setup < run->setup_count; setup++)
        for (uint32_t i = 0; i < run->play_count; i++)
            if (run->plays[i].setup == setup)
                play_one(run, &run->plays[i].play);
}

/* ---- every id has a case: on the null driver, which takes everything ---- */

/* Programs are about what executes, and --submitted is about what command buffers read. */
static bool is_asked_of_calls(const struct rule_info *info, enum build_command command)
{
    return info->level < LEVEL_EXECUTION ||
           (info->level == LEVEL_CONTENT && command == COMMAND_HOST);
}

static bool is_asked_of_submissions(const struct rule_info *info, enum build_command command)
{
    return command < BUILD_COMMAND_COUNT && command != COMMAND_HOST && info->level == LEVEL_CONTENT;
}

static void check_every_id_has_a_case(const struct run *run)
{
    const struct tally *tally = run->tally;
    const struct platform *platform = &tally->platform;
    if (platform->is_null && !platform->is_cpu && !platform->is_guarded && !tally->fails &&
        !limits_are_harsh() && tally->filter == NULL && !tally->list && tally->level == NULL)
        tally_check_ids(run->tally, "every_id_has_a_case",
                        tally->submits ? is_asked_of_submissions : is_asked_of_calls);
}

/* ---- all ---- */

static void read_cases(struct run *run, const struct sources *sources)
{
    for (unsigned i = 0; i < sources->count; i++) {
        const struct source *source = &sources->items[i];
        const unsigned count = case_is_source(source) ? source_variants(source) : 0;
        if (run->case_count + count > CASES_MAX)
            abort();
        for (unsigned j = 0; j < count; j++)
            case_read(&run->cases[run->case_count++], source, j);
    }
}

void calls_play(const struct sources *sources, struct tally *tally, bool are_all)
{
    static struct run run;
    run.tally = tally;
    run.fixture.misaligns = tally->misaligns;
    run.fixture.fails = tally->fails;
    read_cases(&run, sources);
    if (run.case_count == 0)
        return;
    catch_crashes();
    if (tally->fails)
        setenv("VK_ASSAY_VALIDATION_DEBUG_ACTION", "fail", 1);
    plan_all(&run);
    play_all(&run);
    fixture_close(&run.fixture);
    if (are_all)
        check_every_id_has_a_case(&run);
}
