/* SPDX-License-Identifier: Apache-2.0 */
/* Recordings that are played without a device: what structures and queries then hold, and what is
 * written to buffers, and when. */
#include <stdlib.h>
#include <string.h>

#include "src/cpu/host.h"
#include "src/cpu/playback.h"
#include "src/cpu/trees/tree.h"
#include "tests/fixture/make.h"
#include "tests/fixture/objects.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

/* ---- backend cpu without a device: a submission ends when the test says so */

enum { QUERIES = 4, TRIANGLES = 40, WRITES = 8, WRITTEN_MOST = 1 << 16 };

#define BUFFER ((VkBuffer)(uintptr_t)0x40)
#define BUFFER_ADDRESS 0x1000u
#define BUFFER_SIZE 0x10000u

struct submission {
    struct ticket ticket;
    VkResult end;
    uint64_t waited; /* nanoseconds of the longest wait */
};

/* The backend with a built structure, an empty one, and one that is too small for either. */
struct world {
    struct cpu_device *device;
    struct resources *resources;
    struct cpu_playback *playback;
    uint64_t built, other, tiny, pool;
    struct submission submission;
    struct write {
        VkBuffer buffer;
        uint64_t size;
        VkBufferCopy regions[QUERIES];
        uint32_t region_count;
        unsigned char bytes[WRITTEN_MOST];
    } writes[WRITES];
    uint32_t write_count;
    bool postpones_writes;
    int allocations; /* before anything was */
};

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

/* There is one. Closing it fails if anything of it is left. */
static struct world *open_world(void)
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

static void close_world(struct world *world)
{
    assert_int_equal(cpu_playback_take_failed(world->playback), 0);
    cpu_playback_destroy(world->playback);
    cpu_device_destroy(world->device);
    resources_destroy(world->resources);
    assert_int_equal(world->submission.ticket.references, 1); /* the last reference */
    assert_int_equal(allocations_now(), world->allocations);
}

/* ---- recordings */

/* A command of a journal: JOURNAL_COPY or JOURNAL_EXECUTE, or of backend cpu. */
struct command {
    enum journal_kind kind;
    uint64_t dst, src; /* JOURNAL_COPY */
    bool compacts;
    struct journal *secondary; /* JOURNAL_EXECUTE; owned */
    struct recorded_command own;
};

/* A journal of these commands. play() executes it as so many a batch of queue 1, and releases it.
 */
static struct journal *record(const struct command *commands, size_t count)
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

static void play(struct world *world, struct journal *journal, uint64_t batch)
{
    struct execution *execution = execution_create(journal->work, &world->submission.ticket);
    assert_non_null(execution);
    cpu_playback_run(world->playback, execution, (struct timestamp){1, batch});
    execution_release(execution);
    journal_release(journal);
}

#define PLAY(world, ...)                                                                           \
    play(world,                                                                                    \
         record((const struct command[]){__VA_ARGS__},                                             \
                ARRAY_COUNT(((const struct command[]){__VA_ARGS__}))),                             \
         1)

/* Returns the number of bytes of the structure; 0 if it is not built. */
static uint64_t size_of(struct world *world, uint64_t structure)
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

/* The host has seen the end of so many batches of queue 1. */
static void deliver(struct world *world, uint64_t seen)
{
    const struct execution_clock clock = {.queues = 2, .counts = {0, seen}};
    cpu_playback_deliver(world->playback, &(struct cpu_delivery){&clock, note_write, world});
}

#define TEST_OF_WORLD(name) TEST_WITH(name, struct world *world, open_world, close_world)

/* ---- structures */

