/* SPDX-License-Identifier: Apache-2.0 */
/* What callbacks get of a message, and which callbacks. scenes_test.c has which messages are sent.
 */
#include "hearing.h"
#include "src/report/ids/message_id.h"
#include "src/report/summary.h"

HEARD_TEST(callback_data, "")
{
    struct object_names *names = names_create();
    struct label_stack labels = {0};
    object_names_set(names, VK_OBJECT_TYPE_BUFFER, 0xb, "scratch");
    label_push(&labels, "frame");
    const struct call_origin origin = {
        .command_buffer = (VkCommandBuffer)(uintptr_t)0xc, .names = names, .labels = &labels};
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_BUILD};
    struct finding finding;
    finding_says(&finding, "scratchData", "is in {}", object(VK_OBJECT_TYPE_BUFFER, 0xb));

    capture_begin(STDERR_FILENO);
    assert_false(reporter_send(reporter, SENT_RULE, &location, &origin, &finding));
    assert_string_equal(capture_end(), "");
    assert_int_equal(hearing->count, 1);
    assert_int_equal(hearing->severity, VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT);
    assert_int_equal(hearing->types, VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT);
    assert_string_equal(hearing->id, SENT_ID);
    assert_int_equal(hearing->number, message_id_number(SENT_ID));
    assert_memory_equal(hearing->text, "vkCmdBuildAccelerationStructuresKHR(): pInfos[0].", 49);
    assert_int_equal(hearing->queue_label_count, 0);
    assert_int_equal(hearing->label_count, 1);
    assert_string_equal(hearing->labels[0], "frame");
    assert_int_equal(hearing->object_count, 2);
    assert_int_equal(hearing->types_of_objects[0], VK_OBJECT_TYPE_COMMAND_BUFFER);
    assert_string_equal(hearing->names[0], "(null)");
    assert_int_equal(hearing->types_of_objects[1], VK_OBJECT_TYPE_BUFFER);
    assert_int_equal(hearing->objects[1], 0xb);
    assert_string_equal(hearing->names[1], "scratch");
    label_stack_clear(&labels);
    object_names_destroy(names);
}

/* Differences have ids and limits of their own, and the severity of a warning. */
HEARD_TEST(differences, "DUPLICATE_MESSAGE_LIMIT=1")
{
    const struct call_origin origin = {.command_buffer = (VkCommandBuffer)(uintptr_t)0xc};
    const struct location location = {
        .command = COMMAND_DEVICE, .subject = SUBJECT_GEOMETRY, .build = 1, .geometry = 2};
    struct finding finding;
    finding_says(&finding, "", "primitive {} is missed", number(7));
    assert_true(reporter_wants_difference(reporter, DIFFERENCE_MISSED));
    reporter_send_difference(reporter, DIFFERENCE_MISSED, &location, &origin, &finding);
    assert_true(reporter_wants_difference(reporter, DIFFERENCE_DOUBLE));
    reporter_send_difference(reporter, DIFFERENCE_MISSED, &location, &origin, &finding);
    assert_int_equal(hearing->count, 1);
    assert_int_equal(hearing->severity, VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT);
    assert_string_equal(hearing->id, "ASSAY-compare-missed");
    assert_int_equal(hearing->number, message_id_number("ASSAY-compare-missed"));
    const char *says =
        "vkCmdBuildAccelerationStructuresKHR(): pInfos[1].pGeometries[2] primitive 7 is missed. "
        "Command buffer VkCommandBuffer 0xc, build 1.\nThis difference has now been reported 1 "
        "time for VkCommandBuffer 0xc and will not be reported for it again: "
        "duplicate_message_limit is reached. At most 9 more follow for other objects.";
    assert_memory_equal(hearing->text, says, strlen(says));
}

