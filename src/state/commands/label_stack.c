/* SPDX-License-Identifier: Apache-2.0 */
/* The stack of labels. */
#include "src/state/commands/label_stack.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"

static char no_name[] = "";

static void drop_innermost(struct label_stack *stack)
{
    char *name = (char *)stack->labels[--stack->count].pLabelName;
    if (name != no_name)
        free(name);
}

/* Call at the start of each change. */
static void drop_inserted(struct label_stack *stack)
{
    stack->changes++;
    if (stack->inserted)
        drop_innermost(stack);
    stack->inserted = false;
}

static bool has_room(struct label_stack *stack)
{
    return ARRAY_HAS_ROOM(stack->labels, stack->count, stack->capacity);
}

static void append(struct label_stack *stack, const VkDebugUtilsLabelEXT *label)
{
    char *name = label && label->pLabelName ? strdup(label->pLabelName) : NULL;
    VkDebugUtilsLabelEXT *copy = &stack->labels[stack->count++];
    *copy = (VkDebugUtilsLabelEXT){
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT,
        .pLabelName = name ? name : no_name,
    };
    if (label)
        memcpy(copy->color, label->color, sizeof(copy->color));
}

void label_stack_push(struct label_stack *stack, const VkDebugUtilsLabelEXT *label)
{
    drop_inserted(stack);
    /* All labels above a lost label are lost, too, so that each pop matches its push. */
    if (stack->lost || !has_room(stack)) {
        stack->lost++;
        return;
    }
    append(stack, label);
}

void label_stack_insert(struct label_stack *stack, const VkDebugUtilsLabelEXT *label)
{
    drop_inserted(stack);
    if (stack->lost || !has_room(stack))
        return;
    append(stack, label);
    stack->inserted = true;
}

void label_stack_pop(struct label_stack *stack)
{
    drop_inserted(stack);
    if (stack->lost)
        stack->lost--;
    else if (stack->count)
        drop_innermost(stack);
}

void label_stack_drop_all(struct label_stack *stack)
{
    while (stack->count)
        drop_innermost(stack);
    free(stack->labels);
    *stack = (struct label_stack){.changes = stack->changes + 1};
}

struct label_stack label_stack_copy(const struct label_stack *stack)
{
    struct label_stack copy = {0};
    for (uint32_t i = 0; i < stack->count && has_room(&copy); i++)
        append(&copy, &stack->labels[i]);
    return copy;
}
