/* SPDX-License-Identifier: Apache-2.0 */
/* Instances that disable the micromaps of what they refer to, which has to have been built so that
 * they may. */
#include "case.h"
#include "scene_extensions.h"

static const struct setup with_content = {.enable = ENABLE_OPACITY_MICROMAP_KHR,
                                          .level = "content"};

#define ALLOW_DISABLING VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_KHR

/* A BLAS that is like INDEXED; its index behind the builds, where the next one will be, too. */
static uint32_t build_blas(struct scene *scene, VkBuildAccelerationStructureFlagsKHR flags)
{
    const uint32_t build = scene_reserve_build(scene, INDEXED);
    scene->infos[build].flags = flags;
    scene_build_before(scene, build, 1);
    return build;
}

/* 0 of a BLAS that doesn't allow it, 2 of one that does and has it disabled. */
static void use_instances(struct scene *scene)
{
    const VkAccelerationStructureKHR plain =
        scene->infos[build_blas(scene, 0)].dstAccelerationStructure;
    const VkAccelerationStructureKHR allowing =
        scene->infos[build_blas(scene, ALLOW_DISABLING)].dstAccelerationStructure;
    scene_refer(scene, 0, plain);
    scene_refer(scene, 2, allowing);
    scene_instance(scene, 2)->flags = VK_GEOMETRY_INSTANCE_DISABLE_OPACITY_MICROMAPS_BIT_KHR;
}

#define DISABLES(index)                                                                            \
    WRITE_FLAGS(instances, index, VK_GEOMETRY_INSTANCE_DISABLE_OPACITY_MICROMAPS_BIT_KHR)

/* Another build of what instance 0 refers to, with other flags. */
static void use_rebuilt_instances(struct scene *scene)
{
    use_instances(scene);
    const uint32_t build = build_blas(scene, ALLOW_DISABLING);
    scene_refer(scene, 0, scene->infos[build].dstAccelerationStructure);
    scene->infos[build].flags = 0;
    scene_build_before(scene, build, 1);
}

/* A clone of what instance 0 refers to. */
static void use_clone_of(struct scene *scene, VkBuildAccelerationStructureFlagsKHR flags)
{
    use_instances(scene);
    const VkAccelerationStructureKHR source =
        scene->infos[build_blas(scene, flags)].dstAccelerationStructure;
    const VkAccelerationStructureKHR clone = scene_accel_for(scene, INDEXED);
    scene_copy(scene, source, clone, VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    scene_refer(scene, 0, clone);
}

/* What comes after doesn't count. */
static void rebuild_what_allowed(struct scene *scene)
{
    const uint32_t build = scene->info_count; /* the last of use_instances() */
    scene->infos[build].flags = 0;
    scene->vk->CmdBuildAccelerationStructuresKHR(scene->command_buffer, 1, &scene->infos[build],
                                                 &scene->range_pointers[build]);
}

/* ---- of the host ---- */

static void use_what_allows_it_now(struct scene *scene)
{
    use_instances(scene);
    const uint32_t build = build_blas(scene, 0);
    scene_refer(scene, 0, scene->infos[build].dstAccelerationStructure);
    scene->infos[build].flags = ALLOW_DISABLING;
    scene_build_before(scene, build, 1);
}

/* A build of the host's, from the same data by device addresses. */
static void record_on_device(struct scene *scene, uint32_t build, VkCommandBuffer command_buffer)
{
    VkAccelerationStructureGeometryKHR geometry = scene->geometries[build][0];
    VkAccelerationStructureGeometryTrianglesDataKHR *triangles = &geometry.geometry.triangles;
    VkAccelerationStructureBuildGeometryInfoKHR info = scene->infos[build];
    triangles->vertexData.deviceAddress = scene->vertices.address;
    triangles->indexData.deviceAddress = scene->indices.address;
    triangles->transformData.deviceAddress = scene->transforms.address;
    info.pGeometries = &geometry;
    info.scratchData.deviceAddress = scene->scratch_buffers[build].address;
    scene->vk->CmdBuildAccelerationStructuresKHR(command_buffer, 1, &info,
                                                 &scene->range_pointers[build]);
}

/* What the host has built with other flags before. */
static void rebuild_on_device(struct scene *scene)
{
    use_instances(scene);
    const uint32_t build = build_blas(scene, ALLOW_DISABLING);
    const uint32_t family = fixture_find_family(scene->fixture, VK_QUEUE_COMPUTE_BIT, 0);
    const VkCommandBuffer command_buffer = scene_command_buffer(scene, family);
    const VkSubmitInfo submit_info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                                      .commandBufferCount = 1,
                                      .pCommandBuffers = &command_buffer};
    VkQueue queue;
    scene_refer(scene, 0, scene->infos[build].dstAccelerationStructure);
    scene->infos[build].flags = 0;
    scene_begin(scene, command_buffer, 0);
    record_on_device(scene, build, command_buffer);
    scene_end(scene, command_buffer);
    scene->vk->GetDeviceQueue(scene->fixture->device, family, 0, &queue);
    expect_success(scene->vk->QueueSubmit(queue, 1, &submit_info, VK_NULL_HANDLE), "vkQueueSubmit");
}

