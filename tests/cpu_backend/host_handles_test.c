/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu through the loader: handles of its objects, addresses, names and private data; and
 * mistakes, which must neither crash nor change a structure. */
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "host_fixture.h"

static uint64_t address_of(VkAccelerationStructureKHR structure)
{
    return structure_address(&vk, device, structure);
}

static VkAccelerationStructureKHR create_generic(VkBuffer buffer, VkDeviceSize offset)
{
    const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .buffer = buffer, .offset = offset,
                 .size = 256, .type = VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR);
    VkAccelerationStructureKHR structure;
    GET(vk.CreateAccelerationStructureKHR(device, &info, NULL, &structure));
    OWN(DestroyAccelerationStructureKHR, structure);
    return structure;
}

/* Addresses are stable, unique, and as far apart as the offsets of generic structures. */
SILENT_TEST(test_addresses)
{
    open_pair(10, 0);
    uint64_t blas = address_of(pair.blas.handle), tlas = address_of(pair.tlas.handle);
    assert_true(blas != 0 && tlas != 0 && blas != tlas);
    assert_int_equal(address_of(pair.blas.handle), blas);

    struct fixture_structure first = fixture_create_blas(4096);
    VkAccelerationStructureKHR a = create_generic(first.storage.handle, 256);
    VkAccelerationStructureKHR b = create_generic(first.storage.handle, 2048);
    assert_int_equal(address_of(b) - address_of(a), 2048 - 256);
}

SILENT_TEST(test_names)
{
    open_pair(10, 0);
    STRUCT(VkDebugUtilsObjectNameInfoEXT, name,
           .objectType = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
           .objectHandle = (uint64_t)pair.blas.handle, .pObjectName = "bunny");
    GET(vk.SetDebugUtilsObjectNameEXT(device, &name));
    const STRUCT(VkDebugUtilsObjectTagInfoEXT, tag,
                 .objectType = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                 .objectHandle = (uint64_t)pair.blas.handle, .tagSize = 4, .pTag = "tag");
    GET(vk.SetDebugUtilsObjectTagEXT(device, &tag));
    name.objectType = VK_OBJECT_TYPE_BUFFER; /* the driver's own */
    name.objectHandle = (uint64_t)pair.blas.storage.handle;
    GET(vk.SetDebugUtilsObjectNameEXT(device, &name));
}

static void set_data(VkPrivateDataSlot slot, VkObjectType type, uint64_t object, uint64_t value)
{
    GET(vk.SetPrivateData(device, type, object, slot, value));
}

static uint64_t get_data(VkPrivateDataSlot slot, VkObjectType type, uint64_t object)
{
    uint64_t value = 99;
    vk.GetPrivateData(device, type, object, slot, &value);
    return value;
}

static VkPrivateDataSlot create_slot(void)
{
    VkPrivateDataSlot slot;
    GET(vk.CreatePrivateDataSlot(device, &MAKE(VkPrivateDataSlotCreateInfo), NULL, &slot));
    OWN(DestroyPrivateDataSlot, slot);
    return slot;
}

SILENT_TEST(test_private_data)
{
    if (!vk.SetPrivateData)
        skip();
    open_pair(10, 0);
    const uint64_t blas = (uint64_t)pair.blas.handle, tlas = (uint64_t)pair.tlas.handle;
    const VkObjectType type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    const uint64_t buffer = (uint64_t)pair.blas.storage.handle;
    VkPrivateDataSlot slots[] = {create_slot(), create_slot()};
    set_data(slots[0], type, blas, 1);
    set_data(slots[1], type, blas, 2);
    set_data(slots[0], type, tlas, 3);
    set_data(slots[0], VK_OBJECT_TYPE_BUFFER, buffer, 4);
    set_data(slots[0], type, blas, 5);
    assert_int_equal(get_data(slots[0], type, blas), 5);
    assert_int_equal(get_data(slots[1], type, blas), 2);
    assert_int_equal(get_data(slots[0], type, tlas), 3);
    assert_int_equal(get_data(slots[1], type, tlas), 0);
    assert_int_equal(get_data(slots[0], VK_OBJECT_TYPE_BUFFER, buffer), 4);
    destroy((uint64_t)slots[0]);
    slots[0] = create_slot();
    assert_int_equal(get_data(slots[0], type, tlas), 0);
    assert_int_equal(get_data(slots[1], type, blas), 2);
    set_data(slots[0], type, blas, 6);
    destroy_pair();
    assert_int_equal(get_data(slots[0], type, blas), 0);
}

