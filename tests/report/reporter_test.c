/* SPDX-License-Identifier: Apache-2.0 */
/* What callbacks get of a message, messengers of the instance's creation, what is sent when memory
 * runs out, which ids and names a filter mutes, and the list of advice. scenes_test.c has which
 * messages are sent. */
#include "hearing.h"
#include "src/advice/list.h"
#include "src/base/letter_case.h"
#include "src/report/ids/message_filter.h"
#include "src/report/ids/message_id.h"
#include "src/report/message.h"
#include "src/report/summary.h"

HEARD_TEST(callback_data, "")
{
    struct object_names *names = names_create();
    struct label_stack labels = {0};
    struct shared_labels queue_labels = {0};
    object_names_set(names, VK_OBJECT_TYPE_BUFFER, 0xb, "scratch");
    label_push(&labels, "frame");
    label_push(&queue_labels.stack, "queue");
    label_push(&queue_labels.stack, "pass");
    const struct call_origin origin = {
        .command_buffer = (VkCommandBuffer)(uintptr_t)0xc,
        .names = names,
        .labels = &labels,
        .submission = {.queue = (VkQueue)(uintptr_t)0x9, .number = 3, .labels = &queue_labels}};
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
    assert_int_equal(hearing->queue_label_count, 2);
    assert_int_equal(hearing->label_count, 1);
    assert_string_equal(hearing->labels[0], "frame");
    assert_int_equal(hearing->object_count, 3);
    assert_int_equal(hearing->types_of_objects[0], VK_OBJECT_TYPE_COMMAND_BUFFER);
    assert_string_equal(hearing->names[0], "(null)");
    assert_int_equal(hearing->types_of_objects[1], VK_OBJECT_TYPE_BUFFER);
    assert_int_equal(hearing->objects[1], 0xb);
    assert_string_equal(hearing->names[1], "scratch");
    label_stack_clear(&labels);
    label_stack_clear(&queue_labels.stack);
    object_names_destroy(names);
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

/* Without memory for the settings, the line is sent without them. */
TEST_OPENED(information_without_memory, surrounding_set_up)
{
    environment_set("REPORT_FLAGS=info LEVEL=state");
    struct hearing hearing = {0};
    VkDebugUtilsMessengerCreateInfoEXT info = hearing_messenger(&hearing);
    info.messageSeverity |= VK_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT;
    const VkInstanceCreateInfo create_info = {.pNext = &info};
    for (int count = 0; memory_is_scarce(count); count++) {
        struct reporter *reporter = NULL;
        VkResult result = reporter_create(&create_info, &reporter);
        hearing.count = 0;
        if (result == VK_SUCCESS) {
            reporter_announce(reporter, "1.2.3");
            reporter_add_unchecked(reporter, "builds", 1);
            reporter_set_instance_alive(reporter, false);
            reporter_summarize(reporter);
            reporter_destroy(reporter);
            assert_int_equal(hearing.count, 2);
        }
        memory_fail_no_more();
    }
}

/* ---- the entries of message_id_filter */

/* The entry names `count` ids, and one of them is `vuid`. */
static void assert_filter(const char *entry, unsigned count, enum vuid vuid)
{
    bool muted[MESSAGE_ID_COUNT] = {false};
    unsigned found = 0;
    bool is_known = message_filter_add(muted, entry);
    for (unsigned i = 0; i < MESSAGE_ID_COUNT; i++)
        found += muted[i];
    if (is_known != (count != 0) || found != count || muted[vuid] != (count != 0))
        fail_msg("\"%s\" names %u ids", entry, found);
}

TEST(test_entries)
{
#define FORMER "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03674" /* of two ids */
    static const struct {
        const char *entry;
        unsigned count;
        enum vuid vuid;
    } rows[] = {
        {SENT_ID, 1, SENT_VUID},
        {"vuid-vkcmdbuildaccelerationstructureskhr-pinfos-03710", 1, SENT_VUID},
        {"ASSAY-instance-destroyed", 1, WARNING_instance_destroyed},
        {"03710", 2, SENT_VUID}, /* of the device command and of the indirect one */
        {"03710", 2, VUID_vkCmdBuildAccelerationStructuresIndirectKHR_pInfos_03710},
        {FORMER, 2, VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12261},
        {FORMER, 2, VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12260},
        {"03674", 2, VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12260},
        {"", 0, VUID_NONE},
        {"-", 0, VUID_NONE},
        {"0x", 0, VUID_NONE},
        {"3710", 0, VUID_NONE},
        {"parameter", 0, VUID_NONE},
        {"99999", 0, VUID_NONE},
        {"0x1ffffffff", 0, VUID_NONE},
        {"VUID-vkCmdDraw-None-02699", 0, VUID_NONE},
    };
    for (size_t i = 0; i < LENGTH(rows); i++)
        assert_filter(rows[i].entry, rows[i].count, rows[i].vuid);
}

/* As messages show it, in all notations. */
static void assert_number(const char *id, unsigned count, enum vuid vuid)
{
    static const char *const formats[] = {"0x%x", "%u", "%d"};
    for (size_t i = 0; i < LENGTH(formats); i++) {
        char number[32];
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
        snprintf(number, sizeof(number), formats[i], message_id_number(id));
#pragma GCC diagnostic pop
        assert_filter(number, count, vuid);
    }
}

TEST(test_by_number)
{
    for (enum vuid vuid = VUID_NONE + 1; vuid < VUID_COUNT; vuid += 37)
        assert_number(vuid_texts[vuid].id, 1, vuid);
    assert_number(FORMER, 2, VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12261);
}

/* ---- patterns of names, and comparisons that ignore case */

TEST(test_globs)
{
    static const struct {
        const char *glob, *text;
        bool matches;
    } cases[] = {
        {"", "", true},           {"", "a", false},
        {"*", "", true},          {"a*c", "abbc", true},
        {"a*c", "abcb", false},   {"*a*b*", "xaxbx", true},
        {"*ab", "aab", true},     {"a?c", "abc", true},
        {"a?c", "ac", false},     {"?", "\xc3\xa9", true},
        {"?", "\xff", true},      {"[a-c]x", "bx", true},
        {"[ab]c", "bc", true},    {"[bc]c", "ac", false},
        {"[a-c]x", "dx", false},  {"[!a-c]x", "dx", true},
        {"[!a-c]x", "ax", false}, {"[]]", "]", true},
        {"[!]]", "]", false},     {"[a-]", "-", true},
        {"[ab", "[ab", true},     {"[ab", "a", false},
        {"a\\*", "a\\b", true},   {"mesh[0-9]", "mesh7", true},
        {"Mesh", "mesh", false},  {"[\xc3\xa9-\xc3\xab]", "\xc3\xaa", true},
    };
    for (size_t i = 0; i < LENGTH(cases); i++)
        if (glob_matches(cases[i].glob, cases[i].text) != cases[i].matches)
            fail_msg("%s and %s", cases[i].glob, cases[i].text);
}

TEST(test_letter_case)
{
    assert_true(text_equals_in_any_case("VUID-Abc", "vuid-aBC"));
    assert_false(text_equals_in_any_case("abc", "ab"));
    assert_false(text_equals_in_any_case("ab", "abc"));
    assert_false(text_equals_in_any_case("@", "`"));
    assert_true(text_starts_in_any_case("0X1", "0x"));
    assert_false(text_starts_in_any_case("0", "0x"));
}

/* ---- the list of advice: which lines it keeps, in which order, and who gets them */

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
