/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of setting duplicate_message_limit: messages are limited by VUID and object, and by VUID.
 */
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

HEARD_TEST(test_each_object_has_its_limit, "DUPLICATE_MESSAGE_LIMIT=10")
{
    for (unsigned i = 1; i <= 12; i++) {
        send_buffer(reporter, 0xb);
        assert_int_equal(hearing->count, i <= 10 ? i : 10);
        assert_int_equal(strstr(hearing->text, "reported 10 times for VkBuffer 0xb") != NULL,
                         i >= 10);
        assert_true(reporter_wants(reporter, SENT_VUID)); /* for other objects */
    }
    /* The same mistake on another buffer, on an object of another type with that handle, and on
     * another device. */
    send_buffer(reporter, 0xb0);
    assert_int_equal(hearing->count, 11);
    send_about(reporter, 1, VK_OBJECT_TYPE_DEVICE_MEMORY, 0xb);
    assert_int_equal(hearing->count, 12);
    send_about(reporter, 2, VK_OBJECT_TYPE_BUFFER, 0xb);
    assert_int_equal(hearing->count, 13);
    assert_lacks(hearing->text, "has now been reported");
    send_buffer(reporter, 0xb);
    assert_int_equal(hearing->count, 13);
}

/* Without an object in its sentence, a finding is about the command buffer, or else the device. */
HEARD_TEST(test_findings_without_an_object, "DUPLICATE_MESSAGE_LIMIT=1")
{
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

HEARD_TEST(test_a_vuid_has_ten_times_that, "DUPLICATE_MESSAGE_LIMIT=3")
{
    for (unsigned buffer = 1; buffer <= 40; buffer++) {
        send_buffer(reporter, buffer);
        assert_int_equal(hearing->count, buffer <= 30 ? buffer : 30);
        assert_int_equal(reporter_wants(reporter, SENT_VUID), buffer < 30);
        assert_int_equal(strstr(hearing->text, "reported 30 times and will not") != NULL,
                         buffer >= 30);
    }
    assert_true(reporter_wants(reporter, OTHER_VUID));
}

HEARD_TEST(test_no_limit, "DUPLICATE_MESSAGE_LIMIT=0")
{
    for (unsigned i = 1; i <= 200; i++)
        send_buffer(reporter, 0xb);
    assert_int_equal(hearing->count, 200);
    assert_lacks(hearing->text, "has now been reported");
    assert_true(reporter_wants(reporter, SENT_VUID));
}

/* Ten times this limit is more than a count can hold. */
HEARD_TEST(test_the_largest_limit, "DUPLICATE_MESSAGE_LIMIT=4294967295")
{
    send_buffer(reporter, 0xb);
    assert_int_equal(hearing->count, 1);
}

/* A rule that finds one object again and again, such as a pair of each two builds, stops for the
 * rest of the call; the next object is reported all the same. */
HEARD_TEST(test_many_findings_on_one_object_end_a_call, "DUPLICATE_MESSAGE_LIMIT=10")
{
    unsigned sent = 0;
    do {
        send_buffer(reporter, 0xb);
        sent++;
    } while (reporter_wants(reporter, SENT_VUID) && sent < 100000);
    assert_int_equal(sent, 1010);
    assert_int_equal(hearing->count, 10);
    send_buffer(reporter, 0xb0);
    assert_int_equal(hearing->count, 11);
    assert_true(reporter_wants(reporter, SENT_VUID));
}

HEARD_TEST(test_warnings_of_the_layer, "DUPLICATE_MESSAGE_LIMIT=10")
{
    for (unsigned i = 1; i <= 12; i++)
        reporter_warn(reporter, "odd");
    assert_int_equal(hearing->count, 10);
}

/* Without memory for objects, the limit of the VUID holds. */
HEARD_TEST(test_without_memory, "DUPLICATE_MESSAGE_LIMIT=2")
{
    for (unsigned i = 0; i < 50; i++) {
        memory_is_scarce(0);
        send_buffer(reporter, 0xb);
        memory_fail_no_more();
    }
    assert_true(hearing->count >= 2 && hearing->count <= 20);
}

TEST(test_names_of_ids)
{
    assert_string_equal(reported_id_name(SENT_VUID), SENT_ID);
    assert_string_equal(reported_id_name(MESSAGE_ID_COUNT), difference_id((enum difference)0));
    assert_string_equal(reported_id_name(MESSAGE_ID_COUNT + 1), difference_id((enum difference)1));
}
