/* SPDX-License-Identifier: Apache-2.0 */
/* Playing one case: the valid call, the mutation, the twin, each in a scene of its own. */
#include "play.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "levels.h"

static const struct setup default_setup;

const char *rule_id(enum rule rule, enum build_command command)
{
    const enum vuid vuid = rule_infos[rule].vuid[command];
    return vuid == VUID_NONE ? NULL : vuid_texts[vuid].id;
}

__attribute__((format(printf, 2, 3))) static void say(struct report *report, const char *format,
                                                      ...)
{
    const size_t length = strlen(report->text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(report->text + length, sizeof(report->text) - length, format, arguments);
    va_end(arguments);
}

/* ---- worlds ---- */

static bool is_same_setup(const struct setup *a, const struct setup *b)
{
    const bool same_level = a->level == b->level || (a->level != NULL && b->level != NULL &&
                                                     strcmp(a->level, b->level) == 0);
    return same_level && a->configure == b->configure && a->enable == b->enable &&
           a->disable == b->disable && a->route == b->route && a->api_version == b->api_version &&
           a->by_environment == b->by_environment;
}

/* NULL, or why there is no such world here. */
static const char *enter_world(const struct play *play, struct world *world,
                               const struct setup *setup)
{
    struct setup wanted = *setup;
    if (play->level != NULL)
        wanted.level = play->level;
    if (play->command == COMMAND_NV)
        wanted.enable |= ENABLE_RAY_TRACING_NV;
    if (world->device != VK_NULL_HANDLE && is_same_setup(&world->setup, &wanted))
        return NULL;
    world_close(world);
    return world_open(world, play->platform, &wanted);
}

static const char *cannot_play(const struct play *play, const struct world *world)
{
    if (play->test_case->needs_null_driver && !play->platform->is_null)
        return "needs the null driver";
    if (play->command == COMMAND_INDIRECT && !world->has_indirect)
        return "no accelerationStructureIndirectBuild";
    if (play->command == COMMAND_HOST && !world->has_host)
        return "no accelerationStructureHostCommands";
    return NULL;
}

/* ---- one call ---- */

static void apply(struct scene *scene, const struct edit *edits)
{
    for (; edits != NULL && edits->size != 0; edits++) {
        unsigned char *member = (unsigned char *)scene + edits->offset;
        uint64_t value = 0;
        memcpy(&value, member, edits->size);
        value = edits->adds ? value + edits->value : edits->value;
        memcpy(member, &value, edits->size);
    }
}

/* One of the three calls of a case. */
struct call {
    const char *what;
    void (*mutate)(struct scene *scene);
    const struct edit *edits;
    bool breaks, forwards, may_fail_on_cpu;
    void (*then)(struct scene *scene);
};

static bool is_submitted(const struct play *play)
{
    return play->test_case->submits && play->command != COMMAND_HOST;
}

/* Whether a callback has the call itself skipped. */
static bool is_skipped(const struct play *play, const struct call *call)
{
    return call->breaks && !call->forwards && !is_submitted(play);
}

/* Whether the driver below has seen the call when it should, and only then. */
static bool check_forwarding(const struct play *play, const struct call *call, uint64_t seen,
                             struct report *report)
{
    const uint64_t wanted = is_skipped(play, call) ? 0 : 1;
    if (seen == wanted)
        return true;
    say(report, "%s: the driver got the call %u times instead of %u\n", call->what, (unsigned)seen,
        (unsigned)wanted);
    return false;
}

/* A host build that the callback skips fails in the application's eyes. */
static bool check_result(const struct play *play, const struct call *call, VkResult result,
                         struct report *report)
{
    const bool is_host = play->command == COMMAND_HOST;
    const bool skipped = is_host && is_skipped(play, call);
    const bool may_fail = is_host && call->may_fail_on_cpu && play->platform->is_cpu;
    if ((skipped ? result == VK_ERROR_VALIDATION_FAILED_EXT : result >= VK_SUCCESS) ||
        (may_fail && result == VK_ERROR_VALIDATION_FAILED_EXT))
        return true;
    say(report, "%s: the call returned %d\n", call->what, result);
    return false;
}

/* Submits what was recorded without a word; a callback has it skipped where it breaks rules. */
static bool submit(struct world *world, struct scene *scene, const struct call *call,
                   struct report *report)
{
    if (world->messages.count != 0) {
        say(report, "%s: messages before the submission\n", call->what);
        return false;
    }
    world->messages.answer = call->breaks ? VK_TRUE : VK_FALSE;
    const VkResult result = scene_submit_call(scene);
    if (result == (call->breaks ? VK_ERROR_VALIDATION_FAILED_EXT : VK_SUCCESS))
        return true;
    say(report, "%s: the submission returned %d\n", call->what, result);
    return false;
}

/* Makes one call; its messages are in the world afterwards. False where it cannot be judged. */
static bool make_call(const struct play *play, struct world *world, const struct call *call,
                      struct report *report)
{
    const struct null_driver_api *driver = &play->platform->null_driver;
    const char *name = build_command_name(play->command);
    bool good = true;

    messages_clear(&world->messages);
    world->messages.answer = VK_FALSE;
    struct scene *scene = scene_open(world, play->command);
    if (call->mutate != NULL)
        call->mutate(scene);
    apply(scene, call->edits);
    if (play->geometry_pointers)
        scene_use_geometry_pointers(scene);
    if (scene->skip != NULL) {
        report->outcome = OUTCOME_SKIPPED;
        say(report, "%s", scene->skip);
        good = false;
    } else if (world->messages.count != 0) {
        say(report, "%s: messages before the call\n", call->what);
    } else {
        world->messages.answer = is_skipped(play, call) ? VK_TRUE : VK_FALSE;
        const bool reaches_driver = play->platform->is_null && !play->platform->is_cpu;
        const uint64_t before = reaches_driver ? driver->calls(name) : 0;
        /* A call on a device that nobody knows can go nowhere, told or not. */
        const bool can_fail = play->command == COMMAND_HOST && scene->device != world->device;
        const VkResult result = scene_call(scene);
        good = (can_fail && !call->breaks) || check_result(play, call, result, report);
        if (call->then != NULL)
            call->then(scene);
        if (is_submitted(play))
            good = submit(world, scene, call, report) && good;
        if (reaches_driver && (!can_fail || call->breaks))
            good = check_forwarding(play, call, driver->calls(name) - before, report) && good;
        world->messages.answer = VK_FALSE;
    }
    scene_close(scene);
    return good;
}

static void say_messages(const struct world *world, struct report *report)
{
    for (uint32_t i = 0; i < messages_kept(&world->messages) && i < 12; i++)
        say(report, "    got %s\n        %.400s\n", world->messages.items[i].id,
            world->messages.items[i].text);
}

static bool expect_silence(const struct play *play, struct world *world, const struct call *call,
                           struct report *report)
{
    const bool made = make_call(play, world, call, report);
    if (report->outcome == OUTCOME_SKIPPED || world->messages.count == 0)
        return made;
    say(report, "%s: %u messages instead of silence\n", call->what, world->messages.count);
    say_messages(world, report);
    return false;
}

/* ---- the mutation ---- */

/* Where a case asks for level execution, its rules may be of a lower one: what that level knows is
 * what breaks them. */
static bool needs_execution(const struct test_case *test_case)
{
    const struct setup *setup = test_case->setup;
    return setup != NULL && setup->level != NULL && strcmp(setup->level, "execution") == 0;
}

bool play_expects(const struct play *play, enum rule rule)
{
    if (play->level == NULL)
        return true;
    const enum level level = level_named(play->level);
    return level >= rule_infos[rule].level &&
           (level >= LEVEL_EXECUTION || !needs_execution(play->test_case));
}

/* The path of a case as this play's messages spell it. */
static const char *spell_path(const struct play *play, char *buffer, size_t size)
{
    const char *path = play->test_case->path;
    const char *array = path != NULL ? strstr(path, "pGeometries[") : NULL;
    if (array == NULL || !play->geometry_pointers)
        return path;
    const char *dot = strstr(array, "].");
    snprintf(buffer, size, "%.*sp%.*s]->%s", (int)(array - path), path, (int)(dot - array), array,
             dot + 2);
    return buffer;
}

static bool check_messages(const struct play *play, const struct world *world,
                           struct report *report)
{
    const struct test_case *test_case = play->test_case;
    char buffer[256];
    const char *path = spell_path(play, buffer, sizeof(buffer));
    uint32_t expected = 0;
    bool good = true;

    for (uint32_t i = 0; i < test_case->rule_count; i++) {
        const enum rule rule = test_case->rules[i];
        const char *id = rule_id(rule, play->command);
        if (!play_expects(play, rule))
            continue;
        const uint32_t count = messages_count(&world->messages, id, NULL);
        expected += count;
        if (count == 0 || (i == 0 && test_case->count != 0 && count != test_case->count)) {
            say(report, "mutation: %u of %s (%s)\n", count, id, rule_infos[rule].name);
            good = false;
        } else if (path != NULL && messages_count(&world->messages, id, path) == 0) {
            say(report, "mutation: no message names %s\n", path);
            good = false;
        }
    }
    if (expected != world->messages.count) {
        say(report, "mutation: %u messages with unexpected ids\n",
            world->messages.count - expected);
        good = false;
    }
    if (!good)
        say_messages(world, report);
    return good;
}

static bool play_mutation(const struct play *play, struct world *world, struct report *report)
{
    const struct test_case *test_case = play->test_case;
    bool breaks = false;

    for (uint32_t i = 0; i < test_case->rule_count && !test_case->silent; i++)
        breaks = breaks || play_expects(play, test_case->rules[i]);
    const struct call call = {breaks ? "mutation" : "valid mutation",
                              test_case->mutate,
                              test_case->edits,
                              breaks,
                              test_case->forwards,
                              test_case->silent && test_case->may_fail_on_cpu,
                              test_case->then};
    if (!breaks)
        return expect_silence(play, world, &call, report);
    const bool made = make_call(play, world, &call, report);
    return report->outcome != OUTCOME_SKIPPED && check_messages(play, world, report) && made;
}

/* ---- the case ---- */

static const struct setup *setup_of(const struct setup *setup)
{
    return setup != NULL ? setup : &default_setup;
}

static void play_twin(const struct play *play, struct world *world, struct report *report)
{
    const struct test_case *test_case = play->test_case;
    const struct call base = {.what = "valid call"};
    const struct call twin = {.what = "twin",
                              .mutate = test_case->mutate_twin,
                              .edits = test_case->twin_edits,
                              .may_fail_on_cpu = test_case->may_fail_on_cpu,
                              .then = test_case->twin_then};

    report->stayed_silent =
        expect_silence(play, world, &base, report) &&
        ((twin.mutate == NULL && twin.edits == NULL) || expect_silence(play, world, &twin, report));
}

void play_case(const struct play *play, struct world *world, struct report *report)
{
    const struct test_case *test_case = play->test_case;
    const struct setup *setup = setup_of(test_case->setup);
    const struct setup *twin_setup = test_case->twin_setup != NULL ? test_case->twin_setup : setup;
    const char *missing = enter_world(play, world, twin_setup);

    *report = (struct report){.outcome = OUTCOME_FAILED};
    if (missing == NULL)
        missing = cannot_play(play, world);
    if (missing == NULL && !play->is_mutation_alone) {
        play_twin(play, world, report);
        if (report->outcome == OUTCOME_SKIPPED)
            return;
        if (!report->stayed_silent)
            say(report, "(before the mutation)\n");
    }
    if (missing == NULL)
        missing = enter_world(play, world, setup);
    if (missing != NULL) {
        report->outcome = OUTCOME_SKIPPED;
        say(report, "%s", missing);
        return;
    }
    report->fired = play_mutation(play, world, report);
    if (report->outcome == OUTCOME_SKIPPED)
        return;
    if (report->fired && (report->stayed_silent || play->is_mutation_alone))
        report->outcome = OUTCOME_PASSED;
}
