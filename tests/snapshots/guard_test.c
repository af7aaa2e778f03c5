/* SPDX-License-Identifier: Apache-2.0 */
/* The shader of setting guard, by itself: random operations of builds of partitioned structures,
 * against what the null driver does in its place. Programs play the instances of top-level
 * structures, and what the host does. */
#include "tests/snapshots/shader.h"

#include <string.h>

#include "src/snapshots/recorded_build.h"
#include "tests/null_driver/internal.h"
#include "tests/unit/random.h"

static const uint32_t code[] = {
#include "guard_comp.h"
};

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
    UNTOUCHED = 0xa5,
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
    SOURCE_SIZE = 1 << 18,
    /* In the target. */
    COPIED_OPERATIONS_AT = 64,
    COPIED_ARRAYS_AT = 256,
    TARGET_SIZE = 1 << 16,
};

typedef VkBuildPartitionedAccelerationStructureIndirectCommandNV operation;

static struct device_buffer source, target;

static void open_scene(void)
{
    shader_open(code, sizeof(code), 64);
    source = shader_buffer(SOURCE_SIZE);
    target = shader_buffer(TARGET_SIZE);
}

#define GUARD_TEST(name) TEST_BETWEEN_IF(name, open_scene, shader_close, true)

/* ---- what the shader is given */

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

static void draw(struct round *round)
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
static void run(const struct round *round)
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

GUARD_TEST(test_partitioned_structures)
{
    struct round round = {.random = random_of("guard_test")};
    uint32_t replaced = 0, unreadable = 0;
    for (uint32_t i = 0; i < ROUNDS; i++) {
        struct guard_order order;
        draw(&round);
        if (round.order.range_count == GUARD_UNLIMITED && !reads_only_source())
            continue;
        run(&round);
        memcpy(&order, source.bytes + ORDER_AT, sizeof(order));
        assert_int_equal(order.is_done, round.is_open);
        assert_memory_equal(source.bytes, model.source, SOURCE_SIZE);
        assert_memory_equal(target.bytes, model.target, TARGET_SIZE);
        replaced += order.replaced;
        unreadable += order.unreadable;
    }
    assert_true(replaced > 0 && unreadable > 0);
}
