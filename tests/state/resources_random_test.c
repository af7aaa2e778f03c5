/* SPDX-License-Identifier: Apache-2.0 */
/* Random lives of buffers, memory and structures with few handles, which are therefore reused all
 * the time, against a naive model that keeps everything that ever was. */
#include <stdlib.h>

#include "random.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/fixture.h"

enum { BUFFERS = 7, ACCELS = 7, OBJECTS = 4000, STEPS = 3000, SPACE = 0x400 };

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
struct fixture {
    struct resources *resources;
    struct memory_model memories[OBJECTS];
    struct buffer_model buffers[OBJECTS];
    struct accel_model accels[OBJECTS];
    uint32_t memory_count, buffer_count, accel_count;
    uint32_t memory_of[MEMORIES + 1], buffer_of[BUFFERS + 1], accel_of[ACCELS + 1];
};

static struct fixture *a_fixture(void)
{
    struct fixture *fixture = calloc(1, sizeof(*fixture));
    assert_non_null(fixture);
    fixture->resources = no_resources();
    fixture->memory_count = fixture->buffer_count = fixture->accel_count = 1;
    return fixture;
}

/* ---- what happens */

static void destroy_memory(struct fixture *fixture, uint32_t n)
{
    fixture->memories[fixture->memory_of[n]].alive = false;
    fixture->memory_of[n] = 0;
}

static void destroy_buffer(struct fixture *fixture, uint32_t n)
{
    fixture->buffers[fixture->buffer_of[n]].alive = false;
    fixture->buffer_of[n] = 0;
}

static void step_memory(struct random *random, struct fixture *fixture)
{
    uint32_t n = 1 + random_below(random, MEMORIES);
    destroy_memory(fixture, n);
    if (random_one_in(random, 3)) {
        resources_remove_memory(fixture->resources, memory(n));
        return;
    }
    have_memory(fixture->resources, n);
    fixture->memory_of[n] = fixture->memory_count++;
    fixture->memories[fixture->memory_of[n]].alive = true;
}

static void step_buffer(struct random *random, struct fixture *fixture)
{
    uint32_t n = 1 + random_below(random, BUFFERS);
    destroy_buffer(fixture, n);
    if (random_one_in(random, 3)) {
        resources_remove_buffer(fixture->resources, buffer(n));
        return;
    }
    struct buffer_model model = {.alive = true,
                                 .size = 1 + random_below(random, SPACE),
                                 .usage = 1u << random_below(random, 8),
                                 .bound = NO};
    have_buffer(fixture->resources, n, model.size, model.usage);
    fixture->buffer_of[n] = fixture->buffer_count;
    fixture->buffers[fixture->buffer_count++] = model;
}

static void step_binding(struct random *random, struct fixture *fixture)
{
    uint32_t n = 1 + random_below(random, BUFFERS), m = 1 + random_below(random, MEMORIES);
    VkDeviceSize offset = random_below(random, SPACE);
    struct buffer_model *model = &fixture->buffers[fixture->buffer_of[n]];
    if (random_one_in(random, 12)) {
        resources_forget_binding(fixture->resources, buffer(n));
        model->bound = UNKNOWN;
        return;
    }
    bool differs = random_one_in(random, 8);
    resources_bind_buffer(fixture->resources, buffer(n), memory(m), offset, differs);
    model->bound = fixture->memory_of[m] ? YES : UNKNOWN;
    model->memory = fixture->memory_of[m];
    model->memory_handle = m;
    model->offset = offset;
    model->differs = differs;
}

static void step_address(struct random *random, struct fixture *fixture)
{
    uint32_t n = 1 + random_below(random, BUFFERS);
    VkDeviceAddress address = random_one_in(random, 12) ? 0 : BASE + random_below(random, SPACE);
    resources_set_address(fixture->resources, buffer(n), address);
    fixture->buffers[fixture->buffer_of[n]].address = address;
}

static void step_accel(struct random *random, struct fixture *fixture)
{
    uint32_t n = 1 + random_below(random, ACCELS), b = 1 + random_below(random, BUFFERS);
    if (random_one_in(random, 3)) {
        resources_remove_accel(fixture->resources, accel(n));
        fixture->accel_of[n] = 0;
        return;
    }
    struct accel_model model = {.buffer = fixture->buffer_of[b],
                                .buffer_handle = b,
                                .offset = random_below(random, 64),
                                .size = 1 + random_below(random, 64)};
    have_accel(fixture->resources, n, b, model.offset, model.size);
    fixture->accel_of[n] = fixture->accel_count;
    fixture->accels[fixture->accel_count++] = model;
}

