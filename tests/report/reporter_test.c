/* SPDX-License-Identifier: Apache-2.0 */
/* What callbacks get of a message, and which callbacks; the line about settings; and which ids a
 * filter mutes. scenes_test.c has which messages are sent. */
#include "hearing.h"
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

/* ---- report_flags = info: where the line about settings has them from, and who gets it.
 * scenes_test.c has what the lines say */

/* A messenger of the create info that hears information, too. */
static VkDebugUtilsMessengerCreateInfoEXT informed(struct hearing *hearing)
{
    VkDebugUtilsMessengerCreateInfoEXT info = hearing_messenger(hearing);
    info.messageSeverity |= VK_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT;
    return info;
}

static struct reporter *announced(struct hearing *hearing, const void *next)
{
    VkDebugUtilsMessengerCreateInfoEXT info = informed(hearing);
    info.pNext = next;
    struct reporter *reporter = reporter_of(&info);
    reporter_announce(reporter, "1.2.3");
    return reporter;
}

static void finish(struct reporter *reporter)
{
    reporter_set_instance_alive(reporter, false);
    reporter_summarize(reporter);
    reporter_destroy(reporter);
}

TEST_OPENED(sources_of_settings, surrounding_set_up)
{
    surrounding_clear(
        "assay_validation.level = state\n"
        "assay_validation.backend = driver\n"     /* the default */
        "assay_validation.vuid_names = retired\n" /* no valid value: the default counts */
        "assay_validation.report_flags = info\n"
        "assay_validation.log_filename = a.txt\n");
    setenv("VK_VALIDATION_SPEC_TEXT", "none", 1); /* the library reads these names, too */
    const char *filter = "03710";
    const uint32_t limit = 3;
    const char *level = "content";
    const VkLayerSettingEXT given[] = {
        {"VK_LAYER_ASSAY_validation", "message_id_filter", VK_LAYER_SETTING_TYPE_STRING_EXT, 1,
         &filter},
        {"VK_LAYER_ASSAY_validation", "duplicate_message_limit", VK_LAYER_SETTING_TYPE_UINT32_EXT,
         1, &limit},
        {"VK_LAYER_ASSAY_validation", "level", VK_LAYER_SETTING_TYPE_STRING_EXT, 1, &level},
    };
    const VkLayerSettingsCreateInfoEXT settings = {VK_STRUCTURE_TYPE_LAYER_SETTINGS_CREATE_INFO_EXT,
                                                   NULL, LENGTH(given), given};
    struct hearing hearing = {0};
    struct reporter *reporter = announced(&hearing, &settings);
    unsetenv("VK_VALIDATION_SPEC_TEXT");
    assert_string_equal(
        hearing.text,
        "Assay 1.2.3 validates acceleration-structure builds: level = state, backend = driver. "
        "Settings that differ from the defaults: level = \"state\" (file "
        "\"vk_layer_settings.txt\"), spec_text = \"none\" (environment variable "
        "VK_VALIDATION_SPEC_TEXT), report_flags = \"info\" (file \"vk_layer_settings.txt\"), "
        "log_filename = \"a.txt\" (file \"vk_layer_settings.txt\"), duplicate_message_limit = "
        "\"3\" (VkLayerSettingsCreateInfoEXT), message_id_filter = \"03710\" "
        "(VkLayerSettingsCreateInfoEXT).");
    finish(reporter);
    remove("a.txt");
}

/* Without memory for the settings, the line is sent without them. */
TEST_OPENED(information_without_memory, surrounding_set_up)
{
    environment_set("REPORT_FLAGS=info LEVEL=state");
    struct hearing hearing = {0};
    const VkDebugUtilsMessengerCreateInfoEXT info = informed(&hearing);
    const VkInstanceCreateInfo create_info = {.pNext = &info};
    for (int count = 0; memory_is_scarce(count); count++) {
        struct reporter *reporter = NULL;
        VkResult result = reporter_create(&create_info, &reporter);
        hearing.count = 0;
        if (result == VK_SUCCESS) {
            reporter_announce(reporter, "1.2.3");
            reporter_add_unchecked(reporter, "builds", 1);
            finish(reporter);
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
