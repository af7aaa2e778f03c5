/* SPDX-License-Identifier: Apache-2.0 */
/* Updates the record of a command buffer for each recorded command, and finds the memory that
 * accesses lie in. */
#include <stdlib.h>
#include <string.h>

#include "src/base/chain.h"
#include "src/base/recording_path.h"
#include "src/state/commands/command_buffers.h"
#include "src/state/commands/hazard_entries.h"

/* Clears the parts that few recordings have. */
__attribute__((cold, noinline)) static void drop_rare_parts(struct command_buffer *command_buffer)
{
    dependents_invalidate(&command_buffer->dependents);
    validity_release(command_buffer->validity);
    command_buffer->validity = NULL;
    structures_release(&command_buffer->known);
    command_buffer->has_known_states = false;
    label_stack_clear(&command_buffer->labels);
}

/* Empties the journal, or, if it is shared, releases it. */
static void renew_journal(struct command_buffer *command_buffer)
{
    if (!command_buffer->journal)
        return;
    if (!journal_is_shared(command_buffer->journal)) {
        journal_clear(command_buffer->journal);
        return;
    }
    journal_release(command_buffer->journal);
    command_buffer->journal = NULL;
}

ON_RECORDING_PATH static void start_over(struct command_buffer *command_buffer,
                                         enum command_buffer_state state)
{
    struct command_buffer_facts *facts = &command_buffer->facts;
    facts->in_render_pass = NO;
    facts->suspended = UNKNOWN;
    facts->in_video_coding = NO;
    facts->state = state;
    facts->build_index = 0;
    command_buffer->suspending = false;
    command_buffer->work_failed = false;
    command_buffer->has_early_bindings = false;
    if (command_buffer->dependents.count || command_buffer->validity ||
        command_buffer->has_known_states || !label_stack_is_clear(&command_buffer->labels))
        drop_rare_parts(command_buffer);
    renew_journal(command_buffer);
}

static bool inherits_conditions(const VkCommandBufferInheritanceInfo *inheritance)
{
    const VkCommandBufferInheritanceConditionalRenderingInfoEXT *conditional =
        chain_find(inheritance->pNext,
                   VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_CONDITIONAL_RENDERING_INFO_EXT);
    return (inheritance->pipelineStatistics &
            VK_QUERY_PIPELINE_STATISTIC_COMPUTE_SHADER_INVOCATIONS_BIT) ||
           (conditional && conditional->conditionalRenderingEnable);
}

void command_buffer_begin(struct command_buffer *command_buffer,
                          const VkCommandBufferBeginInfo *begin_info, uint64_t destroy_count,
                          VkResult result)
{
    if (!command_buffer)
        return;
    start_over(command_buffer,
               result == VK_SUCCESS ? COMMAND_BUFFER_RECORDING : COMMAND_BUFFER_UNKNOWN);
    if (!command_buffer->journal)
        command_buffer->journal = journal_create(command_buffer->handle);
    if (command_buffer->journal)
        command_buffer->journal->destroy_count = destroy_count;
    command_buffer->executes_once = begin_info->flags & VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    command_buffer->executes_at_once =
        begin_info->flags & VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT;
    command_buffer->inherits_conditions = false;
    /* RENDER_PASS_CONTINUE and pInheritanceInfo are ignored for primary command buffers. */
    if (command_buffer->level != VK_COMMAND_BUFFER_LEVEL_SECONDARY)
        return;
    if (begin_info->pInheritanceInfo)
        command_buffer->inherits_conditions = inherits_conditions(begin_info->pInheritanceInfo);
    if (begin_info->flags & VK_COMMAND_BUFFER_USAGE_RENDER_PASS_CONTINUE_BIT)
        command_buffer->facts.in_render_pass = YES;
}

void command_buffer_end(struct command_buffer *command_buffer, VkResult result)
{
    if (command_buffer)
        command_buffer->facts.state =
            result == VK_SUCCESS ? COMMAND_BUFFER_EXECUTABLE : COMMAND_BUFFER_INVALID;
}

void command_buffer_reset(struct command_buffer *command_buffer, bool releases, VkResult result)
{
    if (!command_buffer)
        return;
    start_over(command_buffer,
               result == VK_SUCCESS ? COMMAND_BUFFER_INITIAL : COMMAND_BUFFER_UNKNOWN);
    if (!releases)
        return;
    journal_release(command_buffer->journal);
    command_buffer->journal = NULL;
    free(command_buffer->early_bindings);
    command_buffer->early_bindings = NULL;
}