TEST_OF_WORLD(copies_have_the_size_of_their_source)
{
    const uint64_t size = size_of(world, world->built);
    assert_true(size > 256);
    PLAY(world, {.kind = JOURNAL_COPY, .dst = world->other, .src = world->built});
    assert_int_equal(size_of(world, world->other), size);
    PLAY(world, {.kind = JOURNAL_COPY, .dst = world->other, .src = world->tiny}); /* not built */
    assert_int_equal(size_of(world, world->other), 0);
    PLAY(world, {.kind = JOURNAL_COPY, .dst = world->other, .src = world->built, .compacts = true});
    assert_true(size_of(world, world->other) > 0 && size_of(world, world->other) <= size);
    PLAY(world, {.kind = JOURNAL_COPY,
                 .dst = world->tiny,
                 .src = world->built,
                 .compacts = true}); /* no room */
    assert_int_equal(size_of(world, world->tiny), 0);
    PLAY(world, {.kind = JOURNAL_COPY, .dst = 12345, .src = world->built});
    assert_int_equal(size_of(world, world->built), size);
}

TEST_OF_WORLD(secondaries_play_in_their_place)
{
    const struct command clones[] = {
        {.kind = JOURNAL_COPY, .dst = world->other, .src = world->built},
        {.kind = JOURNAL_COPY, .dst = world->built, .src = world->tiny}};
    PLAY(world, {.kind = JOURNAL_EXECUTE, .secondary = record(&clones[0], 1)},
         {.kind = JOURNAL_EXECUTE, .secondary = record(&clones[1], 1)});
    assert_int_equal(size_of(world, world->built), 0);
    assert_true(size_of(world, world->other) > 0);
}

/* ---- queries */

static VkResult read_queries(struct world *world, uint32_t first, uint32_t count, void *data,
                             size_t size, VkDeviceSize stride, VkQueryResultFlags flags)
{
    return cpu_query_pools_read(world->device->query_pools, world->pool, first, count, size, data,
                                stride, flags);
}

static void write_queries(struct world *world, uint32_t first)
{
    PLAY(world,
         {.kind = CPU_WRITE_QUERY,
          .own = {.pool = world->pool, .first = first, .structure = world->built}},
         {.kind = CPU_WRITE_QUERY,
          .own = {.pool = world->pool, .first = first + 1, .structure = world->other}});
}

