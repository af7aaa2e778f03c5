/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the tables: ids, rows and texts fit together. */
#include <ctype.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "tests/unit/unit_test.h"
#include "vuid-tables/registry.h"
#include "vuid-tables/rules.h"

TEST(test_no_id_is_no_row)
{
    assert_int_equal(rule_of_vuid(VUID_NONE), RULE_COUNT);
}

TEST(test_every_row_is_whole)
{
    for (int rule = 0; rule < RULE_COUNT; rule++) {
        const struct rule_info *row = &rule_infos[rule];
        assert_non_null(row->name);
        assert_in_range(row->level, 0, LEVEL_COUNT - 1);
        bool decided = row->subject != NULL, pending = row->waits_for != NULL;
        if (decided == pending)
            fail_msg("%s is both decided and pending, or neither", row->name);
        bool has_id = false;
        for (int command = 0; command < COMMAND_COUNT; command++)
            has_id |= row->vuid[command] != VUID_NONE;
        if (!has_id)
            fail_msg("%s has no id", row->name);
    }
}

static bool is_only_for_nv(const struct rule_info *row)
{
    return row->vuid[COMMAND_DEVICE] == VUID_NONE && row->vuid[COMMAND_NV] != VUID_NONE;
}

/* The registry has an id of one command under the name of another one. */
static bool is_misnamed(enum vuid vuid, int command)
{
    return vuid == VUID_vkCmdCopyAccelerationStructureToMemoryKHR_pInfo_11700 &&
           command == COMMAND_CmdCopyMemoryToAccelerationStructureKHR;
}

/* A row's id of a command is one of that command, or of a structure: then it is every build
 * command's, or the NV command's alone, or that of other commands. */
TEST(test_columns_are_of_their_command)
{
    for (int rule = 0; rule < RULE_COUNT; rule++)
        for (int command = 0; command < COMMAND_COUNT; command++) {
            enum vuid vuid = rule_infos[rule].vuid[command];
            if (vuid == VUID_NONE || vuid_is_warning(vuid))
                continue;
            const char *scope = vuid_texts[vuid].id + strlen("VUID-");
            const char *name = build_command_name((enum build_command)command);
            bool of_structure = strncmp(scope, "Vk", 2) == 0;
            bool of_command = strncmp(scope, name, strlen(name)) == 0 && scope[strlen(name)] == '-';
            if (!of_structure && !of_command && !is_misnamed(vuid, command))
                fail_msg("%s stands in the column of %s", vuid_texts[vuid].id, name);
            bool is_shared =
                of_structure && command < BUILD_COMMAND_COUNT && !is_only_for_nv(&rule_infos[rule]);
            for (int other = 0; is_shared && other < BUILD_COMMAND_COUNT; other++)
                assert_int_equal(rule_infos[rule].vuid[other], vuid);
        }
}

/* A hint is one imperative, or two, and fits a line or two of a message. */
TEST(test_hints_are_well_formed)
{
    int count = 0;
    for (int rule = 0; rule < RULE_COUNT; rule++) {
        const char *hint = rule_infos[rule].hint;
        if (!hint)
            continue;
        size_t length = strlen(hint);
        if (!length || length > HINT_LENGTH || hint[length - 1] != '.' || !isupper(hint[0]))
            fail_msg("%s: not a short sentence: %s", rule_infos[rule].name, hint);
        for (const char *at = hint; *at; at++)
            if (strncmp(at, "VUID", 4) == 0 || strspn(at, "0123456789") >= 5 || !isprint(*at) ||
                (at[0] == ' ' && at[1] == ' '))
                fail_msg("%s: names an id, or is not plain text: %s", rule_infos[rule].name, hint);
        count++;
    }
    assert_true(count >= 100);
}

static uint32_t message_id_number(enum vuid vuid)
{
    return XXH32(vuid_texts[vuid].id, strlen(vuid_texts[vuid].id), 8);
}

TEST(test_message_id_numbers_are_unique)
{
    for (int a = VUID_NONE + 1; a < VUID_COUNT; a++)
        for (int b = a + 1; b < VUID_COUNT; b++)
            assert_int_not_equal(message_id_number((enum vuid)a), message_id_number((enum vuid)b));
}

TEST(test_texts_are_plain)
{
    bool same_registry = strcmp(registry_version, "1.4.363") == 0;
    for (int vuid = VUID_NONE + 1; vuid < VUID_COUNT; vuid++) {
        const struct vuid_text *text = &vuid_texts[vuid];
        assert_int_equal(strncmp(text->id, "VUID-", 5), 0);
        /* A newer registry may have dropped ids; this one has all. */
        if (same_registry && (*text->sentence == '\0' || *text->page == '\0'))
            fail_msg("%s has no sentence or no page", text->id);
        if (strpbrk(text->sentence, "\n\t`") || strstr(text->sentence, "</") ||
            strstr(text->sentence, "&#") || strstr(text->sentence, "  "))
            fail_msg("%s is not plain: %s", text->id, text->sentence);
    }
}

