/* SPDX-License-Identifier: Apache-2.0 */
/* The wording of messages: of findings, and what settings add to them and leave out. */
#include "hearing.h"
#include "src/report/finding_message.h"
#include "src/report/ids/message_id.h"
#include "src/state/commands/call_sites.h"

#define DEVICE_HANDLE ((VkDevice)(uintptr_t)0xd0)
#define COMMAND_BUFFER_HANDLE ((VkCommandBuffer)(uintptr_t)0xc0)

static struct message message;

/* A rule without a hint. */
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

/* ---- what settings add to a message and leave out of it */

#define LINK "https://docs.vulkan.org/spec/latest/"

/* A rule without a hint. */
#define PLAIN_VUID VUID_VkAccelerationStructureTrianglesOpacityMicromapKHR_indexStride_11574
#define HINT_OF_12258                                                                              \
    "Pass an address in a VkBuffer with at least buildScratchSize bytes from there on, and keep "  \
    "it until the build has completed."

static struct message message;

/* The message of a call that is wrong, about a buffer if `buffer` is not 0. */
static const char *say_styled(enum vuid vuid, uint64_t buffer, const struct message_style *style)
{
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_CALL};
    struct finding finding;
    if (buffer)
        finding_says(&finding, "", "has {}", object(VK_OBJECT_TYPE_BUFFER, buffer));
    else
        violated_plainly(&finding, "", "is wrong");
    message_of_finding(&message, vuid, &location, &(struct call_origin){0}, &finding, style);
    return message.text;
}

/* ---- the specification's sentence */

/* Each sentence is cut at a word, and only if it is longer than 160 characters. */
TEST(test_a_short_sentence)
{
    const struct message_style style = {.spec_text = SPEC_TEXT_SHORT};
    static const char before[] = "vkCmdBuildAccelerationStructuresKHR(): is wrong.";
    static const char states[] = "\nThe Vulkan spec states: ";
    unsigned cut = 0, whole = 0;
    for (enum vuid vuid = VUID_NONE + 1; vuid < VUID_COUNT; vuid++) {
        const struct vuid_text *stated = &vuid_texts[vuid];
        char expected[512];
        if (!stated->sentence[0])
            continue;
        const char *words = say_styled(vuid, 0, &style);
        assert_memory_equal(words, before, strlen(before));
        words = strstr(words, states); /* a hint comes first, if the row has one */
        assert_non_null(words);
        words += strlen(states);
        snprintf(expected, sizeof(expected), " (" LINK "%s#%s)", stated->page, stated->id);
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

TEST(test_no_sentence)
{
    struct message_style style = {.spec_text = SPEC_TEXT_NONE};
    assert_string_equal(say_styled(PLAIN_VUID, 0, &style),
                        "vkCmdBuildAccelerationStructuresKHR(): is wrong.");
    assert_string_equal(
        say_styled(VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12258, 0, &style),
        "vkCmdBuildAccelerationStructuresKHR(): is wrong. " HINT_OF_12258
        " (formerly "
        "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03671)");
    style.vuid_names = VUID_NAMES_LISTED;
    assert_string_equal(
        say_styled(VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12258, 0, &style),
        "vkCmdBuildAccelerationStructuresKHR(): is wrong. " HINT_OF_12258
        " (today "
        "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-12258)");
}

TEST_OPENED(test_the_setting, surrounding_set_up)
{
    static const struct {
        const char *value, *has, *lacks;
    } cases[] = {
        {"full", ".\nThe Vulkan spec states: For each", "..."},
        {"short", "... (" LINK, "\xff"},
        {"none", "256).", "spec states"},
    };
    for (size_t i = 0; i < LENGTH(cases); i++) {
        struct hearing hearing = {0};
        setenv("VK_ASSAY_VALIDATION_SPEC_TEXT", cases[i].value, 1);
        struct reporter *reporter = reporter_heard_by(&hearing);
        send_one(reporter);
        reporter_destroy(reporter);
        assert_has(hearing.text, cases[i].has);
        assert_lacks(hearing.text, cases[i].lacks);
    }
    unsetenv("VK_ASSAY_VALIDATION_SPEC_TEXT");
}

/* ---- the last message */

TEST(test_last_of_an_object)
{
    struct message_style style = {.last = LAST_OF_OBJECT, .sent = 10, .left = 90};
    const char *words = say_styled(SENT_VUID, 0xb, &style);
    assert_has(words,
               "\nThis VUID has now been reported 10 times for VkBuffer 0xb and will "
               "not be reported for it again: duplicate_message_limit is reached. At "
               "most 90 more follow for other objects.");
    style.sent = 1;
    assert_has(say_styled(SENT_VUID, 0xb, &style), "reported 1 time for VkBuffer 0xb and");
    style.are_counted = true;
    assert_has(say_styled(SENT_VUID, 0xb, &style), " objects. Further ones are only counted.");
}

TEST(test_last_of_an_id)
{
    const struct message_style style = {.last = LAST_OF_ID, .sent = 100};
    assert_has(say_styled(SENT_VUID, 0xb, &style),
               "\nThis VUID has now been reported 100 times and will not be reported "
               "again: ten times duplicate_message_limit is reached.");
}

/* The notice has room of its own. */
TEST(test_too_much_text_is_cut)
{
    static char much[20000];
    for (size_t i = 0; i + 2 < sizeof(much); i += 2)
        memcpy(much + i, "\xc3\xa9", 2); /* é */
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_CALL};
    const struct message_style style = {
        .last = LAST_OF_OBJECT, .sent = 4000000000u, .left = 4000000000u, .are_counted = true};
    struct finding finding;
    finding_says(&finding, "a", "is {} of {}", phrase(much),
                 object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, UINT64_MAX));
    message_of_finding(&message, SENT_VUID, &location, &(struct call_origin){0}, &finding, &style);
    assert_true(strlen(message.heading) < MESSAGE_SIZE);
    assert_has(message.text,
               "\xc3\xa9...\nThis VUID has now been reported 4000000000 times for "
               "VkAccelerationStructureKHR 0xffffffffffffffff and");
    const char *end = " Further ones are only counted.";
    assert_string_equal(message.text + strlen(message.text) - strlen(end), end);
}

