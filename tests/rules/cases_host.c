/* SPDX-License-Identifier: Apache-2.0 */
/* What only host builds have: structures that the host can reach, and operations that they are
 * deferred to. */
#include "case.h"
#include "placing.h"

/* ---- handles of devices ---- */

static void call_on_a_queue(struct scene *scene)
{
    VkQueue queue;
    scene->vk->GetDeviceQueue(scene->fixture->device, 0, 0, &queue);
    scene->device = (VkDevice)queue;
}

static void call_on_zeros(struct scene *scene)
{
    scene->device = bytes_before_unreadable_page(64);
}

/* ---- deferred operations ---- */

static VkDeferredOperationKHR create_operation(struct scene *scene)
{
    VkDeferredOperationKHR operation;
    expect_success(scene->vk->CreateDeferredOperationKHR(scene->fixture->device, NULL, &operation),
                   "vkCreateDeferredOperationKHR");
    return operation;
}

SCENE_DESTROYS(destroy_operation, DestroyDeferredOperationKHR, VkDeferredOperationKHR)

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
    scene_defer(scene, scene->fixture->device, (uint64_t)scene->deferred_operation,
                join_and_destroy);
}

static void defer_to_a_destroyed_operation(struct scene *scene)
{
    scene->deferred_operation = create_operation(scene);
    destroy_operation(scene, scene->fixture->device, (uint64_t)scene->deferred_operation);
}

static void defer_to_another_device(struct scene *scene)
{
    scene_enter_other_device(scene);
    scene->deferred_operation = create_operation(scene);
    scene_defer(scene, scene->fixture->device, (uint64_t)scene->deferred_operation,
                destroy_operation);
    scene_leave_other_device(scene);
}

/* A build before the scene's is deferred to the same operation. */
static void defer_twice(struct scene *scene)
{
    defer(scene);
    scene->vk->BuildAccelerationStructuresKHR(scene->fixture->device, scene->deferred_operation, 1,
                                              &scene->infos[INDEXED],
                                              &scene->range_pointers[INDEXED]);
}

static void complete_the_operation(struct scene *scene)
{
    while (scene->vk->DeferredOperationJoinKHR(scene->fixture->device, scene->deferred_operation) ==
           VK_THREAD_IDLE_KHR)
        continue;
}

/* ---- structures ---- */

static VkAccelerationStructureKHR accel_in(struct scene *scene, struct test_buffer buffer,
                                           uint32_t build)
{
    return scene_accel_in(scene, &buffer, 0, place_size(scene, build), scene->infos[build].type);
}

static VkAccelerationStructureKHR in_a_buffer(struct scene *scene, uint32_t build)
{
    return accel_in(scene, place_buffer(scene), build);
}

static VkAccelerationStructureKHR in_device_memory(struct scene *scene, uint32_t build)
{
    return accel_in(scene, place_device_local_buffer(scene), build);
}

static VkAccelerationStructureKHR in_visible_memory(struct scene *scene, uint32_t build)
{
    return accel_in(scene, place_buffer_of_instances(scene, 1), build);
}

static VkAccelerationStructureKHR of_two_instances(struct scene *scene, uint32_t build)
{
    return accel_in(scene, place_buffer_of_instances(scene, 3), build);
}

/* What the host could not have built itself is deserialized on the device. */
static void deserialize_src(struct scene *scene)
{
    const uint32_t family = fixture_find_family(scene->fixture, VK_QUEUE_COMPUTE_BIT, 0);
    const VkCommandBuffer command_buffer = scene_command_buffer(scene, family);
    const VkCopyMemoryToAccelerationStructureInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_MEMORY_TO_ACCELERATION_STRUCTURE_INFO_KHR,
        .src.deviceAddress = scene->boxes.address,
        .dst = scene->infos[UPDATE].srcAccelerationStructure,
        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR,
    };
    scene_begin(scene, command_buffer, 0);
    scene->vk->CmdCopyMemoryToAccelerationStructureKHR(command_buffer, &info);
    scene_end(scene, command_buffer);
    scene_submit(scene, family, command_buffer);
}

#define DST(function) MAKE_STRUCTURE_WITH(infos[AABBS].dstAccelerationStructure, function, AABBS)
#define SRC(function)                                                                              \
    MAKE_STRUCTURE_WITH(infos[UPDATE].srcAccelerationStructure, function, UPDATE),                 \
        CALL(deserialize_src)
/* An update in place. */
#define SRC_AND_DST(function)                                                                      \
    SRC(function),                                                                                 \
        COPY(infos[UPDATE].dstAccelerationStructure, infos[UPDATE].srcAccelerationStructure)
