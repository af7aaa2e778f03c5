/* SPDX-License-Identifier: Apache-2.0 */
/* VK_NV_ray_tracing on backend cpu, through the loader: what mistakes lead to, none of which
 * crashes; what is refused; and that no driver hears of the backend's handles. */
#include "device_fixture.h"

#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define WILD ((VkAccelerationStructureNV)0x1234567890)

enum { VERTICES_AT = 64, DATA_SIZE = 256 };

/* A BLAS of one triangle at x = 0, whose description tests change. */
static struct {
    struct device_buffer data;
    VkGeometryNV geometry;
    VkAccelerationStructureInfoNV info;
    struct nv_structure blas;
} bad;

static VkGeometryTrianglesNV *const triangles = &bad.geometry.geometry.triangles;

static void describe(void)
{
    bad.geometry = nv_triangles(bad.data.handle, VERTICES_AT, 3 * sizeof(float), 1);
    bad.info =
        MAKE(VkAccelerationStructureInfoNV, .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV,
             .flags = UPDATABLE, .geometryCount = 1, .pGeometries = &bad.geometry);
}

static void open_scene(void)
{
    static const float vertices[9] = {0, 0, 0, 0, 1, 0, 0, 0, 1};
    bad.data = device_buffer_create(DATA_SIZE);
    memcpy(bad.data.bytes + VERTICES_AT, vertices, sizeof(vertices));
    describe();
    bad.blas = nv_create(&bad.info);
}

#define SCENE_TEST(name) TEST_BETWEEN(name, open_scene, close_noisy_test)

static void build(const VkAccelerationStructureInfoNV *info, VkAccelerationStructureNV src)
{
    VkCommandBuffer commands = device_begin(PRIMARY);
    nv_build(commands, info, VK_NULL_HANDLE, 0, &bad.blas, src);
    device_finish(commands);
}

static bool is_built(void)
{
    const VkAccelerationStructureKHR blas = (VkAccelerationStructureKHR)bad.blas.handle;
    const VkResult result = fixture_trace_none(blas);
    if (result == VK_SUCCESS)
        return fixture_trace(blas, 0.25f, 0.25f).isHit;
    expect_mistake(result);
    return false;
}

/* What is described now isn't built, and what is described well is. */
static void expect_unbuilt(void)
{
    build(&bad.info, VK_NULL_HANDLE);
    assert_false(is_built());
    describe();
    build(&bad.info, VK_NULL_HANDLE);
    assert_true(is_built());
}

/* With that change of the description. */
#define EXPECT_UNBUILT(change) ((void)(change), expect_unbuilt())

/* ---- tests */

static VkBuffer create_unbound(void)
{
    const STRUCT(VkBufferCreateInfo, info, .size = DATA_SIZE,
                 .usage = VK_BUFFER_USAGE_RAY_TRACING_BIT_NV);
    VkBuffer buffer;
    GET(vk.CreateBuffer(device, &info, NULL, &buffer));
    OWN(DestroyBuffer, buffer);
    return buffer;
}

/* tests/programs/backend/nv.cases has other data that is not there. */
SCENE_TEST(test_unbound_buffers)
{
    const VkBuffer unbound = create_unbound();
    EXPECT_UNBUILT(triangles->vertexData = unbound);
    EXPECT_UNBUILT(triangles->transformData = unbound);
}

