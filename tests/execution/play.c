/* SPDX-License-Identifier: Apache-2.0 */
/* Playing a program, and judging each step by what the layer said during it. */
#include "play.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "machine.h"

__attribute__((format(printf, 2, 3))) static void say(struct report *report, const char *format,
                                                      ...)
{
    const size_t length = strlen(report->text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(report->text + length, sizeof(report->text) - length, format, arguments);
    va_end(arguments);
}

/* ---- worlds */

static void recycle(struct null_driver_config *config)
{
    config->recycle_handles = config->recycle_addresses = true;
}

/* NULL, or why there is no such world here. */
static const char *enter_world(const struct play *play, struct world *world)
{
    const struct setup setup = {
        .configure = play->program->needs & NEEDS_RECYCLING ? recycle : NULL,
        .level = play->level,
    };
    const bool is_other =
        world->setup.configure != setup.configure || world->setup.level != setup.level;
    if (!play->platform->is_null && play->program->needs & (NEEDS_NULL_DRIVER | NEEDS_RECYCLING))
        return "needs the null driver";
    if (world->device == VK_NULL_HANDLE || is_other) {
        world_close(world);
        const char *missing = world_open(world, play->platform, &setup);
        if (missing != NULL)
            return missing;
    }
    if (play->command == COMMAND_INDIRECT && !world->has_indirect)
        return "no accelerationStructureIndirectBuild";
    if (play->program->needs & NEEDS_TWO_QUEUES && machine_family(world, 1) == UINT32_MAX)
        return "no second queue";
    return NULL;
}

/* ---- what a play is about */

bool program_reports(const struct program *program)
{
    for (const struct step *step = program->steps; step->action != ACTION_END_OF_PROGRAM; step++)
        if (step->action == ACTION_REPORTS || step->action == ACTION_REPORTS_LATE)
            return true;
    return false;
}

uint32_t play_rules(const struct play *play, enum rule rules[SHAPE_RULES])
{
    uint32_t count = 0;
    if (play->program->has_rule)
        rules[count++] = play->program->rule;
    else if (play->difference != NULL)
        for (; count < play->difference->rule_count; count++)
            rules[count] = play->difference->rules[count];
    return count;
}

static void prepare(const struct play *play, struct machine *machine, struct world *world)
{
    struct shape good = shape_plain(), bad;
    if (play->program->shape != NULL)
        good = play->program->shape();
    else if (play->difference != NULL)
        good = play->difference->asked;
    bad = play->difference != NULL && !play->is_twin ? play->difference->built : good;
    machine_open(machine, world,
                 good.type == bad.type ? good.type : VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR);
    machine->update_command = play->command;
    machine->good = good;
    machine->bad = bad;
}

/* ---- one step */

enum expectation { EXPECT_SILENCE, EXPECT_REPORT, EXPECT_LATE_REPORT };

static void say_messages(const struct messages *messages, struct report *report)
{
    for (uint32_t i = 0; i < messages_kept(messages) && i < 12; i++)
        say(report, "    got %s\n        %.600s\n", messages->items[i].id, messages->items[i].text);
}

/* A text that each of the messages has to contain. */
static bool contains(const struct messages *messages, const char *text, struct report *report)
{
    bool good = true;
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        good = good && strstr(messages->items[i].text, text) != NULL;
    if (!good)
        say(report, "a message lacks '%s'\n", text);
    return good;
}

/* The call, the field, and where both builds were recorded. */
static bool check_texts(const struct play *play, const struct machine *machine,
                        const struct step *step, struct report *report)
{
    const struct messages *messages = &machine->scene->world->messages;
    const bool is_update = machine->last_update.command_buffer != COMMAND_BUFFERS;
    const struct place *place = is_update ? &machine->last_update : &machine->last_build;
    const char *path = play->program->has_rule ? play->program->path : play->difference->path;
    const bool is_indirect = is_update && play->command == COMMAND_INDIRECT;
    char text[256];

    snprintf(text, sizeof(text), "%s(): pInfos[0]%s",
             build_command_name(is_indirect ? COMMAND_INDIRECT : COMMAND_DEVICE), path);
    bool good = contains(messages, text, report);
    snprintf(text, sizeof(text), "[\"%s\"], build %u, labels \"frame\" > \"%s\"",
             machine_name(place->command_buffer), place->position, is_update ? "refit" : "build");
    good = contains(messages, text, report) && good;
    if (!play->program->keeps_place) {
        snprintf(text, sizeof(text), "[\"%s\"], build %u)",
                 machine_name(machine->last_bad.command_buffer), machine->last_bad.position);
        good = contains(messages, text, report) && good;
    }
    if (step->action != ACTION_UPDATE)
        good = contains(messages, "submitted to", report) && good;
    return good;
}

static bool check_messages(const struct play *play, const struct machine *machine,
                           const struct step *step, struct report *report)
{
    const struct messages *messages = &machine->scene->world->messages;
    enum rule rules[SHAPE_RULES];
    const uint32_t count = play_rules(play, rules);
    uint32_t expected = 0;
    bool good = true;

    for (uint32_t i = 0; i < count; i++) {
        const enum build_command command =
            machine->last_update.command_buffer == COMMAND_BUFFERS ? COMMAND_DEVICE : play->command;
        const char *id = vuid_texts[rule_infos[rules[i]].vuid[command]].id;
        const uint32_t found = messages_count(messages, id, NULL);
        if (found == 0)
            say(report, "nothing of %s (%s)\n", id, rule_infos[rules[i]].name);
        good = good && found != 0;
        expected += found;
    }
    if (expected != messages->count)
        say(report, "%u messages with unexpected ids\n", messages->count - expected);
    good = good && expected == messages->count;
    if (good)
        good = check_texts(play, machine, step, report);
    if (!good)
        say_messages(messages, report);
    return good;
}

/* A submission that a callback asks to skip never reaches the driver. */
static bool check_result(const struct step *step, enum expectation expectation, VkResult result,
                         struct report *report)
{
    VkResult expected = VK_SUCCESS;
    if (step->action == ACTION_FAILED_SUBMIT)
        expected = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    else if (expectation == EXPECT_REPORT)
        expected = VK_ERROR_VALIDATION_FAILED_EXT;
    if (result != expected)
        say(report, "the submission returned %d instead of %d\n", result, expected);
    return result == expected;
}

static bool is_submission(const struct step *step)
{
    return step->action >= ACTION_SUBMIT && step->action <= ACTION_SIGNAL_FROM_HOST &&
           step->action != ACTION_FAIL_SUBMIT;
}

static bool play_step(const struct play *play, struct machine *machine, const struct step *step,
                      enum expectation expectation, struct report *report)
{
    struct messages *messages = &machine->scene->world->messages;
    messages_clear(messages);
    messages->answer = expectation == EXPECT_SILENCE ? VK_FALSE : VK_TRUE;
    machine_step(machine, step);
    messages->answer = VK_FALSE;
    if (is_submission(step) && !check_result(step, expectation, machine->result, report))
        return false;
    if (expectation != EXPECT_SILENCE)
        return check_messages(play, machine, step, report);
    if (messages->count == 0)
        return true;
    say(report, "%u messages instead of silence\n", messages->count);
    say_messages(messages, report);
    return false;
}

/* ---- the program */

static bool can_report(const struct step *step)
{
    return step->action == ACTION_UPDATE || is_submission(step);
}

static bool play_steps(const struct play *play, struct machine *machine, struct report *report)
{
    const struct program *program = play->program;
    const struct step *first =
        play->is_twin && program->twin != NULL ? program->twin : program->steps;
    enum expectation expectation = EXPECT_SILENCE;

    for (const struct step *step = first; step->action != ACTION_END_OF_PROGRAM; step++) {
        if (step->action == ACTION_REPORTS || step->action == ACTION_REPORTS_LATE) {
            if (!play->is_twin && play->level == NULL)
                expectation = step->action == ACTION_REPORTS ? EXPECT_REPORT : EXPECT_LATE_REPORT;
            continue;
        }
        const bool is_expected = expectation == EXPECT_SILENCE || can_report(step);
        if (!play_step(play, machine, step, is_expected ? expectation : EXPECT_SILENCE, report)) {
            say(report, "(in step %u)\n", (unsigned)(step - first));
            return false;
        }
        if (can_report(step))
            expectation = EXPECT_SILENCE;
    }
    return true;
}

void play_program(const struct play *play, struct world *world, struct report *report)
{
    static struct machine machine;
    const char *missing = enter_world(play, world);

    *report = (struct report){.outcome = OUTCOME_SKIPPED};
    if (missing != NULL) {
        say(report, "%s", missing);
        return;
    }
    messages_clear(&world->messages);
    prepare(play, &machine, world);
    report->outcome = play_steps(play, &machine, report) ? OUTCOME_PASSED : OUTCOME_FAILED;
    machine_close(&machine);
}
