/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes that the host builds. */
#include "host_scene.h"

struct scene scene;

void open_scene(uint32_t triangles, VkBuildAccelerationStructureFlagsKHR flags)
{
    fixture_triangles(&scene.triangles, triangles, flags);
    scene.blas = fixture_create_for(&scene.triangles);
    GET(host_build(&scene.triangles, scene.blas.handle, VK_NULL_HANDLE));
    const VkAccelerationStructureKHR blases[] = {scene.blas.handle, scene.blas.handle};
    fixture_instances(&scene.instances, blases, 2, flags);
    scene.tlas = fixture_create_for(&scene.instances);
    GET(host_build(&scene.instances, scene.tlas.handle, VK_NULL_HANDLE));
}

void destroy_scene(void)
{
    destroy((uint64_t)scene.tlas.handle);
    destroy((uint64_t)scene.blas.handle);
}

void expect_hit(VkAccelerationStructureKHR structure, float y, float t, uint32_t number)
{
    AssayHit hit = fixture_trace(structure, y, 0.25f);
    assert_true(hit.isHit);
    assert_float_equal(hit.t, t, 0);
    assert_float_equal(hit.u, 0.25, 1e-6);
    assert_float_equal(hit.v, 0.25, 1e-6);
    assert_int_equal(hit.primitive, 0);
    assert_int_equal(hit.instance, number);
    assert_int_equal(hit.customIndex, number == UINT32_MAX ? 0 : 100 + number);
    assert_true(hit.isOpaque);
    assert_false(hit.isAabb);
}

void expect_scene(VkAccelerationStructureKHR tlas, float t)
{
    expect_hit(tlas, 0.25f, t, 0);
    expect_hit(tlas, 2.25f, t, 1);
    assert_false(fixture_trace(tlas, 1.5f, 0.25f).isHit);
}

VkResult copy_structure(VkAccelerationStructureKHR src, VkAccelerationStructureKHR dst,
                        VkCopyAccelerationStructureModeKHR mode)
{
    return fixture_copy(VK_NULL_HANDLE, src, dst, mode);
}
