/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of what is done with a message, and which messages are left out. */
#include <signal.h>

#include "hearing.h"
#include "src/report/ids/message_id.h"
#include "src/report/message.h"

TEST_OPENED(test_ignore, surrounding_set_up)
{
    environment_set("DEBUG_ACTION=ignore LEVEL=contents");
    struct hearing hearing = {.answer = VK_TRUE};
    capture_begin(STDERR_FILENO);
    struct reporter *reporter = reporter_heard_by(&hearing);
    assert_false(reporter_wants(reporter, SENT_VUID));
    assert_false(send_one(reporter));
    reporter_warn(reporter, "odd");
    assert_string_equal(capture_end(), "");
    assert_int_equal(hearing.count, 0);
    reporter_destroy(reporter);
}

TEST_OPENED(test_callback_only, surrounding_set_up)
{
    environment_set("DEBUG_ACTION=callback");
    struct hearing hearing = {0};
    capture_begin(STDERR_FILENO);
    struct reporter *reporter = reporter_heard_by(&hearing);
    send_one(reporter);
    reporter_remove_messenger(reporter, MESSENGER(0));
    send_one(reporter);
    assert_string_equal(capture_end(), "");
    assert_int_equal(hearing.count, 1);
    reporter_destroy(reporter);
}

static volatile sig_atomic_t traps;

static void count_trap(int number)
{
    traps++;
}

HEARD_TEST(test_break, "DEBUG_ACTION=break")
{
    struct sigaction old, new = {.sa_handler = count_trap};
    sigaction(SIGTRAP, &new, &old);
    reporter_warn(reporter, "odd");
    assert_int_equal(traps, 0);
    send_one(reporter);
    assert_int_equal(traps, 1);
    sigaction(SIGTRAP, &old, NULL);
    assert_int_equal(hearing->count, 2);
}

TEST_OPENED(test_fail, surrounding_set_up)
{
    struct hearing hearing = {0};
    environment_set("DEBUG_ACTION=VK_DBG_LAYER_ACTION_FAIL DUPLICATE_MESSAGE_LIMIT=1");
    struct reporter *reporter = reporter_heard_by(&hearing);
    assert_true(send_one(reporter));
    assert_int_equal(hearing.count, 1);
    assert_true(send_one(reporter)); /* though the message is held back */
    assert_int_equal(hearing.count, 1);
    /* A warning is about a call that may be valid. */
    assert_false(send_wrong(reporter, RULE_nv_instance_references_are_of_live_structures,
                            COMMAND_NV, "instanceData"));
    assert_int_equal(hearing.count, 2);
    assert_int_equal(hearing.severity, VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT);
    reporter_destroy(reporter);

    /* What is not reported does not fail a call. */
    static const char *const silent[] = {"REPORT_FLAGS=warn",
                                         "REPORT_FLAGS=error MESSAGE_ID_FILTER=03710"};
    for (size_t i = 0; i < LENGTH(silent); i++) {
        environment_set(silent[i]);
        reporter = reporter_heard_by(&hearing);
        assert_false(send_one(reporter));
        reporter_destroy(reporter);
    }
    assert_int_equal(hearing.count, 2);
}

/* The log gets the message if no messenger does. */
TEST_OPENED(test_fail_without_messenger, surrounding_set_up)
{
    environment_set("DEBUG_ACTION=fail");
    struct reporter *reporter = reporter_of(NULL);
    capture_begin(STDERR_FILENO);
    assert_true(send_one(reporter));
    assert_has(capture_end(), SENT_ID);
    reporter_destroy(reporter);
}

HEARD_TEST(test_report_flags_with_errors, "REPORT_FLAGS=error")
{
    reporter_warn(reporter, "odd");
    assert_int_equal(hearing->count, 0);
    send_one(reporter);
    assert_int_equal(hearing->count, 1);
}

HEARD_TEST(test_report_flags_with_warnings, "REPORT_FLAGS=warn")
{
    assert_false(reporter_wants(reporter, SENT_VUID));
    send_one(reporter);
    reporter_report_unsupported(reporter, "This can't be done.");
    assert_int_equal(hearing->count, 0);
    reporter_warn(reporter, "odd");
    assert_int_equal(hearing->count, 1);
}

HEARD_TEST(test_refusals, "DUPLICATE_MESSAGE_LIMIT=2")
{
    for (int i = 0; i < 4; i++)
        reporter_report_unsupported(reporter, "This can't be done.");
    assert_int_equal(hearing->count, 2);
    assert_int_equal(hearing->severity, VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT);
    assert_string_equal(hearing->id, "ASSAY-error");
    assert_string_equal(hearing->text, "This can't be done.");
    reporter_warn(reporter, "odd");
    assert_int_equal(hearing->count, 3);
}

HEARD_TEST(test_muted_ids, "MESSAGE_ID_FILTER=03710")
{
    hearing->answer = VK_TRUE;
    assert_false(reporter_wants(reporter, VUID_NONE));
    assert_false(reporter_wants(reporter, SENT_VUID));
    assert_true(reporter_wants(reporter, VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12258));
    assert_false(send_one(reporter));
    assert_int_equal(hearing->count, 0);
}

HEARD_TEST(test_retired_ids_in_place_of_current_ones, "VUID_NAMES=listed")
{
    static const char retired[] = "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03671";
    send_wrong(reporter, RULE_build_scratch_is_in_one_buffer, COMMAND_DEVICE,
               "scratchData.deviceAddress");
    assert_string_equal(hearing->id, retired);
    assert_int_equal(hearing->number, message_id_number(retired));
    send_one(reporter);
    assert_string_equal(hearing->id, SENT_ID);
}

/* Two current ids may have one retired id, and one current id may have several. */
HEARD_TEST(test_retired_ids_in_the_summary, "VUID_NAMES=listed REPORT_FLAGS=error,info")
{
    static const enum rule sent[] = {RULE_build_scratch_is_in_one_buffer,
                                     RULE_build_scratch_is_in_one_buffer, SENT_RULE};
    for (size_t i = 0; i < LENGTH(sent); i++)
        send_wrong(reporter, sent[i], COMMAND_DEVICE, "scratchData.deviceAddress");
    capture_begin(STDERR_FILENO);
    reporter_summarize(reporter);
    const char *summary = capture_end();
    assert_has(summary, "Assay found 3 violations in this instance: " SENT_ID
                        " 1 time, "
                        "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03671 2 times.");
    assert_lacks(summary, "12258");
}

HEARD_TEST(test_a_command_without_the_statement_is_not_told, "")
{
    hearing->answer = VK_TRUE;
    assert_int_equal(rule_infos[SENT_RULE].vuid[COMMAND_HOST], VUID_NONE);
    assert_false(send_wrong(reporter, SENT_RULE, COMMAND_HOST, ""));
    assert_int_equal(hearing->count, 0);
}
