/* SPDX-License-Identifier: Apache-2.0 */
/* Which messages a reporter sends, to whom, and what it writes to its log: scenes as text. */
#include <signal.h>

#include "hearing.h"
#include "src/report/ids/message_id.h"

#define JSON_FILE "LOG_FORMAT=json LOG_FILENAME=assay.log "

/* A reporter of a living instance with a messenger, created with the settings that
 * environment_set() takes. Steps end in a semicolon:
 *
 *     send 3              sends the finding of send_one() so many times; once without a number
 *     fail                sends it once, and the call is to be skipped
 *     about B             sends a finding about VkBuffer B, in hex; about memory B; about B of 2:
 *                         on another device
 *     wrong               sends a finding of a rule with a retired id
 *     note; host          sends a warning; and one that the host command's rules lack
 *     warn; refuse        a warning, or an error, of the layer's own
 *     hear; unhear        adds the messenger, or removes it
 *     add 1 WHAT; remove 1    another messenger: of all, of `errors` or `warnings` alone, of
 *                         `performance`, or `silent` without a function
 *     report 1 WHAT; remove-report 1    likewise a callback of VK_EXT_debug_report
 *     announce; summarize; unchecked 3 WORDS   the lines of an instance, and what the last one says
 *     answer; answer 1    the messenger, or another one, asks to skip calls from now on
 *     agree               it no longer does
 *     wanted; unwanted    whether the finding is wanted
 *     heard 3; heard 3 of 1    so many messages have come in all, to the messenger or another one
 *     traps 1             so many SIGTRAPs have come
 *     has WORDS; lacks WORDS; says WORDS; id WORDS   of the last message
 *     severity error      likewise; or warning
 *     log WORDS...WORDS; log-lacks WORDS; silent   stderr has the words, in this order; or not; or
 *                         is empty since the last such step
 *     file NAME WORDS...WORDS   the file has the words; lacks-file NAME: there is none
 *     lines 3             assay.log has so many lines
 *     end                 the reporter is destroyed, and the next one is created */
