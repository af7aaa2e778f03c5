/* SPDX-License-Identifier: Apache-2.0 */
/* What only host builds have: host memory, structures that the host can reach, and operations that
 * they are deferred to. */
#include <string.h>

#include "case.h"
#include "placing.h"

#define I_TRIANGLES TRIANGLES(INDEXED, 0)
#define U_TRIANGLES TRIANGLES(UNINDEXED, 0)

/* ---- handles of devices ---- */

static void call_on_a_queue(struct scene *scene)
{
    VkQueue queue;
    scene->vk->GetDeviceQueue(scene->world->device, 0, 0, &queue);
    scene->device = (VkDevice)queue;
}

static void call_on_nothing(struct scene *scene)
{
    scene->device = VK_NULL_HANDLE;
}

static void call_on_an_unreadable_page(struct scene *scene)
{
    scene->device = unreadable_page();
}

static void call_on_zeros(struct scene *scene)
{
    scene->device = bytes_before_unreadable_page(64);
}

/* ---- deferred operations ---- */

static VkDeferredOperationKHR create_operation(struct scene *scene)
{
    VkDeferredOperationKHR operation;
    expect_success(scene->vk->CreateDeferredOperationKHR(scene->world->device, NULL, &operation),
                   "vkCreateDeferredOperationKHR");
    return operation;
}

static void destroy_operation(struct scene *scene, VkDevice device, uint64_t handle)
{
    scene->vk->DestroyDeferredOperationKHR(device, (VkDeferredOperationKHR)handle, NULL);
}

static void join_and_destroy(struct scene *scene, VkDevice device, uint64_t handle)
{
    const VkDeferredOperationKHR operation = (VkDeferredOperationKHR)handle;
    while (scene->vk->DeferredOperationJoinKHR(device, operation) == VK_THREAD_IDLE_KHR)
        continue;
    destroy_operation(scene, device, handle);
}

static void defer(struct scene *scene)
{
    scene->deferred_operation = create_operation(scene);
    scene_defer(scene, scene->world->device, (uint64_t)scene->deferred_operation, join_and_destroy);
}

static void defer_to_a_destroyed_operation(struct scene *scene)
{
    scene->deferred_operation = create_operation(scene);
    destroy_operation(scene, scene->world->device, (uint64_t)scene->deferred_operation);
}

static void destroy_operation_of_other_device(struct scene *scene, VkDevice device, uint64_t handle)
{
    scene->other_vk.DestroyDeferredOperationKHR(device, (VkDeferredOperationKHR)handle, NULL);
}

static void defer_to_another_device(struct scene *scene)
{
    scene_enter_other_device(scene);
    scene->deferred_operation = create_operation(scene);
    scene_defer(scene, scene->world->device, (uint64_t)scene->deferred_operation,
                destroy_operation_of_other_device);
    scene_leave_other_device(scene);
}

/* A build before the scene's is deferred to the same operation. */
static void defer_twice(struct scene *scene)
{
    defer(scene);
    scene->vk->BuildAccelerationStructuresKHR(scene->world->device, scene->deferred_operation, 1,
                                              &scene->infos[INDEXED],
                                              &scene->range_pointers[INDEXED]);
}

static void defer_again(struct scene *scene)
{
    defer_twice(scene);
    while (scene->vk->DeferredOperationJoinKHR(scene->world->device, scene->deferred_operation) ==
           VK_THREAD_IDLE_KHR)
        continue;
}

/* ---- structures ---- */

static VkAccelerationStructureKHR accel_in(struct scene *scene, const struct test_buffer *buffer,
                                           uint32_t build)
{
    return scene_accel_in(scene, buffer, 0, place_size(scene, build), scene->infos[build].type);
}

