/* SPDX-License-Identifier: Apache-2.0 */
/* execution_test PLATFORM [--filter NAME] [--list] [--verbose] [--results FILE] [--level NAME]
 *
 * Plays every program, and writes what fired and what stayed silent as lines of tab-separated
 * values: platform, case, command, id, fired|silent|failed; at a level that is asked for, unseen
 * where it can't see what is broken. */
#include <stdio.h>
#include <string.h>

#include "machine.h"
#include "play.h"

static const struct program_list *const lists[] = {
    &order_programs, &silent_programs, &death_programs, &size_programs,     &sparse_programs,
    &host_programs,  &event_programs,  &nv_programs,    &extension_programs};
enum { LIST_COUNT = sizeof(lists) / sizeof(lists[0]) };

struct run {
    struct platform platform;
    struct tally tally;
    struct fixture fixture;
    struct report report;
    bool fired[MESSAGE_ID_COUNT], stayed_silent[MESSAGE_ID_COUNT];
};

static char current_name[256];

/* ---- output */

static void count_result(struct run *run)
{
    tally_count(&run->tally, run->report.outcome, current_name, run->report.text);
}

static void write_results(struct run *run, const struct play *play, bool expects_silence)
{
    enum rule rules[SHAPE_RULES];
    const uint32_t count = play_rules(play, rules);
    const bool passed = run->report.outcome == OUTCOME_PASSED;
    const char *outcome = !passed           ? "failed"
                          : expects_silence ? "silent"
                          : play_sees(play) ? "fired"
                                            : "unseen";

    if (run->report.outcome == OUTCOME_SKIPPED)
        return;
    for (uint32_t i = 0; i < count; i++) {
        const enum vuid vuid = rule_infos[rules[i]].vuid[play->command];
        if (vuid == VUID_NONE)
            continue;
        if (passed && expects_silence)
            run->stayed_silent[vuid] = true;
        else if (passed)
            run->fired[vuid] = true;
        if (run->tally.results != NULL)
            tally_write(&run->tally, &run->platform, current_name, play->command,
                        vuid_texts[vuid].id, outcome);
    }
}

/* ---- which plays */

static void play_one(struct run *run, const struct program_list *list, const struct play *play)
{
    snprintf(current_name, sizeof(current_name), "%s.%s%s%s/%s%s", list->name, play->program->name,
             play->difference != NULL ? "." : "",
             play->difference != NULL ? play->difference->name : "", command_words[play->command],
             play->is_twin ? "@twin" : "");
    if (!tally_starts(&run->tally, current_name))
        return;
    play_program(play, &run->fixture, &run->report);
    if (play->level == run->tally.level)
        write_results(run, play, play->is_twin || !program_reports(play->program));
    count_result(run);
}

/* Builds are recorded with the device command, updates with each that has an id for them; what the
 * host updates is judged by the ids of its own command. */
static bool fits_command(const struct play *play)
{
    enum rule rules[SHAPE_RULES];
    const uint32_t count = play_rules(play, rules);
    for (uint32_t i = 0; i < count; i++)
        if (rule_infos[rules[i]].vuid[play->command] == VUID_NONE)
            return false;
    return true;
}

/* What dies under NV's builds has programs of its own, and extensions add nothing to them. */
static bool takes_nv(const struct program_list *list, const struct program *program)
{
    return list != &death_programs && list != &extension_programs && machine_nv_takes(program);
}

/* Only the indirect command reads build ranges from a buffer. */
static bool loses_ranges(const struct program *program)
{
    for (const struct step *step = program->steps; step->action != ACTION_END_OF_PROGRAM; step++)
        if ((step->action == ACTION_DESTROY_INPUT || step->action == ACTION_FREE_INPUT) &&
            step->detail == RANGES)
            return true;
    return false;
}

