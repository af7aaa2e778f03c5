/* SPDX-License-Identifier: Apache-2.0 */
/* Random lives of buffers, memory and structures with few handles, which are therefore reused all
 * the time, against a naive model that keeps everything that ever was. The driver reuses handles,
 * also of objects whose destruction the layer has not seen. */
#include "tests/fixture/make.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/fixture.h"
#include "tests/unit/property.h"

enum { BUFFERS = 7, ACCELS = 7, STEPS = 1500, SPACE = 0x400, BASE = 0x10000 };

struct buffer_model {
    bool alive;
    VkDeviceSize size;
    VkBufferUsageFlags usage;
    VkDeviceAddress address;
    enum tristate bound;
    uint32_t memory, memory_handle; /* index in memory_alive */
    VkDeviceSize offset;
    bool differs; /* instances of the memory are exchanged: it has no span */
    bool is_protected;
};

struct accel_model {
    uint32_t buffer, buffer_handle; /* index in `buffers`; 0: unknown */
    VkDeviceSize offset, size;
};

/* Everything that ever was; index 0 is nothing. Handles lead to what they are of now. */
struct world {
    struct resources *resources;
    bool is_scarce; /* memory has run out: only what is known counts */
    bool memory_alive[STEPS + 1];
    struct buffer_model buffers[STEPS + 1];
    struct accel_model accels[STEPS + 1];
    uint32_t memory_count, buffer_count, accel_count;
    uint32_t memory_of[MEMORIES + 1], buffer_of[BUFFERS + 1], accel_of[ACCELS + 1];
};

static void world_begin(void *state)
{
    ((struct world *)state)->resources = no_resources();
}

static void world_end(void *state)
{
    resources_destroy(((struct world *)state)->resources);
}

/* ---- what happens */

static void call(struct world *world, bool failed)
{
    world->is_scarce |= failed;
    world->buffers[0] = (struct buffer_model){0}; /* what was done to no buffer */
}

static void memory_add(void *state, const uint32_t *operands)
{
    struct world *world = state;
    uint32_t *n = &world->memory_of[operands[0] + 1];
    world->memory_alive[*n] = false;
    *n = ++world->memory_count;
    world->memory_alive[*n] = true;
    call(world, PROPERTY_CALL(have_memory(world->resources, operands[0] + 1)));
}

static void memory_remove(void *state, const uint32_t *operands)
{
    struct world *world = state;
    uint32_t *n = &world->memory_of[operands[0] + 1];
    world->memory_alive[*n] = false;
    *n = 0;
    call(world, PROPERTY_CALL(resources_remove_memory(world->resources, memory(operands[0] + 1))));
}

static void buffer_add(void *state, const uint32_t *operands)
{
    struct world *world = state;
    uint32_t *n = &world->buffer_of[operands[0] + 1];
    world->buffers[*n].alive = false;
    *n = ++world->buffer_count;
    world->buffers[*n] = (struct buffer_model){.alive = true,
                                               .size = operands[1] + 1,
                                               .usage = 1u << operands[2],
                                               .is_protected = operands[3] == 0,
                                               .bound = NO};
    const STRUCT(VkBufferCreateInfo, info, .size = operands[1] + 1, .usage = 1u << operands[2],
                 .flags = operands[3] ? 0 : VK_BUFFER_CREATE_PROTECTED_BIT);
    call(world,
         PROPERTY_CALL(resources_add_buffer(world->resources, buffer(operands[0] + 1), &info)));
}

static void buffer_remove(void *state, const uint32_t *operands)
{
    struct world *world = state;
    uint32_t *n = &world->buffer_of[operands[0] + 1];
    world->buffers[*n].alive = false;
    *n = 0;
    call(world, PROPERTY_CALL(resources_remove_buffer(world->resources, buffer(operands[0] + 1))));
}

static void buffer_bind(void *state, const uint32_t *operands)
{
    struct world *world = state;
    const uint32_t m = operands[1] + 1;
    struct buffer_model *model = &world->buffers[world->buffer_of[operands[0] + 1]];
    model->bound = world->memory_of[m] ? YES : UNKNOWN;
    model->memory = world->memory_of[m];
    model->memory_handle = m;
    model->offset = operands[2];
    model->differs = operands[3] == 0;
    call(world, PROPERTY_CALL(resources_bind_buffer(world->resources, buffer(operands[0] + 1),
                                                    memory(m), operands[2], operands[3] == 0)));
}

/* The call that binds has failed. */
static void buffer_forget(void *state, const uint32_t *operands)
{
    struct world *world = state;
    world->buffers[world->buffer_of[operands[0] + 1]].bound = UNKNOWN;
    call(world, PROPERTY_CALL(resources_forget_binding(world->resources, buffer(operands[0] + 1))));
}