SCENE_TEST(test_unreadable_parameters)
{
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    char *hole = mmap(NULL, page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    bad.info.pGeometries = (const void *)hole;
    const STRUCT(VkAccelerationStructureCreateInfoNV, create_info, .info = bad.info);
    VkAccelerationStructureNV created = WILD;
    expect_mistake(vk.CreateAccelerationStructureNV(device, &create_info, NULL, &created));
    assert_true(created == VK_NULL_HANDLE);
    expect_mistake(
        vk.GetAccelerationStructureHandleNV(device, bad.blas.handle, sizeof(uint64_t), hole));
    munmap(hole, page);
}

SCENE_TEST(test_wild_handles)
{
    const VkAccelerationStructureNV wild = WILD;
    const VkQueryType type = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV;
    const VkQueryPool no_pool = (VkQueryPool)WILD;
    uint64_t reference = 7;
    expect_mistake(vk.GetAccelerationStructureHandleNV(device, wild, 8, &reference));
    expect_mistake(vk.GetAccelerationStructureHandleNV(device, bad.blas.handle, 4, &reference));
    assert_int_equal(reference, 7);
    assert_int_equal(
        nv_requirements(wild, VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_OBJECT_NV).size,
        0);
    build(&bad.info, VK_NULL_HANDLE);
    VkCommandBuffer commands = device_begin(PRIMARY);
    vk.CmdCopyAccelerationStructureNV(commands, wild, bad.blas.handle, CLONE);
    vk.CmdWriteAccelerationStructuresPropertiesNV(commands, 1, &wild, type, no_pool, 0);
    vk.CmdBuildAccelerationStructureNV(commands, &bad.info, VK_NULL_HANDLE, 0, VK_FALSE, wild,
                                       VK_NULL_HANDLE, VK_NULL_HANDLE, 0);
    device_finish(commands);
    assert_true(is_built());
    build(&bad.info, wild);
    assert_false(is_built());
    vk.DestroyAccelerationStructureNV(device, VK_NULL_HANDLE, NULL);
}

SCENE_TEST(test_names_and_private_data)
{
    const VkObjectType type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV;
    const STRUCT(VkDebugUtilsObjectNameInfoEXT, name, .objectType = type,
                 .objectHandle = (uint64_t)bad.blas.handle, .pObjectName = "bunny");
    GET(vk.SetDebugUtilsObjectNameEXT(device, &name));
    VkPrivateDataSlot slot;
    uint64_t value = 0;
    GET(vk.CreatePrivateDataSlot(device, &MAKE(VkPrivateDataSlotCreateInfo), NULL, &slot));
    GET(vk.SetPrivateData(device, type, (uint64_t)bad.blas.handle, slot, 5));
    vk.GetPrivateData(device, type, (uint64_t)bad.blas.handle, slot, &value);
    assert_int_equal(value, 5);
    OWN(DestroyPrivateDataSlot, slot);
    messages_expect_none(messages);
}

/* One message each, which names the setting. */
static void expect_refusal(const char *command)
{
    assert_int_equal(messages_count(messages, "ASSAY-error", command), 1);
    assert_int_equal(messages_count(messages, "ASSAY-error", "assay_validation.backend"), 1);
    messages_clear(messages);
}

SCENE_TEST(test_shader_side)
{
    const STRUCT(VkRayTracingPipelineCreateInfoNV, info);
    VkPipeline pipeline = (VkPipeline)WILD;
    expect_mistake(
        vk.CreateRayTracingPipelinesNV(device, VK_NULL_HANDLE, 1, &info, NULL, &pipeline));
    assert_true(pipeline == VK_NULL_HANDLE);
    expect_refusal("vkCreateRayTracingPipelinesNV");
    VkCommandBuffer commands = device_begin(PRIMARY);
    vk.CmdTraceRaysNV(commands, bad.data.handle, 0, VK_NULL_HANDLE, 0, 0, VK_NULL_HANDLE, 0, 0,
                      VK_NULL_HANDLE, 0, 0, 1, 1, 1);
    device_finish(commands);
    expect_refusal("vkCmdTraceRaysNV");
    const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_NV, 1};
    const STRUCT(VkDescriptorPoolCreateInfo, pool, .maxSets = 1, .poolSizeCount = 1,
                 .pPoolSizes = &size);
    VkDescriptorPool created;
    expect_mistake(vk.CreateDescriptorPool(device, &pool, NULL, &created));
    expect_refusal("vkCreateDescriptorPool");
}
