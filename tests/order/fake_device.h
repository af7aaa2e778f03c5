/* SPDX-License-Identifier: Apache-2.0 */
/* A device made of fake commands under the intercepts, and the calls of an application. */
#ifndef ORDER_FAKE_DEVICE_H
#define ORDER_FAKE_DEVICE_H

#include "observers.h"
#include "program.h"
#include "tests/fixture/make.h"

extern struct layer_device device;
extern VkResult next_result; /* of the next call that reaches it */
extern uint32_t calls;       /* that reached it */
extern const char *reached;  /* the last of them */
extern uint64_t counter;     /* of semaphores, and the handle of what is created next */

void fake_device_start(struct program *program);

/* Starts the device with the one program of DEVICE_TEST. */
struct program *fake_device_open(void);

/* A test of `p`, a program on the device; it stops after the test. */
#define DEVICE_TEST(name) TEST_WITH(name, struct program *p, fake_device_open, program_stop)

void create_semaphore(uint32_t handle, VkSemaphoreType type, const void *chain);
void create_fence(uint32_t handle, const void *chain);

/* A batch; semaphore 0: none. */
struct batch {
    uint32_t queue, name, wait, signal, fence;
    uint64_t wait_value, signal_value;
    VkPipelineStageFlags2 wait_stages, signal_stages; /* vkQueueSubmit: of the wait; 0: all */
    uint32_t device_mask;                             /* vkQueueSubmit2 */
    const VkDeviceGroupSubmitInfo *group;             /* vkQueueSubmit */
};

VkResult submit_plain(const struct batch *batch);
VkResult submit_second(const struct batch *batch, PFN_vkQueueSubmit2 call);
#define PLAIN(...) submit_plain(&(struct batch){__VA_ARGS__})
#define SECOND(...) submit_second(&(struct batch){__VA_ARGS__}, entry_QueueSubmit2)

#endif
