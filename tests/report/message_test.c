/* SPDX-License-Identifier: Apache-2.0 */
/* The wording of messages: of findings, and what settings add to them and leave out. */
#include "hearing.h"
#include "src/report/finding_message.h"
#include "src/report/ids/message_id.h"
#include "src/state/commands/call_sites.h"

#define DEVICE_HANDLE ((VkDevice)(uintptr_t)0xd0)
#define COMMAND_BUFFER_HANDLE ((VkCommandBuffer)(uintptr_t)0xc0)
#define BUILD "vkCmdBuildAccelerationStructuresKHR(): "
#define INDIRECT "vkCmdBuildAccelerationStructuresIndirectKHR(): "
#define NV "vkCmdBuildAccelerationStructureNV(): "

/* A rule without a hint, and one with a hint and a retired id. */
#define PLAIN_VUID VUID_VkAccelerationStructureTrianglesOpacityMicromapKHR_indexStride_11574
#define RENAMED_VUID VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12258
#define RENAMED "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-12258"
#define RETIRED "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03671"
#define HINT                                                                                       \
    "Pass an address in a VkBuffer with at least buildScratchSize bytes from there on, and keep "  \
    "it until the build has completed."

static struct message message;

/* How a finding is worded. VUID_NONE: PLAIN_VUID. */
struct wording {
    enum vuid vuid;
    struct location location; /* zeros: the device command's call */
    struct call_origin origin;
    struct message_style style;
};

static const char *word_as(const struct wording *how, const struct finding *finding)
{
    message_of_finding(&message, how->vuid ? how->vuid : PLAIN_VUID, &how->location, &how->origin,
                       finding, &how->style);
    return message.text;
}
#define WORD(finding, ...) word_as(&(struct wording){__VA_ARGS__}, finding)

static struct finding wrong(const char *field)
{
    struct finding finding;
    violated_plainly(&finding, field, "is wrong");
    return finding;
}

/* The message of a call that is wrong. */
static const char *say(enum vuid vuid, struct message_style style)
{
    const struct finding finding = wrong("");
    return WORD(&finding, .vuid = vuid, .style = style);
}

static void assert_first_line(const char *text, const char *expected)
{
    char line[MESSAGE_SIZE];
    snprintf(line, sizeof(line), "%.*s", (int)strcspn(text, "\n"), text);
    assert_string_equal(line, expected);
}

TEST(test_id_numbers_are_those_of_the_khronos_layer)
{
    assert_int_equal(message_id_number("VUID-vkDestroyDevice-device-05137"), 0x4872eaa0);
    assert_int_equal(message_id_number("VUID-vkDestroyDevice-device-00378"), 0x71500fba);
}

/* Cases and programs have the other paths. */
TEST(test_paths)
{
    const struct location range = {COMMAND_INDIRECT, SUBJECT_RANGE, 3, 5, false};
    struct finding finding = wrong("");
    assert_first_line(WORD(&finding, .location = range),
                      INDIRECT "ppMaxPrimitiveCounts[3][5] is wrong.");
    finding = wrong("primitiveCount");
    assert_first_line(WORD(&finding, .location = range),
                      INDIRECT "pIndirectDeviceAddresses[3][5].primitiveCount is wrong.");
    finding = wrong(NULL);
    assert_first_line(WORD(&finding, 0), BUILD "is wrong.");
}

TEST(test_values)
{
    struct finding finding;
    finding_says(&finding, "a", "{}, {}, {}, {}, {} and {} {}", hex(0xffffffffffffffff),
                 number(18446744073709551615u), phrase("VK_FORMAT_UNDEFINED"),
                 object(VK_OBJECT_TYPE_BUFFER, 0x12), field_of(7, "dstAccelerationStructure"),
                 object(VK_OBJECT_TYPE_DEVICE_MEMORY, 0));
    assert_first_line(WORD(&finding, 0), BUILD
                      "a 0xffffffffffffffff, 18446744073709551615, VK_FORMAT_UNDEFINED, "
                      "VkBuffer 0x12, pInfos[7].dstAccelerationStructure and "
                      "VK_NULL_HANDLE {}.");
    assert_int_equal(message.named.count, 1);
    finding_says(&finding, "a", "is {}{}, {}", phrase(NULL), object(VK_OBJECT_TYPE_IMAGE, 3),
                 field_of(1, ""));
    assert_first_line(WORD(&finding, 0), BUILD "a is object 0x3, pInfos[1].");
    finding_says(&finding, "a", "has {} of {}", count_of(UINT64_MAX, "index"),
                 count_of(2, "geometry"));
    assert_first_line(WORD(&finding, 0),
                      BUILD "a has 18446744073709551615 indices of 2 geometries.");
}