TEST_OPENED(report_callback, surrounding_set_up)
{
    struct hearing hearing = {0};
    const VkDebugReportCallbackCreateInfoEXT info = hearing_report_callback(&hearing);
    struct reporter *reporter = reporter_of(NULL);
    assert_int_equal(reporter_add_report_callback(reporter, CALLBACK(0), &info), VK_SUCCESS);
    capture_begin(STDERR_FILENO);
    assert_false(send_one(reporter));
    assert_int_equal(hearing.count, 1);
    assert_int_equal(hearing.report_flags, VK_DEBUG_REPORT_ERROR_BIT_EXT);
    assert_int_equal(hearing.object_type, VK_DEBUG_REPORT_OBJECT_TYPE_UNKNOWN_EXT);
    assert_int_equal(hearing.number, message_id_number(SENT_ID));
    assert_string_equal(hearing.prefix, "Assay");
    assert_has(hearing.text, "Validation Error: [ " SENT_ID " ] | MessageID = 0x");
    assert_has(hearing.text, "\nvkCmdBuildAccelerationStructuresKHR(): pInfos[1].");

    const struct call_origin origin = {.device = (VkDevice)(uintptr_t)0xd};
    struct finding finding;
    violated_plainly(&finding, "", "is wrong");
    hearing.answer = VK_TRUE;
    assert_true(reporter_send(reporter, SENT_RULE, &(struct location){.command = COMMAND_DEVICE},
                              &origin, &finding));
    assert_int_equal(hearing.object_type, VK_DEBUG_REPORT_OBJECT_TYPE_DEVICE_EXT);
    assert_int_equal(hearing.object, 0xd);
    reporter_warn(reporter, "odd");
    assert_int_equal(hearing.report_flags, VK_DEBUG_REPORT_WARNING_BIT_EXT);
    assert_string_equal(capture_end(), "");
    reporter_destroy(reporter);
}

TEST_OPENED(masks, surrounding_set_up)
{
    struct hearing errors = {0}, warnings = {0}, performance = {0}, report_errors = {0};
    VkDebugUtilsMessengerCreateInfoEXT info = hearing_messenger(&errors);
    VkDebugReportCallbackCreateInfoEXT report_info = hearing_report_callback(&report_errors);
    struct reporter *reporter = reporter_of(NULL);
    info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    reporter_add(reporter, MESSENGER(0), &info);
    info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT;
    info.pUserData = &warnings;
    reporter_add(reporter, MESSENGER(1), &info);
    info = hearing_messenger(&performance);
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
    reporter_add(reporter, MESSENGER(2), &info);
    info.pfnUserCallback = NULL;
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    reporter_add(reporter, MESSENGER(3), &info);
    report_info.flags = VK_DEBUG_REPORT_ERROR_BIT_EXT;
    assert_int_equal(reporter_add_report_callback(reporter, CALLBACK(0), &report_info), VK_SUCCESS);
    report_info.pfnCallback = NULL;
    assert_int_equal(reporter_add_report_callback(reporter, CALLBACK(1), &report_info), VK_SUCCESS);

    send_one(reporter);
    assert_int_equal(errors.count, 1);
    assert_int_equal(warnings.count, 0);
    assert_int_equal(report_errors.count, 1);
    reporter_warn(reporter, "Something is odd.");
    assert_int_equal(errors.count, 1);
    assert_int_equal(warnings.count, 1);
    assert_int_equal(report_errors.count, 1);
    assert_int_equal(warnings.severity, VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT);
    assert_string_equal(warnings.text, "Something is odd.");
    assert_int_equal(performance.count, 0);
    reporter_destroy(reporter);
}

TEST_OPENED(create_info_messengers_serve_creation_and_destruction, surrounding_set_up)
{
    environment_set("LEVEL=contents");
    struct hearing early = {0}, early_report = {0}, late = {0};
    VkDebugReportCallbackCreateInfoEXT report = hearing_report_callback(&early_report);
    VkDebugUtilsMessengerCreateInfoEXT utils = hearing_messenger(&early);
    utils.pNext = &report;
    const VkBaseInStructure unknown = {(VkStructureType)0x7ffffff0, (VkBaseInStructure *)&utils};

    capture_begin(STDERR_FILENO);
    struct reporter *reporter = reporter_of(&unknown);
    assert_int_equal(early.count, 1);
    assert_int_equal(early_report.count, 1);
    assert_has(early.text, "assay_validation.level: \"contents\"");
    reporter_remove_messenger(reporter, VK_NULL_HANDLE);

    reporter_set_instance_alive(reporter, true);
    reporter_add_hearing(reporter, 0, &late);
    send_one(reporter);
    assert_int_equal(late.count, 1);
    assert_int_equal(early.count, 1);

    reporter_set_instance_alive(reporter, false);
    reporter_warn(reporter, "Something is left.");
    assert_int_equal(early.count, 2);
    assert_int_equal(early_report.count, 2);
    assert_string_equal(capture_end(), "");
    reporter_destroy(reporter);
}

