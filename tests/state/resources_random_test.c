/* SPDX-License-Identifier: Apache-2.0 */
/* Random lives of buffers, memory and structures with few handles, which are therefore reused all
 * the time, against a naive model that keeps everything that ever was. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../report/scarce_memory.h"
#include "random.h"
#include "things.h"

enum { MEMORIES = 4, BUFFERS = 7, ACCELS = 7, OBJECTS = 4000, STEPS = 3000, SPACE = 0x400 };

#define BASE 0x10000u

struct memory_model {
    bool alive;
};

struct buffer_model {
    bool alive;
    VkDeviceSize size;
    VkBufferUsageFlags usage;
    VkDeviceAddress address;
    enum tristate bound;
    uint32_t memory, memory_handle; /* index in world.memories */
    VkDeviceSize offset;
    bool differs;
};

struct accel_model {
    uint32_t buffer, buffer_handle; /* index in world.buffers; 0: none */
    VkDeviceSize offset, size;
};

/* Everything that ever was; index 0 is nothing. Handles lead to what they are of now. */
struct world {
    struct resources *resources;
    struct memory_model memories[OBJECTS];
    struct buffer_model buffers[OBJECTS];
    struct accel_model accels[OBJECTS];
    uint32_t memory_count, buffer_count, accel_count;
    uint32_t memory_of[MEMORIES + 1], buffer_of[BUFFERS + 1], accel_of[ACCELS + 1];
};

static struct world *a_world(void)
{
    struct world *world = calloc(1, sizeof(*world));
    assert_non_null(world);
    world->resources = no_resources();
    world->memory_count = world->buffer_count = world->accel_count = 1;
    return world;
}

/* ---- what happens */

static void destroy_memory(struct world *world, uint32_t n)
{
    world->memories[world->memory_of[n]].alive = false;
    world->memory_of[n] = 0;
}

static void destroy_buffer(struct world *world, uint32_t n)
{
    world->buffers[world->buffer_of[n]].alive = false;
    world->buffer_of[n] = 0;
}

static void step_memory(struct random *random, struct world *world)
{
    uint32_t n = 1 + random_below(random, MEMORIES);
    destroy_memory(world, n);
    if (random_one_in(random, 3)) {
        resources_remove_memory(world->resources, memory(n));
        return;
    }
    have_memory(world->resources, n);
    world->memory_of[n] = world->memory_count++;
    world->memories[world->memory_of[n]].alive = true;
}

static void step_buffer(struct random *random, struct world *world)
{
    uint32_t n = 1 + random_below(random, BUFFERS);
    destroy_buffer(world, n);
    if (random_one_in(random, 3)) {
        resources_remove_buffer(world->resources, buffer(n));
        return;
    }
    struct buffer_model model = {.alive = true,
                                 .size = 1 + random_below(random, SPACE),
                                 .usage = 1u << random_below(random, 8),
                                 .bound = NO};
    have_buffer(world->resources, n, model.size, model.usage);
    world->buffer_of[n] = world->buffer_count;
    world->buffers[world->buffer_count++] = model;
}

static void step_binding(struct random *random, struct world *world)
{
    uint32_t n = 1 + random_below(random, BUFFERS), m = 1 + random_below(random, MEMORIES);
    VkDeviceSize offset = random_below(random, SPACE);
    struct buffer_model *model = &world->buffers[world->buffer_of[n]];
    if (random_one_in(random, 12)) {
        resources_forget_binding(world->resources, buffer(n));
        model->bound = UNKNOWN;
        return;
    }
    bool differs = random_one_in(random, 8);
    resources_bind_buffer(world->resources, buffer(n), memory(m), offset, differs);
    model->bound = world->memory_of[m] ? YES : UNKNOWN;
    model->memory = world->memory_of[m];
    model->memory_handle = m;
    model->offset = offset;
    model->differs = differs;
}

static void step_address(struct random *random, struct world *world)
{
    uint32_t n = 1 + random_below(random, BUFFERS);
    VkDeviceAddress address = random_one_in(random, 12) ? 0 : BASE + random_below(random, SPACE);
    resources_set_address(world->resources, buffer(n), address);
    world->buffers[world->buffer_of[n]].address = address;
}

static void step_accel(struct random *random, struct world *world)
{
    uint32_t n = 1 + random_below(random, ACCELS), b = 1 + random_below(random, BUFFERS);
    if (random_one_in(random, 3)) {
        resources_remove_accel(world->resources, accel(n));
        world->accel_of[n] = 0;
        return;
    }
    struct accel_model model = {.buffer = world->buffer_of[b],
                                .buffer_handle = b,
                                .offset = random_below(random, 64),
                                .size = 1 + random_below(random, 64)};
    have_accel(world->resources, n, b, model.offset, model.size);
    world->accel_of[n] = world->accel_count;
    world->accels[world->accel_count++] = model;
}

static void step(struct random *random, struct world *world)
{
    static void (*const steps[])(struct random *, struct world *) = {
        step_memory, step_buffer, step_binding, step_binding, step_address, step_accel};
    steps[random_below(random, sizeof(steps) / sizeof(steps[0]))](random, world);
    world->buffers[0] = (struct buffer_model){0}; /* what was done to no buffer */
    world->memories[0] = (struct memory_model){0};
}

