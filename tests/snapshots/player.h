/* SPDX-License-Identifier: Apache-2.0 */
/* A device with what programs of memory_test.c work on, all of which the host can read. */
#ifndef ASSAY_TESTS_SNAPSHOTS_PLAYER_H
#define ASSAY_TESTS_SNAPSHOTS_PLAYER_H

#include "tests/snapshots/fixture.h"

enum {
    BUFFERS = 3,
    VERTICES = 64, /* in each buffer: of 3 floats, then */
    INDICES = 96,  /* each below VERTICES, */
    BOXES = 16,
    INDICES_AT = VERTICES * 12,
    BOXES_AT = INDICES_AT + INDICES * 4,
    SIZE = BOXES_AT + BOXES * sizeof(VkAabbPositionsKHR),
    BLASES = 4,
    INSTANCES = 6,
    POINTERS_AT = INSTANCES * sizeof(VkAccelerationStructureInstanceKHR),
    STRUCTURE_SIZE = 1 << 16,
    SCRATCH_SIZE = 1 << 18,
};

/* As fill.comp has them, behind what other constants there are. */
struct constants {
    uint32_t other[4];
    uint64_t target;
    uint32_t value;
};

struct player {
    struct fixture fixture;
    struct device_buffer inputs[BUFFERS], instances, structures, scratch;
    struct device_buffer conditions; /* two words: one that is false, and one that is true */
    bool is_conditional;             /* the command buffer that is recorded */
    unsigned char instances_written[POINTERS_AT + INSTANCES * 8]; /* by the host, alone */
    VkAccelerationStructureKHR blases[BLASES], tlas;
    VkPipelineLayout layouts[2]; /* with the same push constants: compatible */
    VkPipeline fill;
    VkCommandBuffer commands;
};

void player_open(struct player *player, const struct platform *platform, bool has_layer);
void player_close(struct player *player);

#endif
