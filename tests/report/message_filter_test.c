/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the entries of message_id_filter. */
#include "hearing.h"
#include "src/report/ids/message_filter.h"
#include "src/report/ids/message_id.h"
#include "src/report/message.h"

/* The entry names `count` ids, and one of them is `vuid`. */
static void assert_filter(const char *entry, unsigned count, enum vuid vuid)
{
    bool muted[MESSAGE_ID_COUNT] = {false};
    assert_int_equal(message_filter_add(muted, entry), count != 0);
    unsigned found = 0;
    for (unsigned i = 0; i < MESSAGE_ID_COUNT; i++)
        found += muted[i];
    assert_int_equal(found, count);
    assert_int_equal(muted[vuid], count != 0);
}

TEST(test_by_id_and_number)
{
    char number[32];
    assert_filter(SENT_ID, 1, SENT_VUID);
    assert_filter("vuid-vkcmdbuildaccelerationstructureskhr-pinfos-03710", 1, SENT_VUID);
    for (enum vuid vuid = VUID_NONE + 1; vuid < VUID_COUNT; vuid += 37) {
        int32_t id_number = message_id_number(vuid_texts[vuid].id);
        snprintf(number, sizeof(number), "0x%x", (uint32_t)id_number);
        assert_filter(number, 1, vuid);
        snprintf(number, sizeof(number), "%u", (uint32_t)id_number);
        assert_filter(number, 1, vuid);
        snprintf(number, sizeof(number), "%d", id_number);
        assert_filter(number, 1, vuid);
    }
}

TEST(test_by_id_of_a_warning)
{
    assert_filter("ASSAY-instance-destroyed", 1, WARNING_instance_destroyed);
}

TEST(test_by_digits)
{
    assert_filter("03710", 2, SENT_VUID); /* of the device command and of the indirect one */
    assert_filter("03710", 2, VUID_vkCmdBuildAccelerationStructuresIndirectKHR_pInfos_03710);
}

TEST(test_by_retired_id)
{
    const char *retired = "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03674";
    assert_filter(retired, 2, VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12261);
    assert_filter(retired, 2, VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12260);

    char number[32]; /* as shown where vuid_names is `listed` */
    snprintf(number, sizeof(number), "0x%x", (uint32_t)message_id_number(retired));
    assert_filter(number, 2, VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12261);
    assert_filter("03674", 2, VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12260);
}

TEST(test_entries_that_name_nothing)
{
    static const char *const entries[] = {
        "", "-", "0x", "3710", "parameter", "99999", "0x1ffffffff", "VUID-vkCmdDraw-None-02699",
    };
    for (size_t i = 0; i < LENGTH(entries); i++)
        assert_filter(entries[i], 0, VUID_NONE);
}
