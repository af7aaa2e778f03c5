/* SPDX-License-Identifier: Apache-2.0 */
/* The debug labels open in one command buffer (or queue). Not locked: the application synchronizes
 * command buffers and queues. Zero-initialized is empty. */
#ifndef ASSAY_STATE_COMMANDS_LABEL_STACK_H
#define ASSAY_STATE_COMMANDS_LABEL_STACK_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct label_stack {
    VkDebugUtilsLabelEXT *labels; /* innermost last; pLabelName owned, never NULL */
    uint32_t count, capacity;
    uint32_t lost;    /* opened above the others while there was no memory for them */
    uint32_t changes; /* counts what changed it, so that who copied it knows when to do so again */
    bool inserted;    /* the innermost is a single label, which stands until the next one */
};

/* `label` may be NULL, and may have no name. */
void label_stack_push(struct label_stack *stack, const VkDebugUtilsLabelEXT *label);
void label_stack_insert(struct label_stack *stack, const VkDebugUtilsLabelEXT *label);
void label_stack_pop(struct label_stack *stack);

/* A copy of its own; empty without memory. */
struct label_stack label_stack_copy(const struct label_stack *stack);

/* Empties it and frees its memory. */
void label_stack_drop_all(struct label_stack *stack);
static inline bool label_stack_is_clear(const struct label_stack *stack)
{
    return !stack->labels && !stack->lost;
}
static inline void label_stack_clear(struct label_stack *stack)
{
    if (!label_stack_is_clear(stack))
        label_stack_drop_all(stack);
}

#endif
