/* SPDX-License-Identifier: Apache-2.0 */
/* Instances that disable the micromaps of what they refer to, which has to have been built so that
 * they may. */
#include "case.h"

static const struct setup with_content = {.enable = ENABLE_OPACITY_MICROMAP_KHR,
                                          .level = "content"};

#define ALLOW_DISABLING VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_KHR

static VkAccelerationStructureInstanceKHR *instance_at(struct scene *scene, uint32_t index)
{
    return (VkAccelerationStructureInstanceKHR *)(void *)scene->instances.host + index;
}

/* A BLAS that is like INDEXED; its index behind the builds, where the next one will be, too. */
static uint32_t build_blas(struct scene *scene, VkBuildAccelerationStructureFlagsKHR flags)
{
    const uint32_t build = scene_add_build(scene, INDEXED);
    scene->info_count--;
    scene->infos[build].flags = flags;
    scene_build_before(scene, build, 1);
    return build;
}

static void refer(struct scene *scene, uint32_t index, VkAccelerationStructureKHR blas)
{
    instance_at(scene, index)->accelerationStructureReference = scene_reference(scene, blas);
}

/* 0 of a BLAS that doesn't allow it, 2 of one that does and has it disabled. */
static void use_instances(struct scene *scene)
{
    const VkAccelerationStructureKHR plain =
        scene->infos[build_blas(scene, 0)].dstAccelerationStructure;
    const VkAccelerationStructureKHR allowing =
        scene->infos[build_blas(scene, ALLOW_DISABLING)].dstAccelerationStructure;
    refer(scene, 0, plain);
    refer(scene, 2, allowing);
    instance_at(scene, 2)->flags = VK_GEOMETRY_INSTANCE_DISABLE_OPACITY_MICROMAPS_BIT_KHR;
}

#define DISABLE(name, index)                                                                       \
    static void name(struct scene *scene)                                                          \
    {                                                                                              \
        instance_at(scene, index)->flags = VK_GEOMETRY_INSTANCE_DISABLE_OPACITY_MICROMAPS_BIT_KHR; \
    }

DISABLE(instance_0_disables, 0)
DISABLE(instance_of_nothing_disables, 1)

/* Another build of what instance 0 refers to, with other flags. */
static void use_rebuilt_instances(struct scene *scene)
{
    use_instances(scene);
    const uint32_t build = build_blas(scene, ALLOW_DISABLING);
    refer(scene, 0, scene->infos[build].dstAccelerationStructure);
    scene->infos[build].flags = 0;
    scene_build_before(scene, build, 1);
}

/* A clone of what instance 0 refers to. */
static void use_clone_of(struct scene *scene, VkBuildAccelerationStructureFlagsKHR flags)
{
    use_instances(scene);
    const VkCopyAccelerationStructureInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR,
        .src = scene->infos[build_blas(scene, flags)].dstAccelerationStructure,
        .dst = scene_accel_for(scene, INDEXED),
        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR,
    };
    const VkCommandBuffer command_buffer = scene_begin_before(scene);
    scene->vk->CmdCopyAccelerationStructureKHR(command_buffer, &info);
    scene_end_before(scene, command_buffer);
    refer(scene, 0, info.dst);
}

static void use_clone_that_allows(struct scene *scene)
{
    use_clone_of(scene, ALLOW_DISABLING);
}

static void use_clone_that_does_not(struct scene *scene)
{
    use_clone_of(scene, 0);
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

static void use_instances_and_disable(struct scene *scene)
{
    use_instances(scene);
    instance_0_disables(scene);
}

static void use_rebuilt_instances_and_disable(struct scene *scene)
{
    use_rebuilt_instances(scene);
    instance_0_disables(scene);
}

static void use_what_allows_it_now(struct scene *scene)
{
    use_instances(scene);
    const uint32_t build = build_blas(scene, 0);
    refer(scene, 0, scene->infos[build].dstAccelerationStructure);
    scene->infos[build].flags = ALLOW_DISABLING;
    scene_build_before(scene, build, 1);
    instance_0_disables(scene);
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
    refer(scene, 0, scene->infos[build].dstAccelerationStructure);
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

static void use_what_the_device_has_built(struct scene *scene)
{
    rebuild_on_device(scene);
    wait_for_the_device(scene);
    instance_0_disables(scene);
}

/* The host doesn't know that it is complete. */
static void use_what_the_device_may_build(struct scene *scene)
{
    rebuild_on_device(scene);
    instance_0_disables(scene);
}

#define INSTANCE_0                                                                                 \
    "pInfos[3].pGeometries[0].geometry.instances.data.deviceAddress leads to instance 0, whose "   \
    "flags 0x20 disable micromaps"

#define HOST_INSTANCE_0                                                                            \
    "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance 0, whose "     \
    "flags 0x20 disable micromaps"

static const struct test_case cases[] = {
    SHARED(RULES(RULE_instances_disable_micromaps_only_if_their_blas_allows),
           NAMES(RULE_instance_disables_micromaps_only_if_its_blas_allows),
           .commands = ON_COMMAND_BUFFERS, .setup = &with_content, .mutate = instance_0_disables,
           .is_for_contents = true),
    CASE("instance_disables_what_is_not_to_be", .prepare = use_instances,
         .mutate_twin = instance_of_nothing_disables, .path = INSTANCE_0),
    CASE("instance_disables_what_was_built_anew", .prepare = use_rebuilt_instances,
         .mutate_twin = instance_of_nothing_disables, .path = INSTANCE_0),
    CASE("instance_disables_a_clone", .prepare = use_clone_that_does_not,
         .mutate_twin = instance_of_nothing_disables, .path = INSTANCE_0),
    CASE("instance_disables_a_clone_that_allows_it", .silent = true,
         .prepare = use_clone_that_allows),
    CASE("instance_disables_what_is_built_anew_later", .silent = true, .prepare = use_instances,
         .mutate = instance_of_nothing_disables, .then = rebuild_what_allowed),

    SHARED(RULE(instance_disables_micromaps_only_if_its_blas_allows), .commands = ON_HOST,
           .setup = &with_content, .is_for_the_call = true),
    CASE("instance_of_the_host_disables_what_is_not_to_be", .mutate = use_instances_and_disable,
         .mutate_twin = use_instances, .path = HOST_INSTANCE_0),
    CASE("instance_of_the_host_disables_what_was_built_anew",
         .mutate = use_rebuilt_instances_and_disable, .mutate_twin = use_rebuilt_instances,
         .path = HOST_INSTANCE_0),
    CASE("instance_of_the_host_disables_what_the_device_has_built",
         .mutate = use_what_the_device_has_built, .mutate_twin = use_instances,
         .path = HOST_INSTANCE_0),
    CASE("instance_of_the_host_disables_what_allows_it_now", .silent = true,
         .mutate = use_what_allows_it_now),
    CASE("instance_of_the_host_disables_what_the_device_may_build", .silent = true,
         .mutate = use_what_the_device_may_build, .then = wait_for_the_device),
};

CASE_LIST(cases_disabling, cases);
