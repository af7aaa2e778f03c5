/* SPDX-License-Identifier: Apache-2.0 */
/* Plays a case in one form: fixtures, mutations, and what is expected of messages. */
#include "tests/player/calls/judge.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool judge_is_refused(const struct play *play)
{
    return (play->test_case->refused & UINT64_C(1) << play->command) != 0;
}

const char *rule_id(enum rule rule, enum build_command command)
{
    const enum vuid vuid = rule_infos[rule].vuid[command];
    return vuid == VUID_NONE ? NULL : vuid_texts[vuid].id;
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

/* A setup of the case, with what the play and its command need besides. */
static struct setup setup_wanted(const struct play *play, const struct setup *setup)
{
    struct setup wanted = *setup;
    if (play->level != NULL)
        wanted.level = play->level;
    wanted.needs = command_needs(play->command);
    if (wanted.with == NULL || (wanted.needs != NULL && strstr(wanted.with, wanted.needs))) {
        wanted.with = wanted.with != NULL ? wanted.with : wanted.needs;
        wanted.needs = NULL;
    }
    return wanted;
}

struct setup judge_first_setup(const struct play *play)
{
    return setup_wanted(play, &case_right(play->test_case)->setup);
}

/* Makes the fixture be as the setup asks. NULL, or why there is no such fixture here. */
static const char *enter_fixture(const struct play *play, struct fixture *fixture,
                                 const struct setup *setup)
{
    const struct setup wanted = setup_wanted(play, setup);
    if (fixture->device != VK_NULL_HANDLE && judge_is_same_setup(&fixture->setup, &wanted))
        return NULL;
    fixture_close(fixture);
    return fixture_open(fixture, play->platform, &wanted);
}

bool judge_lacks_features(const struct test_case *test_case)
{
    const char *with = case_wrong(test_case)->setup.with;
    return with != NULL && strchr(with, '-') != NULL && !test_case->silent;
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

/* NULL, or what the fixture lacks for the case. */
static const char *cannot_play(const struct play *play, const struct fixture *fixture)
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

/* ---- mutations ---- */

/* Whether the case has a valid call of its own, here. */
static bool has_twin(const struct play *play)
{
    return !judge_is_refused(play) && !play->test_case->silent &&
           case_right(play->test_case)->step_count > 0;
}

/* ---- messages ---- */

static bool needs_execution(const struct test_case *test_case)
{
    const char *level = case_wrong(test_case)->setup.level;
    return level != NULL && strcmp(level, "execution") == 0;
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

/* Whether the messages are those that the case's mutation is to bring about. */
static bool expect_findings(const struct play *play, const struct fixture *fixture,
                            struct report *report)
{
    const struct test_case *test_case = play->test_case;
    const struct messages *messages = &fixture->instance.messages;
    bool is_expected[MESSAGES_MAX] = {false}, good = true;
    char buffer[256];
    const char *path = spell_path(play, buffer, sizeof(buffer));

    for (uint32_t i = 0; i < test_case->rule_count; i++) {
        const char *id = rule_id(test_case->rules[i], play->command);
        if (!judge_expects(play, test_case->rules[i]))
            continue;
        good &= report_expect(report, messages, &(struct expected_message){id, path, true},
                              is_expected);
        const uint32_t count = messages_count(messages, id, NULL);
        if (i > 0 || test_case->count == 0 || count == test_case->count)
            continue;
        report_say(report, "%u messages of %s instead of %u\n", count, id, test_case->count);
        good = false;
    }
    if (judge_is_refused(play) && judge_expects(play, test_case->refusal))
        good &= report_expect(
            report, messages,
            &(struct expected_message){rule_id(test_case->refusal, play->command), NULL, true},
            is_expected);
    good &= wording_is_good(play, fixture, report);
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

/* ---- the case ---- */

struct scene *judge_open_scene(const struct play *play, struct fixture *fixture,
                               const struct call *call)
{
    struct scene *scene = scene_open(fixture, play->command);
    for (uint32_t i = 0; call->form != NULL && i < call->form->step_count; i++) {
        scene->is_edited |= call->form->steps[i].is_changed;
        call->form->steps[i].edit(scene);
    }
    scene->is_edited = true;
    return scene;
}

static bool expect_silence(const struct play *play, struct fixture *fixture,
                           const struct call *call, struct report *report)
{
    const bool made = play->make_call(play, fixture, call, report);
    return (report->outcome == OUTCOME_SKIPPED ||
            report_expect_none(report, &fixture->instance.messages, call->what,
                               "instead of silence")) &&
           made;
}

static void play_twin(const struct play *play, struct fixture *fixture, struct report *report)
{
    const struct test_case *test_case = play->test_case;
    const struct call base = {.what = "valid call"};
    const struct call twin = {.what = "twin",
                              .form = case_right(test_case),
                              .may_fail_on_cpu = test_case->may_fail_on_cpu};

    report->stayed_silent = (play->base_is_known || expect_silence(play, fixture, &base, report)) &&
                            (!has_twin(play) || expect_silence(play, fixture, &twin, report));
}

/* debug_action = fail skips calls that break rules with ids of the specification. */
static bool warns_only(const struct play *play)
{
    const struct test_case *test_case = play->test_case;
    for (uint32_t i = 0; i < test_case->rule_count; i++)
        if (!vuid_is_warning(rule_infos[test_case->rules[i]].vuid[play->command]))
            return false;
    return true;
}

/* If a case asks for level execution, its rules may be of a lower one: what that level knows is
 * what breaks them. */
static bool play_mutation(const struct play *play, struct fixture *fixture, struct report *report)
{
    const struct test_case *test_case = play->test_case;
    bool breaks = judge_is_refused(play) && judge_expects(play, test_case->refusal);

    for (uint32_t i = 0; i < test_case->rule_count && !test_case->silent; i++)
        breaks = breaks || judge_expects(play, test_case->rules[i]);
    const bool passes = fixture->fails && breaks && warns_only(play);
    const struct call call = {.what = breaks ? "mutation" : "valid mutation",
                              .form = case_wrong(test_case),
                              .is_mutation = true,
                              .breaks = breaks,
                              .forwards = test_case->forwards || passes,
                              .may_fail_on_cpu =
                                  (test_case->silent || passes) && test_case->may_fail_on_cpu};
    if (!breaks)
        return expect_silence(play, fixture, &call, report);
    const bool made = play->make_call(play, fixture, &call, report);
    return report->outcome != OUTCOME_SKIPPED && expect_findings(play, fixture, report) && made;
}

void judge_play(const struct play *play, struct fixture *fixture, struct report *report)
{
    const struct test_case *test_case = play->test_case;
    const struct setup *setup = &case_wrong(test_case)->setup;
    const char *missing = enter_fixture(play, fixture, &case_right(test_case)->setup);

    *report = (struct report){.outcome = OUTCOME_FAILED};
    if (missing == NULL)
        missing = cannot_play(play, fixture);
    if (missing == NULL && test_case->forwards && fixture->fails)
        missing = "debug_action = fail lets no such call pass";
    const bool lacks_queues = setup_has(setup, "queueless");
    if (missing == NULL && fixture->fails &&
        (lacks_queues || (judge_lacks_features(test_case) && is_felt_by_others(test_case))))
        missing = "debug_action = fail lets no scene be opened";
    if (missing == NULL) {
        play_twin(play, fixture, report);
        if (report->outcome == OUTCOME_SKIPPED)
            return;
        if (!report->stayed_silent)
            report_say(report, "(before the mutation)\n");
    }
    if (missing == NULL)
        missing = enter_fixture(play, fixture, setup);
    if (missing != NULL) {
        report->outcome = OUTCOME_SKIPPED;
        report_say(report, "%s", missing);
        return;
    }
    report->fired = play_mutation(play, fixture, report);
    if (report->outcome == OUTCOME_SKIPPED)
        return;
    if (report->fired && report->stayed_silent)
        report->outcome = OUTCOME_PASSED;
}