TEST_OF_WORLD(queries_are_read_when_their_submission_has_ended)
{
    const uint64_t size = size_of(world, world->built);
    uint64_t values[QUERIES] = {1, 1, 1, 1};
    write_queries(world, 1);
    assert_int_equal(read_queries(world, 1, 1, values, 8, 8, VK_QUERY_RESULT_64_BIT), VK_NOT_READY);
    assert_int_equal(world->submission.waited, 0);
    assert_int_equal(values[0], 1);
    world->submission.end = VK_SUCCESS;
    assert_int_equal(
        read_queries(world, 0, 4, values, 32, 8, VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
        VK_NOT_READY); /* no call waits for the first and the last */
    assert_true(world->submission.waited == UINT64_MAX);
    assert_int_equal(values[0], 1);
    assert_int_equal(values[1], size);
    assert_int_equal(values[2], 0); /* not built */
    assert_int_equal(values[3], 1);
    assert_int_equal(read_queries(world, 1, 2, values, 16, 8, VK_QUERY_RESULT_64_BIT), VK_SUCCESS);
    assert_int_equal(values[0], size);
    world->submission.end = VK_ERROR_DEVICE_LOST;
    assert_int_equal(read_queries(world, 0, 2, values, 16, 8, 0), VK_ERROR_DEVICE_LOST);
}

TEST_OF_WORLD(queries_are_written_in_the_width_and_room_that_are_given)
{
    const uint64_t size = size_of(world, world->built);
    uint32_t words[8];
    write_queries(world, 0);
    world->submission.end = VK_SUCCESS;
    memset(words, 0xee, sizeof(words));
    assert_int_equal(
        read_queries(world, 0, 3, words, sizeof(words), 8, VK_QUERY_RESULT_WITH_AVAILABILITY_BIT),
        VK_NOT_READY);
    assert_memory_equal(
        words, ((uint32_t[8]){(uint32_t)size, 1, 0, 1, 0xeeeeeeee, 0, 0xeeeeeeee, 0xeeeeeeee}),
        sizeof(words));
    assert_int_equal(
        read_queries(world, 0, 4, words, sizeof(words), 8, VK_QUERY_RESULT_PARTIAL_BIT),
        VK_NOT_READY);
    assert_int_equal(words[4], 0);
    memset(words, 0xee, sizeof(words));
    read_queries(world, 0, 1, words, 4, 4, VK_QUERY_RESULT_64_BIT); /* no room for 8 bytes */
    assert_int_equal(words[0], 0xeeeeeeee);
    read_queries(world, 0, 1, words, 8, 4, VK_QUERY_RESULT_64_BIT);
    assert_int_equal(words[1], 0);
    memset(words, 0xee, sizeof(words));
    read_queries(world, 0, 2, words, 4, 4, 0); /* room for the first */
    assert_int_equal(words[0], size);
    assert_int_equal(words[1], 0xeeeeeeee);
    read_queries(world, 0, 1, words, sizeof(words), 16,
                 VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
    assert_int_equal(words[2], 1);
    assert_int_equal(words[3], 0);
}

TEST_OF_WORLD(queries_beyond_the_pool_are_ignored)
{
    uint64_t value = 1;
    world->submission.end = VK_SUCCESS;
    write_queries(world, QUERIES - 1);
    assert_int_equal(read_queries(world, QUERIES - 1, 2, &value, 8, 8, VK_QUERY_RESULT_64_BIT),
                     VK_SUCCESS);
    assert_int_equal(value, size_of(world, world->built));
    PLAY(world,
         {.kind = CPU_RESET_QUERIES, .own = {.pool = world->pool, .first = QUERIES, .count = 1}});
    assert_int_equal(read_queries(world, QUERIES - 1, 1, &value, 8, 8, 0), VK_SUCCESS);
    PLAY(world, {.kind = CPU_RESET_QUERIES,
                 .own = {.pool = world->pool, .first = 1, .count = UINT32_MAX}});
    assert_int_equal(read_queries(world, QUERIES - 1, 1, &value, 8, 8, 0), VK_NOT_READY);
}

TEST(types_of_queries_are_known)
{
    static const VkQueryType known[] = {
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV,
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR,
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_BOTTOM_LEVEL_POINTERS_KHR,
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR,
        VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT,
        VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT};
    for (size_t i = 0; i < ARRAY_COUNT(known); i++)
        assert_true(cpu_query_type_is_known(known[i]));
    assert_false(cpu_query_type_is_known(VK_QUERY_TYPE_OCCLUSION));
    assert_false(cpu_query_type_is_known(VK_QUERY_TYPE_TIMESTAMP));
}

/* ---- what is written to buffers */

static void copy_queries(struct world *world, uint32_t first, uint32_t count,
                         VkQueryResultFlags flags, uint64_t batch)
{
    const struct command copy = {.kind = CPU_COPY_QUERIES,
                                 .own = {.pool = world->pool,
                                         .first = first,
                                         .count = count,
                                         .stride = 24,
                                         .flags = flags,
                                         .target = {BUFFER, 32, BUFFER_SIZE - 32, false}}};
    play(world, record(&copy, 1), batch);
}

static void expect_region(const struct write *write, uint32_t i, uint64_t from, uint64_t to,
                          uint64_t size)
{
    assert_int_equal(write->regions[i].srcOffset, from);
    assert_int_equal(write->regions[i].dstOffset, to);
    assert_int_equal(write->regions[i].size, size);
}

TEST_OF_WORLD(copies_of_queries_are_written_in_order_when_they_are_complete)
{
    const uint64_t size = size_of(world, world->built);
    write_queries(world, 0);
    copy_queries(world, 0, 3, VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT, 1);
    copy_queries(world, 0, 9, VK_QUERY_RESULT_PARTIAL_BIT | VK_QUERY_RESULT_WAIT_BIT, 2);
    copy_queries(world, 2, 1, 0, 3); /* not available: nothing to write */
    PLAY(world, {.kind = CPU_RESET_QUERIES,
                 .own = {.pool = world->pool, .count = QUERIES}}); /* too late */
    assert_true(cpu_playback_has_results(world->playback));
    deliver(world, 0);
    assert_int_equal(world->submission.waited, 0);
    deliver(world, 1);
    assert_int_equal(world->submission.waited, TICKET_GRACE_NANOSECONDS); /* its end was seen */
    assert_int_equal(world->write_count, 0);
    world->submission.end = VK_SUCCESS;
    deliver(world, 0);
    assert_false(cpu_playback_has_results(world->playback));
    assert_int_equal(world->write_count, 2);

    const struct write *first = &world->writes[0], *second = &world->writes[1];
    assert_ptr_equal(first->buffer, BUFFER);
    assert_int_equal(first->region_count, 3);
    expect_region(first, 0, 0, 32, 16);
    expect_region(first, 1, 16, 32 + 24, 16);
    expect_region(first, 2, 32 + 8, 32 + 48 + 8, 8); /* not available: no value */
    assert_memory_equal(first->bytes, ((uint64_t[5]){size, 1, 0, 1}), 40);
    assert_int_equal(second->region_count, QUERIES);
    expect_region(second, 3, 48, 32 + 72, 4);
    copy_queries(world, 0, 1, 0, 4); /* the list was emptied */
    assert_true(cpu_playback_has_results(world->playback));
}

TEST_OF_WORLD(results_that_cannot_be_written_yet_are_written_later)
{
    write_queries(world, 0);
    copy_queries(world, 0, 1, 0, 1);
    copy_queries(world, 0, 2, 0, 1);
    world->submission.end = VK_SUCCESS;
    world->postpones_writes = true;
    deliver(world, 1);
    assert_true(cpu_playback_has_results(world->playback));
    world->postpones_writes = false;
    deliver(world, 1);
    assert_false(cpu_playback_has_results(world->playback));
    assert_int_equal(world->write_count, 2);
    assert_int_equal(world->writes[1].region_count, 2);
}

TEST_OF_WORLD(buffers_and_submissions_that_are_gone_are_not_written)
{
    write_queries(world, 0);
    copy_queries(world, 0, 1, 0, 1);
    cpu_playback_forget_buffer(world->playback, (VkBuffer)(uintptr_t)0x44);
    copy_queries(world, 0, 1, 0, 1);
    world->submission.end = VK_ERROR_DEVICE_LOST;
    deliver(world, 1);
    assert_false(cpu_playback_has_results(world->playback));
    world->submission.end = VK_SUCCESS;
    copy_queries(world, 0, 1, 0, 1);
    cpu_playback_forget_buffer(world->playback, BUFFER);
    deliver(world, 1);
    assert_false(cpu_playback_has_results(world->playback));
    assert_int_equal(world->write_count, 0);
    copy_queries(world, 0, 1, 0, 1);
    cpu_playback_forget_buffer(world->playback, (VkBuffer)(uintptr_t)0x44);
    deliver(world, 1);
    assert_int_equal(world->write_count, 1);
}

TEST_OF_WORLD(structures_are_serialized_where_they_fit)
{
    struct cpu_tree *tree = cpu_structures_tree(world->device->structures, world->built);
    const uint64_t size = bytes_serialized_size(cpu_tree_read(tree));
    cpu_tree_release(tree);
    world->submission.end = VK_SUCCESS;
    const uint64_t last = BUFFER_ADDRESS + BUFFER_SIZE - size;
    PLAY(world,
         {.kind = CPU_SERIALIZE,
          .own = {.structure = world->built, .address = BUFFER_ADDRESS + 256}},
         {.kind = CPU_SERIALIZE, .own = {.structure = world->built, .address = last}},
         {.kind = CPU_SERIALIZE, .own = {.structure = world->built, .address = last + 1}},
         {.kind = CPU_SERIALIZE, .own = {.structure = world->built, .address = 0x900000}},
         {.kind = CPU_SERIALIZE, .own = {.structure = world->other, .address = BUFFER_ADDRESS}});
    deliver(world, 1);
    assert_int_equal(world->write_count, 2);
    expect_region(&world->writes[0], 0, 0, 256, size);
    expect_region(&world->writes[1], 0, 0, BUFFER_SIZE - size, size);
    assert_int_equal(world->writes[0].size, size);
    assert_memory_equal(world->writes[0].bytes, &world->device->uuids,
                        sizeof(struct builder_uuids));
    assert_false(cpu_playback_has_results(world->playback));
}
