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

/* ---- fixtures */

#define CONFIGURE(name, statement)                                                                 \
    static void name(struct null_driver_config *config)                                            \
    {                                                                                              \
        statement;                                                                                 \
    }

CONFIGURE(recycle, config->recycle_handles = config->recycle_addresses = true)
CONFIGURE(never_defer, config->deferred_joins = 0)
CONFIGURE(join_twice, config->deferred_joins = 2)
CONFIGURE(lose, ) /* not to be used again */

/* The flags of NV builds are those that dst was created with: programs in which they come to differ
 * are played where no driver minds, and nothing is said of that. */
static struct setup setup_for(const struct play *play)
{
    const uint32_t needs = play->program->needs;
    struct setup setup = {.level = play->level};
    if (needs & NEEDS_RECYCLING)
        setup.configure = recycle;
    if (needs & NEEDS_NO_DEFERRAL)
        setup.configure = never_defer;
    if (needs & NEEDS_LONG_JOINS)
        setup.configure = join_twice;
    if (needs & NEEDS_LOSS)
        setup.configure = lose;
    if (needs & NEEDS_SUBMIT2_KHR)
        setup.enable = ENABLE_SYNCHRONIZATION_2;
    if (needs & NEEDS_SPARSE)
        setup.enable |= ENABLE_SPARSE;
    if (needs & NEEDS_EXTENSIONS)
        setup.enable = ENABLE_MOTION | ENABLE_SPHERES | ENABLE_DENSE;
    if (play->command == COMMAND_NV) {
        setup.enable |= ENABLE_RAY_TRACING_NV;
        setup.muted = "02488";
    }
    return setup;
}

/* NULL, or why there is no such world here. */
static const char *enter_fixture(const struct play *play, struct fixture *fixture)
{
    const struct setup setup = setup_for(play);
    const bool is_other = fixture->setup.configure != setup.configure ||
                          fixture->setup.level != setup.level ||
                          fixture->setup.enable != setup.enable ||
                          fixture->setup.muted != setup.muted || play->program->needs & NEEDS_LOSS;
    if (!play->platform->is_null &&
        play->program->needs &
            ~(NEEDS_TWO_QUEUES | NEEDS_HOST | NEEDS_DRIVER | NEEDS_SPARSE | NEEDS_NO_LOOK))
        return "needs the null driver";
    if (play->platform->is_cpu && play->program->needs & NEEDS_DRIVER)
        return "needs a driver that looks at nothing";
    if (fixture->device == VK_NULL_HANDLE || is_other) {
        fixture_close(fixture);
        const char *missing = fixture_open(fixture, play->platform, &setup);
        if (missing != NULL)
            return missing;
    }
    if (!play->platform->is_null && play->command == COMMAND_NV && play->difference != NULL)
        return "needs the null driver";
    if (!play->platform->is_null && !play->is_twin &&
        program_has(play->program, ACTION_REPORTS_LATE))
        return "a bad update would execute";
    if (play->command == COMMAND_INDIRECT && !fixture->has_indirect)
        return "no accelerationStructureIndirectBuild";
    if ((play->command == COMMAND_HOST || play->program->needs & NEEDS_HOST) && !fixture->has_host)
        return "no accelerationStructureHostCommands";
    if (play->program->needs & NEEDS_TWO_QUEUES && machine_family(fixture, 1) == UINT32_MAX)
        return "no second queue";
    return NULL;
}

/* ---- what a play is about */

bool play_sees(const struct play *play)
{
    return play->level == NULL || level_named(play->level) >= LEVEL_EXECUTION;
}

bool program_has(const struct program *program, enum action action)
{
    for (const struct step *step = program->steps; step->action != ACTION_END_OF_PROGRAM; step++)
        if (step->action == action)
            return true;
    return false;
}

