/* SPDX-License-Identifier: Apache-2.0 */
#include "playback_fixture.h"

#include <stdlib.h>
#include <string.h>

#include "src/cpu/host.h"
#include "src/cpu/trees/tree.h"
#include "tests/fixture/make.h"
#include "tests/fixture/scarce_memory.h"

static VkResult wait_for(struct ticket *ticket, uint64_t nanoseconds)
{
    struct submission *submission = (struct submission *)ticket;
    if (nanoseconds > submission->waited)
        submission->waited = nanoseconds;
    return submission->end;
}

static void free_nothing(struct ticket *ticket)
{
    (void)ticket;
}

static uint64_t add_structure(struct world *world, uint64_t size)
{
    const struct cpu_structure_info info = {.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                                            .size = size,
                                            .buffer_id = 1,
                                            .buffer_size = size};
    uint64_t handle;
    GET(cpu_structures_add(world->device->structures, &info, &handle));
    return handle;
}

static void build(struct world *world, uint64_t structure)
{
    static float corners[9 * TRIANGLES];
    for (int i = 0; i < 9 * TRIANGLES; i++)
        corners[i] = (float)(i * i % 31);
    const STRUCT(VkAccelerationStructureGeometryKHR, geometry,
                 .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
                 .geometry.triangles =
                     MAKE(VkAccelerationStructureGeometryTrianglesDataKHR,
                          .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
                          .vertexData.hostAddress = corners, .vertexStride = 12,
                          .maxVertex = 3 * TRIANGLES - 1, .indexType = VK_INDEX_TYPE_NONE_KHR));
    const STRUCT(VkAccelerationStructureBuildGeometryInfoKHR, info,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                 .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR,
                 .dstAccelerationStructure = (VkAccelerationStructureKHR)(uintptr_t)structure,
                 .geometryCount = 1, .pGeometries = &geometry);
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = TRIANGLES};
    GET(cpu_host_build(world->device, 0, 1, &info,
                       (const VkAccelerationStructureBuildRangeInfoKHR *const[]){&range}));
}

struct world *open_world(void)
{
    static struct world world;
    static const uint8_t uuid[VK_UUID_SIZE] = {7};
    const STRUCT(VkBufferCreateInfo, buffer, .size = BUFFER_SIZE,
                 .usage = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    memset(&world, 0, sizeof(world));
    world.allocations = allocations_now();
    world.submission = (struct submission){{.wait = wait_for, .free = free_nothing}, VK_TIMEOUT, 0};
    atomic_init(&world.submission.ticket.references, 1);
    GET(cpu_device_create(uuid, &world.device));
    GET(resources_create(&world.resources));
    GET(cpu_playback_create(world.device, world.resources, &world.playback));
    world.built = add_structure(&world, 1 << 16);
    world.other = add_structure(&world, 1 << 16);
    world.tiny = add_structure(&world, 256);
    build(&world, world.built);
    GET(cpu_query_pools_add(world.device->query_pools,
                            VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR, QUERIES, &world.pool));
    resources_add_buffer(world.resources, BUFFER, &buffer);
    resources_add_memory(world.resources, (VkDeviceMemory)(uintptr_t)0x50, BUFFER_SIZE, 0, 0,
                         false);
    resources_bind_buffer(world.resources, BUFFER, (VkDeviceMemory)(uintptr_t)0x50, 0, false);
    resources_set_address(world.resources, BUFFER, BUFFER_ADDRESS);
    return &world;
}

void close_world(struct world *world)
{
    assert_int_equal(cpu_playback_take_failed(world->playback), 0);
    cpu_playback_destroy(world->playback);
    cpu_device_destroy(world->device);
    resources_destroy(world->resources);
    assert_int_equal(world->submission.ticket.references, 1); /* the last reference */
    assert_int_equal(allocations_now(), world->allocations);
}

/* ---- recordings */

struct journal *record(const struct command *commands, size_t count)
{
    struct journal *journal = journal_create(VK_NULL_HANDLE);
    struct recording *recording = recording_create(journal, &(struct recording_memory){0});
    assert_non_null(recording);
    recording->has_commands = true;
    for (size_t i = 0; i < count; i++) {
        const struct command *command = &commands[i];
        struct journal_entry entry = {
            .kind = (unsigned char)command->kind, .dst = command->dst, .src = command->src};
        entry.read.compacts = command->compacts;
        if (command->kind >= CPU_COPY) {
            struct recorded_command *own = journal_append(journal, sizeof(*own));
            const unsigned char size = own->size;
            *own = command->own;
            own->kind = (unsigned char)command->kind;
            own->size = size;
            continue;
        }
        if (command->secondary)
            entry.secondary = command->secondary;
        journal->secondary_count += command->secondary != NULL;
        journal_add(journal, &entry);
    }
    return journal;
}

void play(struct world *world, struct journal *journal, uint64_t batch)
{
    struct execution *execution = execution_create(journal->work, &world->submission.ticket);
    assert_non_null(execution);
    cpu_playback_run(world->playback, execution, (struct timestamp){1, batch});
    execution_release(execution);
    journal_release(journal);
}

uint64_t size_of(struct world *world, uint64_t structure)
{
    struct cpu_tree *tree = cpu_structures_tree(world->device->structures, structure);
    const void *bytes = tree ? cpu_tree_read(tree) : NULL;
    const uint64_t size = bytes ? bytes_size(bytes) : 0;
    cpu_tree_release(tree);
    return size;
}

static bool note_write(void *user, const struct result_bytes *result)
{
    struct world *world = user;
    assert_ptr_equal(result->ticket, &world->submission.ticket);
    assert_true(world->write_count < WRITES && result->size <= WRITTEN_MOST &&
                result->region_count <= QUERIES);
    if (world->postpones_writes)
        return false;
    struct write *write = &world->writes[world->write_count++];
    write->buffer = result->buffer;
    write->size = result->size;
    write->region_count = result->region_count;
    memcpy(write->bytes, result->bytes, result->size);
    memcpy(write->regions, result->regions, result->region_count * sizeof(*result->regions));
    return true;
}

void deliver(struct world *world, uint64_t seen)
{
    const struct execution_clock clock = {.queues = 2, .counts = {0, seen}};
    cpu_playback_deliver(world->playback, &(struct cpu_delivery){&clock, note_write, world});
}