static const struct scene {
    const char *test, *settings, *steps;
} scenes[] = {
    /* ---- debug_action */
    {"ignore", "DEBUG_ACTION=ignore LEVEL=contents",
     "answer; unwanted; send; warn; silent; heard 0"},
    {"callback_only", "DEBUG_ACTION=callback", "send; unhear; send; silent; heard 1"},
#ifndef _WIN32
    {"break_stops_at_findings", "DEBUG_ACTION=break", "warn; traps 0; send; traps 1; heard 2"},
#endif
    {"fail_skips_calls", "DEBUG_ACTION=VK_DBG_LAYER_ACTION_FAIL DUPLICATE_MESSAGE_LIMIT=1",
     "fail; heard 1; fail; heard 1; note; heard 2; severity warning"}, /* a warning is about a call
                                                                          that may be valid */
    {"what_is_left_out_skips_no_call", "DEBUG_ACTION=fail REPORT_FLAGS=warn", "send; heard 0"},
    {"what_is_muted_skips_no_call", "DEBUG_ACTION=fail MESSAGE_ID_FILTER=03710", "send; heard 0"},
    {"fail_without_messenger", "DEBUG_ACTION=fail", "unhear; fail; log " SENT_ID},

    /* ---- which messages are sent */
    {"errors_alone", "REPORT_FLAGS=error", "warn; heard 0; send; heard 1"},
    {"warnings_alone", "REPORT_FLAGS=warn", "unwanted; send; refuse; heard 0; warn; heard 1"},
    {"refusals", "DUPLICATE_MESSAGE_LIMIT=2",
     "refuse; refuse; refuse; heard 2; severity error; id ASSAY-error; says This can't be done.; "
     "warn; heard 3"},
    {"muted_ids", "MESSAGE_ID_FILTER=03710", "answer; unwanted; send; heard 0; wrong; heard 1"},
    {"retired_ids_in_place_of_current_ones", "VUID_NAMES=listed",
     "wrong; id VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03671; send; id " SENT_ID},
    {"a_command_without_the_statement_is_not_told", "", "answer; host; heard 0"},
    {"any_callback_can_skip_the_call", "",
     "add 1; send; answer; fail; agree; answer 1; fail; heard 3; heard 3 of 1"},
    {"removal", "",
     "unhear; send; log " SENT_ID "; heard 0; report 1; remove 2; send; heard 0; heard 1 of 1;"
     "hear; remove-report 1; send; heard 1; heard 1 of 1; silent"},
    {"masks", "",
     "unhear; add 1 errors; add 2 warnings; add 3 performance; add 4 silent; report 5 errors;"
     "report 6 silent; send; heard 1 of 1; heard 0 of 2; heard 1 of 5; warn; heard 1 of 1;"
     "heard 1 of 2; heard 1 of 5; heard 0 of 3; silent"},
    {"a_messenger_for_errors_leaves_warnings_to_the_log", "",
     "unhear; add 1 errors; send; silent; warn; log \nodd\n; heard 1 of 1"},

    {"retired_ids_in_the_summary", "VUID_NAMES=listed REPORT_FLAGS=error,info",
     "wrong; wrong; send; summarize; log Assay found 3 violations in this instance: " SENT_ID
     " 1 time, VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03671 2 times."},

    /* ---- one line when an instance is created, and one at its end */
    {"no_information_without_the_flag", "", "announce; send; summarize; silent; heard 1"},
    {"creation", "REPORT_FLAGS=info",
     "announce; heard 0; log Assay 1.2.3 validates acceleration-structure builds: level = "
     "execution, "
     "backend = driver. Settings that differ from the defaults: report_flags = \"info\" "
     "(environment variable VK_ASSAY_VALIDATION_REPORT_FLAGS)."},
    /* The preset stands for what it sets. A key beside it is named if it changes that. */
    {"settings_of_a_preset", "PRESET=everything REPORT_FLAGS=info HAZARDS=false CALL_SITES=full",
     "announce; log Assay 1.2.3 validates acceleration-structure builds: level = content, "
     "backend = driver. Settings that differ from the defaults: preset = \"everything\" "
     "(environment variable VK_ASSAY_VALIDATION_PRESET), report_flags = \"info\" (environment "
     "variable VK_ASSAY_VALIDATION_REPORT_FLAGS), hazards = \"false\" (environment variable "
     "VK_ASSAY_VALIDATION_HAZARDS).\n"},
    {"information_for_a_callback", "REPORT_FLAGS=info",
     "report 1 errors; announce; heard 0 of 1; log Assay 1.2.3; report 2 information; announce;"
     "heard 0 of 1; heard 1 of 2; silent"},
    {"heading_of_information", "REPORT_FLAGS=info",
     "announce; log Validation Information: [ ASSAY-info ] | MessageID = 0x"},
    {"end", "REPORT_FLAGS=error,warn,info DUPLICATE_MESSAGE_LIMIT=2 LEVEL=content",
     "send 5000; wanted; heard 2; has Further ones are only counted.; note; summarize;"
     "log Assay found 5001 violations in this instance: " SENT_ID
     " 5000 times (4998 held back by duplicate_message_limit), ASSAY-instance-destroyed 1 time."},
    {"end_without_errors_and_warnings", "REPORT_FLAGS=info LEVEL=content",
     "send; note; summarize; log Assay reported no violations, because report_flags leaves out "
     "errors and warnings."},
    {"end_without_findings", "REPORT_FLAGS=warn,info LEVEL=content",
     "summarize; log Assay found no violations in this instance"},
    {"what_was_not_checked",
     "REPORT_FLAGS=error,warn,info LEVEL=parameters MESSAGE_ID_FILTER=" SENT_ID,
     "unchecked 3 builds without memory for copies; unchecked 1 executions on a lost device;"
     "unchecked 4 builds without memory for copies; summarize; log Assay found no violations in "
     "this instance. Not checked: ... VUIDs of higher levels (level = parameters)...1 VUID that "
     "message_id_filter names...builds without memory for copies (7)...executions on a lost device "
     "(1)."},
    {"what_level_execution_does_not_check", "REPORT_FLAGS=error,warn,info LEVEL=execution",
     "summarize; log  VUIDs of higher levels (level = execution)"},
    {"what_level_content_does_not_check", "REPORT_FLAGS=error,warn,info LEVEL=content",
     "summarize; log-lacks of higher levels"},

    /* ---- duplicate_message_limit: of an object, and ten times that of a VUID */
    {"each_object_has_its_limit", "DUPLICATE_MESSAGE_LIMIT=3",
     "about b; about b; lacks reported; about b; has reported 3 times for VkBuffer 0xb; about b;"
     "heard 3; wanted; about b0; heard 4; about memory b; heard 5; about b of 2; heard 6;"
     "lacks has now been reported; about b; heard 6"},
    {"a_vuid_has_ten_times_that", "DUPLICATE_MESSAGE_LIMIT=1",
     "about 1; about 2; about 3; about 4; about 5; about 6; about 7; about 8; about 9; wanted;"
     "about a; heard 10; has reported 10 times and will not; unwanted; about b; heard 10; wrong;"
     "heard 11"},
    {"no_limit", "DUPLICATE_MESSAGE_LIMIT=0", "send 200; heard 200; lacks has now been; wanted"},
    /* Ten times this limit is more than a count can hold. */
    {"the_largest_limit", "DUPLICATE_MESSAGE_LIMIT=4294967295", "send; heard 1"},
    /* A rule that finds one object again and again, such as a pair of each two builds, stops for
     * the rest of the call; the next object is reported all the same. */
    {"many_findings_on_one_object_end_a_call", "DUPLICATE_MESSAGE_LIMIT=10",
     "send 1009; wanted; send; unwanted; heard 10; about b0; heard 11; wanted"},
    {"warnings_of_the_layer_have_the_limit", "DUPLICATE_MESSAGE_LIMIT=2",
     "warn; warn; warn; heard 2"},

    /* ---- spec_text */
    {"sentences", "", "send; has .\nThe Vulkan spec states: For each; lacks ..."},
    {"short_sentences", "SPEC_TEXT=short", "send; has ... (https://docs.vulkan.org/"},
    {"no_sentences", "SPEC_TEXT=none", "send; has 256).; lacks spec states"},

    /* ---- the log */
    {"stderr_without_messenger", "",
     "unhear; send; log Validation Error: [ " SENT_ID " ] | MessageID = 0x"},
    {"stderr_has_the_text", "",
     "unhear; send; log \nvkCmdBuildAccelerationStructuresKHR(): pInfos[1].scratchData."
     "deviceAddress 0x1010 is not a multiple of minAccelerationStructureScratchOffsetAlignment "
     "(256). Round the address up to that alignment, and create the scratch VkBuffer with as many "
     "bytes more.\nThe Vulkan spec states: "},
    {"the_log_comes_beside_messengers", "LOG_FILENAME=assay.log DEBUG_ACTION=log",
     "send; heard 1; silent; file assay.log Validation Error: [ " SENT_ID " ]"},
    /* A file that stays empty because a messenger gets all messages looks as if there were none. */
    {"a_log_file_beside_a_messenger", "LOG_FILENAME=assay.log",
     "send; warn; silent; heard 2; file assay.log Validation Error: [ " SENT_ID " ];"
     "file assay.log \nodd\n"},
    {"instances_share_a_log_file", "LOG_FILENAME=assay.log",
     "warn; end; send; file assay.log \nodd\n; file assay.log " SENT_ID},
    {"callbacks_alone_leave_no_file", "LOG_FILENAME=assay.log DEBUG_ACTION=callback",
     "send; heard 1; lacks-file assay.log"},
    {"a_log_file_that_cannot_be_opened", "LOG_FILENAME=/nonexistent/assay.log",
     "unhear; send; log assay_validation.log_filename: \"/nonexistent/assay.log\" cannot be opened "
     "for writing (No such file or directory)"},

    /* ---- lines of JSON; after `end`, those of the next reporter begin */
    {"json_on_stderr", "LOG_FORMAT=json",
     "unhear; send; end; log \"Header\"...\n{\"Type\":\"Finding\"...\n{\"Type\":\"Summary\"...\n{"},
    {"no_json_for_callbacks_alone", "LOG_FORMAT=json DEBUG_ACTION=callback",
     "unhear; send; end; silent"},
    {"flags_do_not_hide_header_and_summary", JSON_FILE "REPORT_FLAGS=warn",
     "send; end; lines 3; file assay.log \"Header\"...\"Findings\":{}...errors, which "
     "report_flags leaves out"},
    /* The ids of one rule are its current one and those before; "formerly" has all but the one that
     * the finding is reported with. */
    {"former_ids", JSON_FILE,
     "wrong; file assay.log \"VUID\":\"VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-12258\"..."
     "\"formerly\":[\"VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03671\"]"},
    {"former_ids_of_a_retired_one", JSON_FILE "VUID_NAMES=listed",
     "wrong; file assay.log \"VUID\":\"VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03671\"..."
     "\"formerly\":[]"},
};

