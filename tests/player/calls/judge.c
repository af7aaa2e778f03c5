/* SPDX-License-Identifier: Apache-2.0 */
/* Plays a program of a call in one form: its device, its edits, and what is expected of messages.
 */
#include "tests/player/calls/judge.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *rule_id(enum rule rule, enum build_command command)
{
    const enum vuid vuid = rule_infos[rule].vuid[command];
    return vuid == VUID_NONE ? NULL : vuid_texts[vuid].id;
}

bool judge_is_refused(const struct call_play *play)
{
    return (play->test_case->refused & UINT64_C(1) << play->command) != 0;
}

const struct case_form *judge_form(const struct call_play *play)
{
    return &play->test_case->forms[play->is_repaired];
}

/* ---- fixtures ---- */

static bool is_same_text(const char *a, const char *b)
{
    return a == b || (a != NULL && b != NULL && strcmp(a, b) == 0);
}

bool judge_is_same_setup(const struct setup *a, const struct setup *b)
{
    return is_same_text(a->level, b->level) && is_same_text(a->muted, b->muted) &&
           is_same_text(a->with, b->with) && is_same_text(a->needs, b->needs) &&
           a->configure == b->configure && a->route == b->route &&
           a->api_version == b->api_version && a->by_environment == b->by_environment;
}

struct setup judge_setup(const struct call_play *play)
{
    struct setup wanted = judge_form(play)->setup;
    if (play->level != NULL)
        wanted.level = play->level;
    if (play->is_muted)
        wanted.muted = rule_id(play->test_case->rules[0], play->command);
    wanted.needs = command_needs(play->command);
    if (wanted.with == NULL || (wanted.needs != NULL && strstr(wanted.with, wanted.needs))) {
        wanted.with = wanted.with != NULL ? wanted.with : wanted.needs;
        wanted.needs = NULL;
    }
    return wanted;
}

/* Makes the fixture be as the setup asks. NULL, or why there is no such fixture here. */
static const char *enter_fixture(const struct call_play *play, struct fixture *fixture)
{
    const struct setup wanted = judge_setup(play);
    if (fixture->device != VK_NULL_HANDLE && judge_is_same_setup(&fixture->setup, &wanted))
        return NULL;
    fixture_close(fixture);
    return fixture_open(fixture, play->platform, &wanted);
}

bool judge_lacks_features(const struct call_play *play)
{
    const char *with = judge_form(play)->setup.with;
    return with != NULL && strchr(with, '-') != NULL && !play->is_repaired;
}

/* Whether commands besides those that build structures have ids of the case's rules. */
static bool is_felt_by_others(const struct test_case *test_case)
{
    for (int command = BUILD_COMMAND_COUNT; command < COMMAND_COUNT; command++)
        if (rule_id(test_case->rules[0], (enum build_command)command) != NULL)
            return true;
    return false;
}

bool limits_are_harsh(void)
{
    const char *limits = getenv("VK_ASSAY_VALIDATION_LIMITS");
    return limits != NULL && strcmp(limits, "harsh") == 0;
}

/* NULL, or why setting debug_action = fail cannot play the program. */
static const char *cannot_fail(const struct call_play *play)
{
    if (play->is_repaired)
        return NULL;
    if (play->test_case->forwards)
        return "debug_action = fail lets no such call pass";
    if (setup_has(&judge_form(play)->setup, "queueless") ||
        (judge_lacks_features(play) && is_felt_by_others(play->test_case)))
        return "debug_action = fail lets no scene be opened";
    return NULL;
}

/* NULL, or what the fixture lacks for the case. */
static const char *cannot_play(const struct call_play *play, const struct fixture *fixture)
{
    if (play->test_case->needs_null_driver && !play->platform->is_null)
        return "needs the null driver";
    if (play->test_case->needs_drivers_sizes && limits_are_harsh())
        return "needs the sizes of the driver";
    const bool is_guarded = play->platform->is_guarded && play->test_case->guard_protects;
    if (play->test_case->spares_drivers && !play->platform->is_null && !play->platform->is_cpu &&
        !is_guarded)
        return "needs the null driver or backend cpu";
    if (play->platform->is_cpu &&
        (play->command == COMMAND_GetAccelerationStructureOpaqueCaptureDescriptorDataEXT ||
         command_writes_descriptors(play->command)))
        return "backend cpu has no descriptors of structures";
    if (play->command == COMMAND_INDIRECT && !fixture->has_indirect)
        return "no accelerationStructureIndirectBuild";
    if (command_is_on_host(play->command) && !fixture->has_host)
        return "no accelerationStructureHostCommands";
    return NULL;
}

/* ---- what is expected ---- */

static bool needs_execution(const struct call_play *play)
{
    const char *level = judge_form(play)->setup.level;
    return level != NULL && strcmp(level, "execution") == 0;
}

