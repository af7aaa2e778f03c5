/* SPDX-License-Identifier: Apache-2.0 */
/* Dependencies of programs, as barriers, events and render passes have them. */
#ifndef ASSAY_TESTS_PROGRAMS_SYNC_H
#define ASSAY_TESTS_PROGRAMS_SYNC_H

#include "play.h"

struct dependencies {
    VkDependencyInfo info;
    VkMemoryBarrier2 memory[PLAY_ITEMS];
    VkBufferMemoryBarrier2 buffers[PLAY_ITEMS];
    VkImageMemoryBarrier2 images[PLAY_ITEMS];
    VkMemoryBarrierAccessFlags3KHR flags_3;
    /* In the chain. */
    VkMemoryRangeBarriersInfoKHR ranges;
    VkMemoryRangeBarrierKHR range;
    VkTensorDependencyInfoARM tensors;
    VkTensorMemoryBarrierARM tensor;
    VkBaseInStructure unknown;
    /* As the older commands take them: with one pair of stage masks for all. */
    struct {
        VkPipelineStageFlags src, dst;
        VkMemoryBarrier memory[PLAY_ITEMS];
        VkBufferMemoryBarrier buffers[PLAY_ITEMS];
        VkImageMemoryBarrier images[PLAY_ITEMS];
    } old;
};

/* Reads dependencies with commas between them. */
void play_read_dependencies(struct play *play, char **words, struct dependencies *to);
/* render_passes.c */
void play_render(struct play *play, char **words);

#endif