static struct {
    struct reporter *reporter;
    struct hearing hearing, others[8];
} scene;

static volatile sig_atomic_t traps;

static void count_trap(int number)
{
    traps++;
}

static void open_scene(void)
{
    scene.reporter = reporter_heard_by(&scene.hearing);
}

static void send_about(const char *words)
{
    char type[16] = "", object_text[16] = "";
    unsigned device = 1;
    if (sscanf(words, "memory %15s", object_text) == 1)
        snprintf(type, sizeof(type), "memory");
    else
        sscanf(words, "%15s of %u", object_text, &device);
    const uint64_t handle = strtoull(object_text, NULL, 16);
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_BUILD};
    const struct call_origin origin = {.device = (VkDevice)(uintptr_t)device,
                                       .command_buffer = (VkCommandBuffer)(uintptr_t)0xc};
    struct finding finding;
    finding_says(&finding, "scratchData", "is {} in {}", number(1),
                 object(type[0] ? VK_OBJECT_TYPE_DEVICE_MEMORY : VK_OBJECT_TYPE_BUFFER, handle));
    reporter_send(scene.reporter, SENT_RULE, &location, &origin, &finding);
}

static bool is(const char *verb, const char *other)
{
    return strcmp(verb, other) == 0;
}

/* Another messenger, as the words say. */
static void add_messenger(const char *words)
{
    struct hearing *hearing = &scene.others[atoi(words)];
    const char *what = words + strcspn(words, " ");
    VkDebugUtilsMessengerCreateInfoEXT info = hearing_messenger(hearing);
    if (is(what, " errors"))
        info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    else if (is(what, " warnings"))
        info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT;
    else if (is(what, " performance"))
        info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
    else if (is(what, " silent"))
        info.pfnUserCallback = NULL;
    reporter_add(scene.reporter, MESSENGER(atoi(words)), &info);
}