/* If a program asks for level execution, its rules may be of a lower one: what that level knows is
 * what breaks them. */
bool judge_expects(const struct call_play *play, enum rule rule)
{
    if (play->level == NULL)
        return true;
    const enum level level = level_named(play->level);
    return level >= rule_infos[rule].level && (level >= LEVEL_EXECUTION || !needs_execution(play));
}

uint32_t judge_rules(const struct call_play *play, enum rule rules[2 * CASE_RULES])
{
    const struct test_case *test_case = play->test_case;
    uint32_t count = 0;
    for (uint32_t i = 0; i < test_case->name_count && play->is_muted; i++)
        if (rule_id(test_case->names[i], play->command) != NULL)
            rules[count++] = test_case->names[i];
    for (uint32_t i = play->is_muted; i < test_case->rule_count; i++)
        rules[count++] = test_case->rules[i];
    return count;
}

/* Whether the program is the broken one, and the layer can see that at the play's level. */
static bool is_broken(const struct call_play *play)
{
    enum rule rules[2 * CASE_RULES];
    const uint32_t count = judge_rules(play, rules);
    if (play->is_repaired)
        return false;
    bool breaks = judge_is_refused(play) && judge_expects(play, play->test_case->refusal);
    for (uint32_t i = 0; i < count; i++)
        breaks = breaks || judge_expects(play, rules[i]);
    return breaks;
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

/* Puts the one build of a query of sizes in the place of an element of pInfos. */
static void spell_build(char *text, size_t size)
{
    const char *const begin = strstr(text, "pInfos[");
    const char *const end = begin != NULL ? strchr(begin, ']') : NULL;
    if (end == NULL)
        return;
    const bool has_member = end[1] == '.';
    char element[32];
    snprintf(element, sizeof(element), "%.*s", (int)(end - begin) + 1 + has_member, begin);
    replace_word(text, size, element, has_member ? "pBuildInfo->" : "pBuildInfo");
}

/* The path of a case as this play's messages spell it. */
static const char *spell_path(const struct call_play *play, char *buffer, size_t size)
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
    if (!command_is_on_host(play->command))
        replace_word(buffer, size, "hostAddress", "deviceAddress");
    if (play->command == COMMAND_INDIRECT)
        replace_word(buffer, size, "ppBuildRangeInfos", "pIndirectDeviceAddresses");
    if (play->command == COMMAND_GetAccelerationStructureBuildSizesKHR)
        spell_build(buffer, size);
    if (play->command == COMMAND_CreateAccelerationStructureNV)
        replace_word(buffer, size, "pInfo->", "pCreateInfo->info.");
    if (play->command == COMMAND_CmdCopyAccelerationStructureNV)
        replace_word(buffer, size, "pInfo->", "");
    if (command_is_of_micromaps(play->command))
        replace_word(buffer, size, "pAccelerationStructures", "pMicromaps");
    return buffer;
}

/* ---- other ids of the same mistake ---- */

static bool names_the_others(const struct call_play *play, const struct fixture *fixture,
                             struct report *report)
{
    const struct test_case *test_case = play->test_case;
    const char *id = rule_id(test_case->rules[0], play->command);
    for (uint32_t i = 0; i < test_case->name_count && judge_expects(play, test_case->rules[0]);
         i++) {
        const char *other = rule_id(test_case->names[i], play->command);
        if (other == NULL || !judge_expects(play, test_case->names[i]) ||
            messages_count(&fixture->instance.messages, id, other) > 0)
            continue;
        report_say(report, "no message of %s names %s\n", id, other);
        return false;
    }
    return true;
}

static bool is_id(enum rule rule, const struct call_play *play, const char *at)
{
    const char *id = rule_id(rule, play->command);
    return id != NULL && strncmp(at, id, strlen(id)) == 0;
}

/* Whether the id at `at` is that of a rule of `names`, or of one that reads data which the setup's
 * level does not. */
static bool is_named(const struct call_play *play, const char *at)
{
    const struct test_case *test_case = play->test_case;
    for (uint32_t i = 0; i < test_case->name_count; i++)
        if (is_id(test_case->names[i], play, at))
            return true;
    const char *level = judge_form(play)->setup.level;
    if (level != NULL && level_named(level) >= LEVEL_CONTENT)
        return false;
    for (enum rule rule = 0; rule < RULE_COUNT; rule++)
        if (rule_infos[rule].level == LEVEL_CONTENT && is_id(rule, play, at))
            return true;
    return false;
}

/* Checks only messages of the first rule: other programs check those of other rules. */
static bool names_nothing_else(const struct call_play *play, const struct message *message,
                               struct report *report)
{
    const char *own = rule_id(play->test_case->rules[0], play->command);
    const char *end = report_own_end(message);
    if (own == NULL || strcmp(message->id, own) != 0)
        return true;
    for (const char *at = strstr(message->text, " (also VUID-"); at != NULL && at < end;
         at = strstr(at, ", VUID-")) {
        at = strstr(at, "VUID-");
        if (is_named(play, at))
            continue;
        report_say(report, "the message of %s names %.90s\n", own, at);
        return false;
    }
    return true;
}

