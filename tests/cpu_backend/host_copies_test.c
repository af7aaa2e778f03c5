/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu through the loader: clones and compaction, properties, and structures that go to
 * memory and come back elsewhere. The valid calls are silent. */
#include "host_fixture.h"

#include <stdlib.h>

NOISY_TEST(test_copies)
{
    open_pair(100, COMPACTABLE | UPDATABLE);
    uint64_t size = fixture_property(pair.blas.handle, COMPACTED_SIZE);
    assert_true(size > 0 && size <= pair.blas.size);
    assert_int_equal(fixture_property(pair.blas.handle, STRUCTURE_SIZE), pair.blas.size);
    struct fixture_structure compact = fixture_create_blas(size);
    struct fixture_structure clone = fixture_create_blas(pair.blas.size);
    GET(host_copy(pair.blas.handle, compact.handle, COMPACT));
    GET(host_copy(pair.blas.handle, clone.handle, CLONE));
    messages_expect_none(messages);
    assert_int_equal(fixture_property(compact.handle, STRUCTURE_SIZE), size);
    fixture_move(&pair.triangles, 2, 0, 0);
    GET(host_build(&pair.triangles, compact.handle, compact.handle));
    assert_float_equal(fixture_trace(compact.handle, 0.25f, 0.25f).t, 3, 0);
    assert_float_equal(fixture_trace(clone.handle, 0.25f, 0.25f).t, 1, 0);
    messages_expect_none(messages);

    if (size < pair.blas.size)
        expect_mistake(host_copy(pair.blas.handle, compact.handle, CLONE));
    destroy((uint64_t)clone.handle);
    expect_mistake(host_copy(pair.blas.handle, clone.handle, CLONE));
    expect_mistake(host_copy(clone.handle, compact.handle, COMPACT));
}

static VkResult deserialize(const void *bytes, VkAccelerationStructureKHR dst)
{
    return fixture_load(VK_NULL_HANDLE, bytes, dst);
}

static VkAccelerationStructureCompatibilityKHR compatibility(const void *bytes)
{
    const STRUCT(VkAccelerationStructureVersionInfoKHR, info, .pVersionData = bytes);
    VkAccelerationStructureCompatibilityKHR answer;
    vk.GetDeviceAccelerationStructureCompatibilityKHR(device, &info, &answer);
    return answer;
}

/* A pair written to memory, destroyed, and read back with other references. */
NOISY_TEST(test_serialize_and_relocate)
{
    open_pair(100, 0);
    size_t blas_size, tlas_size;
    uint64_t pointers = fixture_property(
        pair.tlas.handle,
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_BOTTOM_LEVEL_POINTERS_KHR);
    assert_int_equal(pointers, 2);
    uint64_t *blas = fixture_serialize(pair.blas.handle, &blas_size);
    uint64_t *tlas = fixture_serialize(pair.tlas.handle, &tlas_size);
    assert_int_equal(blas[4], blas_size);
    assert_int_equal(tlas[4], tlas_size);
    assert_int_equal(tlas[6], 2);
    assert_int_equal(tlas[7], (uint64_t)pair.blas.handle);
    destroy_pair();

    struct fixture_structure new_blas = fixture_create_blas(blas[5]);
    struct fixture_structure new_tlas = fixture_create(TOP, tlas[5]);
    assert_int_equal(compatibility(tlas), VK_ACCELERATION_STRUCTURE_COMPATIBILITY_COMPATIBLE_KHR);
    GET(deserialize(blas, new_blas.handle));
    GET(deserialize(tlas, new_tlas.handle));
    assert_false(fixture_trace(new_tlas.handle, 0.25f, 0.25f).isHit); /* its BLAS is gone */
    tlas[7] = tlas[8] = structure_address(&vk, device, new_blas.handle);
    GET(deserialize(tlas, new_tlas.handle));
    expect_pair(new_tlas.handle, 1);
    messages_expect_none(messages);

    tlas[4] -= 8;
    expect_mistake(deserialize(tlas, new_tlas.handle));
    tlas[4] = UINT64_MAX;
    expect_mistake(deserialize(tlas, new_tlas.handle));
    ((uint8_t *)tlas)[VK_UUID_SIZE] ^= 1;
    assert_int_equal(compatibility(tlas), VK_ACCELERATION_STRUCTURE_COMPATIBILITY_INCOMPATIBLE_KHR);
    expect_mistake(deserialize(tlas, new_tlas.handle));
    expect_mistake(deserialize(NULL, new_tlas.handle));
    expect_mistake(deserialize((void *)(uintptr_t)0x1000, new_tlas.handle));
    expect_pair(new_tlas.handle, 1);
}