void command_buffer_begin_rendering(struct command_buffer *command_buffer, VkRenderingFlags flags)
{
    if (!command_buffer)
        return;
    command_buffer->facts.in_render_pass = YES;
    command_buffer->facts.suspended = NO;
    command_buffer->suspending = flags & VK_RENDERING_SUSPENDING_BIT;
}

void command_buffer_end_rendering(struct command_buffer *command_buffer)
{
    if (!command_buffer)
        return;
    command_buffer->facts.in_render_pass = NO;
    command_buffer->facts.suspended = command_buffer->suspending ? YES : NO;
    command_buffer->suspending = false;
}

void command_buffer_set_video_coding(struct command_buffer *command_buffer, bool inside)
{
    if (command_buffer)
        command_buffer->facts.in_video_coding = inside ? YES : NO;
}

/* If memory runs out, invalidating the secondary does not invalidate the primary. */
static void depend_on(struct command_buffer *primary, struct command_buffer *secondary)
{
    if (!primary->validity)
        primary->validity = validity_create();
    if (primary->validity)
        dependents_add(&secondary->dependents, primary->validity);
}

/* A secondary command buffer that begins no rendering does not change whether a rendering is
 * suspended. An unknown secondary may have done anything. */
void command_buffer_execute(struct command_buffer *primary, struct command_buffer *secondary)
{
    if (!primary)
        return;
    if (!secondary) {
        primary->facts.suspended = UNKNOWN;
        if (primary->journal)
            unknown_set(&primary->journal->unknown, UNKNOWN_SECONDARIES);
        return;
    }
    if (secondary->facts.suspended != UNKNOWN)
        primary->facts.suspended = secondary->facts.suspended;
    depend_on(primary, secondary);
    bool is_circle = primary->journal && secondary->journal &&
                     journal_contains(secondary->journal, primary->journal);
    if (primary->journal && secondary->journal && !is_circle)
        journal_add_secondary(primary->journal, secondary->journal);
    if (primary->journal && (is_circle || !secondary->journal))
        unknown_set(&primary->journal->unknown, UNKNOWN_SECONDARIES);
    else if (primary->journal)
        unknown_follow(&primary->journal->unknown, unknown_is_set(&secondary->journal->unknown));
    primary->facts.build_index += secondary->facts.build_index;
}

/* ---- the memory that accesses lie in */

enum { RECENT_BITS = 4, RECENT_MEMORIES = 1 << RECENT_BITS };

/* The memory of recent accesses. */
struct recent_memory {
    uint64_t destroy_count; /* resources_destroy_count() when it was looked up */
    struct {
        VkDeviceMemory memory;
        uint64_t id;
    } items[RECENT_MEMORIES];
};

static uint32_t slot_of(VkDeviceMemory memory)
{
    return handle_number(memory) * 0x9e3779b97f4a7c15u >> (64 - RECENT_BITS);
}

static uint64_t look_up_memory(struct journal *journal, struct resources *resources,
                               VkDeviceMemory memory)
{
    uint64_t destroy_count = resources_destroy_count(resources);
    uint64_t id = resources_find_memory_id(resources, memory);
    struct recent_memory *recent = journal->recent_memory;
    if (!recent)
        journal->recent_memory = recent = calloc(1, sizeof(*recent));
    if (!recent)
        return id;
    if (recent->destroy_count != destroy_count)
        memset(recent->items, 0, sizeof(recent->items));
    recent->destroy_count = destroy_count;
    if (id) {
        recent->items[slot_of(memory)].memory = memory;
        recent->items[slot_of(memory)].id = id;
    }
    return id;
}

uint64_t hazard_memory_id(struct journal *journal, struct resources *resources,
                          VkDeviceMemory memory)
{
    const struct recent_memory *recent = journal->recent_memory;
    if (!memory)
        return 0;
    return recent && recent->items[slot_of(memory)].memory == memory &&
                   recent->destroy_count == resources_destroy_count(resources)
               ? recent->items[slot_of(memory)].id
               : look_up_memory(journal, resources, memory);
}