/* What the host could not have built itself is deserialized on the device. */
static void update_from(struct scene *scene, VkAccelerationStructureKHR src)
{
    const uint32_t family = world_find_family(scene->world, VK_QUEUE_COMPUTE_BIT, 0);
    const VkCommandBuffer command_buffer = scene_command_buffer(scene, family);
    const VkCopyMemoryToAccelerationStructureInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_MEMORY_TO_ACCELERATION_STRUCTURE_INFO_KHR,
        .src.deviceAddress = scene->boxes.address,
        .dst = src,
        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR,
    };
    scene_begin(scene, command_buffer, 0);
    scene->vk->CmdCopyMemoryToAccelerationStructureKHR(command_buffer, &info);
    scene_end(scene, command_buffer);
    scene_submit(scene, family, command_buffer);
    scene->infos[UPDATE].srcAccelerationStructure = src;
}

static void dst_by_address(struct scene *scene)
{
    scene->infos[AABBS].dstAccelerationStructure = place_accel_by_address(scene, AABBS);
}

static void src_by_address(struct scene *scene)
{
    update_from(scene, place_accel_by_address(scene, UPDATE));
}

static void ignored_src_by_address(struct scene *scene)
{
    scene->infos[AABBS].srcAccelerationStructure = place_accel_by_address(scene, AABBS);
}

static void src_in_a_buffer(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    update_from(scene, accel_in(scene, &buffer, UPDATE));
}

static void dst_in_device_memory(struct scene *scene)
{
    const struct test_buffer buffer = place_device_local_buffer(scene);
    scene->infos[AABBS].dstAccelerationStructure = accel_in(scene, &buffer, AABBS);
}

static void dst_in_visible_memory(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer_of_instances(scene, 1);
    scene->infos[AABBS].dstAccelerationStructure = accel_in(scene, &buffer, AABBS);
}

static void src_in_device_memory(struct scene *scene)
{
    const struct test_buffer buffer = place_device_local_buffer(scene);
    update_from(scene, accel_in(scene, &buffer, UPDATE));
}

static void ignored_src_in_device_memory(struct scene *scene)
{
    const struct test_buffer buffer = place_device_local_buffer(scene);
    scene->infos[AABBS].srcAccelerationStructure = accel_in(scene, &buffer, AABBS);
}

static void dst_of_two_instances(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer_of_instances(scene, 3);
    scene->infos[AABBS].dstAccelerationStructure = accel_in(scene, &buffer, AABBS);
}

static void src_of_two_instances(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer_of_instances(scene, 3);
    update_from(scene, accel_in(scene, &buffer, UPDATE));
}

static void ignored_src_of_two_instances(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer_of_instances(scene, 3);
    scene->infos[AABBS].srcAccelerationStructure = accel_in(scene, &buffer, AABBS);
}

/* ---- input data ---- */

/* A copy of `size` bytes at the edge of what can be read, less the last `missing` of them. */
static void *at_edge(const void *data, size_t size, size_t missing)
{
    char *copy = bytes_before_unreadable_page(size - missing);
    return memcpy(copy, data, size - missing);
}

#define PUT_AT_EDGE(name, place, buffer, size)                                                     \
    static void put_##name##_at_edge(struct scene *scene)                                          \
    {                                                                                              \
        scene->place.hostAddress = at_edge(scene->buffer.host, size, 0);                           \
    }                                                                                              \
    static void put_##name##_over_edge(struct scene *scene)                                        \
    {                                                                                              \
        scene->place.hostAddress = at_edge(scene->buffer.host, size, 1);                           \
    }

PUT_AT_EDGE(vertices, U_TRIANGLES.vertexData, vertices, 6 * 12)
PUT_AT_EDGE(indices, I_TRIANGLES.indexData, indices, 6 * 4)
PUT_AT_EDGE(short_indices, TRIANGLES(UNINDEXED, 1).indexData, indices, 6 * 2)
PUT_AT_EDGE(transform, I_TRIANGLES.transformData, transforms, 48)
PUT_AT_EDGE(boxes, BOXES(AABBS, 0).data, boxes, 3 * 24)
PUT_AT_EDGE(instances, INSTANCES(TLAS, 0).data, instances, 3 * 64)