static void step(struct random *random, struct fixture *fixture)
{
    static void (*const steps[])(struct random *, struct fixture *) = {
        step_memory, step_buffer, step_binding, step_binding, step_address, step_accel};
    steps[random_below(random, sizeof(steps) / sizeof(steps[0]))](random, fixture);
    fixture->buffers[0] = (struct buffer_model){0}; /* what was done to no buffer */
    fixture->memories[0] = (struct memory_model){0};
}

/* ---- what should be known of it */

static enum tristate backing_of(const struct fixture *fixture, const struct buffer_model *buffer)
{
    if (!buffer->alive)
        return NO;
    if (buffer->bound != YES)
        return buffer->bound;
    return fixture->memories[buffer->memory].alive ? YES : NO;
}

static void assert_lies(const struct fixture *fixture, struct memory_span span,
                        const struct buffer_model *buffer, VkDeviceSize begin, VkDeviceSize end)
{
    if (backing_of(fixture, buffer) == YES && !buffer->differs)
        assert_span(span, buffer->memory_handle, buffer->offset + begin, buffer->offset + end);
    else
        assert_null(span.memory);
}

static void assert_accel(const struct fixture *fixture, uint32_t n)
{
    struct accel_facts facts = accel_facts(fixture->resources, n);
    const struct accel_model *model = &fixture->accels[fixture->accel_of[n]];
    assert_int_equal(facts.alive, fixture->accel_of[n] ? YES : NO);
    assert_int_equal(facts.details_known, facts.alive == YES);
    if (facts.alive == NO)
        return;
    const struct buffer_model *in = &fixture->buffers[model->buffer];
    assert_int_equal(facts.size, model->size);
    assert_int_equal(facts.backed, model->buffer ? backing_of(fixture, in) : UNKNOWN);
    assert_ptr_equal(facts.buffer, buffer(model->buffer ? model->buffer_handle : 0));
    assert_lies(fixture, accel_span(&facts), in, model->offset, model->offset + model->size);
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
static void assert_address(const struct fixture *fixture, VkDeviceAddress address)
{
    struct address_facts facts = address_facts(fixture->resources, address);
    struct address_facts expected = {.status = ADDRESS_NOWHERE};
    const struct buffer_model *chosen = NULL;
    for (uint32_t i = 1; i < fixture->buffer_count; i++) {
        const struct buffer_model *model = &fixture->buffers[i];
        if (!model->alive || !model->address || address < model->address ||
            address - model->address >= model->size)
            continue;
        enum address_status status = status_of(backing_of(fixture, model));
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
            chosen = &fixture->buffers[fixture->buffer_of[n]];
    assert_non_null(chosen);
    assert_int_equal(chosen->size - (address - chosen->address), facts.bytes_left);
    assert_lies(fixture, address_span(&facts), chosen, address - chosen->address, chosen->size);
}

TEST(test_random_lives)
{
    struct random random = random_of("resources");
    for (int life = 0; life < 4; life++) {
        struct fixture *fixture = a_fixture();
        for (int i = 0; i < STEPS; i++) {
            step(&random, fixture);
            assert_accel(fixture, 1 + random_below(&random, ACCELS));
            assert_address(fixture, BASE + random_below(&random, 2 * SPACE));
        }
        for (uint32_t n = 1; n <= ACCELS; n++)
            assert_accel(fixture, n);
        resources_destroy(fixture->resources);
        free(fixture);
    }
}

/* ---- with memory running out: nothing that is said with certainty may be wrong */

static void assert_accel_is_not_wrong(const struct fixture *fixture, uint32_t n)
{
    struct accel_facts facts = accel_facts(fixture->resources, n);
    const struct accel_model *model = &fixture->accels[fixture->accel_of[n]];
    const struct buffer_model *in = &fixture->buffers[model->buffer];
    if (facts.alive != UNKNOWN)
        assert_int_equal(facts.alive, fixture->accel_of[n] ? YES : NO);
    if (facts.alive == YES && facts.backed != UNKNOWN)
        assert_int_equal(facts.backed, backing_of(fixture, in));
    if (facts.memory)
        assert_lies(fixture, accel_span(&facts), in, model->offset, model->offset + model->size);
}

TEST(test_random_lives_without_memory)
{
    struct random random = random_of("resources without memory");
    unsigned failures = 0;
    for (int life = 0; life < 200; life++) {
        struct fixture *fixture = a_fixture();
        memory_fail_after((int)random_below(&random, 60));
        for (int i = 0; i < 150; i++) {
            step(&random, fixture);
            assert_accel_is_not_wrong(fixture, 1 + random_below(&random, ACCELS));
        }
        bool failed = memory_fail_no_more();
        failures += failed;
        struct address_facts facts = address_facts(fixture->resources, BASE + SPACE);
        if (facts.status != ADDRESS_UNKNOWN)
            assert_address(fixture, BASE + SPACE);
        resources_destroy(fixture->resources);
        free(fixture);
    }
    assert_true(failures > 50);
}
