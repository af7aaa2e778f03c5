/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes, and the frame of the tests' programs. */
#include "host_scene.h"

#include <stdlib.h>

struct fixture fixture;

void expect_silence(void)
{
    messages_expect_none(&fixture.instance_fixture.messages);
}

void forget_messages(void)
{
    messages_clear(&fixture.instance_fixture.messages);
}

void open_scene(struct scene *scene, uint32_t triangles, VkBuildAccelerationStructureFlagsKHR flags)
{
    fixture_triangles(&scene->triangles, triangles, flags);
    scene->blas = fixture_create_for(&fixture, &scene->triangles);
    GET(fixture_build(&fixture, VK_NULL_HANDLE, &scene->triangles, scene->blas.handle,
                      VK_NULL_HANDLE));
    const VkAccelerationStructureKHR blases[] = {scene->blas.handle, scene->blas.handle};
    fixture_instances(&scene->instances, blases, 2, flags);
    scene->tlas = fixture_create_for(&fixture, &scene->instances);
    GET(fixture_build(&fixture, VK_NULL_HANDLE, &scene->instances, scene->tlas.handle,
                      VK_NULL_HANDLE));
}

void close_scene(struct scene *scene)
{
    fixture_destroy(&fixture, &scene->tlas);
    fixture_destroy(&fixture, &scene->blas);
    fixture_free(&scene->instances);
    fixture_free(&scene->triangles);
}

void expect_hit(VkAccelerationStructureKHR structure, float y, float t, uint32_t instance)
{
    AssayHit hit = fixture_trace(&fixture, structure, y, 0.25f);
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
    assert_false(fixture_trace(&fixture, tlas, 1.5f, 0.25f).isHit);
}

VkResult copy_structure(VkAccelerationStructureKHR src, VkAccelerationStructureKHR dst,
                        VkCopyAccelerationStructureModeKHR mode)
{
    const VkCopyAccelerationStructureInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR,
        .src = src,
        .dst = dst,
        .mode = mode};
    return fixture.vk.CopyAccelerationStructureKHR(fixture.device, VK_NULL_HANDLE, &info);
}

uint64_t property(VkAccelerationStructureKHR structure, VkQueryType type)
{
    uint64_t values[4] = {7, 7, 7, 7};
    const VkAccelerationStructureKHR both[] = {structure, structure};
    GET(fixture.vk.WriteAccelerationStructuresPropertiesKHR(fixture.device, 2, both, type,
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
    GET(fixture.vk.CopyAccelerationStructureToMemoryKHR(fixture.device, VK_NULL_HANDLE, &info));
    return bytes;
}

static const char *open(const char *name)
{
    return fixture_open(&fixture, name);
}

static void close(void)
{
    fixture_close(&fixture);
}

int fixture_main(int argc, char **argv, const struct CMUnitTest *tests, size_t count)
{
    return tests_run(argc, argv, NULL, open, close, tests, count);
}
