/* SPDX-License-Identifier: Apache-2.0 */
/* What the layer queries about structures on its own account: addresses only if an instance needs
 * one, and addresses and sizes only if the query is valid. */
#include "tests/snapshots/scene.h"

enum { BUFFER_SIZE = 1 << 16 };

static struct device_buffer instances;

static void open_with(const char *guard)
{
    SCENE_OPEN(.settings.guard = guard, .boxes_size = BUFFER_SIZE, .structure_size = BUFFER_SIZE,
               .has_tlas = true);
    instances = scene_input(BUFFER_SIZE);
}

static void open_scene(void)
{
    open_with(NULL);
}

static void open_guarded(void)
{
    open_with("references");
}

static uint64_t count_queries(void)
{
    return platform.null_driver.calls("vkGetAccelerationStructureDeviceAddressKHR");
}

/* A buffer for structures without VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT. */
static struct device_buffer create_plain_buffer(void)
{
    const STRUCT(VkBufferCreateInfo, info, .size = BUFFER_SIZE,
                 .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    struct device_buffer buffer = {.size = BUFFER_SIZE};
    GET(fixture.vk.CreateBuffer(fixture.device, &info, NULL, &buffer.handle));
    buffer.memory =
        memory_create(&fixture.vk, fixture.device, fixture.memory_type, 2 * BUFFER_SIZE);
    assert_true(fixture.buffer_count < FIXTURE_OBJECTS);
    return fixture.buffers[fixture.buffer_count++] = buffer;
}

static struct device_buffer create_bound_buffer(void)
{
    struct device_buffer buffer = create_plain_buffer();
    GET(fixture.vk.BindBufferMemory(fixture.device, buffer.handle, buffer.memory, 0));
    return buffer;
}

static VkAccelerationStructureKHR create_structure(const struct device_buffer *buffer,
                                                   VkAccelerationStructureTypeKHR type)
{
    return fixture_structure(&fixture, buffer, 0, BUFFER_SIZE, type);
}

/* The null driver gives a structure the address of its bytes. */
static void refer_to(VkDeviceAddress address)
{
    VkAccelerationStructureInstanceKHR *instance = (void *)instances.bytes;
    *instance = (VkAccelerationStructureInstanceKHR){.mask = 0xff,
                                                     .accelerationStructureReference = address};
    for (int i = 0; i < 3; i++)
        instance->transform.matrix[i][i] = 1;
}

static void build_instance(void)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    scene_build_boxes(commands, 1);
    scene_build_instance(commands, instances.address, false);
    scene_submit(commands);
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
}

#define ADDRESS_TEST(name) TEST_BETWEEN(name, open_scene, scene_wait_and_close)
#define GUARD_TEST(name) TEST_BETWEEN(name, open_guarded, scene_wait_and_close)

/* ---- without need */

