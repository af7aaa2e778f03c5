/* SPDX-License-Identifier: Apache-2.0 */
/* Commands that build no structures. */
#include <stdlib.h>

#include "tests/fixture/copies.h"
#include "tests/rules/calls/placing.h"
#include "tests/rules/case.h"

/* ---- sources */

static uint64_t unbuilt_object(struct scene *scene)
{
    switch (scene->life.object_type) {
    case VK_OBJECT_TYPE_MICROMAP_EXT:
        return (uint64_t)scene_micromap_ext(scene, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT);
    case VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV:
        return (uint64_t)scene_nv_accel(scene);
    default:
        return (uint64_t)scene_accel_for(scene, INDEXED);
    }
}

static void use_source(struct scene *scene, uint64_t source)
{
    scene->life.copy.src = (VkAccelerationStructureKHR)source;
    scene->life.to_memory.src = (VkAccelerationStructureKHR)source;
    scene->life.objects[1] = source;
}

static void use_unbuilt(struct scene *scene)
{
    use_source(scene, unbuilt_object(scene));
}

static void build_uncompactable_micromap(struct scene *scene, uint64_t micromap)
{
    VkMicromapBuildInfoEXT info = scene->life.builds[0];
    info.flags = 0;
    info.dstMicromap = (VkMicromapEXT)micromap;
    if (command_is_on_host(scene->command))
        GET(scene->vk->BuildMicromapsEXT(scene->fixture->device, VK_NULL_HANDLE, 1, &info));
    else
        scene->vk->CmdBuildMicromapsEXT(scene->command_buffer, 1, &info);
}

static void use_uncompactable(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    uint64_t source = life->src;
    if (life->object_type == VK_OBJECT_TYPE_MICROMAP_EXT) {
        build_uncompactable_micromap(scene, source);
    } else if (life->object_type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV) {
        scene->nv.info.flags &= ~(VkFlags)VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_NV;
        source = (uint64_t)scene_nv_accel(scene);
        scene_nv_build(scene, (VkAccelerationStructureNV)source);
    } else {
        scene->infos[INDEXED].flags &=
            ~(VkFlags)VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR;
        scene_build_before(scene, INDEXED, 1);
    }
    use_source(scene, source);
    life->objects[0] = source;
}

/* ---- deserialized sources that refer to a micromap */

static void deserialize_by_device(struct scene *scene, VkAccelerationStructureKHR dst)
{
    const VkCopyMemoryToAccelerationStructureInfoKHR info =
        deserialize_info(scene_serialized(scene), dst);
    const VkCommandBuffer command_buffer = scene_begin_before(scene);
    scene->vk->CmdCopyMemoryToAccelerationStructureKHR(command_buffer, &info);
    scene_end_before(scene, command_buffer);
}

/* The data have a block with one micromap. */
static void deserialize_with(struct scene *scene, VkAccelerationStructureKHR dst,
                             VkDeviceAddress micromap)
{
    enum { BLOCK_TYPE = VK_ACCELERATION_STRUCTURE_SERIALIZED_BLOCK_TYPE_OPACITY_MICROMAP_KHR };
    struct {
        uint8_t driver[VK_UUID_SIZE], format[VK_UUID_SIZE];
        uint64_t size, deserialized_size, blocks;
        uint32_t type, reserved;
        uint64_t count, micromap;
    } *data = (void *)place_buffer(scene).bytes;
    STRUCT(VkPhysicalDeviceIDProperties, ids);
    STRUCT(VkPhysicalDeviceProperties2, properties, .pNext = &ids);
    scene->fixture->instance.vk.GetPhysicalDeviceProperties2(scene->fixture->instance.physical,
                                                             &properties);
    memset(data, 0, sizeof(*data));
    memcpy(data->driver, ids.driverUUID, VK_UUID_SIZE);
    memcpy(data->format, ids.driverUUID, VK_UUID_SIZE);
    data->size = data->deserialized_size = sizeof(*data);
    data->blocks = (uint64_t)UINT32_MAX << 32 | 1;
    data->type = BLOCK_TYPE;
    data->count = 1;
    data->micromap = micromap;
    const VkCopyMemoryToAccelerationStructureInfoKHR info = deserialize_info((uintptr_t)data, dst);
    GET(scene->vk->CopyMemoryToAccelerationStructureKHR(scene->fixture->device, VK_NULL_HANDLE,
                                                        &info));
}