/* ---- the submission */

TEST_OPENED(test_submission, surrounding_set_up)
{
    struct label_stack labels = {0};
    struct shared_labels queue_labels = {0};
    struct hearing hearing = {0};
    struct reporter *reporter = reporter_heard_by(&hearing);
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_CALL};
    struct call_origin origin = {
        .command_buffer = (VkCommandBuffer)(uintptr_t)0xc,
        .labels = &labels,
        .submission = {.queue = (VkQueue)(uintptr_t)0x9, .number = 3, .labels = &queue_labels}};
    struct finding finding;
    violated_plainly(&finding, "", "is wrong");
    label_push(&labels, "build");
    label_push(&queue_labels.stack, "frame\n");
    label_push(&queue_labels.stack, "pass");
    reporter_send(reporter, SENT_RULE, &location, &origin, &finding);
    assert_has(hearing.text,
               "Command buffer VkCommandBuffer 0xc, labels \"build\", as submitted to "
               "VkQueue 0x9, submission 3, queue labels \"frame\\n\" > \"pass\".\n");
    assert_int_equal(hearing.label_count, 1);
    assert_int_equal(hearing.queue_label_count, 2);

    origin.submission.number = 0;
    origin.submission.labels = NULL;
    reporter_send(reporter, SENT_RULE, &location, &origin, &finding);
    assert_has(hearing.text, "as submitted to VkQueue 0x9.\n");
    assert_int_equal(hearing.queue_label_count, 0);
    reporter_destroy(reporter);
    label_stack_clear(&labels);
    label_stack_clear(&queue_labels.stack);
}

/* ---- what messages say beside the finding: counts with their nouns, hints, and the other ids that
 * the same mistake violates */

static struct message message;

static const char *word_rule(enum rule rule, enum build_command command,
                             const struct finding *finding)
{
    const struct location location = {.command = command, .subject = SUBJECT_BUILD};
    message_of_finding(&message, rule_infos[rule].vuid[command], &location,
                       &(struct call_origin){0}, finding, &(struct message_style){0});
    return message.text;
}

static void assert_counted(uint64_t count, const char *noun, const char *expected)
{
    struct finding finding;
    finding_says(&finding, "a", "has {}", count_of(count, noun));
    const char *text = word_rule(RULE_opacity_index_stride_fits_32_bits, COMMAND_DEVICE, &finding);
    const char *found = strstr(text, " has ");
    assert_non_null(found);
    assert_int_equal(strncmp(found + strlen(" has "), expected, strlen(expected)), 0);
}

TEST(test_counts_agree_with_their_nouns)
{
    assert_counted(0, "byte", "0 bytes.");
    assert_counted(1, "byte", "1 byte.");
    assert_counted(2, "byte", "2 bytes.");
    assert_counted(UINT64_MAX, "byte", "18446744073709551615 bytes.");
    assert_counted(1, "vertex", "1 vertex.");
    assert_counted(3, "vertex", "3 vertices.");
    assert_counted(3, "index", "3 indices.");
    assert_counted(1, "geometry", "1 geometry.");
    assert_counted(2, "geometry", "2 geometries.");
    assert_counted(21, "AABB", "21 AABBs.");
    assert_counted(4096, "ray", "4096 rays.");
}

TEST(test_the_hint_is_the_second_sentence)
{
    struct finding finding;
    finding_fill(&finding, "flags", "are odd", NULL, 0);
    assert_has(word_rule(RULE_fast_trace_excludes_fast_build, COMMAND_HOST, &finding),
               "(): pInfos[0].flags are odd. Clear one of the two flags.\n");
    assert_has(word_rule(RULE_opacity_index_stride_fits_32_bits, COMMAND_HOST, &finding),
               "(): pInfos[0].flags are odd.\n");
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

TEST(test_a_call_site_is_named_by_its_first_frames)
{
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_BUILD};
    struct call_site site = {6,
                             {{"/a/\"b\n", 0x1139}, {NULL, 7}, {"/c", 8}, {"/d", 9}, {"/e", 10}}};
    const struct call_origin origin = {.call_site = &site};
    const struct message_style style = {.spec_text = SPEC_TEXT_NONE};
    struct finding finding;
    finding_fill(&finding, "mode", "is odd", NULL, 0);
    message_of_finding(&message, rule_infos[RULE_build_mode_is_valid].vuid[COMMAND_DEVICE],
                       &location, &origin, &finding, &style);
    assert_non_null(strstr(
        message.text, ". Called from /a/\\\"b\\n+0x1139, unknown module+0x7, /c+0x8, /d+0x9."));
    site.count = 1;
    message_of_finding(&message, rule_infos[RULE_build_mode_is_valid].vuid[COMMAND_DEVICE],
                       &location, &origin, &finding, &style);
    assert_non_null(strstr(message.text, " Called from /a/\\\"b\\n+0x1139."));
}
