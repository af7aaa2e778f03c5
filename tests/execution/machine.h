/* SPDX-License-Identifier: Apache-2.0 */
/* What plays the steps of a program: structures, command buffers, queues and semaphores. */
#ifndef EXECUTION_MACHINE_H
#define EXECUTION_MACHINE_H

#include "program.h"
#include "tests/fixture/batches.h"

enum { MACHINE_ACCEL_SIZE = 65536 };

/* Where a build was recorded; or NOWHERE, or BY_HOST with its index in pInfos. */
struct place {
    uint32_t command_buffer, position;
};
enum { NOWHERE = COMMAND_BUFFERS, BY_HOST };

struct machine {
    struct scene *scene;
    const VkuDeviceDispatchTable *vk;
    VkDevice device;
    enum build_command build_command, update_command;
    VkAccelerationStructureTypeKHR type; /* of structures */
    struct shape good, bad;

    struct {
        VkAccelerationStructureKHR handle;
        struct test_buffer buffer;
    } structures[STRUCTURES];
    bool is_nv; /* VK_NV_ray_tracing takes the steps */
    struct {
        VkAccelerationStructureNV handle;
        VkDeviceMemory memory;
    } nv[STRUCTURES];
    struct test_buffer scratch, blob;
    VkCommandPool pools[COMMAND_BUFFERS];
    VkCommandBuffer command_buffers[COMMAND_BUFFERS];
    VkQueue queues[QUEUES]; /* null where there is no second */
    VkSemaphore binaries[SEMAPHORES], timelines[SEMAPHORES + 1];
    VkFence fence;
    VkEvent events[EVENTS];
    struct test_memory pages; /* for sparse buffers */
    VkQueryPool queries;
    VkDeviceSize compacted; /* as read last */

    struct batch batches[BATCHES_MAX]; /* of the submission that is being put together */
    uint32_t batch_count;
    uint32_t positions[COMMAND_BUFFERS];                        /* builds recorded so far */
    VkDeferredOperationKHR operations[DEFERRED_OPERATIONS + 1]; /* the first is null */
    struct place last_build, last_bad, last_update;
    VkResult result; /* of the last submission, or update by the host */
};

/* Calls a command of the machine's device that has to succeed. */
#define MACHINE_CALL(machine, name, ...)                                                           \
    expect_success((machine)->vk->name(__VA_ARGS__), "vk" #name)

/* `type` is that of the structures. */
void machine_open(struct machine *machine, struct fixture *fixture,
                  VkAccelerationStructureTypeKHR type);
void machine_close(struct machine *machine);

/* Neither ACTION_REPORTS nor the end. */
void machine_step(struct machine *machine, const struct step *step);

/* The family of a queue, UINT32_MAX if there is none. */
uint32_t machine_family(const struct fixture *fixture, uint32_t queue);

/* The name that a command buffer has in messages. */
const char *machine_name(uint32_t command_buffer);

/* Gives a command buffer its place, which is empty, and its name. */
void machine_allocate(struct machine *machine, uint32_t command_buffer);

/* machine_record.c */
void machine_record(struct machine *machine, const struct step *step);
/* Around a build: its place and labels, then a barrier behind it. */
void machine_begin_build(struct machine *machine, const struct step *step);
void machine_end_build(struct machine *machine, const struct step *step);
/* Between builds, and copies of structures. */
void machine_barrier(const struct machine *machine, VkCommandBuffer command_buffer);

/* What the device and the host copy. */
VkCopyAccelerationStructureInfoKHR machine_copy(const struct machine *machine,
                                                const struct step *step);

/* machine_nv.c: gives the machine structures of its kind; takes a step, unless it is the same for
 * both extensions; and whether a program has no other steps than it can take. */
void machine_nv_open(struct machine *machine);
bool machine_nv_step(struct machine *machine, const struct step *step);
bool machine_nv_takes(const struct program *program);

/* Gives a command buffer a pool of its own. */
void machine_create_pool(struct machine *machine, uint32_t command_buffer);

/* The arguments of a build of that shape into a structure. */
void machine_fill_build(struct machine *machine, struct shape_arguments *arguments,
                        uint32_t command_buffer, uint32_t dst, const struct shape *shape);
const struct shape *machine_shape(const struct machine *machine, const struct step *step);

/* machine_host.c */
void machine_host(struct machine *machine, const struct step *step);
void machine_create_operation(struct machine *machine, uint32_t operation);
void machine_query(struct machine *machine, const struct step *step);

/* machine_submit.c */
void machine_submit(struct machine *machine, const struct step *step);

#endif