static void buffer_address(void *state, const uint32_t *operands)
{
    struct world *world = state;
    const VkDeviceAddress address = operands[2] ? BASE + operands[1] : 0;
    world->buffers[world->buffer_of[operands[0] + 1]].address = address;
    call(world,
         PROPERTY_CALL(resources_set_address(world->resources, buffer(operands[0] + 1), address)));
}

static void accel_add(void *state, const uint32_t *operands)
{
    struct world *world = state;
    const uint32_t b = operands[1] + 1;
    world->accel_of[operands[0] + 1] = ++world->accel_count;
    world->accels[world->accel_count] =
        (struct accel_model){world->buffer_of[b], b, operands[2], operands[3] + 1};
    call(world, PROPERTY_CALL(have_accel(world->resources, operands[0] + 1, b, operands[2],
                                         operands[3] + 1)));
}

/* A structure over an address range lies in the buffer that has all of it, if there is one alone.
 */
static void accel_add_at(void *state, const uint32_t *operands)
{
    struct world *world = state;
    const VkDeviceAddress address = BASE + operands[1];
    struct accel_model model = {.size = operands[2] + 1};
    uint32_t holders = 0;
    for (uint32_t b = 1; b <= BUFFERS; b++) {
        const struct buffer_model *in = &world->buffers[world->buffer_of[b]];
        if (!in->alive || !in->address || address - in->address >= in->size ||
            model.size > in->size - (address - in->address))
            continue;
        holders++;
        model = (struct accel_model){world->buffer_of[b], b, address - in->address, model.size};
    }
    if (holders != 1)
        model.buffer = 0;
    world->accel_of[operands[0] + 1] = ++world->accel_count;
    world->accels[world->accel_count] = model;
    call(world,
         PROPERTY_CALL(have_accel_at(world->resources, operands[0] + 1, address, model.size)));
}

static void accel_remove(void *state, const uint32_t *operands)
{
    struct world *world = state;
    const uint64_t id = accel_facts(world->resources, operands[0] + 1).id;
    EXPECT_EQUAL(
        id, resources_find_id(world->resources, RESOURCE_ACCEL, (uintptr_t)accel(operands[0] + 1)));
    EXPECT_EQUAL(resources_remove_accel(world->resources, accel(operands[0] + 1)), id);
    world->accel_of[operands[0] + 1] = 0;
}

/* ---- what should be known of it */

static enum tristate backing_of(const struct world *world, const struct buffer_model *buffer)
{
    if (!buffer->alive)
        return NO;
    if (buffer->bound != YES)
        return buffer->bound;
    return world->memory_alive[buffer->memory] ? YES : NO;
}

static void expect_span(const struct world *world, struct memory_span span,
                        const struct buffer_model *buffer, VkDeviceSize begin, VkDeviceSize end)
{
    const bool is_known = backing_of(world, buffer) == YES && !buffer->differs;
    EXPECT_SAME(span.memory, memory(is_known ? buffer->memory_handle : 0));
    EXPECT(!is_known || (span.begin == buffer->offset + begin && span.end == buffer->offset + end));
}

static void look_at_accel(void *state, const uint32_t *operands)
{
    struct world *world = state;
    const uint32_t n = world->accel_of[operands[0] + 1];
    const struct accel_facts facts = accel_facts(world->resources, operands[0] + 1);
    const struct accel_model *model = &world->accels[n];
    const struct buffer_model *in = &world->buffers[model->buffer];
    if (world->is_scarce && facts.alive == UNKNOWN)
        return;
    EXPECT_EQUAL(facts.alive, n ? YES : NO);
    EXPECT_EQUAL(facts.details_known, n != 0);
    EXPECT_EQUAL(facts.id != 0, n != 0);
    if (!n || (world->is_scarce && facts.backed == UNKNOWN))
        return;
    EXPECT_EQUAL(facts.size, model->size);
    EXPECT_EQUAL(facts.backed, model->buffer ? backing_of(world, in) : UNKNOWN);
    EXPECT_SAME(facts.buffer, buffer(model->buffer ? model->buffer_handle : 0));
    EXPECT(!model->buffer || facts.begin == model->offset + (facts.memory ? in->offset : 0));
    expect_span(world, accel_span(&facts), in, model->offset, model->offset + model->size);
}

static enum address_status status_of(enum tristate backing)
{
    return backing == YES ? ADDRESS_IN_BUFFER : backing == NO ? ADDRESS_UNBOUND : ADDRESS_UNKNOWN;
}

static int rank_of(enum address_status status)
{
    return status == ADDRESS_UNKNOWN     ? 3
           : status == ADDRESS_IN_BUFFER ? 2
           : status == ADDRESS_UNBOUND   ? 1
                                         : 0;
}

/* From all buffers that have an address: whether one is protected; among those of the best status,
 * the same, the usage of all and the length of the longest. */
