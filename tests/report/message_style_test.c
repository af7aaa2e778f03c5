/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of what settings add to a message and leave out of it. */
#include "hearing.h"
#include "src/report/finding_message.h"

#define LINK "https://docs.vulkan.org/spec/latest/"

/* A rule without a hint. */
#define PLAIN_VUID VUID_VkAccelerationStructureTrianglesOpacityMicromapKHR_indexStride_11574
#define HINT_OF_12258                                                                              \
    "Pass an address in a VkBuffer with at least buildScratchSize bytes from there on, and keep "  \
    "it until the build has completed."

static struct message message;

/* The message of a call that is wrong, about a buffer if `buffer` is not 0. */
static const char *say(enum vuid vuid, uint64_t buffer, const struct message_style *style)
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
        const char *words = say(vuid, 0, &style);
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
    assert_string_equal(say(PLAIN_VUID, 0, &style),
                        "vkCmdBuildAccelerationStructuresKHR(): is wrong.");
    assert_string_equal(say(VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12258, 0, &style),
                        "vkCmdBuildAccelerationStructuresKHR(): is wrong. " HINT_OF_12258
                        " (formerly "
                        "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03671)");
    style.vuid_names = VUID_NAMES_LISTED;
    assert_string_equal(say(VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12258, 0, &style),
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
    const char *words = say(SENT_VUID, 0xb, &style);
    assert_has(words,
               "\nThis VUID has now been reported 10 times for VkBuffer 0xb and will "
               "not be reported for it again: duplicate_message_limit is reached. At "
               "most 90 more follow for other objects.");
    style.sent = 1;
    assert_has(say(SENT_VUID, 0xb, &style), "reported 1 time for VkBuffer 0xb and");
    style.are_counted = true;
    assert_has(say(SENT_VUID, 0xb, &style), " objects. Further ones are only counted.");
}

TEST(test_last_of_an_id)
{
    const struct message_style style = {.last = LAST_OF_ID, .sent = 100};
    assert_has(say(SENT_VUID, 0xb, &style),
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
