/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of what is done with a message, and which messages are left out. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "hearing.h"
#include "src/report/ids/message_id.h"
#include "src/report/message.h"
#include "src/state/commands/object_names.h"

TEST_OPENED(test_ignore, surrounding_set_up)
{
    setenv("VK_ASSAY_VALIDATION_DEBUG_ACTION", "ignore", 1);
    setenv("VK_ASSAY_VALIDATION_LEVEL", "contents", 1);
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
    setenv("VK_ASSAY_VALIDATION_DEBUG_ACTION", "callback", 1);
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

TEST_OPENED(test_break, surrounding_set_up)
{
    setenv("VK_ASSAY_VALIDATION_DEBUG_ACTION", "break", 1);
    struct hearing hearing = {0};
    struct reporter *reporter = reporter_heard_by(&hearing);
    struct sigaction old, new = {.sa_handler = count_trap};
    sigaction(SIGTRAP, &new, &old);
    reporter_warn(reporter, "odd");
    assert_int_equal(traps, 0);
    send_one(reporter);
    assert_int_equal(traps, 1);
    sigaction(SIGTRAP, &old, NULL);
    assert_int_equal(hearing.count, 2);
    reporter_destroy(reporter);
}

TEST_OPENED(test_fail, surrounding_set_up)
{
    struct hearing hearing = {0};
    setenv("VK_ASSAY_VALIDATION_DEBUG_ACTION", "VK_DBG_LAYER_ACTION_FAIL", 1);
    setenv("VK_ASSAY_VALIDATION_DUPLICATE_MESSAGE_LIMIT", "1", 1);
    struct reporter *reporter = reporter_heard_by(&hearing);
    const struct call_origin origin = {.device = (VkDevice)(uintptr_t)1};
    struct finding finding;
    assert_true(send_one(reporter));
    assert_int_equal(hearing.count, 1);
    assert_true(send_one(reporter)); /* though the message is held back */
    assert_int_equal(hearing.count, 1);
    /* A warning is about a call that may be valid. */
    violated_plainly(&finding, "instanceData", "is odd");
    assert_false(reporter_send(reporter, RULE_nv_instance_references_are_of_live_structures,
                               &(struct location){.command = COMMAND_NV}, &origin, &finding));
    assert_int_equal(hearing.count, 2);
    assert_int_equal(hearing.severity, VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT);
    reporter_destroy(reporter);

    /* What is not reported does not fail a call. */
    setenv("VK_ASSAY_VALIDATION_REPORT_FLAGS", "warn", 1);
    reporter = reporter_heard_by(&hearing);
    assert_false(send_one(reporter));
    reporter_destroy(reporter);
    setenv("VK_ASSAY_VALIDATION_REPORT_FLAGS", "error", 1);
    setenv("VK_ASSAY_VALIDATION_MESSAGE_ID_FILTER", "03710", 1);
    reporter = reporter_heard_by(&hearing);
    assert_false(send_one(reporter));
    reporter_destroy(reporter);
    assert_int_equal(hearing.count, 2);
}

/* The log gets the message if no messenger does. */
TEST_OPENED(test_fail_without_messenger, surrounding_set_up)
{
    setenv("VK_ASSAY_VALIDATION_DEBUG_ACTION", "fail", 1);
    struct reporter *reporter = reporter_of(NULL);
    capture_begin(STDERR_FILENO);
    assert_true(send_one(reporter));
    assert_has(capture_end(), SENT_ID);
    reporter_destroy(reporter);
}

TEST_OPENED(test_report_flags, surrounding_set_up)
{
    struct hearing hearing = {0};
    setenv("VK_ASSAY_VALIDATION_REPORT_FLAGS", "error", 1);
    struct reporter *reporter = reporter_heard_by(&hearing);
    reporter_warn(reporter, "odd");
    assert_int_equal(hearing.count, 0);
    send_one(reporter);
    assert_int_equal(hearing.count, 1);
    reporter_destroy(reporter);

    setenv("VK_ASSAY_VALIDATION_REPORT_FLAGS", "warn", 1);
    reporter = reporter_heard_by(&hearing);
    assert_false(reporter_wants(reporter, SENT_VUID));
    send_one(reporter);
    reporter_report_unsupported(reporter, "This can't be done.");
    assert_int_equal(hearing.count, 1);
    reporter_warn(reporter, "odd");
    assert_int_equal(hearing.count, 2);
    reporter_destroy(reporter);
}

TEST_OPENED(test_refusals, surrounding_set_up)
{
    struct hearing hearing = {0};
    setenv("VK_ASSAY_VALIDATION_DUPLICATE_MESSAGE_LIMIT", "2", 1);
    struct reporter *reporter = reporter_heard_by(&hearing);
    for (int i = 0; i < 4; i++)
        reporter_report_unsupported(reporter, "This can't be done.");
    assert_int_equal(hearing.count, 2);
    assert_int_equal(hearing.severity, VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT);
    assert_string_equal(hearing.id, "ASSAY-error");
    assert_string_equal(hearing.text, "This can't be done.");
    reporter_warn(reporter, "odd");
    assert_int_equal(hearing.count, 3);
    reporter_destroy(reporter);
}

TEST_OPENED(test_muted_ids, surrounding_set_up)
{
    struct hearing hearing = {.answer = VK_TRUE};
    setenv("VK_ASSAY_VALIDATION_MESSAGE_ID_FILTER", "03710", 1);
    struct reporter *reporter = reporter_heard_by(&hearing);
    assert_false(reporter_wants(reporter, VUID_NONE));
    assert_false(reporter_wants(reporter, SENT_VUID));
    assert_true(reporter_wants(reporter, VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12258));
    assert_false(send_one(reporter));
    assert_int_equal(hearing.count, 0);
    reporter_destroy(reporter);
}

TEST_OPENED(test_retired_ids_in_place_of_current_ones, surrounding_set_up)
{
    static const char retired[] = "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03671";
    struct hearing hearing = {0};
    setenv("VK_ASSAY_VALIDATION_VUID_NAMES", "listed", 1);
    struct reporter *reporter = reporter_heard_by(&hearing);
    struct finding finding;
    violated_plainly(&finding, "scratchData.deviceAddress", "is wrong");
    reporter_send(reporter, RULE_build_scratch_is_in_one_buffer,
                  &(struct location){.command = COMMAND_DEVICE}, &(struct call_origin){0},
                  &finding);
    assert_string_equal(hearing.id, retired);
    assert_int_equal(hearing.number, message_id_number(retired));
    send_one(reporter);
    assert_string_equal(hearing.id, SENT_ID);
    reporter_destroy(reporter);
}

/* Two current ids may have one retired id, and one current id may have several. */
TEST_OPENED(test_retired_ids_in_the_summary, surrounding_set_up)
{
    static const struct {
        enum rule rule;
        const char *field;
    } sent[] = {
        {RULE_build_scratch_is_in_one_buffer, "scratchData.deviceAddress"},
        {RULE_build_scratch_is_in_one_buffer, "scratchData.deviceAddress"},
        {SENT_RULE, "scratchData.deviceAddress"},
    };
    static struct hearing hearing;
    setenv("VK_ASSAY_VALIDATION_VUID_NAMES", "listed", 1);
    setenv("VK_ASSAY_VALIDATION_REPORT_FLAGS", "error,info", 1);
    struct reporter *reporter = reporter_heard_by(&hearing);
    for (size_t i = 0; i < LENGTH(sent); i++) {
        struct finding finding;
        violated_plainly(&finding, sent[i].field, "is wrong");
        reporter_send(reporter, sent[i].rule, &(struct location){.command = COMMAND_DEVICE},
                      &(struct call_origin){0}, &finding);
    }
    capture_begin(STDERR_FILENO);
    reporter_summarize(reporter);
    const char *summary = capture_end();
    assert_has(summary, "Assay found 3 violations in this instance: " SENT_ID
                        " 1 time, "
                        "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03671 2 times.");
    assert_lacks(summary, "12258");
    reporter_destroy(reporter);
}

TEST_OPENED(test_a_command_without_the_statement_is_not_told, surrounding_set_up)
{
    struct hearing hearing = {.answer = VK_TRUE};
    struct reporter *reporter = reporter_heard_by(&hearing);
    struct finding finding;
    violated_plainly(&finding, "", "is wrong");
    assert_int_equal(rule_infos[SENT_RULE].vuid[COMMAND_HOST], VUID_NONE);
    assert_false(reporter_send(reporter, SENT_RULE, &(struct location){.command = COMMAND_HOST},
                               &(struct call_origin){0}, &finding));
    assert_int_equal(hearing.count, 0);
    reporter_destroy(reporter);
}
