/* SPDX-License-Identifier: Apache-2.0 */
/* A device of lavapipe below the layer. */
#ifndef TESTS_COMPARE_BENCH_H
#define TESTS_COMPARE_BENCH_H

#include "layer/compare/tracer.h"
#include "subject.h"
#include "tests/fixture/instance.h"

enum bench_kind {
    BENCH_PLAIN,     /* the application enables nothing that traces */
    BENCH_PIPELINES, /* it enables pipelines */
};

struct bench {
    enum bench_kind kind;
    struct instance_fixture instance;
    VkCommandPool pool;
    char driver[VK_MAX_DRIVER_INFO_SIZE]; /* its version */
    VkDevice device;
    VkQueue queue;
    VkPhysicalDeviceMemoryProperties memory;
    VkuDeviceDispatchTable vk;
    struct compare_device compare;
};

/* NULL, or why there is no such device here. */
const char *bench_open(enum bench_kind kind);
void bench_close(void);

/* The bench of a program of tests, which unit_test_open() opens: for pipelines if that is its
 * argument. Fills the soup. Returns NULL, or why there is no such device here. */
extern struct bench bench;
const char *bench_open_tests(const char *argument);

/* How many messages there were of a difference. */
uint32_t bench_count(enum difference difference);

/* A command buffer, which is submitted, waited for and freed. */
VkCommandBuffer bench_begin(void);
void bench_submit(VkCommandBuffer commands);
void bench_finish(VkCommandBuffer commands);

#endif
