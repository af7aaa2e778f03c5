/* SPDX-License-Identifier: Apache-2.0 */
/* Dependencies of programs, as barriers, events and render passes have them. */
#ifndef ASSAY_TESTS_PLAYER_COMMANDS_SYNC_H
#define ASSAY_TESTS_PLAYER_COMMANDS_SYNC_H

#include "tests/player/play.h"

enum { DEPENDENCIES_MAX = 256 };

struct dependencies {
    VkDependencyInfo info;
    VkMemoryBarrier2 memory[DEPENDENCIES_MAX];
    VkBufferMemoryBarrier2 buffers[DEPENDENCIES_MAX];
    VkImageMemoryBarrier2 images[DEPENDENCIES_MAX];
    VkMemoryBarrierAccessFlags3KHR flags_3;
    /* In the chain. */
    VkMemoryRangeBarriersInfoKHR ranges;
    VkMemoryRangeBarrierKHR range;
    VkTensorDependencyInfoARM tensors;
    VkTensorMemoryBarrierARM tensor, not_of_list;
    VkBaseInStructure unknown;
    /* The dependencies of a render pass. */
    VkSubpassDependency of_subpasses[DEPENDENCIES_MAX];
    VkSubpassDependency2 of_subpasses_2[DEPENDENCIES_MAX];
    /* As the older commands take them: with one pair of stage masks for all. */
    struct {
        VkPipelineStageFlags src, dst;
        VkMemoryBarrier memory[DEPENDENCIES_MAX];
        VkBufferMemoryBarrier buffers[DEPENDENCIES_MAX];
        VkImageMemoryBarrier images[DEPENDENCIES_MAX];
    } old;
};

/* Reads dependencies with commas between them, up to `and`, to memory that lasts for the line.
 * Returns those of the first command; if there is an `and`, others follow. */
struct dependencies *play_read_dependencies(struct play *play, char **words, uint32_t *count);
/* Stages and accesses with : between them. */
VkAccessFlags2 play_accesses(struct play *play, const char *word);
/* below.c */
void play_expect_below(struct play *play, char **words);
/* render_passes.c */
void play_render(struct play *play, char **words);

#endif
