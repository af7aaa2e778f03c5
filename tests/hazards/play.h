/* SPDX-License-Identifier: Apache-2.0 */
/* Plays a case: creates a device and the objects that the program names, and executes its lines.
 *
 * An object exists from its first use on. The first letter of its name says what it is:
 * B and T bottom- and top-level structures, M micromaps, E events, F images, P query pools,
 * s binary semaphores, t timelines, q queues, all other capital letters buffers. NAME+OFFSET is a
 * place in a buffer. Each object has memory of its own, unless the program says otherwise. */
#ifndef ASSAY_TESTS_HAZARDS_PLAY_H
#define ASSAY_TESTS_HAZARDS_PLAY_H

#include "cases.h"
#include "tests/fixture/batches.h"
#include "tests/fixture/instance.h"
#include "tests/fixture/make.h"

enum {
    PLAY_OBJECTS = 48,
    PLAY_QUEUES = 3,          /* two of family 0, one of family 1 */
    PLAY_ITEMS = BATCH_ITEMS, /* of anything that a line or a submission lists */
    PLAY_BUFFER_SIZE = 128 * 1024,
    PLAY_STRUCTURE_SIZE = 32 * 1024, /* serialized, it fits into a buffer */
};

struct play_object {
    char name[8];
    struct device_buffer buffer; /* of structures and micromaps, too; memory is null if another
                                    object owns it */
    union {
        VkAccelerationStructureKHR structure;
        VkMicromapEXT micromap;
        VkSemaphore semaphore;
        VkEvent event;
        VkQueryPool queries;
        VkImage image;
    };
    uint64_t value; /* of a timeline */
};

struct play {
    struct instance_fixture *fixture;
    const struct hazard_case *program;
    bool is_repaired; /* else broken */
    unsigned at;      /* index of the line that is executed */
    VkDevice device;
    VkuDeviceDispatchTable vk;
    uint32_t memory_type;
    VkQueue queues[PLAY_QUEUES]; /* null: the device has none */
    VkCommandPool pools[2];      /* of the families */
    bool has_indirect, has_host, has_micromaps, has_copy_stage, has_markers;

    struct play_object objects[PLAY_OBJECTS];
    unsigned object_count;
    struct device_buffer scratch, instances; /* parts are used once */
    VkDeviceSize scratch_used, instances_used;

    VkCommandBuffer primary, secondary; /* recording, or null */
    VkCommandBuffer executed;           /* the last secondary */
    VkCommandBuffer ended[PLAY_ITEMS];  /* for the next batch */
    uint32_t ended_count;
    struct batch batches[BATCHES_MAX];
    uint32_t batch_count;
    VkFence fence;
    VkRenderPass render_pass; /* null: none was begun */
    VkFramebuffer framebuffer;
};

/* Ends the program, because a line is wrong. */
_Noreturn void play_fail(const struct play *play, const char *what);
#define PLAY_REQUIRE(play, condition)                                                              \
    do {                                                                                           \
        if (!(condition))                                                                          \
            play_fail(play, #condition);                                                           \
    } while (0)

/* Executes a program. Returns NULL, or why the device cannot: nothing was executed then. */
const char *play_case(struct instance_fixture *fixture, const struct hazard_case *program,
                      bool is_repaired);

/* ---- objects (play_objects.c) */

/* Finds or creates an object. */
struct play_object *play_object(struct play *play, const char *name);
/* Finds an object and the offset behind its name. */
struct play_object *play_place(struct play *play, const char *word, VkDeviceSize *offset);
VkDeviceAddress play_address(struct play *play, const char *word);
/* An address of a buffer, for the device or the host. */
VkDeviceOrHostAddressKHR play_address_in(const struct device_buffer *buffer, VkDeviceSize offset,
                                         bool is_host);
VkDeviceOrHostAddressKHR play_address_for(struct play *play, const char *word, bool is_host);
void play_destroy_objects(struct play *play);
/* alias NAME PLACE: a buffer in the memory of another one.
 * place NAME PLACE: a structure in a buffer. */
void play_alias(struct play *play, char **words);
void play_put(struct play *play, char **words);
/* init PLACE transform | ranges | triangles (of a micromap) | instances NAME...: the host writes,
 * before all submissions */
void play_init(struct play *play, char **words);
/* The references of a host build are handles. */
void play_write_instances(struct play *play, void *to, char **names, bool is_host);

/* ---- commands (each returns false if the line is another command) */

/* The command buffer that commands are recorded to. */
VkCommandBuffer play_commands(struct play *play);

/* play_builds.c */
bool play_build(struct play *play, char **words);
/* play_copies.c */
bool play_copy(struct play *play, char **words);
/* play_sync.c */
bool play_sync(struct play *play, char **words);
VkPipelineStageFlags2 play_stages(struct play *play, const char *names);
/* play_submit.c */
bool play_submit(struct play *play, char **words);
/* Submits what was not submitted, and waits. */
void play_finish(struct play *play);

static inline bool play_is(const char *word, const char *name)
{
    return word && !__builtin_strcmp(word, name);
}

#endif
