/* SPDX-License-Identifier: Apache-2.0 */
/* Messages about an address say which object had it, and when that was destroyed. */
#include "tests/snapshots/scene.h"

#include <stdio.h>

#include "src/state/resources/destroyed.h"

enum { BUFFER_SIZE = 1 << 16 };

static struct device_buffer instances;

static void open_scene(void)
{
    SCENE_OPEN(.boxes_size = BUFFER_SIZE, .structure_size = BUFFER_SIZE, .has_tlas = true);
    instances = scene_input(BUFFER_SIZE);
    scene_write_instance(&instances, true);
}

static void submit_nothing(uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        GET(fixture.vk.QueueSubmit(fixture.queue, 0, NULL, VK_NULL_HANDLE));
}

static void destroy_blas(void)
{
    fixture.vk.DestroyAccelerationStructureKHR(fixture.device, scene.blas, NULL);
    fixture.structures[0] = fixture.structures[--fixture.structure_count];
}

static VkCommandBuffer record_tlas(void)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    scene_build_instance(commands, instances.address, false);
    return commands;
}

static void run(VkCommandBuffer commands)
{
    scene_submit(commands);
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
}

SCENE_TEST(test_structure)
{
    char text[256];
    snprintf(text, sizeof(text),
             "is not the address of an acceleration structure of this device. "
             "VkAccelerationStructureKHR 0x%llx[\"rabbit\"] had this address and was destroyed 3 "
             "submissions ago.",
             (unsigned long long)scene.blas);
    scene_set_name(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, (uint64_t)scene.blas, "rabbit");
    VkCommandBuffer commands = record_tlas();
    destroy_blas();
    submit_nothing(2);
    run(commands);
    expect_messages(1, text);
}

SCENE_TEST(test_structure_of_last_submission)
{
    VkCommandBuffer commands = record_tlas();
    destroy_blas();
    run(commands);
    expect_messages(1, " had this address and was destroyed 1 submission ago.");
}

/* Nothing was ever there. */
SCENE_TEST(test_wild_reference)
{
    ((VkAccelerationStructureInstanceKHR *)instances.bytes)->accelerationStructureReference =
        0x1234567800;
    run(record_tlas());
    for (uint32_t i = 0; i < fixture.instance.messages.count; i++)
        assert_lacks(fixture.instance.messages.items[i].text, "had this address");
    expect_messages(1, "is not the address of an acceleration structure of this device.");
}

SCENE_TEST(test_buffer)
{
    struct device_buffer vertices = scene_input(BUFFER_SIZE);
    scene_set_name(VK_OBJECT_TYPE_BUFFER, (uint64_t)vertices.handle, "vertices");
    const VkDeviceAddress address = vertices.address + 1024;
    fixture_destroy_buffer(&fixture, &vertices);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture_build_boxes(&fixture, commands, scene.blas, address, 1, scene.scratch_address);
    assert_int_equal(fixture.instance.messages.count, 1);
    assert_has(fixture.instance.messages.items[0].text,
               "is in no buffer whose address was retrieved. VkBuffer ");
    expect_messages(1,
                    "[\"vertices\"] had this address and was destroyed since the last "
                    "submission.");
}

TEST(test_ring)
{
    struct destroyed_objects *destroyed;
    struct destroyed_object object = {.type = VK_OBJECT_TYPE_BUFFER, .handle = 1, .size = 16};
    GET(destroyed_objects_create(&destroyed));
    destroyed_objects_add(destroyed, &object); /* had no address */
    assert_false(destroyed_objects_find_range(destroyed, 0, &object));
    for (uint64_t i = 1; i <= DESTROYED_MAX + 1; i++) {
        object.handle = i;
        object.address = 256 * i;
        destroyed_objects_add(destroyed, &object);
    }
    assert_false(destroyed_objects_find(destroyed, VK_OBJECT_TYPE_BUFFER, 256, &object));
    assert_false(destroyed_objects_find(destroyed, VK_OBJECT_TYPE_BUFFER, 512 + 16, &object));
    assert_true(destroyed_objects_find(destroyed, VK_OBJECT_TYPE_BUFFER, 512 + 15, &object));
    assert_int_equal(object.handle, 2);
    destroyed_objects_count_submission(destroyed);
    object = (struct destroyed_object){
        .type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, .handle = 7, .address = 512, .size = 64};
    destroyed_objects_add(destroyed, &object);
    assert_true(
        destroyed_objects_find(destroyed, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, 512, &object));
    assert_int_equal(object.handle, 7);
    assert_int_equal(object.submissions, 1);
    assert_true(
        destroyed_objects_find(destroyed, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, 768, &object));
    assert_int_equal(object.type, VK_OBJECT_TYPE_BUFFER);
    assert_true(destroyed_objects_find_range(destroyed, 512 + 63, &object));
    assert_int_equal(object.handle, 7);
    destroyed_objects_destroy(destroyed);
}