bool program_reports(const struct program *program)
{
    return program_has(program, ACTION_REPORTS) || program_has(program, ACTION_REPORTS_LATE);
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

static void prepare(const struct play *play, struct machine *machine, struct fixture *fixture)
{
    struct shape good = shape_plain(), bad;
    if (play->program->shape != NULL)
        good = play->program->shape();
    else if (play->difference != NULL)
        good = play->difference->asked;
    bad = play->difference != NULL && !play->is_twin ? play->difference->built : good;
    if (play->program->bad != NULL && !play->is_twin)
        bad = play->program->bad();
    machine_open(machine, fixture,
                 good.type == bad.type ? good.type : VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR);
    machine->update_command = play->command == COMMAND_HOST ? COMMAND_DEVICE : play->command;
    machine->good = good;
    machine->bad = bad;
    if (play->program->needs & NEEDS_EXTENSIONS)
        machine->scene->boxes = scene_dense_buffer(machine->scene, DENSE_USAGE);
    if (play->command == COMMAND_NV)
        machine_nv_open(machine);
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

/* The command that the last update, or build, was made by. */
static enum build_command command_of_reports(const struct machine *machine)
{
    if (machine->is_nv)
        return COMMAND_NV;
    if (machine->last_update.command_buffer == NOWHERE)
        return COMMAND_DEVICE;
    return machine->last_update.command_buffer == BY_HOST ? COMMAND_HOST : machine->update_command;
}

/* How the messages of a play begin: the call and the field. Programs of both extensions name fields
 * of KHR's structure. */
static void describe_field(const struct play *play, const struct machine *machine, char *text,
                           size_t size)
{
    const char *path = play->program->has_rule ? play->program->path : play->difference->path;
    const char *name = build_command_name(command_of_reports(machine));
    if (!machine->is_nv)
        snprintf(text, size, "%s(): %s%s", name, path[0] == 'p' ? "" : "pInfos[0]", path);
    else if (strcmp(path, ".srcAccelerationStructure") == 0)
        snprintf(text, size, "%s(): src VkAccelerationStructureNV", name);
    else
        snprintf(text, size, "%s(): %s", name, path);
}

/* As the source of an update is described. */
static void describe_place(const struct place *place, char *text, size_t size)
{
    if (place->command_buffer == BY_HOST)
        snprintf(text, size, "(by vkBuildAccelerationStructuresKHR, pInfos[%u])", place->position);
    else
        snprintf(text, size, "[\"%s\"], build %u)", machine_name(place->command_buffer),
                 place->position);
}

static bool is_submission(const struct step *step)
{
    return step->action >= ACTION_SUBMIT && step->action <= ACTION_SIGNAL_FROM_HOST &&
           step->action != ACTION_FAIL_SUBMIT;
}

/* The call, the field, and where both builds were recorded. */
static bool check_texts(const struct play *play, const struct machine *machine,
                        const struct step *step, struct report *report)
{
    const struct messages *messages = &machine->scene->fixture->messages;
    const bool is_update = machine->last_update.command_buffer != NOWHERE;
    const struct place *place = is_update ? &machine->last_update : &machine->last_build;
    char text[256];

    describe_field(play, machine, text, sizeof(text));
    bool good = contains(messages, text, report);
    if (place->command_buffer != BY_HOST) {
        snprintf(text, sizeof(text), "[\"%s\"], build %u, labels \"frame\" > \"%s\"",
                 machine_name(place->command_buffer), place->position,
                 is_update ? "refit" : "build");
        good = contains(messages, text, report) && good;
    }
    if (!play->program->keeps_place) {
        describe_place(&machine->last_bad, text, sizeof(text));
        good = contains(messages, text, report) && good;
    }
    if (is_submission(step))
        good = contains(messages, "submitted to", report) && good;
    return good;
}

static bool check_messages(const struct play *play, const struct machine *machine,
                           const struct step *step, struct report *report)
{
    const struct messages *messages = &machine->scene->fixture->messages;
    enum rule rules[SHAPE_RULES];
    const uint32_t count = play_rules(play, rules);
    uint32_t expected = 0;
    bool good = true;

    for (uint32_t i = 0; i < count; i++) {
        const enum build_command command = command_of_reports(machine);
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
    if (step->action == ACTION_FAILED_SUBMIT || step->action == ACTION_FAILED_BIND)
        expected = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    else if (step->action == ACTION_LOST_SUBMIT)
        expected = VK_ERROR_DEVICE_LOST;
    else if (expectation == EXPECT_REPORT)
        expected = VK_ERROR_VALIDATION_FAILED_EXT;
    if (result != expected)
        say(report, "the call returned %d instead of %d\n", result, expected);
    return result == expected;
}

/* An operation may be deferred or not. */
static bool check_host_result(const struct step *step, enum expectation expectation,
                              VkResult result, struct report *report)
{
    if (step->value == 0 && step->object != 0 && expectation == EXPECT_SILENCE &&
        result >= VK_SUCCESS)
        return true;
    if (step->value == 0)
        return check_result(step, expectation, result, report);
    return result == VK_ERROR_OUT_OF_HOST_MEMORY;
}

static bool is_host_command(const struct step *step)
{
    return step->action >= ACTION_HOST_BUILD && step->action <= ACTION_HOST_FILL;
}

/* But for what is said of a lost device, which is no finding. */
static bool is_silent(const struct messages *messages)
{
    return messages->count == messages_count(messages, "ASSAY-warning", " is lost") +
                                  messages_count(messages, "ASSAY-device-lost", NULL);
}

static bool play_step(const struct play *play, struct machine *machine, const struct step *step,
                      enum expectation expectation, struct report *report)
{
    struct messages *messages = &machine->scene->fixture->messages;
    messages_clear(messages);
    messages->answer = expectation == EXPECT_SILENCE ? VK_FALSE : VK_TRUE;
    machine_step(machine, step);
    messages->answer = VK_FALSE;
    if (is_submission(step) && !check_result(step, expectation, machine->result, report))
        return false;
    if (is_host_command(step) && !check_host_result(step, expectation, machine->result, report))
        return false;
    if (expectation != EXPECT_SILENCE)
        return check_messages(play, machine, step, report);
    if (is_silent(messages))
        return true;
    say(report, "%u messages instead of silence\n", messages->count);
    say_messages(messages, report);
    return false;
}

/* ---- the program */

static bool can_report(const struct step *step)
{
    return step->action == ACTION_UPDATE || step->action == ACTION_HOST_UPDATE ||
           is_submission(step);
}

static bool play_steps(const struct play *play, struct machine *machine, struct report *report)
{
    const struct program *program = play->program;
    const struct step *first =
        play->is_twin && program->twin != NULL ? program->twin : program->steps;
    enum expectation expectation = EXPECT_SILENCE;

    for (const struct step *step = first; step->action != ACTION_END_OF_PROGRAM; step++) {
        if (step->action == ACTION_REPORTS || step->action == ACTION_REPORTS_LATE) {
            if (!play->is_twin && play_sees(play))
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

void play_program(const struct play *play, struct fixture *fixture, struct report *report)
{
    static struct machine machine;
    const char *missing = enter_fixture(play, fixture);

    *report = (struct report){.outcome = OUTCOME_SKIPPED};
    if (missing != NULL) {
        say(report, "%s", missing);
        return;
    }
    messages_clear(&fixture->messages);
    prepare(play, &machine, fixture);
    report->outcome = play_steps(play, &machine, report) ? OUTCOME_PASSED : OUTCOME_FAILED;
    machine_close(&machine);
}