TEST(test_retired_ids_have_a_successor)
{
    static const struct {
        const char *id;
        enum vuid current;
        const char *field;
    } retired[] = {
#define RETIRED(id, current, field) {id, VUID_##current, field},
#include "vuid-tables/retired.def"
#undef RETIRED
    };
    for (size_t i = 0; i < sizeof(retired) / sizeof(retired[0]); i++) {
        assert_in_range(retired[i].current, VUID_NONE + 1, VUID_COUNT - 1);
        for (int vuid = VUID_NONE + 1; vuid < VUID_COUNT; vuid++)
            assert_string_not_equal(retired[i].id, vuid_texts[vuid].id);
        unsigned n = 0;
        const char *id = vuid_retired(retired[i].current, n);
        while (id && strcmp(id, retired[i].id) != 0)
            id = vuid_retired(retired[i].current, ++n);
        assert_non_null(id);
    }
    assert_null(vuid_retired(VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_03403, 0));
}

TEST(test_a_retired_id_is_of_its_command_and_field)
{
#define DIRECT "VUID-vkCmdBuildAccelerationStructuresKHR-"
    static const struct {
        enum vuid vuid;
        enum build_command command;
        const char *field, *listed;
    } cases[] = {
        {VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_10126, COMMAND_DEVICE,
         "dstAccelerationStructure", DIRECT "pInfos-03675"},
        {VUID_vkBuildAccelerationStructuresKHR_pInfos_10126, COMMAND_HOST,
         "dstAccelerationStructure", NULL},
        {VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12260, COMMAND_DEVICE,
         "scratchData.deviceAddress", DIRECT "pInfos-03674"},
        {VUID_VkDeviceAddress_None_10894, COMMAND_DEVICE,
         "geometry.triangles.vertexData.deviceAddress", DIRECT "pInfos-03805"},
        {VUID_VkDeviceAddress_None_10894, COMMAND_DEVICE,
         "geometry.triangles.indexData.deviceAddress", DIRECT "pInfos-03807"},
        {VUID_VkDeviceAddress_None_10894, COMMAND_DEVICE,
         "geometry.triangles.transformData.deviceAddress", DIRECT "pInfos-03809"},
        {VUID_VkDeviceAddress_None_10894, COMMAND_DEVICE, "geometry.aabbs.data.deviceAddress",
         DIRECT "pInfos-03812"},
        {VUID_VkDeviceAddress_None_10894, COMMAND_DEVICE, "geometry.instances.data.deviceAddress",
         DIRECT "pInfos-03814"},
        {VUID_VkDeviceAddress_None_10894, COMMAND_DEVICE, "geometry.triangles.pNext", NULL},
        {VUID_VkDeviceAddress_None_10894, COMMAND_INDIRECT,
         "geometry.triangles.vertexData.deviceAddress", NULL},
        {VUID_VkAccelerationStructureBuildGeometryInfoKHR_flags_11558, COMMAND_INDIRECT, "flags",
         "VUID-VkAccelerationStructureBuildGeometryInfoKHR-flags-07334"},
        {VUID_vkCmdBuildAccelerationStructureNV_accelerationStructureReference_12264, COMMAND_NV,
         "instanceData",
         "VUID-vkCmdBuildAccelerationStructureNV-accelerationStructureReference-03786"},
        {VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_03403, COMMAND_DEVICE, "", NULL},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        const char *listed = vuid_listed(cases[i].vuid, cases[i].command, cases[i].field);
        if (cases[i].listed)
            assert_string_equal(listed, cases[i].listed);
        else
            assert_null(listed);
    }
}

TEST(test_registry_knows_its_extensions)
{
    for (size_t i = 0; i < registry_extension_count; i++) {
        assert_true(registry_knows_extension(registry_extensions[i]));
        assert_true(i == 0 || strcmp(registry_extensions[i - 1], registry_extensions[i]) < 0);
    }
    assert_true(registry_knows_extension("VK_KHR_acceleration_structure"));
    assert_false(registry_knows_extension("VK_KHR_acceleration_structur"));
    assert_false(registry_knows_extension(""));
}

TEST(test_registry_knows_ray_tracing)
{
    assert_true(registry_is_ray_tracing("VK_KHR_acceleration_structure"));
    assert_true(registry_is_ray_tracing("VK_KHR_ray_query"));
    assert_true(registry_is_ray_tracing("VK_NV_displacement_micromap")); /* through another one */
    assert_false(registry_is_ray_tracing("VK_KHR_buffer_device_address"));
    assert_false(registry_is_ray_tracing("VK_KHR_device_address_commands"));
}

TEST(test_registry_knows_structures)
{
    const struct registry_structure *found =
        registry_find_structure(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR);
    assert_non_null(found);
    assert_int_equal(found->size, sizeof(VkPhysicalDeviceRayQueryFeaturesKHR));
    assert_string_equal(found->ray_tracing, "VkPhysicalDeviceRayQueryFeaturesKHR");
    assert_int_equal(found->feature_count, 1);
    found = registry_find_structure(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
    assert_non_null(found);
    assert_int_equal(found->size, sizeof(VkPhysicalDeviceVulkan12Features));
    assert_null(found->ray_tracing);
    found =
        registry_find_structure(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR);
    assert_non_null(found);
    assert_null(found->ray_tracing);
    assert_null(registry_find_structure(VK_STRUCTURE_TYPE_MAX_ENUM));
}