static void add_report_callback(const char *words)
{
    struct hearing *hearing = &scene.others[atoi(words)];
    const char *what = words + strcspn(words, " ");
    VkDebugReportCallbackCreateInfoEXT info = hearing_report_callback(hearing);
    if (is(what, " errors"))
        info.flags = VK_DEBUG_REPORT_ERROR_BIT_EXT;
    else if (is(what, " information"))
        info.flags = VK_DEBUG_REPORT_INFORMATION_BIT_EXT;
    else if (is(what, " silent"))
        info.pfnCallback = NULL;
    assert_int_equal(reporter_add_report_callback(scene.reporter, CALLBACK(atoi(words)), &info),
                     VK_SUCCESS);
}

/* What is sent, and to whom. Returns false if that is no such step. */
static bool act(const char *verb, const char *words)
{
    struct reporter *reporter = scene.reporter;
    if (is(verb, "send"))
        for (unsigned count = words[0] ? (unsigned)atoi(words) : 1; count; count--)
            assert_false(send_one(reporter));
    else if (is(verb, "fail"))
        assert_true(send_one(reporter));
    else if (is(verb, "about"))
        send_about(words);
    else if (is(verb, "wrong"))
        send_wrong(reporter, RULE_build_scratch_is_in_one_buffer, COMMAND_DEVICE, "scratchData");
    else if (is(verb, "note"))
        assert_false(send_wrong(reporter, RULE_nv_instance_references_are_of_live_structures,
                                COMMAND_NV, "instanceData"));
    else if (is(verb, "host"))
        assert_false(send_wrong(reporter, SENT_RULE, COMMAND_HOST, ""));
    else if (is(verb, "warn"))
        reporter_warn(reporter, "odd");
    else if (is(verb, "refuse"))
        reporter_report_unsupported(reporter, "This can't be done.");
    else if (is(verb, "hear"))
        reporter_add_hearing(reporter, 0, &scene.hearing);
    else if (is(verb, "unhear"))
        reporter_remove_messenger(reporter, MESSENGER(0));
    else if (is(verb, "add"))
        add_messenger(words);
    else if (is(verb, "remove"))
        reporter_remove_messenger(reporter, MESSENGER(atoi(words)));
    else if (is(verb, "report"))
        add_report_callback(words);
    else if (is(verb, "remove-report"))
        reporter_remove_report_callback(reporter, CALLBACK(atoi(words)));
    else if (is(verb, "announce"))
        reporter_announce(reporter, "1.2.3");
    else if (is(verb, "summarize"))
        reporter_summarize(reporter);
    else if (is(verb, "unchecked"))
        reporter_add_unchecked(reporter, strchr(words, ' ') + 1, (uint64_t)atoi(words));
    else if (is(verb, "answer"))
        *(words[0] ? &scene.others[atoi(words)].answer : &scene.hearing.answer) = VK_TRUE;
    else if (is(verb, "agree"))
        scene.hearing.answer = VK_FALSE;
    else
        return false;
    return true;
}

