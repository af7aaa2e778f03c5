/* SPDX-License-Identifier: Apache-2.0 */
/* Copies and queries of opacity micromaps on backend cpu, through the loader: by the host and by
 * command buffers. */
#include <stdlib.h>

#include "micromap_scene.h"

static uint64_t property(const struct micromap *micromap, VkQueryType type)
{
    uint64_t value = 0;
    GET(vk.WriteMicromapsPropertiesEXT(device, 1, &micromap->ext, type, sizeof(value), &value, 8));
    return value;
}

static void *serialize(const struct micromap *micromap, size_t *size)
{
    *size = property(micromap, VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT);
    void *bytes = own_block(malloc(*size));
    GET(micromap_save_by_host(micromap, bytes));
    return bytes;
}

static void expect_copy(const struct micromap *copy, const void *bytes, size_t size)
{
    size_t copied_size;
    void *copied = serialize(copy, &copied_size);
    assert_int_equal(copied_size, size);
    assert_memory_equal(copied, bytes, size);
}

SILENT_TEST(test_copies_by_host)
{
    struct micromap from, to;
    size_t size;
    micromap_open(&from, true);
    GET(micromap_build_by_host(&from));
    void *bytes = serialize(&from, &size);
    assert_true(property(&from, VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT) <= MICROMAP_SIZE);
    const VkCopyMicromapModeEXT modes[] = {VK_COPY_MICROMAP_MODE_CLONE_EXT,
                                           VK_COPY_MICROMAP_MODE_COMPACT_EXT};
    for (int i = 0; i < 3; i++) {
        micromap_open(&to, true);
        GET(i == 2 ? micromap_load_by_host(bytes, &to)
                   : micromap_copy_by_host(&from, &to, modes[i]));
        expect_copy(&to, bytes, size);
    }
    VkAccelerationStructureCompatibilityKHR compatibility;
    const STRUCT(VkMicromapVersionInfoEXT, version, .pVersionData = bytes);
    vk.GetDeviceMicromapCompatibilityEXT(device, &version, &compatibility);
    assert_int_equal(compatibility, VK_ACCELERATION_STRUCTURE_COMPATIBILITY_COMPATIBLE_KHR);
}

/* Built, cloned, serialized and deserialized by one command buffer each, and queried. */
SILENT_TEST(test_copies_by_device)
{
    struct micromap from, clone, again;
    struct device_buffer bytes = device_buffer_create(MICROMAP_SIZE);
    const VkQueryType type = VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT;
    VkQueryPool pool = query_pool_create(&vk, device, type, 1);
    OWN(DestroyQueryPool, pool);
    size_t size;
    micromap_open(&from, true);
    micromap_open(&clone, true);
    micromap_open(&again, true);
    micromap_build_by_device(&from);
    const STRUCT(VkCopyMicromapToMemoryInfoEXT, to_memory, .src = clone.ext,
                 .dst.deviceAddress = bytes.address, .mode = VK_COPY_MICROMAP_MODE_SERIALIZE_EXT);
    const STRUCT(VkCopyMemoryToMicromapInfoEXT, from_memory, .src.deviceAddress = bytes.address,
                 .dst = again.ext, .mode = VK_COPY_MICROMAP_MODE_DESERIALIZE_EXT);
    VkCommandBuffer commands = device_begin(PRIMARY);
    vk.CmdResetQueryPool(commands, pool, 0, 1);
    micromap_clone_by_device(commands, &from, &clone);
    vk.CmdWriteMicromapsPropertiesEXT(commands, 1, &clone.ext, type, pool, 0);
    vk.CmdCopyMicromapToMemoryEXT(commands, &to_memory);
    device_finish(commands);
    commands = device_begin(PRIMARY);
    vk.CmdCopyMemoryToMicromapEXT(commands, &from_memory);
    device_finish(commands);
    const uint64_t queried = device_query(pool, 0);
    void *expected = serialize(&from, &size);
    assert_int_equal(queried, size);
    expect_copy(&again, expected, size);
}