static bool names_are_good(const struct call_play *play, const struct fixture *fixture,
                           struct report *report)
{
    const struct messages *messages = &fixture->instance.messages;
    if (play->is_muted)
        return true;
    bool good = names_the_others(play, fixture, report);
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        good = names_nothing_else(play, &messages->items[i], report) && good;
    return good;
}

/* ---- the program ---- */

/* Whether the messages are those of the rules that the program breaks. */
static bool expect_findings(const struct call_play *play, const struct fixture *fixture,
                            struct report *report)
{
    const struct test_case *test_case = play->test_case;
    const struct messages *messages = &fixture->instance.messages;
    bool is_expected[MESSAGES_MAX] = {false}, good = true;
    char buffer[256];
    const char *path = spell_path(play, buffer, sizeof(buffer));
    enum rule rules[2 * CASE_RULES];
    const uint32_t count = judge_rules(play, rules);

    for (uint32_t i = 0; i < count; i++) {
        const char *id = rule_id(rules[i], play->command);
        if (judge_expects(play, rules[i]))
            good &= report_expect(report, messages, &(struct expected_message){id, path, true},
                                  is_expected);
    }
    if (judge_is_refused(play) && judge_expects(play, test_case->refusal))
        good &= report_expect(
            report, messages,
            &(struct expected_message){rule_id(test_case->refusal, play->command), NULL, true},
            is_expected);
    const uint32_t found = messages_count(messages, rule_id(rules[0], play->command), NULL);
    if (test_case->count != 0 && !play->is_muted && judge_expects(play, rules[0]) &&
        found != test_case->count) {
        report_say(report, "%u messages of the first rule instead of %u\n", found,
                   test_case->count);
        good = false;
    }
    good &= names_are_good(play, fixture, report) && report_judge_wording(report, messages);
    return report_judge(report, messages, is_expected, good);
}

void offer_packed_format(struct null_driver_config *config)
{
    static const VkFormat formats[] = {VK_FORMAT_A2B10G10R10_SNORM_PACK32,
                                       VK_FORMAT_R64G64B64_SFLOAT, VK_FORMAT_R8G8B8A8_SNORM};
    for (size_t i = 0; i < sizeof(formats) / sizeof(formats[0]); i++)
        config->formats[config->format_count++] = (struct null_driver_format){
            formats[i], VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR};
}

struct scene *judge_open_scene(const struct call_play *play, struct fixture *fixture)
{
    struct scene *scene = scene_open(fixture, play->command);
    const struct case_form *form = judge_form(play);
    const bool has_edits = !judge_is_refused(play) || !play->is_repaired;
    for (uint32_t i = 0; i < form->step_count && has_edits; i++) {
        scene->is_edited |= form->steps[i].is_changed;
        form->steps[i].edit(scene);
    }
    scene->is_edited = true;
    return scene;
}

/* debug_action = fail skips calls that break rules with ids of the specification. */
static bool warns_only(const struct call_play *play)
{
    enum rule rules[2 * CASE_RULES];
    const uint32_t count = judge_rules(play, rules);
    for (uint32_t i = 0; i < count; i++)
        if (!vuid_is_warning(rule_infos[rules[i]].vuid[play->command]))
            return false;
    return true;
}

static bool is_good(const struct call_play *play, struct fixture *fixture, struct report *report)
{
    const bool breaks = is_broken(play);
    const bool passes = fixture->fails && breaks && warns_only(play);
    const struct call call = {.breaks = breaks,
                              .is_skipped = breaks && !play->test_case->forwards && !passes,
                              .may_fail_on_cpu =
                                  (!breaks || passes) && play->test_case->may_fail_on_cpu};
    const bool made = play->variant != NULL ? content_call(play, fixture, report)
                                            : play_call(play, fixture, &call, report);
    if (report->outcome == OUTCOME_SKIPPED)
        return false;
    return (breaks ? expect_findings(play, fixture, report)
                   : report_expect_none(report, &fixture->instance.messages, "the call",
                                        "instead of silence")) &&
           made;
}

void judge_play(const struct call_play *play, struct fixture *fixture, struct report *report)
{
    const char *missing = fixture->fails ? cannot_fail(play) : NULL;
    if (missing == NULL)
        missing = enter_fixture(play, fixture);
    if (missing == NULL)
        missing = cannot_play(play, fixture);
    *report = (struct report){.outcome = missing ? OUTCOME_SKIPPED : OUTCOME_FAILED};
    if (missing != NULL)
        report_say(report, "%s", missing);
    else if (is_good(play, fixture, report))
        report->outcome = OUTCOME_PASSED;
}
