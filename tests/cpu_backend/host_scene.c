/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes, and the frame of the tests' programs. */
#include "host_scene.h"

struct fixture fixture;
struct scene scene;

void expect_silence(void)
{
    messages_expect_none(&fixture.instance_fixture.messages);
}

void forget_messages(void)
{
    messages_clear(&fixture.instance_fixture.messages);
}

void open_scene(uint32_t triangles, VkBuildAccelerationStructureFlagsKHR flags)
{
    fixture_triangles(&scene.triangles, triangles, flags);
    scene.blas = fixture_create_for(&fixture, &scene.triangles);
    GET(host_build(&scene.triangles, scene.blas.handle, VK_NULL_HANDLE));
    const VkAccelerationStructureKHR blases[] = {scene.blas.handle, scene.blas.handle};
    fixture_instances(&scene.instances, blases, 2, flags);
    scene.tlas = fixture_create_for(&fixture, &scene.instances);
    GET(host_build(&scene.instances, scene.tlas.handle, VK_NULL_HANDLE));
}

void close_scene(void)
{
    fixture_destroy(&fixture, &scene.tlas);
    fixture_destroy(&fixture, &scene.blas);
    fixture_free(&scene.instances);
    fixture_free(&scene.triangles);
}

void close_silent_scene(void)
{
    close_scene();
    expect_silence();
}

void close_any_scene(void)
{
    close_scene();
    forget_messages();
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

VkResult host_build(struct fixture_build *build, VkAccelerationStructureKHR dst,
                    VkAccelerationStructureKHR src)
{
    return fixture_build(&fixture, VK_NULL_HANDLE, build, dst, src);
}

VkResult copy_structure(VkAccelerationStructureKHR src, VkAccelerationStructureKHR dst,
                        VkCopyAccelerationStructureModeKHR mode)
{
    return fixture_copy(&fixture, VK_NULL_HANDLE, src, dst, mode);
}

uint64_t property(VkAccelerationStructureKHR structure, VkQueryType type)
{
    return fixture_property(&fixture, structure, type);
}

void *serialize(VkAccelerationStructureKHR src, size_t *size)
{
    return fixture_serialize(&fixture, src, size);
}

const char *unit_test_open(const char *name)
{
    return fixture_open(&fixture, name);
}

void unit_test_close(void)
{
    fixture_close(&fixture);
}
