/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of setting duplicate_message_limit: messages are limited by VUID and object, and by VUID.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "hearing.h"
#include "src/report/duplicates.h"

#define OTHER_VUID VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12258

static const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_BUILD};

/* A finding about an object of a device. */
static void send_about(struct reporter *reporter, uintptr_t device, VkObjectType type,
                       uint64_t handle)
{
    const struct call_origin origin = {.device = (VkDevice)device,
                                       .command_buffer = (VkCommandBuffer)(uintptr_t)0xc};
    struct finding finding;
    finding_says(&finding, "scratchData", "is {} in {}", number(1), object(type, handle));
    reporter_send(reporter, SENT_RULE, &location, &origin, &finding);
}

static void send_buffer(struct reporter *reporter, uint64_t buffer)
{
    send_about(reporter, 1, VK_OBJECT_TYPE_BUFFER, buffer);
}

static struct reporter *limited(const char *limit, struct hearing *hearing)
{
    *hearing = (struct hearing){0};
    setenv("VK_ASSAY_VALIDATION_DUPLICATE_MESSAGE_LIMIT", limit, 1);
    return reporter_heard_by(hearing);
}

TEST_OPENED(test_each_object_has_its_limit, surrounding_set_up)
{
    static struct hearing hearing;
    struct reporter *reporter = limited("10", &hearing);
    for (unsigned i = 1; i <= 12; i++) {
        send_buffer(reporter, 0xb);
        assert_int_equal(hearing.count, i <= 10 ? i : 10);
        assert_int_equal(strstr(hearing.text, "reported 10 times for VkBuffer 0xb") != NULL,
                         i >= 10);
        assert_true(reporter_wants(reporter, SENT_VUID)); /* for other objects */
    }
    /* The same mistake on another buffer, on an object of another type with that handle, and on
     * another device. */
    send_buffer(reporter, 0xb0);
    assert_int_equal(hearing.count, 11);
    send_about(reporter, 1, VK_OBJECT_TYPE_DEVICE_MEMORY, 0xb);
    assert_int_equal(hearing.count, 12);
    send_about(reporter, 2, VK_OBJECT_TYPE_BUFFER, 0xb);
    assert_int_equal(hearing.count, 13);
    assert_lacks(hearing.text, "has now been reported");
    send_buffer(reporter, 0xb);
    assert_int_equal(hearing.count, 13);
    reporter_destroy(reporter);
}

/* Without an object in its sentence, a finding is about the command buffer, or else the device. */
TEST_OPENED(test_findings_without_an_object, surrounding_set_up)
{
    static struct hearing hearing;
    struct reporter *reporter = limited("1", &hearing);
    struct finding finding;
    violated_plainly(&finding, "", "is wrong");
    for (uintptr_t i = 0; i < 8; i++) {
        const struct call_origin origin = {.device = (VkDevice)(uintptr_t)(1 + (i & 1)),
                                           .command_buffer =
                                               (VkCommandBuffer)(uintptr_t)((i & 2) * 8)};
        reporter_send(reporter, SENT_RULE, &location, &origin, &finding);
    }
    assert_int_equal(hearing.count, 4);
    reporter_destroy(reporter);
}

TEST_OPENED(test_a_vuid_has_ten_times_that, surrounding_set_up)
{
    static struct hearing hearing;
    struct reporter *reporter = limited("3", &hearing);
    for (unsigned buffer = 1; buffer <= 40; buffer++) {
        send_buffer(reporter, buffer);
        assert_int_equal(hearing.count, buffer <= 30 ? buffer : 30);
        assert_int_equal(reporter_wants(reporter, SENT_VUID), buffer < 30);
        assert_int_equal(strstr(hearing.text, "reported 30 times and will not") != NULL,
                         buffer >= 30);
    }
    assert_true(reporter_wants(reporter, OTHER_VUID));
    reporter_destroy(reporter);
}

TEST_OPENED(test_no_limit, surrounding_set_up)
{
    static struct hearing hearing;
    struct reporter *reporter = limited("0", &hearing);
    for (unsigned i = 1; i <= 200; i++)
        send_buffer(reporter, 0xb);
    assert_int_equal(hearing.count, 200);
    assert_lacks(hearing.text, "has now been reported");
    assert_true(reporter_wants(reporter, SENT_VUID));
    reporter_destroy(reporter);

    /* Ten times this limit is more than a count can hold. */
    reporter = limited("4294967295", &hearing);
    send_buffer(reporter, 0xb);
    assert_int_equal(hearing.count, 1);
    reporter_destroy(reporter);
}

/* A rule that finds one object again and again, such as a pair of each two builds, stops for the
 * rest of the call; the next object is reported all the same. */
TEST_OPENED(test_many_findings_on_one_object_end_a_call, surrounding_set_up)
{
    static struct hearing hearing;
    struct reporter *reporter = limited("10", &hearing);
    unsigned sent = 0;
    do {
        send_buffer(reporter, 0xb);
        sent++;
    } while (reporter_wants(reporter, SENT_VUID) && sent < 100000);
    assert_int_equal(sent, 1010);
    assert_int_equal(hearing.count, 10);
    send_buffer(reporter, 0xb0);
    assert_int_equal(hearing.count, 11);
    assert_true(reporter_wants(reporter, SENT_VUID));
    reporter_destroy(reporter);
}

TEST_OPENED(test_warnings_of_the_layer, surrounding_set_up)
{
    static struct hearing hearing;
    struct reporter *reporter = limited("10", &hearing);
    for (unsigned i = 1; i <= 12; i++)
        reporter_warn(reporter, "odd");
    assert_int_equal(hearing.count, 10);
    reporter_destroy(reporter);
}

/* Without memory for objects, the limit of the VUID holds. */
TEST_OPENED(test_without_memory, surrounding_set_up)
{
    static struct hearing hearing;
    struct reporter *reporter = limited("2", &hearing);
    for (unsigned i = 0; i < 50; i++) {
        memory_is_scarce(0);
        send_buffer(reporter, 0xb);
        memory_fail_no_more();
    }
    assert_true(hearing.count >= 2 && hearing.count <= 20);
    reporter_destroy(reporter);
}

TEST(test_names_of_ids)
{
    assert_string_equal(reported_id_name(SENT_VUID), SENT_ID);
    assert_string_equal(reported_id_name(MESSAGE_ID_COUNT), difference_id((enum difference)0));
    assert_string_equal(reported_id_name(MESSAGE_ID_COUNT + 1), difference_id((enum difference)1));
}