static struct address_facts expected_at(const struct world *world, VkDeviceAddress address,
                                        bool *any_protected)
{
    struct address_facts expected = {.status = ADDRESS_NOWHERE};
    *any_protected = false;
    for (uint32_t b = 1; b <= BUFFERS; b++) {
        const struct buffer_model *model = &world->buffers[world->buffer_of[b]];
        if (!model->alive || !model->address || address - model->address >= model->size)
            continue;
        const enum address_status status = status_of(backing_of(world, model));
        const VkDeviceSize left = model->size - (address - model->address);
        *any_protected |= model->is_protected;
        if (rank_of(status) > rank_of(expected.status))
            expected = (struct address_facts){.status = status};
        if (status != expected.status)
            continue;
        expected.is_protected |= model->is_protected;
        expected.usage |= model->usage;
        expected.bytes_left = left > expected.bytes_left ? left : expected.bytes_left;
    }
    return expected;
}

/* Whether what the device can read at the address of some buffer is unknown. */
static bool expected_unknown(const struct world *world)
{
    for (uint32_t b = 1; b <= BUFFERS; b++) {
        const struct buffer_model *model = &world->buffers[world->buffer_of[b]];
        if (model->alive && model->address &&
            (model->is_protected || backing_of(world, model) == UNKNOWN))
            return true;
    }
    return false;
}

static void look_at_address(void *state, const uint32_t *operands)
{
    struct world *world = state;
    const VkDeviceAddress address = BASE + operands[0];
    bool any_protected;
    const struct address_facts facts = address_facts(world->resources, address),
                               expected = expected_at(world, address, &any_protected);
    if (world->is_scarce && facts.status == ADDRESS_UNKNOWN)
        return;
    if (!world->is_scarce)
        EXPECT_EQUAL(resources_has_unknown_ranges(world->resources), expected_unknown(world));
    const uint64_t readable =
        resources_find_readable(world->resources, address, operands[1] + 1, &all_of_queue_1);
    const uint64_t end =
        expected.bytes_left < operands[1] + 1 ? expected.bytes_left : operands[1] + 1;
    EXPECT_EQUAL(facts.status, expected.status);
    EXPECT_EQUAL(facts.usage, expected.usage);
    EXPECT_EQUAL(facts.bytes_left, expected.bytes_left);
    if (facts.status != ADDRESS_IN_BUFFER || expected.is_protected || !any_protected || readable)
        EXPECT_EQUAL(readable,
                     facts.status == ADDRESS_IN_BUFFER && !expected.is_protected ? end : 0);
    for (uint32_t b = 1; b <= BUFFERS && facts.status != ADDRESS_NOWHERE; b++)
        if (facts.buffer == buffer(b)) {
            const struct buffer_model *in = &world->buffers[world->buffer_of[b]];
            EXPECT_EQUAL(in->size - (address - in->address), facts.bytes_left);
            expect_span(world, address_span(&facts), in, address - in->address, in->size);
            return;
        }
    EXPECT_EQUAL(facts.status, ADDRESS_NOWHERE);
}

#define LIVES(scarce_)                                                                             \
    .size = sizeof(struct world), .begin = world_begin, .end = world_end,                          \
    .operations = {{"memory_add", memory_add, {MEMORIES}, 4, .scarce = scarce_},                   \
                   {"memory_remove", memory_remove, {MEMORIES}, 2, .scarce = scarce_},             \
                   {"buffer_add", buffer_add, {BUFFERS, SPACE, 8, 12}, 4, .scarce = scarce_},      \
                   {"buffer_remove", buffer_remove, {BUFFERS}, 2, .scarce = scarce_},              \
                   {"bind", buffer_bind, {BUFFERS, MEMORIES, SPACE, 8}, 11, .scarce = scarce_},    \
                   {"forget", buffer_forget, {BUFFERS}, 1},                                        \
                   {"address", buffer_address, {BUFFERS, SPACE, 12}, 6, .scarce = scarce_},        \
                   {"accel_add", accel_add, {ACCELS, BUFFERS, 64, 64}, 3, .scarce = scarce_},      \
                   {"accel_add_at", accel_add_at, {ACCELS, SPACE, 64}, 2, .scarce = scarce_},      \
                   {"accel_remove", accel_remove, {ACCELS}, 2},                                    \
                   {"accel", look_at_accel, {ACCELS}, 20},                                         \
                   {"at", look_at_address, {2 * SPACE, SPACE}, 20}}

PROPERTY_TEST(resources, LIVES(0), .sequences = 16, .steps = STEPS)
PROPERTY_TEST(resources_without_memory, LIVES(60), .sequences = 200, .steps = 150,
              .cases = (const char *const[]){
                  /* The buffer that is lost may have the structure's addresses, too. */
                  "buffer_add 2 187 0 1 !0; buffer_add 0 0 0 1; address 0 455 1; address 2 268 1;"
                  "accel_add_at 5 455 0; buffer_remove 0; accel 5",
                  NULL})
