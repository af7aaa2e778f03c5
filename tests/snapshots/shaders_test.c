/* SPDX-License-Identifier: Apache-2.0 */
/* The shaders of level content, by themselves. The one that copies: sources of any alignment and
 * size, against memcpy(). The one of setting guard: random operations of builds of partitioned
 * structures, against what the null driver does in its place. Programs play the instances of
 * top-level structures, and what the host does. */
#include <string.h>

#include "copy_comp.h"
#include "guard_comp.h"
#include "src/snapshots/recorded_build.h"
#include "tests/fixture/objects.h"
#include "tests/null_driver/internal.h"
#include "tests/player/play.h"
#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

/* ---- a shader on the device of programs, at a level where the layer passes all calls on */

enum { BUFFERS = 8, SOURCE_SIZE = 1 << 18, UNTOUCHED = 0xa5 };

static struct platform platform;
static struct play play;
static struct program program;
static struct device_buffer buffers[BUFFERS], source, target;
static uint32_t buffer_count;
static VkPipelineLayout layout;
static VkPipeline pipeline;

const char *unit_test_open(const char *name)
{
    return platform_open(&platform, name ? name : "null");
}

static void shader_open(const uint32_t *code, size_t code_size, uint32_t constants_size)
{
    play = (struct play){.platform = &platform, .level = "parameters"};
    assert_true(play_begin(&play, &program));
    layout = constants_layout_create(&play.vk, play.device, 0, constants_size);
    pipeline = compute_pipeline_create(&play.vk, play.device, layout, code, code_size);
}

static void shader_close(void)
{
    while (buffer_count > 0)
        buffer_destroy(&play.vk, play.device, &buffers[--buffer_count]);
    play.vk.DestroyPipeline(play.device, pipeline, NULL);
    play.vk.DestroyPipelineLayout(play.device, layout, NULL);
    messages_expect_none(&play.fixture.messages);
    play_end(&play);
    play_close(&play);
}

/* Creates a buffer that shaders access by its address, and that shader_close() destroys. */
static struct device_buffer shader_buffer(VkDeviceSize size)
{
    const STRUCT(VkBufferCreateInfo, info, .size = size,
                 .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                          VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    assert_true(buffer_count < BUFFERS);
    return buffers[buffer_count++] = buffer_create(&play.vk, play.device, play.memory_type, &info);
}

/* Executes the shader, and waits. */
static void shader_run(const void *constants, uint32_t constants_size, uint32_t groups)
{
    VkCommandBuffer commands = commands_begin(&play.vk, play.device, play.pools[0],
                                              VK_COMMAND_BUFFER_LEVEL_PRIMARY, 0, NULL);
    play.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    play.vk.CmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, constants_size,
                             constants);
    play.vk.CmdDispatch(commands, groups, 1, 1);
    commands_barrier(&play.vk, commands);
    GET(play.vk.EndCommandBuffer(commands));
    commands_run(&play.vk, play.device, play.queues[0], commands);
    play.vk.FreeCommandBuffers(play.device, play.pools[0], 1, &commands);
}

/* ---- the shader that copies */

enum {
    ORDERS = 300,
    SMALL_MAX = 300,
    ROOM = COPY_SIZE_MAX, /* of each target, */
    LARGE = 7,            /* and every so many sources are nearly as large */
};

static struct device_buffer list, gate;

static void open_copy(void)
{
    shader_open(copy_comp, sizeof(copy_comp), 2 * sizeof(uint64_t));
    source = shader_buffer(SOURCE_SIZE);
    target = shader_buffer((VkDeviceSize)ORDERS * ROOM);
    gate = shader_buffer(sizeof(uint32_t));
    list = shader_buffer(ORDERS * sizeof(struct copy_order));
}

#define COPY_TEST(name) TEST_BETWEEN(name, open_copy, shader_close)

static struct copy_order draw_order(struct random *random, uint32_t i)
{
    uint32_t size = i % LARGE ? random_below(random, SMALL_MAX)
                              : COPY_SIZE_MAX - random_below(random, SMALL_MAX);
    uint64_t left = size;
    if (i % 3 == 1)
        left = random_below(random, size + 1);
    if (i % 3 == 2)
        left = size + ((uint64_t)random_below(random, 2) << 32);
    return (struct copy_order){
        .source = source.address + random_below(random, SOURCE_SIZE - COPY_SIZE_MAX),
        .target = target.address + (uint64_t)i * ROOM,
        .size = size,
        .left = left,
    };
}

