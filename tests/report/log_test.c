/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of what is written to the log, and where to. */
#include "hearing.h"

TEST_OPENED(test_stderr_without_messenger, surrounding_set_up)
{
    struct reporter *reporter = reporter_of(NULL);
    capture_begin(STDERR_FILENO);
    assert_false(send_one(reporter));
    const char *log = capture_end();
    assert_has(log, "Validation Error: [ " SENT_ID " ] | MessageID = 0x");
    assert_has(log,
               "\nvkCmdBuildAccelerationStructuresKHR(): pInfos[1].scratchData."
               "deviceAddress 0x1010 is not a multiple of "
               "minAccelerationStructureScratchOffsetAlignment (256). Round the "
               "address up to that alignment, and create the scratch VkBuffer with as "
               "many bytes more.\n"
               "The Vulkan spec states: ");
    reporter_destroy(reporter);

    /* A messenger that hears errors only leaves the warnings to the log. */
    struct hearing hearing = {0};
    reporter = reporter_heard_by(&hearing);
    reporter_remove_messenger(reporter, MESSENGER(0));
    VkDebugUtilsMessengerCreateInfoEXT info = hearing_messenger(&hearing);
    info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    reporter_add(reporter, MESSENGER(0), &info);
    capture_begin(STDERR_FILENO);
    send_one(reporter);
    reporter_warn(reporter, "Something is odd.");
    log = capture_end();
    assert_lacks(log, SENT_ID);
    assert_has(log, "\nSomething is odd.\n");
    reporter_destroy(reporter);
}

static unsigned occurrences(const char *text, const char *word)
{
    unsigned count = 0;
    for (; (text = strstr(text, word)); text++)
        count++;
    return count;
}

TEST_OPENED(test_log_file, surrounding_set_up)
{
    environment_set("LOG_FILENAME=assay.log DEBUG_ACTION=log");
    struct hearing hearing = {0};
    capture_begin(STDERR_FILENO);
    struct reporter *first = reporter_heard_by(&hearing), *second = reporter_of(NULL);
    send_one(first);
    send_one(second);
    assert_string_equal(capture_end(), "");
    assert_int_equal(hearing.count, 1); /* the log comes beside the messengers */

    const char *log = file_read("assay.log"); /* written at once, not only at the end */
    assert_int_equal(occurrences(log, "Validation Error: [ " SENT_ID " ]"), 2);
    reporter_destroy(first);
    reporter_destroy(second);
    remove("assay.log");
}

/* A file that stays empty because a messenger gets all messages looks as if there were none. */
TEST_OPENED(test_log_file_beside_a_messenger, surrounding_set_up)
{
    struct hearing hearing = {0};
    environment_set("LOG_FILENAME=assay.log");
    capture_begin(STDERR_FILENO);
    struct reporter *reporter = reporter_heard_by(&hearing);
    send_one(reporter);
    reporter_warn(reporter, "Something is odd.");
    assert_string_equal(capture_end(), "");
    assert_int_equal(hearing.count, 2);
    const char *log = file_read("assay.log");
    assert_int_equal(occurrences(log, "Validation Error: [ " SENT_ID " ]"), 1);
    assert_int_equal(occurrences(log, "\nSomething is odd.\n"), 1);
    reporter_destroy(reporter);
    remove("assay.log");

    /* Only callbacks are wanted: no empty file appears. */
    environment_set("DEBUG_ACTION=callback");
    reporter = reporter_heard_by(&hearing);
    send_one(reporter);
    assert_int_equal(hearing.count, 3);
    assert_int_equal(access("assay.log", F_OK), -1);
    reporter_destroy(reporter);
}

TEST_OPENED(test_log_to_stdout, surrounding_set_up)
{
    environment_set("LOG_FILENAME=stdout");
    struct reporter *reporter = reporter_of(NULL);
    capture_begin(STDOUT_FILENO);
    send_one(reporter);
    const char *log = capture_end();
    assert_has(log, SENT_ID);
    reporter_destroy(reporter);
    assert_int_not_equal(access("stdout", F_OK), 0);
}

TEST_OPENED(test_log_file_that_cannot_be_opened, surrounding_set_up)
{
    environment_set("LOG_FILENAME=/nonexistent/assay.log");
    capture_begin(STDERR_FILENO);
    struct reporter *reporter = reporter_of(NULL);
    send_one(reporter);
    const char *log = capture_end();
    assert_has(log, "Validation Warning: ");
    assert_has(log,
               "assay_validation.log_filename: \"/nonexistent/assay.log\" cannot "
               "be opened for writing (No such file or directory)");
    assert_has(log, SENT_ID);
    reporter_destroy(reporter);
}