enum micromap_state { UNWRITTEN, BUILT, REBUILT, DESERIALIZED };

static void use_source_with_micromap(struct scene *scene, enum micromap_state state)
{
    if (scene->fixture->instance.platform->is_cpu) {
        scene_skip(scene, "backend cpu writes no blocks");
        return;
    }
    const struct device_buffer buffer = place_buffer(scene),
                               visible = place_buffer_of_instances(scene, 1);
    const VkAccelerationStructureKHR micromap = scene_accel_in(
        scene, &buffer, 0, PLACE_FAR, VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR);
    const VkAccelerationStructureKHR structure = scene_accel_in(
        scene, &visible, 0, PLACE_FAR, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    if (state == REBUILT || state == DESERIALIZED)
        deserialize_by_device(scene, micromap);
    if (state == REBUILT || state == BUILT)
        scene_record_micromap_in(scene, micromap, 4);
    scene_run_so_far(scene);
    deserialize_with(scene, structure, buffer.address);
    use_source(scene, (uint64_t)structure);
}

/* ---- descriptors */

static VkAccelerationStructureNV nv_blas(struct scene *scene)
{
    scene->nv.info.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV;
    scene->nv.info.instanceCount = 0;
    scene->nv.info.geometryCount = 1;
    scene->nv.info.pGeometries = scene->nv.geometries;
    return scene_nv_accel(scene);
}

/* Has the call write descriptors of VK_KHR_acceleration_structure, with both structures. */
static void chain_both_descriptors(struct scene *scene)
{
    static VkAccelerationStructureKHR structures[2];
    struct scene_life *life = &scene->life;
    structures[0] = structures[1] = scene->infos[TLAS].dstAccelerationStructure;
    life->descriptor.pAccelerationStructures = structures;
    life->descriptor.pNext = &life->descriptor_nv;
    life->write.pNext = &life->descriptor;
    life->write.descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
}

/* ---- destruction */

static void wait_idle(struct scene *scene)
{
    GET(scene->vk->DeviceWaitIdle(scene->fixture->device));
}

VKAPI_ATTR static void *VKAPI_CALL allocate(void *user, size_t size, size_t alignment,
                                            VkSystemAllocationScope scope)
{
    (void)user, (void)scope;
    return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

/* No Vulkan command on structures reallocates. */
VKAPI_ATTR static void *VKAPI_CALL reallocate(void *user, void *original, size_t size,
                                              size_t alignment, VkSystemAllocationScope scope)
{
    return original ? NULL : allocate(user, size, alignment, scope);
}

VKAPI_ATTR static void VKAPI_CALL release(void *user, void *memory)
{
    (void)user;
    free(memory);
}

static const VkAllocationCallbacks callbacks = {
    .pfnAllocation = allocate, .pfnReallocation = reallocate, .pfnFree = release};

static void destroy_with_callbacks(struct scene *scene, VkDevice device, uint64_t handle)
{
    if (scene->life.object_type == VK_OBJECT_TYPE_MICROMAP_EXT)
        scene->vk->DestroyMicromapEXT(device, (VkMicromapEXT)handle, &callbacks);
    else if (scene->life.object_type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV)
        scene->vk->DestroyAccelerationStructureNV(device, (VkAccelerationStructureNV)handle,
                                                  &callbacks);
    else
        scene->vk->DestroyAccelerationStructureKHR(device, (VkAccelerationStructureKHR)handle,
                                                   &callbacks);
}

/* Has the call destroy an object that was created with callbacks. */
static void use_created_with_callbacks(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    const VkDevice device = scene->device;
    void *created = &life->destroyed;
    if (life->object_type == VK_OBJECT_TYPE_MICROMAP_EXT)
        GET(scene->vk->CreateMicromapEXT(device, &life->create_micromap, &callbacks,
                                         (VkMicromapEXT *)created));
    else if (life->object_type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV)
        GET(scene->vk->CreateAccelerationStructureNV(device, &life->create_nv, &callbacks,
                                                     (VkAccelerationStructureNV *)created));
    else
        GET(scene->vk->CreateAccelerationStructureKHR(device, &life->create, &callbacks,
                                                      (VkAccelerationStructureKHR *)created));
    scene_defer(scene, device, life->destroyed, destroy_with_callbacks);
}

/* Submits the build of the scene, and waits for it if asked to. */
static void submit_build(struct scene *scene, int waits)
{
    const VkQueue queue = scene_queue(scene, scene_family(scene));
    scene_end(scene, scene->command_buffer);
    GET(commands_submit(scene->vk, queue, scene->command_buffer, VK_NULL_HANDLE));
    if (waits)
        wait_idle(scene);
}

/* Builds a structure in a buffer and memory of its own. */
static struct device_buffer buffer_of_a_build(struct scene *scene)
{
    const struct device_buffer buffer = place_buffer(scene);
    scene->infos[INDEXED].dstAccelerationStructure =
        scene_accel_in(scene, &buffer, 0, place_size(scene, INDEXED), scene->infos[INDEXED].type);
    scene_build_before(scene, INDEXED, 1);
    return buffer;
}

/* ---- queries */

static void record_queries(struct scene *scene, VkCommandBuffer command_buffer, uint64_t object,
                           uint32_t query, VkQueryType type, VkQueryPool pool)
{
    const VkuDeviceDispatchTable *vk = scene->vk;
    if (command_is_of_micromaps(scene->command))
        vk->CmdWriteMicromapsPropertiesEXT(command_buffer, 1, (const VkMicromapEXT *)&object, type,
                                           pool, query);
    else if (command_is_of_nv(scene->command))
        vk->CmdWriteAccelerationStructuresPropertiesNV(
            command_buffer, 1, (const VkAccelerationStructureNV *)&object, type, pool, query);
    else
        vk->CmdWriteAccelerationStructuresPropertiesKHR(
            command_buffer, 1, (const VkAccelerationStructureKHR *)&object, type, pool, query);
}

/* ---- sizes */

static void build_and_query(struct scene *scene, VkAccelerationStructureKHR accel, VkQueryPool pool)
{
    const VkCommandBuffer command_buffer = scene_begin_own(scene);
    VkAccelerationStructureBuildGeometryInfoKHR info = scene->infos[INDEXED];
    info.dstAccelerationStructure = accel;
    scene->vk->CmdBuildAccelerationStructuresKHR(command_buffer, 1, &info,
                                                 &scene->range_pointers[INDEXED]);
    scene_barrier(scene, command_buffer);
    scene->vk->CmdResetQueryPool(command_buffer, pool, 0, 1);
    scene->vk->CmdWriteAccelerationStructuresPropertiesKHR(
        command_buffer, 1, &accel, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, pool,
        0);
    scene_run(scene, command_buffer);
}

static VkDeviceSize read_size(struct scene *scene, VkQueryPool pool)
{
    uint64_t size = 0;
    GET(scene->vk->GetQueryPoolResults(scene->fixture->device, pool, 0, 1, sizeof(size), &size,
                                       sizeof(size),
                                       VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
    return size;
}

/* Builds a structure before the call, and returns its compacted size. */
static VkDeviceSize compacted_size_of(struct scene *scene, VkAccelerationStructureKHR accel)
{
    const VkQueryType type = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
    const VkDevice device = scene->fixture->device;
    uint64_t size = 0;
    if (command_is_on_host(scene->command)) {
        scene_build_before(scene, INDEXED, 1);
        GET(scene->vk->WriteAccelerationStructuresPropertiesKHR(device, 1, &accel, type,
                                                                sizeof(size), &size, sizeof(size)));
        return size;
    }
    const VkQueryPool pool = scene_query_pool(scene, type, 1);
    build_and_query(scene, accel, pool);
    return read_size(scene, pool);
}

enum dst_size { SMALL, COMPACTED, FULL };

/* Queries the structure that the scene has built, and returns what the host reads. */
static VkDeviceSize queried_size_of_source(struct scene *scene, VkQueryType type)
{
    const VkQueryPool pool = scene_query_pool(scene, type, 1);
    scene_barrier(scene, scene->command_buffer);
    scene->vk->CmdResetQueryPool(scene->command_buffer, pool, 0, 1);
    record_queries(scene, scene->command_buffer, scene->life.src, 0, type, pool);
    scene_run_so_far(scene);
    return read_size(scene, pool);
}

enum { ALIGNMENT = 256 };

#include "copies.inc"
#include "copy_sizes.inc"
#include "descriptors.inc"
#include "destruction.inc"
#include "life_features.inc"
#include "life_results.inc"
#include "queries.inc"
#include "query_pools.inc"
#include "sources.inc"
#include "written_queries.inc"