#define IGNORED_SRC(function)                                                                      \
    MAKE_STRUCTURE_WITH(infos[AABBS].srcAccelerationStructure, function, AABBS)

static const struct test_case cases[] = {
    SHARED(RULE(device_is_valid), .commands = ON_HOST),
    CASE("device_is_a_queue", .mutate = call_on_a_queue, .path = "(): device 0x"),
    CASE("device_is_null", EDITS(SET(device, 0)), .path = "(): device is VK_NULL_HANDLE."),
    CASE("device_is_unreadable", EDITS(UNREADABLE(device))),
    CASE("device_is_zeros", .mutate = call_on_zeros),

    SHARED(RULE(deferred_operation_is_valid), .mutate_twin = defer),
    CASE("deferred_operation_forged", EDITS(SET(deferred_operation, 0xdeadbeef)),
         .path = "(): deferredOperation VkDeferredOperationKHR 0xdeadbeef is not"),
    CASE("deferred_operation_destroyed", .mutate = defer_to_a_destroyed_operation),

    SHARED(.path = "(): deferredOperation VkDeferredOperationKHR"),
    CASE("deferred_operation_of_another_device", RULE(deferred_operation_is_of_the_device),
         .mutate = defer_to_another_device, .mutate_twin = defer),
    CASE("deferred_operation_in_use", RULE(previous_deferred_operation_is_complete),
         .prepare = defer_twice, .mutate_twin = complete_the_operation, .spares_drivers = true),
    CASE("dst_by_address", RULE(host_build_dst_was_created_with_a_buffer),
         SETUP(.enable = ENABLE_OPACITY_MICROMAP_KHR), EDITS(DST(place_accel_by_address)),
         TWIN_EDITS(DST(in_visible_memory)), .path = "pInfos[2].dstAccelerationStructure"),

    SHARED(RULE(host_build_src_was_created_with_a_buffer)),
    CASE("src_by_address", SETUP(.enable = ENABLE_OPACITY_MICROMAP_KHR),
         EDITS(SRC(place_accel_by_address)), TWIN_EDITS(SRC(in_a_buffer)), .may_fail_on_cpu = true,
         .path = "pInfos[4].srcAccelerationStructure"),
    CASE("ignored_src_by_address", .silent = true, SETUP(.enable = ENABLE_OPACITY_MICROMAP_KHR),
         EDITS(IGNORED_SRC(place_accel_by_address))),
    CASE("dst_in_device_memory", RULE(host_build_dst_is_host_visible), EDITS(DST(in_device_memory)),
         TWIN_EDITS(DST(in_visible_memory)), .path = "pInfos[2].dstAccelerationStructure"),

    SHARED(.path = "pInfos[4].srcAccelerationStructure"),
    CASE("src_in_device_memory", RULE(host_build_src_is_host_visible), EDITS(SRC(in_device_memory)),
         TWIN_EDITS(IGNORED_SRC(in_device_memory))),
    CASE("dst_of_two_instances", RULE(host_build_dst_has_one_memory_instance),
         SETUP(.enable = ENABLE_GROUP), EDITS(DST(of_two_instances)),
         TWIN_EDITS(DST(in_visible_memory)), .path = "pInfos[2].dstAccelerationStructure"),
    CASE("refit_by_address", RULE(host_build_dst_was_created_with_a_buffer),
         NAMES(RULE_host_build_src_was_created_with_a_buffer),
         SETUP(.enable = ENABLE_OPACITY_MICROMAP_KHR), EDITS(SRC_AND_DST(place_accel_by_address)),
         .path = "pInfos[4]."),
    CASE("refit_in_device_memory", RULE(host_build_dst_is_host_visible),
         NAMES(RULE_host_build_src_is_host_visible), EDITS(SRC_AND_DST(in_device_memory)),
         .path = "pInfos[4]."),
    CASE("refit_of_two_instances", RULE(host_build_dst_has_one_memory_instance),
         NAMES(RULE_host_build_src_has_one_memory_instance), SETUP(.enable = ENABLE_GROUP),
         EDITS(SRC_AND_DST(of_two_instances)), .path = "pInfos[4]."),
    CASE("src_of_two_instances", RULE(host_build_src_has_one_memory_instance),
         SETUP(.enable = ENABLE_GROUP), EDITS(SRC(of_two_instances)),
         TWIN_EDITS(IGNORED_SRC(of_two_instances))),
};

CASE_LIST(cases_host, cases);
