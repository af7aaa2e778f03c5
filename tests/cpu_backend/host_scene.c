/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes, and the frame of the tests' programs. */
#include "host_scene.h"

#include <stdio.h>
#include <stdlib.h>

struct stage stage;

void expect_silence(void)
{
    for (uint32_t i = 0; i < messages_kept(&stage.kit.messages); i++)
        print_error("%s: %s\n", stage.kit.messages.items[i].id, stage.kit.messages.items[i].text);
    assert_int_equal(stage.kit.messages.count, 0);
}

void forget_messages(void)
{
    messages_clear(&stage.kit.messages);
}

void open_scene(struct scene *scene, uint32_t triangles, VkBuildAccelerationStructureFlagsKHR flags)
{
    stage_triangles(&scene->triangles, triangles, flags);
    scene->blas = stage_create_for(&stage, &scene->triangles);
    expect(
        stage_build(&stage, VK_NULL_HANDLE, &scene->triangles, scene->blas.handle, VK_NULL_HANDLE));
    const VkAccelerationStructureKHR blases[] = {scene->blas.handle, scene->blas.handle};
    stage_instances(&scene->instances, blases, 2, flags);
    scene->tlas = stage_create_for(&stage, &scene->instances);
    expect(
        stage_build(&stage, VK_NULL_HANDLE, &scene->instances, scene->tlas.handle, VK_NULL_HANDLE));
}

void close_scene(struct scene *scene)
{
    stage_destroy(&stage, &scene->tlas);
    stage_destroy(&stage, &scene->blas);
    stage_free(&scene->instances);
    stage_free(&scene->triangles);
}

void expect_hit(VkAccelerationStructureKHR structure, float y, float t, uint32_t instance)
{
    AssayHit hit = stage_trace(&stage, structure, y, 0.25f);
    assert_true(hit.isHit);
    assert_float_equal(hit.t, t, 0);
    assert_float_equal(hit.u, 0.25, 1e-6);
    assert_float_equal(hit.v, 0.25, 1e-6);
    assert_int_equal(hit.primitive, 0);
    assert_int_equal(hit.instance, instance);
    assert_int_equal(hit.customIndex, instance == UINT32_MAX ? 0 : 100 + instance);
    assert_true(hit.isOpaque);
    assert_false(hit.isAabb);
}

void expect_scene(VkAccelerationStructureKHR tlas, float t)
{
    expect_hit(tlas, 0.25f, t, 0);
    expect_hit(tlas, 2.25f, t, 1);
    assert_false(stage_trace(&stage, tlas, 1.5f, 0.25f).isHit);
}

VkResult copy_structure(VkAccelerationStructureKHR src, VkAccelerationStructureKHR dst,
                        VkCopyAccelerationStructureModeKHR mode)
{
    const VkCopyAccelerationStructureInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR,
        .src = src,
        .dst = dst,
        .mode = mode};
    return stage.vk.CopyAccelerationStructureKHR(stage.device, VK_NULL_HANDLE, &info);
}

uint64_t property(VkAccelerationStructureKHR structure, VkQueryType type)
{
    uint64_t values[4] = {7, 7, 7, 7};
    const VkAccelerationStructureKHR both[] = {structure, structure};
    expect(stage.vk.WriteAccelerationStructuresPropertiesKHR(stage.device, 2, both, type,
                                                             sizeof(values), values, 16));
    assert_int_equal(values[0], values[2]);
    assert_int_equal(values[1], 7);
    assert_int_equal(values[3], 7);
    return values[0];
}

void *serialize(VkAccelerationStructureKHR src, size_t *size)
{
    *size = property(src, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR);
    void *bytes = malloc(*size);
    const VkCopyAccelerationStructureToMemoryInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_TO_MEMORY_INFO_KHR,
        .src = src,
        .dst.hostAddress = bytes,
        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR};
    expect(stage.vk.CopyAccelerationStructureToMemoryKHR(stage.device, VK_NULL_HANDLE, &info));
    return bytes;
}

int stage_main(int argc, char **argv, int (*run)(void))
{
    const char *reason = argc == 2 ? stage_open(&stage, argv[1]) : "a platform is to be named";
    if (reason) {
        printf("skipped: %s\n", reason);
        return 77;
    }
    int failed = run();
    stage_close(&stage);
    return failed;
}