/* Whatever fails, a reporter that came to be sends its findings. */
TEST_OPENED(without_memory, surrounding_set_up)
{
    environment_set("LEVEL=contents LOG_FILENAME=/nonexistent/assay.log");
    struct hearing early = {0}, late = {0};
    const VkDebugUtilsMessengerCreateInfoEXT chain = hearing_messenger(&early);
    const VkDebugUtilsMessengerCreateInfoEXT info = hearing_messenger(&late);
    const VkInstanceCreateInfo create_info = {.pNext = &chain};
    for (int count = 0; memory_is_scarce(count); count++) {
        struct reporter *reporter = NULL;
        late.count = 0;
        VkResult result = reporter_create(&create_info, &reporter);
        if (result == VK_SUCCESS) {
            reporter_set_instance_alive(reporter, true);
            result = reporter_add_messenger(reporter, MESSENGER(0), &info);
            capture_begin(STDERR_FILENO);
            send_one(reporter);
            const char *log = capture_end();
            assert_int_equal(late.count, result == VK_SUCCESS);
            assert_int_equal(strstr(log, SENT_ID) != NULL, result != VK_SUCCESS);
            reporter_remove_messenger(reporter, MESSENGER(0));
        }
        memory_fail_no_more();
        if (result != VK_SUCCESS)
            assert_int_equal(result, VK_ERROR_OUT_OF_HOST_MEMORY);
        reporter_destroy(reporter);
    }
    assert_int_equal(late.count, 1);
}

TEST(names_of_ids)
{
    assert_string_equal(reported_id_name(SENT_VUID), SENT_ID);
    assert_string_equal(reported_id_name(MESSAGE_ID_COUNT), difference_id((enum difference)0));
    assert_string_equal(reported_id_name(MESSAGE_ID_COUNT + 1), difference_id((enum difference)1));
}

/* Without memory for objects, the limit of the VUID holds. */
HEARD_TEST(limits_without_memory, "DUPLICATE_MESSAGE_LIMIT=2")
{
    for (unsigned i = 0; i < 50; i++) {
        memory_is_scarce(0);
        send_one(reporter);
        memory_fail_no_more();
    }
    assert_true(hearing->count >= 2 && hearing->count <= 20);
}

TEST_OPENED(log_to_stdout, surrounding_set_up)
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

HEARD_TEST(any_callback_can_skip_the_call, "")
{
    struct hearing second = {0};
    reporter_add_hearing(reporter, 1, &second);
    assert_false(send_one(reporter));
    hearing->answer = VK_TRUE;
    assert_true(send_one(reporter));
    hearing->answer = VK_FALSE;
    second.answer = VK_TRUE;
    assert_true(send_one(reporter));
    assert_int_equal(hearing->count, 3);
    assert_int_equal(second.count, 3);
}

HEARD_TEST(removal, "")
{
    struct hearing second = {0};
    const VkDebugReportCallbackCreateInfoEXT info = hearing_report_callback(&second);
    assert_int_equal(reporter_add_report_callback(reporter, CALLBACK(0), &info), VK_SUCCESS);
    reporter_remove_messenger(reporter, MESSENGER(1));
    reporter_remove_messenger(reporter, MESSENGER(0));
    send_one(reporter);
    assert_int_equal(hearing->count, 0);
    assert_int_equal(second.count, 1);

    reporter_add_hearing(reporter, 0, hearing);
    reporter_remove_report_callback(reporter, CALLBACK(0));
    send_one(reporter);
    assert_int_equal(hearing->count, 1);
    assert_int_equal(second.count, 1);
}

/* Without an object in its sentence, a finding is about the command buffer, or else the device. */
HEARD_TEST(findings_without_an_object, "DUPLICATE_MESSAGE_LIMIT=1")
{
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_BUILD};
    struct finding finding;
    violated_plainly(&finding, "", "is wrong");
    for (uintptr_t i = 0; i < 8; i++) {
        const struct call_origin origin = {.device = (VkDevice)(uintptr_t)(1 + (i & 1)),
                                           .command_buffer =
                                               (VkCommandBuffer)(uintptr_t)((i & 2) * 8)};
        reporter_send(reporter, SENT_RULE, &location, &origin, &finding);
    }
    assert_int_equal(hearing->count, 4);
}

TEST_OPENED(a_messenger_for_errors_leaves_warnings_to_the_log, surrounding_set_up)
{
    struct hearing hearing = {0};
    struct reporter *reporter = reporter_of(NULL);
    VkDebugUtilsMessengerCreateInfoEXT info = hearing_messenger(&hearing);
    info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    reporter_add(reporter, MESSENGER(0), &info);
    capture_begin(STDERR_FILENO);
    send_one(reporter);
    reporter_warn(reporter, "Something is odd.");
    const char *log = capture_end();
    assert_lacks(log, SENT_ID);
    assert_has(log, "\nSomething is odd.\n");
    reporter_destroy(reporter);
}
