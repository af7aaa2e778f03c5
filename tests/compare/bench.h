/* SPDX-License-Identifier: Apache-2.0 */
/* A device that traces, without the layer. */
#ifndef TESTS_COMPARE_BENCH_H
#define TESTS_COMPARE_BENCH_H

#include "compare/tracer.h"
#include "subject.h"

struct bench {
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
const char *bench_open(struct bench *bench);
void bench_close(struct bench *bench);

/* `source`: what is built first and then updated; or NULL. Ends the test where something fails. */
void bench_compare(struct bench *bench, const struct subject *source, const struct subject *subject,
                   uint32_t count, struct tally *tally);

#endif
