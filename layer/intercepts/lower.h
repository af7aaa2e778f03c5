/* SPDX-License-Identifier: Apache-2.0 */
/* Writes calls of the first version of a command in the structures of the newer version, which is
 * all that observers get (docs/code/commands.md). The generated entries do so by the names of
 * parameters and members; here is what names do not say. What no observer reads is left out.
 *
 * A function with a block begins it, for the structures that the function returns; the caller ends
 * it. The function returns NULL without memory, and never for arrays that are empty. */
#ifndef ASSAY_LAYER_INTERCEPTS_LOWER_H
#define ASSAY_LAYER_INTERCEPTS_LOWER_H

#include <vulkan/vulkan_core.h>

#include "src/base/block.h"

/* So many equal dependencies, one for each event that is waited for. All memory barriers become
 * one, because they share one access scope on each side: the specification can be read so. Image
 * barriers are left out: the stages of the memory barrier are theirs, too. */
const VkDependencyInfo *lower_dependencies(struct block *block, uint32_t count,
                                           VkPipelineStageFlags src, VkPipelineStageFlags dst,
                                           uint32_t memory_count, const VkMemoryBarrier *memory,
                                           uint32_t buffer_count,
                                           const VkBufferMemoryBarrier *buffers);

const VkSubmitInfo2 *lower_submits(struct block *block, uint32_t count,
                                   const VkSubmitInfo *submits);

/* The value of a wait or a signal of a VkSubmitInfo or VkBindSparseInfo with this chain. A missing
 * value is 0: it belongs to a binary semaphore, and is ignored. */
enum semaphore_use { WAIT_OF_BATCH, SIGNAL_OF_BATCH };
uint64_t lower_value(const void *chain, enum semaphore_use use, uint32_t index);

#endif
