/* SPDX-License-Identifier: Apache-2.0 */
/* What programs that play cases have in common: fixtures, mutations, and what is expected of
 * messages. */
#include "judge.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "levels.h"
#include "wording.h"

static const struct setup default_setup;

const struct refusal indirect_takes_no_micromap = {COMMAND_INDIRECT,
                                                   RULE_micromap_build_is_not_indirect};
const struct refusal host_takes_no_dense_geometry = {COMMAND_HOST,
                                                     RULE_host_build_has_no_dense_geometry};

bool judge_is_refused(const struct play *play)
{
    const struct refusal *refusal = play->test_case->refusal;
    return refusal != NULL && refusal->command == play->command;
}

const char *rule_id(enum rule rule, enum build_command command)
{
    const enum vuid vuid = rule_infos[rule].vuid[command];
    return vuid == VUID_NONE ? NULL : vuid_texts[vuid].id;
}

void judge_say(struct report *report, const char *format, ...)
{
    const size_t length = strlen(report->text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(report->text + length, sizeof(report->text) - length, format, arguments);
    va_end(arguments);
}

/* ---- fixtures ---- */

static bool is_same_text(const char *a, const char *b)
{
    return a == b || (a != NULL && b != NULL && strcmp(a, b) == 0);
}

static bool is_same_setup(const struct setup *a, const struct setup *b)
{
    return is_same_text(a->level, b->level) && is_same_text(a->muted, b->muted) &&
           a->configure == b->configure && a->enable == b->enable && a->disable == b->disable &&
           a->route == b->route && a->api_version == b->api_version &&
           a->by_environment == b->by_environment;
}

/* NULL, or why there is no such world here. */
const char *judge_enter_fixture(const struct play *play, struct fixture *fixture,
                                const struct setup *setup)
{
    struct setup wanted = *setup;
    if (play->level != NULL)
        wanted.level = play->level;
    if (play->command == COMMAND_NV)
        wanted.enable |= ENABLE_RAY_TRACING_NV;
    if (fixture->device != VK_NULL_HANDLE && is_same_setup(&fixture->setup, &wanted))
        return NULL;
    fixture_close(fixture);
    return fixture_open(fixture, play->platform, &wanted);
}

const char *judge_cannot_play(const struct play *play, const struct fixture *fixture)
{
    if (play->test_case->needs_null_driver && !play->platform->is_null)
        return "needs the null driver";
    const bool is_guarded =
        play->platform->is_guarded && strncmp(play->test_case->name, "nv_instance_of_", 15) == 0;
    if (play->test_case->spares_drivers && !play->platform->is_null && !play->platform->is_cpu &&
        !is_guarded)
        return "needs the null driver or backend cpu";
    if (play->command == COMMAND_INDIRECT && !fixture->has_indirect)
        return "no accelerationStructureIndirectBuild";
    if (play->command == COMMAND_HOST && !fixture->has_host)
        return "no accelerationStructureHostCommands";
    return NULL;
}

/* ---- mutations ---- */

/* Members that are read and written as numbers have no more bytes than a number. */
static uint64_t read_member(const struct scene *scene, const struct edit *edit)
{
    uint64_t value = 0;
    memcpy(&value, (const unsigned char *)scene + edit->offset, edit->size);
    return value;
}

static void write_to_buffer(struct scene *scene, const struct edit *edit)
{
    const struct test_buffer *buffer = (const void *)((const unsigned char *)scene + edit->offset);
    if (edit->kind == EDIT_WRITE)
        memcpy(buffer->host + edit->build, &edit->value, edit->size);
    else
        memcpy(buffer->host + edit->build, &edit->number, sizeof(edit->number));
}

/* False if the edit is an assignment. */
static bool call_function(struct scene *scene, const struct edit *edit)
{
    switch (edit->kind) {
    case EDIT_DESTROY:
        scene_destroy(scene, read_member(scene, edit));
        return true;
    case EDIT_CALL:
        edit->call(scene);
        return true;
    case EDIT_CALL_WITH:
        edit->call_with(scene, (uint32_t)edit->value);
        return true;
    case EDIT_CALL_WITH_SIZE:
        edit->call_with_size(scene, edit->value);
        return true;
    case EDIT_CALL_FOR:
        edit->call_for(scene, edit->build, edit->value);
        return true;
    case EDIT_RECORD:
        edit->record(scene, scene->command_buffer);
        return true;
    case EDIT_WRITE:
    case EDIT_WRITE_FLOAT:
        write_to_buffer(scene, edit);
        return true;
    default:
        return false;
    }
}

static uint64_t value_of(struct scene *scene, const struct edit *edit)
{
    switch (edit->kind) {
    case EDIT_ADD:
        return read_member(scene, edit) + edit->value;
    case EDIT_POINT:
        return (uintptr_t)((unsigned char *)scene + edit->value);
    case EDIT_UNREADABLE:
        return (uintptr_t)unreadable_page();
    case EDIT_MAKE_ADDRESS:
        return edit->make_address(scene);
    case EDIT_MAKE_STRUCTURE_WITH:
        return (uint64_t)edit->make_structure_with(scene, (uint32_t)edit->value);
    default:
        return edit->value;
    }
}

static void apply_edit(struct scene *scene, const struct edit *edit)
{
    unsigned char *bytes = (unsigned char *)scene;

    if (edit->kind == EDIT_COPY) {
        memmove(bytes + edit->offset, bytes + edit->value, edit->size);
    } else if (!call_function(scene, edit)) {
        const uint64_t value = value_of(scene, edit);
        memcpy(bytes + edit->offset, &value, edit->size);
    }
}

void judge_apply(struct scene *scene, const struct edit *edits)
{
    for (; edits != NULL && edits->kind != EDIT_END; edits++)
        apply_edit(scene, edits);
}

void judge_prepare(struct scene *scene, const struct test_case *test_case)
{
    if (test_case->prepare != NULL)
        test_case->prepare(scene);
    judge_apply(scene, test_case->prepare_edits);
}

bool judge_has_twin(const struct play *play)
{
    const struct test_case *test_case = play->test_case;
    return !judge_is_refused(play) &&
           (test_case->prepare != NULL || test_case->prepare_edits != NULL ||
            test_case->mutate_twin != NULL || test_case->twin_edits != NULL);
}

/* ---- messages ---- */

void judge_say_messages(const struct fixture *fixture, struct report *report)
{
    for (uint32_t i = 0; i < messages_kept(&fixture->messages) && i < 12; i++)
        judge_say(report, "    got %s\n        %.400s\n", fixture->messages.items[i].id,
                  fixture->messages.items[i].text);
}

static bool needs_execution(const struct test_case *test_case)
{
    const struct setup *setup = test_case->setup;
    return setup != NULL && setup->level != NULL && strcmp(setup->level, "execution") == 0;
}

bool judge_expects(const struct play *play, enum rule rule)
{
    if (play->level == NULL)
        return true;
    const enum level level = level_named(play->level);
    return level >= rule_infos[rule].level &&
           (level >= LEVEL_EXECUTION || !needs_execution(play->test_case));
}

/* Puts one word of a text in another's place, where it is. */
static void replace_word(char *text, size_t size, const char *word, const char *by)
{
    char *at = strstr(text, word);
    if (at == NULL)
        return;
    char rest[256];
    snprintf(rest, sizeof(rest), "%s", at + strlen(word));
    snprintf(at, size - (size_t)(at - text), "%s%s", by, rest);
}

/* The path of a case as this play's messages spell it. */
static const char *spell_path(const struct play *play, char *buffer, size_t size)
{
    if (play->test_case->path == NULL)
        return NULL;
    snprintf(buffer, size, "%s", play->test_case->path);
    char *array = strstr(buffer, "pGeometries[");
    if (play->geometry_pointers && array != NULL) {
        const size_t left = size - (size_t)(array - buffer);
        replace_word(array, left, "].", "]->");
        replace_word(array, left, "pGeometries", "ppGeometries");
    }
    if (play->command != COMMAND_HOST)
        replace_word(buffer, size, "hostAddress", "deviceAddress");
    if (play->command == COMMAND_INDIRECT)
        replace_word(buffer, size, "ppBuildRangeInfos", "pIndirectDeviceAddresses");
    return buffer;
}

bool judge_messages(const struct play *play, const struct fixture *fixture, struct report *report)
{
    const struct test_case *test_case = play->test_case;
    char buffer[256];
    const char *path = spell_path(play, buffer, sizeof(buffer));
    uint32_t expected = 0;
    bool good = true;

    for (uint32_t i = 0; i < test_case->rule_count; i++) {
        const enum rule rule = test_case->rules[i];
        const char *id = rule_id(rule, play->command);
        if (!judge_expects(play, rule))
            continue;
        const uint32_t count = messages_count(&fixture->messages, id, NULL);
        expected += count;
        if (count == 0 || (i == 0 && test_case->count != 0 && count != test_case->count)) {
            judge_say(report, "mutation: %u of %s (%s)\n", count, id, rule_infos[rule].name);
            good = false;
        } else if (path != NULL && messages_count(&fixture->messages, id, path) == 0) {
            judge_say(report, "mutation: no message names %s\n", path);
            good = false;
        }
    }
    if (judge_is_refused(play) && judge_expects(play, test_case->refusal->rule)) {
        const uint32_t count = messages_count(
            &fixture->messages, rule_id(test_case->refusal->rule, play->command), NULL);
        expected += count;
        good = good && count > 0;
    }
    if (expected != fixture->messages.count) {
        judge_say(report, "mutation: %u messages with unexpected ids\n",
                  fixture->messages.count - expected);
        good = false;
    }
    good = wording_is_good(play, fixture, report) && good;
    if (!good)
        judge_say_messages(fixture, report);
    return good;
}

const struct setup *judge_setup(const struct setup *setup)
{
    return setup != NULL ? setup : &default_setup;
}