/* The offsets lead over the edge. */
static void offset_boxes_over_edge(struct scene *scene)
{
    put_boxes_at_edge(scene);
    scene->ranges[AABBS][0].primitiveOffset = 24;
}

static void offset_fewer_boxes_at_edge(struct scene *scene)
{
    offset_boxes_over_edge(scene);
    scene->ranges[AABBS][0].primitiveCount = 2;
}

static void offset_vertices_over_edge(struct scene *scene)
{
    put_vertices_at_edge(scene);
    scene->ranges[UNINDEXED][0].firstVertex = 3;
    scene->U_TRIANGLES.maxVertex = 8;
}

/* Which is inside: one triangle behind the first. */
static void offset_fewer_vertices_at_edge(struct scene *scene)
{
    offset_vertices_over_edge(scene);
    scene->ranges[UNINDEXED][0].primitiveCount = 1;
}

static void point_to_instances(struct scene *scene, size_t missing)
{
    const void *pointers[3];
    for (size_t i = 0; i < 3; i++)
        pointers[i] = scene->instances.host + i * 64;
    scene->INSTANCES(TLAS, 0).arrayOfPointers = VK_TRUE;
    scene->INSTANCES(TLAS, 0).data.hostAddress = at_edge(pointers, sizeof(pointers), missing);
}

static void put_pointers_at_edge(struct scene *scene)
{
    point_to_instances(scene, 0);
}

static void put_pointers_over_edge(struct scene *scene)
{
    point_to_instances(scene, 1);
}

static void put_all_nowhere_without_primitives(struct scene *scene)
{
    scene->U_TRIANGLES.vertexData.hostAddress = unreadable_page();
    scene->BOXES(AABBS, 0).data.hostAddress = unreadable_page();
    scene->INSTANCES(TLAS, 0).data.hostAddress = unreadable_page();
    scene->TRIANGLES(UNINDEXED, 1).indexData.hostAddress = unreadable_page();
    scene->TRIANGLES(UNINDEXED, 1).transformData.hostAddress = unreadable_page();
    scene->ranges[UNINDEXED][0].primitiveCount = scene->ranges[UNINDEXED][1].primitiveCount = 0;
    scene->ranges[AABBS][0].primitiveCount = scene->ranges[TLAS][0].primitiveCount = 0;
}

/* The fourth component of the last vertex is not read. */
static void put_wide_vertices_at_edge(struct scene *scene)
{
    scene->U_TRIANGLES.vertexFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
    scene->U_TRIANGLES.vertexStride = 8;
    scene->U_TRIANGLES.vertexData.hostAddress = at_edge(scene->vertices.host, 6 * 8, 2);
}

/* ---- scratch ---- */

static void put_scratch_at_edge_of(struct scene *scene, uint32_t build, size_t missing)
{
    scene->infos[build].scratchData.hostAddress =
        bytes_before_unreadable_page((size_t)scene_scratch_size(scene, build) - missing);
}

#define PUT_SCRATCH(build)                                                                         \
    static void put_scratch_of_##build##_at_edge(struct scene *scene)                              \
    {                                                                                              \
        put_scratch_at_edge_of(scene, build, 0);                                                   \
    }                                                                                              \
    static void put_scratch_of_##build##_over_edge(struct scene *scene)                            \
    {                                                                                              \
        put_scratch_at_edge_of(scene, build, 1);                                                   \
    }

PUT_SCRATCH(AABBS)
PUT_SCRATCH(REFIT)

