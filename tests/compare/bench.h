/* SPDX-License-Identifier: Apache-2.0 */
/* A device of lavapipe: one that traces, without the layer; or one that only builds, below it. */
#ifndef TESTS_COMPARE_BENCH_H
#define TESTS_COMPARE_BENCH_H

#include "layer/compare/tracer.h"
#include "subject.h"

enum bench_kind {
    BENCH_QUERIES,
    BENCH_PIPELINES,
    BENCH_LAYER, /* neither is enabled */
    BENCH_LAYER_PIPELINES,
};

/* Messages of the layer. */
struct heard {
    uint32_t count, counts[DIFFERENCE_COUNT];
    char texts[DIFFERENCE_COUNT][4096], last[4096]; /* the last ones */
};

struct bench {
    enum bench_kind kind;
    struct heard heard;
    VkDebugUtilsMessengerEXT messenger;
    VkCommandPool pool;                   /* BENCH_LAYER */
    char driver[VK_MAX_DRIVER_INFO_SIZE]; /* its version */
    VkInstance instance;
    VkPhysicalDevice physical;
    VkDevice device;
    VkQueue queue;
    VkPhysicalDeviceMemoryProperties memory;
    VkuDeviceDispatchTable vk;
    pthread_mutex_t queue_lock;
    struct compare_device compare;
    struct tracer *tracer;
};

/* NULL, or why there is no such device here. */
const char *bench_open(struct bench *bench, enum bench_kind kind);
void bench_close(struct bench *bench);
/* Around a group of cmocka's tests, for which the soup is filled; without such a device they are
 * skipped. */
int bench_begin_tests(void **state, struct bench *bench, enum bench_kind kind);
int bench_end_tests(void **state);
/* "pipelines", or no argument. */
bool bench_wants_pipelines(int argc, char **argv);

/* A command buffer, which is submitted, waited for and freed. */
VkCommandBuffer bench_begin(struct bench *bench);
void bench_submit(struct bench *bench, VkCommandBuffer commands);
void bench_finish(struct bench *bench, VkCommandBuffer commands);

/* `source`: what is built first and then updated; or NULL. Ends the test where something fails. */
void bench_compare(struct bench *bench, const struct subject *source, const struct subject *subject,
                   uint32_t count, struct tally *tally);

#endif