/* The layer's own commands are those of backend cpu, where acceleration structures are enabled. */
static void expect_own_commands(const struct instance_fixture_setup *setup, bool has_extensions,
                                bool expected)
{
    static const char *const names[] = {"vkTraceRaysASSAY", "vkGetCountersASSAY"};
    struct instance_fixture other;
    VkDevice made;
    VkuDeviceDispatchTable made_vk;
    instance_fixture_open(&other, &platform, setup);
    GET(instance_fixture_create_device(&other, NULL, backend_extensions, has_extensions ? 2 : 0,
                                       &made, &made_vk));
    for (int i = 0; i < 2; i++)
        assert_int_equal(other.get_device_proc_addr(made, names[i]) != NULL, expected);
    made_vk.DestroyDevice(made, NULL);
    instance_fixture_close(&other);
}

TEST(test_own_commands)
{
    expect_own_commands(&(struct instance_fixture_setup){.backend = "cpu"}, true, true);
    expect_own_commands(&(struct instance_fixture_setup){.backend = "cpu"}, false, false);
    expect_own_commands(
        &(struct instance_fixture_setup){.backend = "driver", .driver_traces = true}, true, false);
    expect_own_commands(&(struct instance_fixture_setup){.backend = "driver"}, false, false);
}

/* ---- mistakes */

#define WILD ((VkAccelerationStructureKHR)0x1234567890)

NOISY_TEST(test_wild_handles)
{
    open_pair(10, UPDATABLE);
    assert_int_equal(address_of(WILD), 0);
    expect_mistake(host_build(&pair.triangles, WILD, VK_NULL_HANDLE));
    expect_mistake(host_build(&pair.triangles, pair.blas.handle, WILD));
    expect_mistake(host_copy(WILD, pair.blas.handle, CLONE));
    uint64_t value = 1;
    const VkAccelerationStructureKHR wild = WILD;
    expect_mistake(vk.WriteAccelerationStructuresPropertiesKHR(device, 1, &wild, STRUCTURE_SIZE, 8,
                                                               &value, 8));
    assert_int_equal(value, 0);
    expect_mistake(vk.WriteAccelerationStructuresPropertiesKHR(
        device, 1, &pair.blas.handle, VK_QUERY_TYPE_OCCLUSION, 8, &value, 8));
    const VkDeferredOperationKHR operation = (VkDeferredOperationKHR)0x42;
    expect_mistake(fixture_build(operation, &pair.triangles, pair.blas.handle, VK_NULL_HANDLE));
    expect_mistake(vk.DeferredOperationJoinKHR(device, operation));
    expect_mistake(vk.GetDeferredOperationResultKHR(device, operation));
    assert_int_equal(vk.GetDeferredOperationMaxConcurrencyKHR(device, operation), 0);
    vk.DestroyDeferredOperationKHR(device, operation, NULL);
    vk.DestroyDeferredOperationKHR(device, VK_NULL_HANDLE, NULL);
    vk.DestroyAccelerationStructureKHR(device, VK_NULL_HANDLE, NULL);
    expect_pair(pair.tlas.handle, 1);
}

static VkResult build_again(void)
{
    return host_build(&pair.triangles, pair.blas.handle, VK_NULL_HANDLE);
}

/* No pointer here changes the structure. tests/programs/backend/mistakes.cases has the input data.
 */
NOISY_TEST(test_bad_pointers)
{
    open_pair(10, UPDATABLE);
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    char *hole = mmap(NULL, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    mprotect(hole + page, page, PROT_NONE);
    VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &pair.triangles.geometry.geometry.triangles;
    const VkAccelerationStructureGeometryTrianglesDataKHR valid = *triangles;

    triangles->vertexData.hostAddress = NULL;
    expect_mistake(build_again());
    *triangles = valid;
    triangles->transformData.hostAddress = hole + page - 47;
    expect_mistake(build_again());
    *triangles = valid;
    triangles->vertexFormat = VK_FORMAT_D32_SFLOAT;
    expect_mistake(build_again());
    *triangles = valid;

    pair.triangles.info.pGeometries = (const void *)(hole + page - 8);
    expect_mistake(build_again());
    pair.triangles.info.pGeometries = &pair.triangles.geometry;
    expect_mistake(vk.WriteAccelerationStructuresPropertiesKHR(device, 1, &pair.blas.handle,
                                                               STRUCTURE_SIZE, 8, hole + page, 8));
    GET(build_again());
    expect_pair(pair.tlas.handle, 1);
    munmap(hole, 2 * page);
}
