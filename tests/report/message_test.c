/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the wording of messages. */
#include "hearing.h"
#include "src/report/finding_message.h"
#include "src/report/ids/message_id.h"

#define DEVICE_HANDLE ((VkDevice)(uintptr_t)0xd0)
#define COMMAND_BUFFER_HANDLE ((VkCommandBuffer)(uintptr_t)0xc0)

static struct message message;

/* A rule without a hint; see message_wording_test.c. */
#define PLAIN_VUID VUID_VkAccelerationStructureTrianglesOpacityMicromapKHR_indexStride_11574

/* The message of a finding of that rule. */
static const char *word(const struct location *location, const struct call_origin *origin,
                        const struct finding *finding)
{
    const struct message_style style = {0};
    message_of_finding(&message, PLAIN_VUID, location, origin, finding, &style);
    return message.text;
}

/* The message of a call that is wrong. */
static void say(enum vuid vuid, enum vuid_names_setting names)
{
    const struct message_style style = {.vuid_names = names};
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_CALL};
    struct finding finding;
    violated_plainly(&finding, "", "is wrong");
    message_of_finding(&message, vuid, &location, &(struct call_origin){0}, &finding, &style);
}

/* The first line of a message of word(). */
static const char *first_line(enum build_command command, enum subject subject, bool by_pointer,
                              const struct finding *finding)
{
    static char line[MESSAGE_SIZE];
    const struct location location = {
        .command = command,
        .subject = subject,
        .build = 3,
        .geometry = 5,
        .geometry_by_pointer = by_pointer,
    };
    snprintf(line, sizeof(line), "%s", word(&location, &(struct call_origin){0}, finding));
    line[strcspn(line, "\n")] = '\0';
    return line;
}

TEST(test_id_numbers_are_those_of_the_khronos_layer)
{
    assert_int_equal(message_id_number("VUID-vkDestroyDevice-device-05137"), 0x4872eaa0);
    assert_int_equal(message_id_number("VUID-vkDestroyDevice-device-00378"), 0x71500fba);
}

TEST(test_paths)
{
#define BUILD "vkCmdBuildAccelerationStructuresKHR(): "
#define INDIRECT "vkCmdBuildAccelerationStructuresIndirectKHR(): "
    static const struct {
        enum build_command command;
        enum subject subject;
        bool by_pointer;
        const char *field, *expected;
    } cases[] = {
        {COMMAND_DEVICE, SUBJECT_CALL, false, "infoCount", BUILD "infoCount is wrong."},
        {COMMAND_DEVICE, SUBJECT_CALL, false, "", BUILD "is wrong."},
        {COMMAND_DEVICE, SUBJECT_CALL, false, NULL, BUILD "is wrong."},
        {COMMAND_DEVICE, SUBJECT_BUILD, false, "mode", BUILD "pInfos[3].mode is wrong."},
        {COMMAND_DEVICE, SUBJECT_BUILD, false, "", BUILD "pInfos[3] is wrong."},
        {COMMAND_HOST, SUBJECT_BUILD, false, "mode",
         "vkBuildAccelerationStructuresKHR(): pInfos[3].mode is wrong."},
        {COMMAND_DEVICE, SUBJECT_GEOMETRY, false, "flags",
         BUILD "pInfos[3].pGeometries[5].flags is wrong."},
        {COMMAND_DEVICE, SUBJECT_GEOMETRY, true, "flags",
         BUILD "pInfos[3].ppGeometries[5]->flags is wrong."},
        {COMMAND_DEVICE, SUBJECT_GEOMETRY, true, "", BUILD "pInfos[3].ppGeometries[5] is wrong."},
        {COMMAND_DEVICE, SUBJECT_RANGE, false, "primitiveOffset",
         BUILD "ppBuildRangeInfos[3][5].primitiveOffset is wrong."},
        {COMMAND_DEVICE, SUBJECT_RANGE, false, "", BUILD "ppBuildRangeInfos[3][5] is wrong."},
        {COMMAND_INDIRECT, SUBJECT_RANGE, false, "",
         INDIRECT "ppMaxPrimitiveCounts[3][5] is wrong."},
        {COMMAND_INDIRECT, SUBJECT_RANGE, false, "primitiveCount",
         INDIRECT "pIndirectDeviceAddresses[3][5].primitiveCount is wrong."},
        {COMMAND_INDIRECT, SUBJECT_BUILD, false, "mode", INDIRECT "pInfos[3].mode is wrong."},
        {COMMAND_NV, SUBJECT_PARAMETER, false, "scratchOffset",
         "vkCmdBuildAccelerationStructureNV(): scratchOffset is wrong."},
        {COMMAND_NV, SUBJECT_BUILD, false, "flags",
         "vkCmdBuildAccelerationStructureNV(): pInfo->flags is wrong."},
        {COMMAND_NV, SUBJECT_GEOMETRY, false, "flags",
         "vkCmdBuildAccelerationStructureNV(): pInfo->pGeometries[5].flags is wrong."},
    };
    for (size_t i = 0; i < LENGTH(cases); i++) {
        struct finding finding;
        violated_plainly(&finding, cases[i].field, "is wrong");
        assert_string_equal(
            first_line(cases[i].command, cases[i].subject, cases[i].by_pointer, &finding),
            cases[i].expected);
    }
}