static void run_copy(bool is_open)
{
    *(uint32_t *)gate.bytes = is_open;
    const VkDeviceAddress constants[] = {gate.address, list.address};
    shader_run(constants, sizeof(constants), ORDERS);
}

COPY_TEST(test_copies)
{
    struct random random = random_of("copy_test");
    struct copy_order *orders = (struct copy_order *)list.bytes;
    for (uint32_t i = 0; i < SOURCE_SIZE; i++)
        source.bytes[i] = (unsigned char)random_below(&random, 256);
    memset(target.bytes, UNTOUCHED, target.size);
    for (uint32_t i = 0; i < ORDERS; i++)
        orders[i] = draw_order(&random, i);
    run_copy(true);
    for (uint32_t i = 0; i < ORDERS; i++) {
        const unsigned char *to = target.bytes + (size_t)i * ROOM;
        uint64_t size = orders[i].left < orders[i].size ? orders[i].left : orders[i].size;
        assert_int_equal(orders[i].is_done, 1);
        assert_memory_equal(to, source.bytes + (orders[i].source - source.address), size);
        for (uint64_t at = (size + 3) / 4 * 4; at < ROOM; at++)
            assert_int_equal(to[at], UNTOUCHED);
    }
}

COPY_TEST(test_closed_gate)
{
    struct copy_order *orders = (struct copy_order *)list.bytes;
    memset(target.bytes, UNTOUCHED, target.size);
    for (uint32_t i = 0; i < ORDERS; i++)
        orders[i] = (struct copy_order){.source = source.address,
                                        .target = target.address,
                                        .left = sizeof(uint32_t),
                                        .size = sizeof(uint32_t)};
    run_copy(false);
    for (uint32_t i = 0; i < ORDERS; i++)
        assert_int_equal(orders[i].is_done, 0);
    assert_int_equal(target.bytes[0], UNTOUCHED);
}

enum {
    ROUNDS = 200,
    INSTANCES_MAX = 150,
    OPERATIONS_GIVEN = 5, /* at most; more than there may be */
    WRITE_SIZE = sizeof(VkPartitionedAccelerationStructureWriteInstanceDataNV),
    UPDATE_SIZE = sizeof(VkPartitionedAccelerationStructureUpdateInstanceDataNV),
    SLOTS = 64,
    REFERENCES = 20,
    LIMIT = 100,
    OF_PARTITIONS = 8,
    WITH_CLUSTERS = 16,
    /* In the source, whose rest has arrays. */
    GATE_AT = 0,
    ORDER_AT = 64,
    COUNT_AT = 256,
    RANGES_AT = 512,
    PLACES_AT = 640,
    TABLE_AT = 1024,
    ENTRIES_AT = 2048,
    OPERATIONS_AT = 4096,
    ARRAYS_AT = 8192,
    ARRAYS_END = 1 << 17,
    /* In the target. */
    COPIED_OPERATIONS_AT = 64,
    COPIED_ARRAYS_AT = 256,
    TARGET_SIZE = 1 << 16,
};

typedef VkBuildPartitionedAccelerationStructureIndirectCommandNV operation;

static void open_guard(void)
{
    shader_open(guard_comp, sizeof(guard_comp), 64);
    source = shader_buffer(SOURCE_SIZE);
    target = shader_buffer(TARGET_SIZE);
}

/* ---- the shader of setting guard: what it is given */

struct round {
    struct random random;
    struct guard_order order;
    uint32_t instances, flags;
    bool is_open;
    uint64_t references[REFERENCES];
};

static uint32_t hash_of(uint64_t reference) /* as references.c has it */
{
    uint32_t hash = (uint32_t)reference * 0x9e3779b1u ^ (uint32_t)(reference >> 32) * 0x85ebca77u;
    hash = (hash ^ hash >> 15) * 0x2c1b3c6du;
    return hash ^ hash >> 16;
}