/* ---- where it was found */

TEST(test_origin)
{
    struct label_stack labels = {0}, queue_labels = {0};
    struct object_names *names = names_create();
    struct wording how = {.location = {COMMAND_DEVICE, SUBJECT_BUILD, 3, 0, false},
                          .origin = {.device = DEVICE_HANDLE,
                                     .command_buffer = COMMAND_BUFFER_HANDLE,
                                     .build_index = 14,
                                     .names = names,
                                     .labels = &labels}};
    struct finding finding;
    finding_says(&finding, "dst", "{} overlaps {}",
                 object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, 0xa),
                 object(VK_OBJECT_TYPE_COMMAND_BUFFER, 0xc0));
    assert_first_line(word_as(&how, &finding), BUILD
                      "pInfos[3].dst VkAccelerationStructureKHR 0xa overlaps VkCommandBuffer 0xc0. "
                      "Command buffer VkCommandBuffer 0xc0, build 17.");

    object_names_set(names, VK_OBJECT_TYPE_COMMAND_BUFFER, 0xc0, "builds");
    object_names_set(names, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, 0xa, "bunny");
    label_push(&labels, "Frame 3");
    label_push(&labels, "BLAS updates");
    assert_first_line(word_as(&how, &finding), BUILD
                      "pInfos[3].dst VkAccelerationStructureKHR 0xa[\"bunny\"] overlaps "
                      "VkCommandBuffer 0xc0[\"builds\"]. Command buffer VkCommandBuffer "
                      "0xc0[\"builds\"], build 17, labels \"Frame 3\" > \"BLAS updates\".");
    assert_int_equal(message.named.count, 2);
    assert_int_equal(message.named.objects[0].objectType, VK_OBJECT_TYPE_COMMAND_BUFFER);
    assert_int_equal(message.named.objects[0].objectHandle, 0xc0);
    assert_string_equal(message.named.objects[0].pObjectName, "builds");
    assert_int_equal(message.named.objects[1].objectHandle, 0xa);
    assert_string_equal(message.named.objects[1].pObjectName, "bunny");
    assert_int_equal(message.label_count, 2);
    assert_string_equal(message.labels[0].pLabelName, "BLAS updates");
    assert_string_equal(message.labels[1].pLabelName, "Frame 3");

    how.location.subject = SUBJECT_CALL;
    label_push(&queue_labels, "frame\n");
    struct shared_labels shared = {.stack = queue_labels};
    how.origin.submission = (struct submission_origin){
        .queue = (VkQueue)(uintptr_t)0x9, .number = 3, .labels = &shared};
    assert_has(word_as(&how, &finding),
               "0xc0[\"builds\"], labels \"Frame 3\" > \"BLAS updates\", as submitted to VkQueue "
               "0x9, submission 3, queue labels \"frame\\n\".\n");
    assert_int_equal(message.queue_label_count, 1);

    how.origin.command_buffer = VK_NULL_HANDLE;
    assert_lacks(word_as(&how, &finding), "Command buffer");
    assert_int_equal(message.named.objects[0].objectType, VK_OBJECT_TYPE_DEVICE);
    assert_null(message.named.objects[0].pObjectName);
    label_stack_clear(&labels);
    label_stack_clear(&queue_labels);
    object_names_destroy(names);
}

TEST(test_a_call_site_is_named_by_its_first_frames)
{
    struct call_site site = {6,
                             {{"/a/\"b\n", 0x1139}, {NULL, 7}, {"/c", 8}, {"/d", 9}, {"/e", 10}}};
    const struct finding finding = wrong("");
    assert_has(WORD(&finding, .origin.call_site = &site),
               ". Called from /a/\\\"b\\n+0x1139, unknown module+0x7, /c+0x8, /d+0x9.");
    site.count = 1;
    assert_has(WORD(&finding, .origin.call_site = &site), " Called from /a/\\\"b\\n+0x1139.");
}

/* ---- the specification's sentence, the hint before it, and ids */