static void wait_for_the_device(struct scene *scene)
{
    expect_success(scene->vk->DeviceWaitIdle(scene->fixture->device), "vkDeviceWaitIdle");
}

#define INSTANCE_0                                                                                 \
    "pInfos[3].pGeometries[0].geometry.instances.data.deviceAddress leads to instance 0, whose "   \
    "flags 0x20 disable micromaps"

#define HOST_INSTANCE_0                                                                            \
    "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance 0, whose "     \
    "flags 0x20 disable micromaps"

static const struct test_case cases[] = {
    SHARED(RULE(instances_disable_micromaps_only_if_their_blas_allows),
           NAMES(RULE_instance_disables_micromaps_only_if_its_blas_allows),
           .commands = ON_COMMAND_BUFFERS, .setup = &with_content, .is_for_contents = true),
    CASE("instance_disables_what_is_not_to_be", .prepare = use_instances, EDITS(DISABLES(0)),
         TWIN_EDITS(DISABLES(1)), .path = INSTANCE_0),
    CASE("instance_disables_what_was_built_anew", .prepare = use_rebuilt_instances,
         EDITS(DISABLES(0)), TWIN_EDITS(DISABLES(1)), .path = INSTANCE_0),
    CASE("instance_disables_a_clone", PREPARE_EDITS(CALL_WITH(use_clone_of, 0)), EDITS(DISABLES(0)),
         TWIN_EDITS(DISABLES(1)), .path = INSTANCE_0),
    CASE("instance_disables_a_clone_that_allows_it", .silent = true,
         PREPARE_EDITS(CALL_WITH(use_clone_of, ALLOW_DISABLING)), EDITS(DISABLES(0))),
    CASE("instance_disables_what_is_built_anew_later", .silent = true, .prepare = use_instances,
         EDITS(DISABLES(1)), .then = rebuild_what_allowed),

    SHARED(RULE(instance_disables_micromaps_only_if_its_blas_allows), .commands = ON_HOST,
           .setup = &with_content, .is_for_the_call = true),
    CASE("instance_of_the_host_disables_what_is_not_to_be", .mutate = use_instances,
         EDITS(DISABLES(0)), .mutate_twin = use_instances, .path = HOST_INSTANCE_0),
    CASE("instance_of_the_host_disables_what_was_built_anew", .mutate = use_rebuilt_instances,
         EDITS(DISABLES(0)), .mutate_twin = use_rebuilt_instances, .path = HOST_INSTANCE_0),
    CASE("instance_of_the_host_disables_what_the_device_has_built", .mutate = rebuild_on_device,
         EDITS(CALL(wait_for_the_device), DISABLES(0)), .mutate_twin = use_instances,
         .path = HOST_INSTANCE_0),
    CASE("instance_of_the_host_disables_what_allows_it_now", .silent = true,
         .mutate = use_what_allows_it_now, EDITS(DISABLES(0))),
    /* The host doesn't know that it is complete. */
    CASE("instance_of_the_host_disables_what_the_device_may_build", .silent = true,
         .mutate = rebuild_on_device, EDITS(DISABLES(0)), .then = wait_for_the_device),
};

CASE_LIST(cases_disabling, cases);