static void draw_table(struct round *round)
{
    struct {
        uint64_t reference;
        uint32_t built, kinds;
    } *entries = (void *)(source.bytes + ENTRIES_AT);
    const struct {
        uint32_t current, known_kinds, unused[2];
        uint64_t entries;
        uint32_t mask, reserved;
    } table = {0, 1, {0}, source.address + ENTRIES_AT, SLOTS - 1, 0};
    memset(entries, 0, SLOTS * sizeof(*entries));
    memcpy(source.bytes + TABLE_AT, &table, sizeof(table));
    for (uint32_t i = 0; i < REFERENCES; i++) {
        round->references[i] = (uint64_t)(i + 1) << 33 | random_below(&round->random, 1 << 20) << 8;
        uint32_t slot = hash_of(round->references[i]) % SLOTS;
        while (entries[slot].reference)
            slot = (slot + 1) % SLOTS;
        if (i % 8 == 7) /* it is not in the table, not even as a structure that was destroyed */
            continue;
        entries[slot].reference = round->references[i];
        entries[slot].built = i % 4 == 3 ? UINT32_MAX : i % 4 == 2 ? LIMIT + 1 : i;
        entries[slot].kinds = i % 4 != 3;
    }
}

/* Ranges of one structure or of all bytes but some. */
static void draw_lists(struct round *round)
{
    const uint64_t gap = source.address + ARRAYS_AT + random_below(&round->random, ARRAYS_END / 2),
                   ranges[][2] = {{source.address, gap}, {gap + 512, source.address + SOURCE_SIZE}},
                   places[][2] = {{round->references[3], round->references[3] + 1},
                                  {round->references[6] - 16, round->references[6] + 16}};
    memcpy(source.bytes + RANGES_AT, ranges, sizeof(ranges));
    memcpy(source.bytes + PLACES_AT, places, sizeof(places));
    round->order.range_count = random_below(&round->random, 3) ? 2 : GUARD_UNLIMITED;
    round->order.place_count =
        random_below(&round->random, 8) ? random_below(&round->random, 3) : GUARD_UNLIMITED;
}

static void draw_operations(struct round *round)
{
    static const uint32_t types[] = {0, 0, 1, 1, 2, 77};
    operation *operations = (void *)(source.bytes + OPERATIONS_AT);
    for (uint32_t i = 0; i < OPERATIONS_GIVEN; i++) {
        const uint32_t size = i % 2 ? UPDATE_SIZE : WRITE_SIZE, skipped[] = {0, 0, 8, 4, 1};
        operations[i] = (operation){
            .opType = (VkPartitionedAccelerationStructureOpTypeNV)
                types[random_below(&round->random, ARRAY_COUNT(types))],
            .argCount = random_below(&round->random, round->instances + 3),
            .argData = {source.address + ARRAYS_AT + random_below(&round->random, ARRAYS_END / 2) +
                            skipped[random_below(&round->random, ARRAY_COUNT(skipped))],
                        random_below(&round->random, 8) ? size + 8 * random_below(&round->random, 3)
                                                        : 0}};
        operations[i].argData.startAddress &= ~(uint64_t)(i ? 3 : 0);
        if (random_below(&round->random, 20) == 0)
            operations[i].argData.strideInBytes |= (uint64_t)1 << random_below(&round->random, 64);
    }
    for (uint32_t at = ARRAYS_AT; at < SOURCE_SIZE; at += 4) {
        const uint32_t word = random_below(&round->random, 1 << 16);
        memcpy(source.bytes + at, &word, sizeof(word));
    }
    /* References where those of the elements are. */
    for (uint32_t i = 0; i < OPERATIONS_GIVEN; i++)
        for (uint32_t j = 0; j < INSTANCES_MAX + 3; j++) {
            const uint32_t size = operations[i].opType == 1 ? UPDATE_SIZE : WRITE_SIZE;
            const uint64_t at = operations[i].argData.startAddress - source.address +
                                j * operations[i].argData.strideInBytes + size - sizeof(uint64_t);
            const uint64_t reference =
                random_below(&round->random, 8)
                    ? round->references[random_below(&round->random, REFERENCES)]
                    : 0;
            if (at >= ARRAYS_AT && at < SOURCE_SIZE - sizeof(reference))
                memcpy(source.bytes + at, &reference, sizeof(reference));
        }
}