ADDRESS_TEST(test_creation)
{
    platform.null_driver.reset();
    const struct device_buffer buffer = create_bound_buffer();
    create_structure(&buffer, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    create_structure(&scene.structures, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR);
    assert_int_equal(count_queries(), 0);
}

ADDRESS_TEST(test_queried_by_the_application)
{
    refer_to(structure_address(&fixture.vk, fixture.device, scene.blas));
    platform.null_driver.reset();
    build_instance();
    assert_int_equal(count_queries(), 0);
    fixture_expect_silence(&fixture);
}

/* ---- if needed */

/* Where the application computes the address, each structure is queried once. */
ADDRESS_TEST(test_computed_address)
{
    platform.null_driver.reset();
    refer_to(scene.structures.address);
    for (int i = 0; i < 2; i++)
        build_instance();
    assert_int_equal(count_queries(), 1);
    fixture_expect_silence(&fixture);
}

ADDRESS_TEST(test_wild_address)
{
    const struct device_buffer buffer = create_bound_buffer();
    create_structure(&buffer, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    platform.null_driver.reset();
    refer_to(0x1234567800);
    build_instance();
    assert_int_equal(count_queries(), 1);
    expect_messages(1, "is not the address of an acceleration structure of this device.");
}

/* The structure may be what the instance refers to. */
ADDRESS_TEST(test_unbound_structure)
{
    const STRUCT(VkBufferCreateInfo, info, .size = BUFFER_SIZE,
                 .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
                          VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    struct device_buffer buffer = {.size = BUFFER_SIZE};
    GET(fixture.vk.CreateBuffer(fixture.device, &info, NULL, &buffer.handle));
    create_structure(&buffer, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    refer_to(0x1234567800);
    build_instance();
    fixture_expect_silence(&fixture);
    buffer.memory = memory_create(&fixture.vk, fixture.device, fixture.memory_type, BUFFER_SIZE);
    GET(fixture.vk.BindBufferMemory(fixture.device, buffer.handle, buffer.memory, 0));
    fixture.buffers[fixture.buffer_count++] = buffer;
    build_instance();
    expect_messages(1, "is not the address of an acceleration structure of this device.");
}

/* The application queried the address of one structure, and builds another one that lies there. */
ADDRESS_TEST(test_aliases)
{
    VkAccelerationStructureKHR other =
        create_structure(&scene.structures, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    refer_to(structure_address(&fixture.vk, fixture.device, other));
    build_instance();
    fixture_expect_silence(&fixture);
}

/* Its address was never known, and it was alive at the submission. */
ADDRESS_TEST(test_destroyed_before_the_check)
{
    VkAccelerationStructureKHR other =
        create_structure(&scene.structures, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR);
    refer_to(0x1234567800);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    scene_build_instance(commands, instances.address, false);
    scene_submit(commands);
    fixture.vk.DestroyAccelerationStructureKHR(fixture.device, other, NULL);
    fixture.structure_count--;
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    fixture_expect_silence(&fixture);
    build_instance();
    expect_messages(1, "is not the address of an acceleration structure of this device.");
}

/* ---- guarded builds need the addresses when they execute */

GUARD_TEST(test_guard)
{
    platform.null_driver.reset();
    const struct device_buffer buffers[] = {create_bound_buffer(), create_plain_buffer()};
    for (size_t i = 0; i < ARRAY_COUNT(buffers); i++)
        create_structure(&buffers[i], VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    assert_int_equal(count_queries(), 0);
    create_structure(&scene.structures, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    assert_int_equal(count_queries(), 1);
    refer_to(scene.structures.address);
    build_instance();
    fixture_expect_silence(&fixture);
}

/* ---- sizes */

static void record_build(const VkuDeviceDispatchTable *vk, VkDevice device)
{
    const VkAccelerationStructureGeometryKHR geometry =
        boxes_geometry(1 << 16, sizeof(VkAabbPositionsKHR));
    const STRUCT(VkAccelerationStructureBuildGeometryInfoKHR, info,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, .geometryCount = 1,
                 .pGeometries = &geometry);
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = 1}, *ranges = &range;
    VkCommandPool pool = command_pool_create(vk, device);
    VkCommandBuffer commands =
        commands_begin(vk, device, pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 0, NULL);
    vk->CmdBuildAccelerationStructuresKHR(commands, 1, &info, &ranges);
    vk->DestroyCommandPool(device, pool, NULL);
}

/* How often the build of a device queries sizes, with the feature or without it. */
static uint64_t count_sizes(VkBool32 has_feature)
{
    const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                      VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME};
    const STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, structures,
                 .accelerationStructure = has_feature);
    const struct instance_settings settings = {.level = "state"};
    struct instance_fixture instance;
    VkuDeviceDispatchTable vk;
    VkDevice device;
    instance_fixture_create(&instance, &platform, &settings);
    GET(instance_fixture_create_device(&instance, &structures, extensions, ARRAY_COUNT(extensions),
                                       &device, &vk));
    platform.null_driver.reset();
    record_build(&vk, device);
    vk.DestroyDevice(device, NULL);
    messages_clear(&instance.messages);
    instance_fixture_close(&instance);
    return platform.null_driver.calls("vkGetAccelerationStructureBuildSizesKHR");
}

TEST(test_sizes)
{
    assert_int_equal(count_sizes(VK_TRUE), 1);
    assert_int_equal(count_sizes(VK_FALSE), 0);
}