/* ---- what should be known of it */

static enum tristate backing_of(const struct world *world, const struct buffer_model *buffer)
{
    if (!buffer->alive)
        return NO;
    if (buffer->bound != YES)
        return buffer->bound;
    return world->memories[buffer->memory].alive ? YES : NO;
}

static void assert_lies(const struct world *world, struct memory_span span,
                        const struct buffer_model *buffer, VkDeviceSize begin, VkDeviceSize end)
{
    if (backing_of(world, buffer) == YES && !buffer->differs)
        assert_span(&span, buffer->memory_handle, buffer->offset + begin, buffer->offset + end);
    else
        assert_no_span(&span);
}

static void assert_accel(const struct world *world, uint32_t n)
{
    struct accel_facts facts = accel_facts(world->resources, n);
    const struct accel_model *model = &world->accels[world->accel_of[n]];
    assert_int_equal(facts.alive, world->accel_of[n] ? YES : NO);
    assert_int_equal(facts.details_known, facts.alive == YES);
    if (facts.alive == NO)
        return;
    const struct buffer_model *in = &world->buffers[model->buffer];
    assert_int_equal(facts.size, model->size);
    assert_int_equal(facts.backed, model->buffer ? backing_of(world, in) : UNKNOWN);
    assert_ptr_equal(facts.buffer, buffer(model->buffer ? model->buffer_handle : 0));
    assert_lies(world, accel_span(&facts), in, model->offset, model->offset + model->size);
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

/* The facts about an address, from all buffers that hold it; among those of the best status, the
 * usage of all and the length of the longest. */
static void assert_address(const struct world *world, VkDeviceAddress address)
{
    struct address_facts facts = address_facts(world->resources, address);
    struct address_facts expected = {.status = ADDRESS_NOWHERE};
    const struct buffer_model *chosen = NULL;
    for (uint32_t i = 1; i < world->buffer_count; i++) {
        const struct buffer_model *model = &world->buffers[i];
        if (!model->alive || !model->address || address < model->address ||
            address - model->address >= model->size)
            continue;
        enum address_status status = status_of(backing_of(world, model));
        if (rank_of(status) < rank_of(expected.status))
            continue;
        if (rank_of(status) > rank_of(expected.status))
            expected = (struct address_facts){.status = status};
        expected.usage |= model->usage;
        VkDeviceSize left = model->size - (address - model->address);
        if (left > expected.bytes_left)
            expected.bytes_left = left;
    }
    assert_int_equal(facts.status, expected.status);
    assert_int_equal(facts.usage, expected.usage);
    assert_int_equal(facts.bytes_left, expected.bytes_left);
    if (facts.status == ADDRESS_NOWHERE)
        return;
    for (uint32_t n = 1; n <= BUFFERS; n++)
        if (facts.buffer == buffer(n))
            chosen = &world->buffers[world->buffer_of[n]];
    assert_non_null(chosen);
    assert_int_equal(chosen->size - (address - chosen->address), facts.bytes_left);
    assert_lies(world, address_span(&facts), chosen, address - chosen->address, chosen->size);
}

static void test_random_lives(void **state)
{
    (void)state;
    struct random random = random_of("resources");
    for (int life = 0; life < 4; life++) {
        struct world *world = a_world();
        for (int i = 0; i < STEPS; i++) {
            step(&random, world);
            assert_accel(world, 1 + random_below(&random, ACCELS));
            assert_address(world, BASE + random_below(&random, 2 * SPACE));
        }
        for (uint32_t n = 1; n <= ACCELS; n++)
            assert_accel(world, n);
        resources_destroy(world->resources);
        free(world);
    }
}

/* ---- with memory running out: nothing that is said with certainty may be wrong */

static void assert_accel_is_not_wrong(const struct world *world, uint32_t n)
{
    struct accel_facts facts = accel_facts(world->resources, n);
    const struct accel_model *model = &world->accels[world->accel_of[n]];
    const struct buffer_model *in = &world->buffers[model->buffer];
    if (facts.alive != UNKNOWN)
        assert_int_equal(facts.alive, world->accel_of[n] ? YES : NO);
    if (facts.alive == YES && facts.backed != UNKNOWN)
        assert_int_equal(facts.backed, backing_of(world, in));
    if (facts.memory)
        assert_lies(world, accel_span(&facts), in, model->offset, model->offset + model->size);
}

static void test_random_lives_without_memory(void **state)
{
    (void)state;
    struct random random = random_of("resources without memory");
    unsigned failures = 0;
    for (int life = 0; life < 200; life++) {
        struct world *world = a_world();
        memory_fail_after((int)random_below(&random, 60));
        for (int i = 0; i < 150; i++) {
            step(&random, world);
            assert_accel_is_not_wrong(world, 1 + random_below(&random, ACCELS));
        }
        bool failed = memory_fail_no_more();
        failures += failed;
        struct address_facts facts = address_facts(world->resources, BASE + SPACE);
        if (facts.status != ADDRESS_UNKNOWN)
            assert_address(world, BASE + SPACE);
        resources_destroy(world->resources);
        free(world);
    }
    assert_true(failures > 50);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random_lives),
        cmocka_unit_test(test_random_lives_without_memory),
    };
    return cmocka_run_group_tests_name("resources at random", tests, NULL, NULL);
}