static void draw_round(struct round *round)
{
    const uint32_t given = random_below(&round->random, OPERATIONS_GIVEN + 1);
    round->instances = random_below(&round->random, INSTANCES_MAX);
    round->flags = OF_PARTITIONS | (random_below(&round->random, 2) ? WITH_CLUSTERS : 0);
    round->is_open = random_below(&round->random, 10);
    round->order =
        (struct guard_order){.source = source.address + OPERATIONS_AT,
                             .ranges = source.address + RANGES_AT,
                             .places = source.address + PLACES_AT,
                             .indirect = source.address + COUNT_AT,
                             .readable = random_below(&round->random, 4)
                                             ? GUARD_UNLIMITED
                                             : random_below(&round->random, 4 * sizeof(operation)),
                             .limit = random_below(&round->random, 8) ? LIMIT : GUARD_UNLIMITED,
                             .can_read_range = random_below(&round->random, 10),
                             .first_replaced = UINT32_MAX};
    draw_table(round);
    draw_lists(round);
    draw_operations(round);
    memcpy(source.bytes + GATE_AT, &(uint32_t){round->is_open}, sizeof(uint32_t));
    memcpy(source.bytes + COUNT_AT, &given, sizeof(given));
    memcpy(source.bytes + ORDER_AT, &round->order, sizeof(round->order));
    memset(target.bytes, UNTOUCHED, target.size);
}

/* ---- the null driver, whose memory is a copy of both buffers */

static struct {
    unsigned char source[SOURCE_SIZE], target[TARGET_SIZE];
} model;

static unsigned char *model_bytes(VkDeviceAddress address, VkDeviceSize size)
{
    if (address >= source.address && address - source.address <= SOURCE_SIZE - size)
        return model.source + (address - source.address);
    if (address >= target.address && address - target.address <= TARGET_SIZE - size)
        return model.target + (address - target.address);
    return NULL;
}

bool address_read(VkDeviceAddress address, void *bytes, VkDeviceSize size)
{
    const unsigned char *from = model_bytes(address, size);
    if (from)
        memcpy(bytes, from, size);
    return from;
}

void address_write(VkDeviceAddress address, const void *bytes, VkDeviceSize size)
{
    unsigned char *to = model_bytes(address, size);
    if (to)
        memcpy(to, bytes, size);
}

/* Executes the shader, and the null driver's function. */
static void run_guard(const struct round *round)
{
    const struct {
        uint64_t gate, references, order, range, pointers, elements;
        uint32_t count, flags;
    } constants = {source.address + GATE_AT,
                   source.address + TABLE_AT,
                   source.address + ORDER_AT,
                   target.address,
                   target.address + COPIED_OPERATIONS_AT,
                   target.address + COPIED_ARRAYS_AT,
                   round->instances,
                   round->flags};
    struct dispatch dispatch = {.groups = 2};
    memcpy(dispatch.constants, &constants, sizeof(constants));
    memcpy(model.source, source.bytes, SOURCE_SIZE);
    memcpy(model.target, target.bytes, TARGET_SIZE);
    guard_execute(&dispatch);
    shader_run(&constants, sizeof(constants), dispatch.groups);
}

/* Without ranges, arrays are read wherever they are: they must be there. */
static bool reads_only_source(void)
{
    operation operations[OPERATIONS_GIVEN];
    memcpy(operations, source.bytes + OPERATIONS_AT, sizeof(operations));
    for (uint32_t i = 0; i < OPERATIONS_GIVEN; i++)
        if (operations[i].argData.strideInBytes > SOURCE_SIZE / 4 / (INSTANCES_MAX + 3))
            return false;
    return true;
}

/* The null driver does not execute the shader. */
TEST_BETWEEN_IF(test_partitioned_structures, open_guard, shader_close, !platform.is_null)
{
    struct round round = {.random = random_of("guard_test")};
    uint32_t replaced = 0, unreadable = 0;
    for (uint32_t i = 0; i < ROUNDS; i++) {
        struct guard_order order;
        draw_round(&round);
        if (round.order.range_count == GUARD_UNLIMITED && !reads_only_source())
            continue;
        run_guard(&round);
        memcpy(&order, source.bytes + ORDER_AT, sizeof(order));
        assert_int_equal(order.is_done, round.is_open);
        assert_memory_equal(source.bytes, model.source, SOURCE_SIZE);
        assert_memory_equal(target.bytes, model.target, TARGET_SIZE);
        replaced += order.replaced;
        unreadable += order.unreadable;
    }
    assert_true(replaced > 0 && unreadable > 0);
}
