/* SPDX-License-Identifier: Apache-2.0 */
/* The list of advice: which lines it keeps, in which order, and who gets them. */
#include "hearing.h"
#include "src/advice/list.h"

enum { LINES = 2 };

static void advise(struct advice_list *list, enum advice advice, uint64_t object, uint64_t weight)
{
    struct advice_report report = {
        .advice = advice, .type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, .object = object};
    snprintf(report.name, sizeof(report.name), "rock %u", (unsigned)object);
    finding_says(&report.finding, "", "weighs {}", count_of(weight, "byte"));
    advice_list_add(list, &report, weight);
}

/* The lines of a log, and what the summary says. */
TEST_OPENED(worst_first, surrounding_set_up)
{
    environment_set("REPORT_FLAGS=perf,info");
    struct reporter *reporter = reporter_of(NULL);
    struct advice_list *list = advice_list_create(LINES);
    assert_non_null(list);
    const enum advice first = ADVICE_created_structure_is_built,
                      second = ADVICE_allowed_updates_are_made;
    advise(list, second, 9, 1);
    advise(list, first, 1, 20);
    advise(list, first, 2, 10);
    advise(list, first, 3, 30);
    advise(list, first, 4, 10);
    capture_begin(STDERR_FILENO);
    advice_list_send(list, reporter, VK_NULL_HANDLE);
    advice_list_send(list, reporter, VK_NULL_HANDLE); /* it is empty now */
    const char *text = capture_end();
    assert_parts(
        text,
        "Validation Performance Warning: [ ASSAY-advice-never-built ]...0x3[\"rock 3\"] "
        "weighs 30 bytes. ...ASSAY-advice-never-built...0x1[\"rock 1\"] weighs 20 bytes. ..."
        "The list leaves out 2 more objects with this advice...ASSAY-advice-never-updated..."
        "0x9[\"rock 9\"] weighs 1 byte. ");
    assert_lacks(text, "rock 2");
    assert_lacks(text, "rock 4");
    assert_lacks(strstr(text, "rock 9"), "leaves out");
    capture_begin(STDERR_FILENO);
    reporter_summarize(reporter);
    assert_parts(
        capture_end(),
        "no violations...It gave 5 pieces of advice: ASSAY-advice-never-built 4 times (2 held "
        "back...ASSAY-advice-never-updated 1 time.");
    advice_list_destroy(list);
    advice_list_destroy(NULL);
    reporter_destroy(reporter);
}

/* A messenger gets the types that it has asked for. */
TEST_OPENED(messengers, surrounding_set_up)
{
    struct hearing validation = {0}, performance = {0}, report = {0};
    struct reporter *reporter = reporter_of(NULL);
    struct advice_list *list = advice_list_create(LINES);
    assert_non_null(list);
    VkDebugUtilsMessengerCreateInfoEXT info = hearing_messenger(&performance);
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
    reporter_add(reporter, MESSENGER(0), &info);
    reporter_add_hearing(reporter, 1, &validation);
    VkDebugReportCallbackCreateInfoEXT callback = hearing_report_callback(&report);
    callback.flags = VK_DEBUG_REPORT_PERFORMANCE_WARNING_BIT_EXT;
    assert_int_equal(reporter_add_report_callback(reporter, CALLBACK(0), &callback), VK_SUCCESS);
    advise(list, ADVICE_structure_is_destroyed_before_its_device, 1, 1);
    advise(list, ADVICE_created_structure_is_built, 2, 1);
    advice_list_send(list, reporter, VK_NULL_HANDLE);
    assert_int_equal(validation.count, 1);
    assert_string_equal(validation.id, "ASSAY-advice-leaked");
    assert_int_equal(performance.count, 1);
    assert_int_equal(performance.severity, VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT);
    assert_int_equal(performance.types, VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT);
    assert_string_equal(performance.id, "ASSAY-advice-never-built");
    assert_int_equal(performance.object_count, 1);
    assert_int_equal(performance.objects[0], 2);
    assert_string_equal(performance.names[0], "rock 2");
    assert_int_equal(report.count, 1);
    assert_int_equal(report.report_flags, VK_DEBUG_REPORT_PERFORMANCE_WARNING_BIT_EXT);
    advice_list_destroy(list);
    reporter_destroy(reporter);
}