static void play_commands(struct run *run, const struct program_list *list,
                          const struct program *program, const struct difference *difference)
{
    const bool by_host = program_has(program, ACTION_HOST_UPDATE);
    for (enum build_command command = COMMAND_DEVICE; command <= COMMAND_NV; command++) {
        struct play play = {&run->platform, program, difference, command, false, run->tally.level};
        if (!fits_command(&play) || by_host != (command == COMMAND_HOST) ||
            (command == COMMAND_INDIRECT && !program_has(program, ACTION_UPDATE)) ||
            (command != COMMAND_INDIRECT && loses_ranges(program)) ||
            (command == COMMAND_NV ? !takes_nv(list, program) : list == &nv_programs))
            continue;
        play_one(run, list, &play);
        play.is_twin = true;
        if (program_reports(program))
            play_one(run, list, &play);
    }
}

/* What level content reads has to be data: the inputs of extensions are none. */
static bool fits_level(const struct program *program, const char *level)
{
    return level == NULL || level_named(level) < LEVEL_CONTENT ||
           (program->needs & (NEEDS_EXTENSIONS | NEEDS_NO_LOOK)) == 0;
}

static void play_all(struct run *run)
{
    for (size_t i = 0; i < LIST_COUNT; i++)
        for (size_t j = 0; j < lists[i]->count; j++) {
            const struct program *program = &lists[i]->programs[j];
            if (!fits_level(program, run->tally.level))
                continue;
            if (program->once)
                play_commands(run, lists[i], program, NULL);
            for (uint32_t k = 0; k < DIFFERENCES && !program->once; k++)
                play_commands(run, lists[i], program, &differences[k]);
        }
}

/* Below level execution nothing is said of what is executed. */
static void play_at_level_state(struct run *run)
{
    for (size_t i = 0; i < order_programs.count; i++) {
        const struct play play = {&run->platform,  &order_programs.programs[i],
                                  &differences[0], COMMAND_DEVICE,
                                  false,           "state"};
        play_one(run, &order_programs, &play);
    }
}

/* ---- every rule about what was built has fired, and stayed silent */

/* What was built, not with what data: programs run at level execution. */
static bool is_about_updates(enum rule rule)
{
    const char *subject = rule_infos[rule].subject;
    return subject != NULL && rule_infos[rule].level < LEVEL_CONTENT &&
           (strcmp(subject, "update") == 0 || strcmp(subject, "updated_geometry") == 0);
}

static void check_every_rule_has_fired(struct run *run)
{
    const bool is_complete = run->platform.is_null && !run->platform.is_cpu;

    run->report = (struct report){.outcome = OUTCOME_PASSED};
    snprintf(current_name, sizeof(current_name), "every_rule_has_fired");
    for (enum rule rule = 0; rule < RULE_COUNT; rule++) {
        const struct rule_info *info = &rule_infos[rule];
        if (!is_about_updates(rule))
            continue;
        for (enum build_command command = COMMAND_DEVICE; command <= COMMAND_NV; command++) {
            const enum vuid vuid = info->vuid[command];
            if (vuid == VUID_NONE || (command != COMMAND_DEVICE && !is_complete))
                continue;
            if (run->fired[vuid] && run->stayed_silent[vuid])
                continue;
            printf("never %s: %s (%s)\n", run->fired[vuid] ? "silent" : "fired",
                   vuid_texts[vuid].id, info->name);
            run->report.outcome = OUTCOME_FAILED;
        }
    }
    count_result(run);
}

/* ---- the program */

int main(int argc, char **argv)
{
    static struct run run;

    const int status = tally_open(&run.tally, &run.platform, argc, argv,
                                  "usage: execution_test " PLATFORM_NAMES
                                  " [--filter NAME] [--list] [--verbose] "
                                  "[--results FILE] [--level NAME]\n");
    if (status != 0)
        return status;
    differences_fill();
    play_all(&run);
    if (run.platform.is_null && run.tally.level == NULL)
        play_at_level_state(&run);
    fixture_close(&run.fixture);
    if (run.tally.filter == NULL && !run.tally.list && run.tally.level == NULL)
        check_every_rule_has_fired(&run);
    return tally_close(&run.tally);
}