TEST(test_values)
{
    struct finding finding;
    finding_says(&finding, "a", "{}, {}, {}, {}, {} and {} {}", hex(0xffffffffffffffff),
                 number(18446744073709551615u), phrase("VK_FORMAT_UNDEFINED"),
                 object(VK_OBJECT_TYPE_BUFFER, 0x12), field_of(7, "dstAccelerationStructure"),
                 object(VK_OBJECT_TYPE_DEVICE_MEMORY, 0));
    assert_string_equal(first_line(COMMAND_DEVICE, SUBJECT_CALL, false, &finding), BUILD
                        "a 0xffffffffffffffff, 18446744073709551615, VK_FORMAT_UNDEFINED, "
                        "VkBuffer 0x12, pInfos[7].dstAccelerationStructure and "
                        "VK_NULL_HANDLE {}.");
    assert_int_equal(message.named.count, 1);

    finding_says(&finding, "a", "is {}{}, {}", phrase(NULL), object(VK_OBJECT_TYPE_IMAGE, 3),
                 field_of(1, ""));
    assert_string_equal(first_line(COMMAND_DEVICE, SUBJECT_CALL, false, &finding),
                        BUILD "a is object 0x3, pInfos[1].");
}

TEST(test_origin)
{
    struct label_stack labels = {0};
    struct call_origin origin = {.device = DEVICE_HANDLE,
                                 .command_buffer = COMMAND_BUFFER_HANDLE,
                                 .build_index = 14,
                                 .labels = &labels};
    struct location location = {COMMAND_DEVICE, SUBJECT_BUILD, 3, 0, false};
    struct finding finding;
    finding_says(&finding, "dst", "{} overlaps {}",
                 object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, 0xa),
                 object(VK_OBJECT_TYPE_COMMAND_BUFFER, 0xc0));

    assert_has(word(&location, &origin, &finding), BUILD
               "pInfos[3].dst VkAccelerationStructureKHR 0xa overlaps "
               "VkCommandBuffer 0xc0. Command buffer VkCommandBuffer 0xc0, "
               "build 17.\n");

    struct object_names *names = names_create();
    object_names_set(names, VK_OBJECT_TYPE_COMMAND_BUFFER, 0xc0, "builds");
    object_names_set(names, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, 0xa, "bunny");
    origin.names = names;
    label_push(&labels, "Frame 3");
    label_push(&labels, "BLAS updates");
    assert_has(word(&location, &origin, &finding), BUILD
               "pInfos[3].dst VkAccelerationStructureKHR 0xa[\"bunny\"] overlaps "
               "VkCommandBuffer 0xc0[\"builds\"]. Command buffer VkCommandBuffer "
               "0xc0[\"builds\"], build 17, labels \"Frame 3\" > \"BLAS updates\".\n");
    location.subject = SUBJECT_CALL;
    assert_has(word(&location, &origin, &finding),
               "0xc0[\"builds\"], labels \"Frame 3\" > \"BLAS updates\".\n");

    assert_int_equal(message.named.count, 2);
    assert_int_equal(message.named.objects[0].objectType, VK_OBJECT_TYPE_COMMAND_BUFFER);
    assert_int_equal(message.named.objects[0].objectHandle, 0xc0);
    assert_string_equal(message.named.objects[0].pObjectName, "builds");
    assert_int_equal(message.named.objects[1].objectHandle, 0xa);
    assert_string_equal(message.named.objects[1].pObjectName, "bunny");
    assert_int_equal(message.label_count, 2);
    assert_string_equal(message.labels[0].pLabelName, "BLAS updates");
    assert_string_equal(message.labels[1].pLabelName, "Frame 3");

    origin.command_buffer = VK_NULL_HANDLE;
    assert_lacks(word(&location, &origin, &finding), "Command buffer");
    assert_int_equal(message.named.objects[0].objectType, VK_OBJECT_TYPE_DEVICE);
    assert_null(message.named.objects[0].pObjectName);
    label_stack_clear(&labels);
    object_names_destroy(names);
}

