/* SPDX-License-Identifier: Apache-2.0 */
/* The debug labels that are open in one command buffer or queue. No lock: the application
 * synchronizes command buffers and queues. A zero-initialized stack is empty. */
#ifndef ASSAY_STATE_COMMANDS_LABEL_STACK_H
#define ASSAY_STATE_COMMANDS_LABEL_STACK_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct label_stack {
    VkDebugUtilsLabelEXT *labels; /* innermost last; pLabelName owned, never NULL */
    uint32_t count, capacity;
    uint32_t lost;    /* open labels above the others for which memory ran out */
    uint32_t changes; /* generation counter: bumped by every change, so copies can be compared */
    bool inserted;    /* the innermost label was inserted, and ends at the next label command */
};

/* `label` may be NULL, and may have no name. */
void label_stack_push(struct label_stack *stack, const VkDebugUtilsLabelEXT *label);
void label_stack_insert(struct label_stack *stack, const VkDebugUtilsLabelEXT *label);
void label_stack_pop(struct label_stack *stack);

/* Returns a copy that the caller owns. If memory runs out, inner labels are missing. */
struct label_stack label_stack_copy(const struct label_stack *stack);

/* Empties the stack and frees its memory. */
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
