/* SPDX-License-Identifier: Apache-2.0 */
/* The shader that copies, by itself: sources of any alignment and size, against memcpy(). */
#include "tests/snapshots/shader.h"

#include <string.h>

#include "src/snapshots/recorded_build.h"
#include "tests/unit/random.h"

static const uint32_t code[] = {
#include "copy_comp.h"
};

enum {
    ORDERS = 300,
    SMALL_MAX = 300,
    ROOM = COPY_SIZE_MAX, /* of each target, */
    LARGE = 7,            /* and every so many sources are nearly as large */
    SOURCE_SIZE = 1 << 18,
    UNTOUCHED = 0xa5,
};

static struct device_buffer source, target, list, gate;

static void open_scene(void)
{
    shader_open(code, sizeof(code), 2 * sizeof(uint64_t));
    source = shader_buffer(SOURCE_SIZE);
    target = shader_buffer((VkDeviceSize)ORDERS * ROOM);
    gate = shader_buffer(sizeof(uint32_t));
    list = shader_buffer(ORDERS * sizeof(struct copy_order));
}

#define COPY_TEST(name) TEST_BETWEEN_IF(name, open_scene, shader_close, true)

static struct copy_order draw(struct random *random, uint32_t i)
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

static void run(bool is_open)
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
        orders[i] = draw(&random, i);
    run(true);
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
    run(false);
    for (uint32_t i = 0; i < ORDERS; i++)
        assert_int_equal(orders[i].is_done, 0);
    assert_int_equal(target.bytes[0], UNTOUCHED);
}