TEST(test_specification)
{
    char expected[MESSAGE_SIZE];
    for (enum vuid vuid = VUID_NONE + 1; vuid < VUID_COUNT; vuid++) {
        const struct vuid_text *stated = &vuid_texts[vuid];
        const char *hint = rule_infos[rule_of_vuid(vuid)].hint;
        if (!stated->sentence[0])
            continue;
        say(vuid, VUID_NAMES_CURRENT);
        snprintf(expected, sizeof(expected),
                 BUILD
                 "is wrong.%s%s\nThe Vulkan spec states: %s "
                 "(https://docs.vulkan.org/spec/latest/%s#%s)",
                 hint ? " " : "", hint ? hint : "", stated->sentence, stated->page, stated->id);
        assert_memory_equal(message.text, expected, strlen(expected));
        const char *rest = message.text + strlen(expected);
        if (vuid_retired(vuid, 0)) {
            snprintf(expected, sizeof(expected), " (formerly %s", vuid_retired(vuid, 0));
            assert_memory_equal(rest, expected, strlen(expected));
            assert_int_equal(rest[strlen(rest) - 1], ')');
        } else {
            assert_string_equal(rest, "");
        }
    }
    say(VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12261, VUID_NAMES_CURRENT);
    assert_has(message.text,
               ") (formerly VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03674, "
               "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03802)");
}

TEST(test_a_message_may_go_by_the_retired_id)
{
#define RETIRED "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03671"
    const enum vuid vuid = VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12258;
    say(vuid, VUID_NAMES_LISTED);
    assert_string_equal(message.id, RETIRED);
    assert_int_equal(message.id_number, message_id_number(RETIRED));
    assert_has(message.heading, "Error: [ " RETIRED " ] | MessageID = 0x");
    assert_has(message.text, vuid_texts[vuid].sentence);
    assert_lacks(message.text, "formerly");
    assert_has(message.text, ") (today VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-12258)");

    /* Most have none. */
    say(SENT_VUID, VUID_NAMES_LISTED);
    assert_string_equal(message.id, SENT_ID);
    assert_lacks(message.text, "today");
}

/* No sentence of the specification goes with an id of the layer's own. */
TEST(test_a_warning_of_the_layers_own)
{
    const struct location location = {.command = COMMAND_NV, .subject = SUBJECT_PARAMETER};
    const struct message_style style = {
        .vuid_names = VUID_NAMES_LISTED, .last = LAST_OF_ID, .sent = 100};
    struct finding finding;
    finding_fill(&finding, "instanceData", "is odd", NULL, 0);
    message_of_finding(&message, WARNING_instance_destroyed, &location, &(struct call_origin){0},
                       &finding, &style);
    assert_int_equal(message.severity, REPORT_WARNING);
    assert_string_equal(message.id, "ASSAY-instance-destroyed");
    assert_has(message.heading, "Validation Warning: [ ASSAY-instance-destroyed ] | MessageID");
    assert_string_equal(message.text,
                        "vkCmdBuildAccelerationStructureNV(): instanceData is odd. Destroy the "
                        "structure only after the build has completed.\n"
                        "This warning has now been reported 100 times and will not be reported "
                        "again: ten times duplicate_message_limit is reached.");
}