static void expect_file(const char *words)
{
    char name[64];
    snprintf(name, sizeof(name), "%.*s", (int)strcspn(words, " "), words);
    assert_parts(file_read(name), words + strlen(name) + 1);
}

static void expect_log(const char *words)
{
    assert_parts(capture_end(), words);
    capture_begin(STDERR_FILENO);
}

static void expect_no_log(const char *words)
{
    const char *log = capture_end();
    if (*words)
        assert_lacks(log, words);
    else
        assert_string_equal(log, "");
    capture_begin(STDERR_FILENO);
}

static bool expect(const char *verb, const char *words)
{
    const struct hearing *hearing = &scene.hearing;
    if (is(verb, "wanted") || is(verb, "unwanted"))
        assert_int_equal(reporter_wants(scene.reporter, SENT_VUID), is(verb, "wanted"));
    else if (is(verb, "heard") && strstr(words, " of "))
        assert_int_equal(scene.others[atoi(strstr(words, " of ") + 4)].count, atoi(words));
    else if (is(verb, "heard"))
        assert_int_equal(hearing->count, atoi(words));
    else if (is(verb, "traps"))
        assert_int_equal(traps, atoi(words));
    else if (is(verb, "has"))
        assert_has(hearing->text, words);
    else if (is(verb, "lacks"))
        assert_lacks(hearing->text, words);
    else if (is(verb, "says"))
        assert_string_equal(hearing->text, words);
    else if (is(verb, "id"))
        assert_true(is(hearing->id, words) && hearing->number == message_id_number(words));
    else if (is(verb, "severity"))
        assert_int_equal(hearing->severity, is(words, "error")
                                                ? VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT
                                                : VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT);
    else if (is(verb, "log"))
        expect_log(words);
    else if (is(verb, "log-lacks") || is(verb, "silent"))
        expect_no_log(words);
    else if (is(verb, "file"))
        expect_file(words);
    else if (is(verb, "lines"))
        assert_int_equal(count_lines(file_read("assay.log")), atoi(words));
    else if (is(verb, "lacks-file"))
        assert_int_equal(access(words, F_OK), -1);
    else
        return false;
    return true;
}

static void play(char *step)
{
    char *words = step + strcspn(step, " ");
    if (*words)
        *words++ = '\0';
    if (is(step, "end")) {
        reporter_destroy(scene.reporter);
        open_scene();
    } else if (!act(step, words) && !expect(step, words)) {
        fail_msg("no step: %s", step);
    }
}

static void close_scene(void)
{
    remove("assay.log");
}

TEST_OF_ROWS_BETWEEN(play_scene, scenes, const struct scene *row, surrounding_set_up, close_scene)
{
    char text[2000], *rest;
    environment_set(row->settings);
    memset(&scene, 0, sizeof(scene));
    traps = 0;
#ifndef _WIN32
    signal(SIGTRAP, count_trap);
#endif
    capture_begin(STDERR_FILENO);
    open_scene();
    snprintf(text, sizeof(text), "%s", row->steps);
    for (char *step = strtok_r(text, ";", &rest); step; step = strtok_r(NULL, ";", &rest))
        play(step + strspn(step, " "));
    capture_end();
    reporter_destroy(scene.reporter);
}