TEST(test_specification)
{
    char expected[MESSAGE_SIZE];
    for (enum vuid vuid = VUID_NONE + 1; vuid < VUID_COUNT; vuid++) {
        const struct vuid_text *stated = &vuid_texts[vuid];
        const char *hint = rule_infos[rule_of_vuid(vuid)].hint;
        if (!stated->sentence[0])
            continue;
        say(vuid, (struct message_style){0});
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
    say(VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12261, (struct message_style){0});
    assert_has(message.text,
               ") (formerly VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03674, "
               "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03802)");
}

/* Each sentence is cut at a word, and only if it is longer than 160 characters. */
TEST(test_a_short_sentence)
{
    const struct message_style style = {.spec_text = SPEC_TEXT_SHORT};
    static const char states[] = "\nThe Vulkan spec states: ";
    unsigned cut = 0, whole = 0;
    for (enum vuid vuid = VUID_NONE + 1; vuid < VUID_COUNT; vuid++) {
        const struct vuid_text *stated = &vuid_texts[vuid];
        char expected[512];
        if (!stated->sentence[0])
            continue;
        const char *words = strstr(say(vuid, style), states);
        assert_non_null(words);
        words += strlen(states);
        snprintf(expected, sizeof(expected), " (https://docs.vulkan.org/spec/latest/%s#%s)",
                 stated->page, stated->id);
        const char *after = strstr(words, expected);
        assert_non_null(after);
        size_t length = (size_t)(after - words), full = strlen(stated->sentence);
        if (full <= 160) {
            assert_int_equal(length, full);
            whole++;
            continue;
        }
        assert_memory_equal(after - 3, "...", 3);
        length -= 3;
        assert_memory_equal(words, stated->sentence, length);
        assert_int_equal(stated->sentence[length], ' ');
        /* The next word does not fit. */
        const char *next = strchr(stated->sentence + length + 1, ' ');
        assert_true(length <= 160);
        assert_true(!next || next - stated->sentence > 160);
        cut++;
    }
    assert_true(cut > 100);
    assert_true(whole > 100);
}

/* What styles add to the text of a call that is wrong, and leave out. */
TEST(test_styles)
{
#define FURTHER                                                                                    \
    " for VkBuffer 0xb and will not be reported for it again: duplicate_message_limit is "         \
    "reached. At most 90 more follow for other objects."
    static const struct {
        enum vuid vuid;
        bool has_buffer;
        struct message_style style;
        const char *end;
    } rows[] = {
        {PLAIN_VUID, false, {.spec_text = SPEC_TEXT_NONE}, "(): is wrong."},
        {RENAMED_VUID,
         false,
         {.spec_text = SPEC_TEXT_NONE},
         "(): is wrong. " HINT " (formerly " RETIRED ")"},
        {RENAMED_VUID,
         false,
         {.spec_text = SPEC_TEXT_NONE, .vuid_names = VUID_NAMES_LISTED},
         "(): is wrong. " HINT " (today " RENAMED ")"},
        {RENAMED_VUID, false, {.vuid_names = VUID_NAMES_LISTED}, ") (today " RENAMED ")"},
        {SENT_VUID,
         true,
         {.last = LAST_OF_OBJECT, .sent = 10, .left = 90},
         "\nThis VUID has now been reported 10 times" FURTHER},
        {SENT_VUID,
         true,
         {.last = LAST_OF_OBJECT, .sent = 1, .left = 90, .are_counted = true},
         " reported 1 time" FURTHER " Further ones are only counted."},
        {SENT_VUID,
         true,
         {.last = LAST_OF_ID, .sent = 100},
         "\nThis VUID has now been reported 100 times and will not be reported again: ten times "
         "duplicate_message_limit is reached."},
    };
    for (size_t i = 0; i < LENGTH(rows); i++) {
        struct finding finding = wrong("");
        if (rows[i].has_buffer)
            finding_says(&finding, "", "has {}", object(VK_OBJECT_TYPE_BUFFER, 0xb));
        const char *text = WORD(&finding, .vuid = rows[i].vuid, .style = rows[i].style);
        const size_t length = strlen(text), expected = strlen(rows[i].end);
        assert_true(length >= expected);
        assert_string_equal(text + length - expected, rows[i].end);
    }
}

/* The id, its number and the heading go by vuid_names, too. */
TEST(test_a_message_may_go_by_the_retired_id)
{
    say(RENAMED_VUID, (struct message_style){.vuid_names = VUID_NAMES_LISTED});
    assert_string_equal(message.id, RETIRED);
    assert_int_equal(message.id_number, message_id_number(RETIRED));
    assert_has(message.heading, "Error: [ " RETIRED " ] | MessageID = 0x");
    assert_has(message.text, vuid_texts[RENAMED_VUID].sentence);
    say(SENT_VUID, (struct message_style){.vuid_names = VUID_NAMES_LISTED}); /* has none */
    assert_string_equal(message.id, SENT_ID);
    assert_lacks(message.text, "today");
}

/* No sentence of the specification goes with an id of the layer's own. */
TEST(test_a_warning_of_the_layers_own)
{
    struct finding finding;
    finding_fill(&finding, "instanceData", "is odd", NULL, 0);
    assert_string_equal(
        WORD(&finding, .vuid = WARNING_instance_destroyed,
             .location = {.command = COMMAND_NV, .subject = SUBJECT_PARAMETER},
             .style = {.vuid_names = VUID_NAMES_LISTED, .last = LAST_OF_ID, .sent = 100}),
        NV
        "instanceData is odd. Destroy the structure only after the build has completed.\n"
        "This warning has now been reported 100 times and will not be reported again: ten times "
        "duplicate_message_limit is reached.");
    assert_int_equal(message.severity, REPORT_WARNING);
    assert_string_equal(message.id, "ASSAY-instance-destroyed");
    assert_has(message.heading, "Validation Warning: [ ASSAY-instance-destroyed ] | MessageID");
}

/* The message of a rule, for pInfos[0] of a command. */
static const char *word_rule(enum rule rule, enum build_command command,
                             const struct finding *finding)
{
    return WORD(finding, .vuid = rule_infos[rule].vuid[command],
                .location = {.command = command, .subject = SUBJECT_BUILD});
}

/* The id of a command is named with the messages of that command. */
TEST(test_other_ids_of_the_mistake_are_named)
{
    struct finding finding;
    finding_fill(&finding, "mode", "is odd", NULL, 0);
    also_violates(&finding, RULE_indirect_build_ranges_are_valid);
    assert_lacks(word_rule(RULE_build_mode_is_valid, COMMAND_DEVICE, &finding), "(also");
    assert_has(
        word_rule(RULE_build_mode_is_valid, COMMAND_INDIRECT, &finding),
        " (also VUID-vkCmdBuildAccelerationStructuresIndirectKHR-pIndirectDeviceAddresses-03651)"
        "\nThe Vulkan spec states: ");
    also_violates(&finding, RULE_build_flags_are_valid);
    assert_has(
        word_rule(RULE_build_mode_is_valid, COMMAND_INDIRECT, &finding),
        " (also VUID-vkCmdBuildAccelerationStructuresIndirectKHR-pIndirectDeviceAddresses-03651, "
        "VUID-VkAccelerationStructureBuildGeometryInfoKHR-flags-parameter)\n");
    assert_has(word_rule(RULE_build_mode_is_valid, COMMAND_HOST, &finding),
               " (also VUID-VkAccelerationStructureBuildGeometryInfoKHR-flags-parameter)\n");
    finding_fill(&finding, "mode", "is odd", NULL, 0);
    assert_lacks(word_rule(RULE_build_mode_is_valid, COMMAND_INDIRECT, &finding), "(also");
    also_violates(&finding, RULE_build_flags_are_valid);
    is_reported_with(&finding, RULE_build_flags_are_valid);
    assert_lacks(word_rule(RULE_build_mode_is_valid, COMMAND_DEVICE, &finding), "(also");
    /* A caller that needs the result of a predicate passes no finding. */
    assert_false(also_violates(NULL, RULE_build_flags_are_valid));
    assert_false(is_reported_with(NULL, RULE_build_flags_are_valid));
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
    const struct finding finding = wrong("");
    const char *words = WORD(
        &finding,
        .origin = {.command_buffer = COMMAND_BUFFER_HANDLE, .names = names, .labels = &labels});
    assert_has(words, "labels ... > \"x\" > ");
    assert_has(words, "n\".\nThe Vulkan spec states: ");
    assert_int_equal(strlen(message.named.objects[0].pObjectName), MESSAGE_NAME_SIZE - 1);
    assert_int_equal(message.label_count, MESSAGE_LABELS);
    assert_string_equal(message.labels[0].pLabelName, name);
    label_stack_clear(&labels);
    object_names_destroy(names);
}

/* The notice has room of its own. */
TEST(test_too_much_text_is_cut)
{
    static char much[20000];
    for (size_t i = 0; i + 2 < sizeof(much); i += 2)
        memcpy(much + i, "\xc3\xa9", 2); /* é */
    struct finding finding;
    finding_says(&finding, "a", "is {} of {}", phrase(much),
                 object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, UINT64_MAX));
    WORD(
        &finding, .vuid = SENT_VUID,
        .style = {
            .last = LAST_OF_OBJECT, .sent = 4000000000u, .left = 4000000000u, .are_counted = true});
    assert_true(strlen(message.heading) < MESSAGE_SIZE);
    assert_has(message.text,
               "\xc3\xa9...\nThis VUID has now been reported 4000000000 times for "
               "VkAccelerationStructureKHR 0xffffffffffffffff and");
    const char *end = " Further ones are only counted.";
    assert_string_equal(message.text + strlen(message.text) - strlen(end), end);
}