/* Scratch that is no VkDeviceMemory at all. */
static void put_scratch_in_own_memory(struct scene *scene, bool shares)
{
    const size_t first = (size_t)scene_scratch_size(scene, INDEXED);
    const size_t second = (size_t)scene_scratch_size(scene, AABBS);
    char *bytes = bytes_before_unreadable_page(first + second);
    scene->infos[INDEXED].scratchData.hostAddress = bytes;
    scene->infos[AABBS].scratchData.hostAddress = bytes + first - shares;
}

static void overlap_scratch_in_own_memory(struct scene *scene)
{
    put_scratch_in_own_memory(scene, true);
}

static void put_scratch_side_by_side_in_own_memory(struct scene *scene)
{
    put_scratch_in_own_memory(scene, false);
}

/* The same bytes, but no host memory any more that anything is known of. */
static void unmap_shared_scratch(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    place_dst(scene, INDEXED, &buffer, 0);
    place_scratch(scene, INDEXED, &buffer, 0);
    scene->vk->UnmapMemory(scene->world->device, buffer.memory);
}

static const struct setup with_group = {.enable = ENABLE_GROUP};
static const struct setup with_addresses = {.enable = ENABLE_OPACITY_MICROMAP_KHR};

static const struct test_case cases[] = {
    {.name = "device_is_a_queue",
     RULES(RULE_device_is_valid),
     .mutate = call_on_a_queue,
     .path = "(): device 0x",
     .commands = ON_HOST},
    {.name = "device_is_null",
     RULES(RULE_device_is_valid),
     .mutate = call_on_nothing,
     .path = "(): device 0x0 is",
     .commands = ON_HOST},
    {.name = "device_is_unreadable",
     RULES(RULE_device_is_valid),
     .mutate = call_on_an_unreadable_page,
     .commands = ON_HOST},
    {.name = "device_is_zeros",
     RULES(RULE_device_is_valid),
     .mutate = call_on_zeros,
     .commands = ON_HOST},

    {.name = "deferred_operation_forged",
     RULES(RULE_deferred_operation_is_valid),
     .edits = EDITS(SET(deferred_operation, 0xdeadbeef)),
     .mutate_twin = defer,
     .path = "(): deferredOperation VkDeferredOperationKHR 0xdeadbeef is not"},
    {.name = "deferred_operation_destroyed",
     RULES(RULE_deferred_operation_is_valid),
     .mutate = defer_to_a_destroyed_operation,
     .mutate_twin = defer},
    {.name = "deferred_operation_of_another_device",
     RULES(RULE_deferred_operation_is_of_the_device),
     .mutate = defer_to_another_device,
     .mutate_twin = defer,
     .path = "(): deferredOperation VkDeferredOperationKHR"},
    {.name = "deferred_operation_in_use",
     RULES(RULE_previous_deferred_operation_is_complete),
     .mutate = defer_twice,
     .mutate_twin = defer_again,
     .path = "(): deferredOperation VkDeferredOperationKHR",
     .spares_drivers = true},

    {.name = "dst_by_address",
     RULES(RULE_host_build_dst_was_created_with_a_buffer),
     .setup = &with_addresses,
     .mutate = dst_by_address,
     .mutate_twin = dst_in_visible_memory,
     .path = "pInfos[2].dstAccelerationStructure"},
    {.name = "src_by_address",
     RULES(RULE_host_build_src_was_created_with_a_buffer),
     .setup = &with_addresses,
     .mutate = src_by_address,
     .mutate_twin = src_in_a_buffer,
     .may_fail_on_cpu = true,
     .path = "pInfos[4].srcAccelerationStructure"},
    {.name = "ignored_src_by_address",
     RULES(RULE_host_build_src_was_created_with_a_buffer),
     .silent = true,
     .setup = &with_addresses,
     .mutate = ignored_src_by_address},
    {.name = "dst_in_device_memory",
     RULES(RULE_host_build_dst_is_host_visible),
     .mutate = dst_in_device_memory,
     .mutate_twin = dst_in_visible_memory,
     .path = "pInfos[2].dstAccelerationStructure"},
    {.name = "src_in_device_memory",
     RULES(RULE_host_build_src_is_host_visible),
     .mutate = src_in_device_memory,
     .mutate_twin = ignored_src_in_device_memory,
     .path = "pInfos[4].srcAccelerationStructure"},
    {.name = "dst_of_two_instances",
     RULES(RULE_host_build_dst_has_one_memory_instance),
     .setup = &with_group,
     .mutate = dst_of_two_instances,
     .mutate_twin = dst_in_visible_memory,
     .path = "pInfos[2].dstAccelerationStructure"},
    {.name = "src_of_two_instances",
     RULES(RULE_host_build_src_has_one_memory_instance),
     .setup = &with_group,
     .mutate = src_of_two_instances,
     .mutate_twin = ignored_src_of_two_instances,
     .path = "pInfos[4].srcAccelerationStructure"},

    {.name = "vertices_null",
     RULES(RULE_vertex_host_address_is_readable),
     .edits = EDITS(SET(U_TRIANGLES.vertexData, 0)),
     .path = "pInfos[1].pGeometries[0].geometry.triangles.vertexData.hostAddress is NULL"},
    {.name = "vertices_null_without_primitives",
     RULES(RULE_vertex_host_address_is_readable),
     .edits = EDITS(SET(U_TRIANGLES.vertexData, 0), SET(ranges[UNINDEXED][0].primitiveCount, 0))},
    {.name = "vertices_nowhere",
     RULES(RULE_vertex_host_address_is_readable),
     .edits = EDITS(SET(U_TRIANGLES.vertexData, 0x10)),
     .path = "pInfos[1].pGeometries[0].geometry.triangles.vertexData.hostAddress 0x10"},
    {.name = "indexed_vertices_nowhere",
     RULES(RULE_vertex_host_address_is_readable),
     .edits = EDITS(SET(I_TRIANGLES.vertexData, 0x10)),
     .path = "pInfos[0].pGeometries[0].geometry.triangles.vertexData.hostAddress"},
    {.name = "vertices_over_edge",
     RULES(RULE_vertex_host_address_is_readable),
     .mutate = put_vertices_over_edge,
     .mutate_twin = put_vertices_at_edge},
    {.name = "vertices_over_edge_by_offset",
     RULES(RULE_vertex_host_address_is_readable),
     .mutate = offset_vertices_over_edge,
     .mutate_twin = offset_fewer_vertices_at_edge},
    {.name = "vertices_with_a_fourth_component",
     RULES(RULE_vertex_host_address_is_readable),
     .silent = true,
     .mutate = put_wide_vertices_at_edge},
    {.name = "indices_null",
     RULES(RULE_index_host_address_is_readable),
     .edits = EDITS(SET(I_TRIANGLES.indexData, 0)),
     .twin_edits = EDITS(SET(U_TRIANGLES.indexData, 0)),
     .path = "pInfos[0].pGeometries[0].geometry.triangles.indexData.hostAddress is NULL"},
    {.name = "indices_over_edge",
     RULES(RULE_index_host_address_is_readable),
     .mutate = put_indices_over_edge,
     .mutate_twin = put_indices_at_edge,
     .path = "pInfos[0].pGeometries[0].geometry.triangles.indexData.hostAddress"},
    {.name = "short_indices_over_edge",
     RULES(RULE_index_host_address_is_readable),
     .mutate = put_short_indices_over_edge,
     .mutate_twin = put_short_indices_at_edge},
    {.name = "indices_that_are_not_used",
     RULES(RULE_index_host_address_is_readable),
     .silent = true,
     .edits = EDITS(SET(U_TRIANGLES.indexData, 0x10))},
    {.name = "transform_over_edge",
     RULES(RULE_transform_host_address_is_null_or_readable),
     .mutate = put_transform_over_edge,
     .mutate_twin = put_transform_at_edge,
     .path = "pInfos[0].pGeometries[0].geometry.triangles.transformData.hostAddress"},
    {.name = "transform_nowhere",
     RULES(RULE_transform_host_address_is_null_or_readable),
     .edits = EDITS(SET(TRIANGLES(UNINDEXED, 1).transformData, 0x10)),
     .twin_edits = EDITS(SET(TRIANGLES(UNINDEXED, 1).transformData, 0))},
    {.name = "boxes_null",
     RULES(RULE_aabb_host_address_is_readable),
     .edits = EDITS(SET(BOXES(AABBS, 0).data, 0)),
     .path = "pInfos[2].pGeometries[0].geometry.aabbs.data.hostAddress is NULL"},
    {.name = "boxes_over_edge",
     RULES(RULE_aabb_host_address_is_readable),
     .mutate = put_boxes_over_edge,
     .mutate_twin = put_boxes_at_edge,
     .path = "pInfos[2].pGeometries[0].geometry.aabbs.data.hostAddress"},
    {.name = "boxes_over_edge_by_offset",
     RULES(RULE_aabb_host_address_is_readable),
     .mutate = offset_boxes_over_edge,
     .mutate_twin = offset_fewer_boxes_at_edge},
    {.name = "instances_null",
     RULES(RULE_instance_host_address_is_readable),
     .edits = EDITS(SET(INSTANCES(TLAS, 0).data, 0)),
     .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress is NULL"},
    {.name = "instances_over_edge",
     RULES(RULE_instance_host_address_is_readable),
     .mutate = put_instances_over_edge,
     .mutate_twin = put_instances_at_edge,
     .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress"},
    {.name = "pointers_over_edge",
     RULES(RULE_instance_host_address_is_readable),
     .mutate = put_pointers_over_edge,
     .mutate_twin = put_pointers_at_edge},
    {.name = "nowhere_without_primitives",
     RULES(RULE_vertex_host_address_is_readable, RULE_index_host_address_is_readable,
           RULE_transform_host_address_is_null_or_readable, RULE_aabb_host_address_is_readable,
           RULE_instance_host_address_is_readable),
     .silent = true,
     .mutate = put_all_nowhere_without_primitives},

    {.name = "scratch_null",
     RULES(RULE_build_scratch_is_host_memory),
     .edits = EDITS(SET(infos[AABBS].scratchData, 0)),
     .path = "pInfos[2].scratchData.hostAddress 0x0"},
    {.name = "scratch_over_edge",
     RULES(RULE_build_scratch_is_host_memory),
     .mutate = put_scratch_of_AABBS_over_edge,
     .mutate_twin = put_scratch_of_AABBS_at_edge,
     .path = "pInfos[2].scratchData.hostAddress"},
    {.name = "scratch_of_update_null",
     RULES(RULE_update_scratch_is_host_memory),
     .edits = EDITS(SET(infos[REFIT].scratchData, 0)),
     .path = "pInfos[5].scratchData.hostAddress 0x0"},
    {.name = "scratch_of_update_over_edge",
     RULES(RULE_update_scratch_is_host_memory),
     .mutate = put_scratch_of_REFIT_over_edge,
     .mutate_twin = put_scratch_of_REFIT_at_edge,
     .path = "pInfos[5].scratchData.hostAddress"},
    {.name = "scratch_shared_in_own_memory",
     RULES(RULE_scratch_and_scratch_are_apart),
     .mutate = overlap_scratch_in_own_memory,
     .mutate_twin = put_scratch_side_by_side_in_own_memory,
     .commands = ON_HOST,
     .path = "pInfos[0].scratchData shares host memory [0x"},
    {.name = "scratch_in_memory_unmapped",
     RULES(RULE_dst_and_scratch_are_apart),
     .silent = true,
     .mutate = unmap_shared_scratch,
     .commands = ON_HOST,
     .needs_null_driver = true},
};

CASE_LIST(cases_host, cases);