TEST(test_heading_and_log)
{
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_BUILD};
    struct finding finding;
    finding_says(&finding, "dst", "{} is wrong", object(VK_OBJECT_TYPE_BUFFER, 0xb));
    struct object_names *names = names_create();
    object_names_set(names, VK_OBJECT_TYPE_BUFFER, 0xb, "vertices");
    message_of_finding(&message, SENT_VUID, &location,
                       &(struct call_origin){.device = DEVICE_HANDLE, .names = names}, &finding,
                       &(struct message_style){0});
    object_names_destroy(names);

    char heading[256];
    snprintf(heading, sizeof(heading), "Validation Error: [ " SENT_ID " ] | MessageID = 0x%x\n",
             (uint32_t)message_id_number(SENT_ID));
    assert_memory_equal(message.heading, heading, strlen(heading));
    assert_ptr_equal(message.text, message.heading + strlen(heading));

    const char *log = capture_message(&message);
    assert_memory_equal(log, message.heading, strlen(message.heading));
    assert_string_equal(log + strlen(message.heading),
                        "\n    Objects: 2\n"
                        "        [0] VkDevice 0xd0\n"
                        "        [1] VkBuffer 0xb[\"vertices\"]\n");

    message_of_layer(&message, REPORT_WARNING, "Something is odd.");
    log = capture_message(&message);
    assert_has(log, "Validation Warning: [ ASSAY-warning ] | MessageID = 0x");
    assert_has(log, "\nSomething is odd.\n");
    assert_lacks(log, "Objects");
}

/* ---- what does not fit */

TEST(test_long_names_and_deep_labels_are_cut)
{
    char name[2000];
    memset(name, 'n', sizeof(name) - 1);
    name[sizeof(name) - 1] = '\0';
    struct label_stack labels = {0};
    struct object_names *names = names_create();
    object_names_set(names, VK_OBJECT_TYPE_COMMAND_BUFFER, 0xc0, name);
    for (unsigned i = 0; i <= MESSAGE_LABELS; i++)
        label_push(&labels, i == MESSAGE_LABELS ? name : "x");
    const struct call_origin origin = {
        .command_buffer = COMMAND_BUFFER_HANDLE, .names = names, .labels = &labels};
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_CALL};
    struct finding finding;
    violated_plainly(&finding, "", "is wrong");
    const char *words = word(&location, &origin, &finding);
    assert_has(words, "labels ... > \"x\" > ");
    assert_has(words, "n\".\nThe Vulkan spec states: ");
    assert_int_equal(strlen(message.named.objects[0].pObjectName), MESSAGE_NAME_SIZE - 1);
    assert_int_equal(message.label_count, MESSAGE_LABELS);
    assert_string_equal(message.labels[0].pLabelName, name);
    label_stack_clear(&labels);
    object_names_destroy(names);
}

TEST(test_every_object_has_room)
{
    struct finding finding;
    finding_says(&finding, "", "{} {} {} {} {} {}", object(VK_OBJECT_TYPE_BUFFER, 1),
                 object(VK_OBJECT_TYPE_BUFFER, 2), object(VK_OBJECT_TYPE_BUFFER, 3),
                 object(VK_OBJECT_TYPE_BUFFER, 4), object(VK_OBJECT_TYPE_BUFFER, 5),
                 object(VK_OBJECT_TYPE_DEVICE_MEMORY, 5));
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_CALL};
    const struct call_origin origin = {.command_buffer = COMMAND_BUFFER_HANDLE,
                                       .submission.queue = (VkQueue)(uintptr_t)0x9};
    word(&location, &origin, &finding);
    assert_int_equal(message.named.count, MESSAGE_OBJECTS);
    assert_has(message.text, "VkBuffer 0x5 VkDeviceMemory 0x5.");
}
