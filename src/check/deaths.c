/* SPDX-License-Identifier: Apache-2.0 */
/* What recorded builds use, asked for again at submission: structures and buffers may have been
 * destroyed, and memory freed, in between. An address that another buffer has taken over meanwhile
 * is as good as before. */
#include "check/input.h"
#include "check/replay.h"

static bool is_wanted(const struct replay *replay, const struct journal_entry *entry,
                      enum rule rule)
{
    return replay->active[entry->command][rule];
}

static void report(struct replay *replay, const struct journal *journal, uint32_t position,
                   enum rule rule, const struct location *location, const struct finding *finding)
{
    replay->locate(replay->user, journal, position, location->build);
    replay->found(replay->user, rule, location, finding);
}

struct structure_rules {
    const char *field;
    enum rule alive, backed;
};

static void check_structure(struct replay *replay, const struct journal *journal,
                            const struct journal_entry *entry, uint64_t handle, uint64_t id,
                            bool was_backed, const struct structure_rules *rules)
{
    struct accel_facts facts;
    unsigned token = resources_begin_reading(replay->resources);
    resources_find_accel(replay->resources, (VkAccelerationStructureKHR)(uintptr_t)handle, &facts);
    resources_end_reading(replay->resources, token);

    bool died = facts.alive == NO || (facts.alive == YES && facts.id != id);
    bool lost_memory = facts.alive == YES && was_backed && facts.backed == NO;
    enum rule rule = died ? rules->alive : rules->backed;
    if ((!died && !lost_memory) || !is_wanted(replay, entry, rule))
        return;
    struct location location = {.command = (enum build_command)entry->command,
                                .subject = SUBJECT_BUILD,
                                .build = entry->info};
    struct finding finding;
    violated(&finding, rules->field,
             died ? "{} was destroyed after the build was recorded"
                  : "{} lost its memory, or its buffer, after the build was recorded",
             object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, handle));
    report(replay, journal, entry->built.position, rule, &location, &finding);
}

static void check_entry(struct replay *replay, const struct journal *journal,
                        const struct journal_entry *entry)
{
    static const struct structure_rules dst = {
        "dstAccelerationStructure", RULE_dst_is_a_valid_handle, RULE_dst_is_backed_by_memory};
    static const struct structure_rules src = {"srcAccelerationStructure",
                                               RULE_src_is_a_valid_handle,
                                               RULE_update_src_is_backed_by_memory};
    if (entry->kind != JOURNAL_BUILD && entry->kind != JOURNAL_UPDATE)
        return;
    check_structure(replay, journal, entry, entry->dst, entry->dst_id, entry->dst_backed, &dst);
    if (entry->kind == JOURNAL_UPDATE && entry->src_id && entry->src_id != entry->dst_id)
        check_structure(replay, journal, entry, entry->src, entry->src_id, entry->src_backed, &src);
}

/* Inputs. */

static enum rule rule_of_input(const struct journal_input *input, enum address_status status)
{
    if (input->role == INPUT_SCRATCH)
        return input->is_update ? RULE_update_scratch_is_in_one_buffer
                                : RULE_build_scratch_is_in_one_buffer;
    if (status == ADDRESS_UNBOUND)
        return RULE_input_buffer_is_bound;
    return input->role == INPUT_TRANSFORM ? RULE_transform_address_is_valid
                                          : RULE_input_address_is_in_a_buffer;
}

static void check_input(struct replay *replay, const struct journal *journal,
                        const struct journal_input *input)
{
    struct address_facts facts;
    unsigned token = resources_begin_reading(replay->resources);
    resources_find_address(replay->resources, input->address, &facts);
    resources_end_reading(replay->resources, token);
    if (facts.status != ADDRESS_NOWHERE && facts.status != ADDRESS_UNBOUND)
        return;
    enum rule rule = rule_of_input(input, facts.status);
    if (!replay->active[input->command][rule])
        return;
    bool is_scratch = input->role == INPUT_SCRATCH;
    struct location location = {.command = (enum build_command)input->command,
                                .subject = is_scratch ? SUBJECT_BUILD : SUBJECT_GEOMETRY,
                                .build = input->info,
                                .geometry = input->geometry,
                                .geometry_by_pointer = input->geometry_by_pointer};
    struct finding finding;
    violated(&finding, input_field((enum input_role)input->role),
             facts.status == ADDRESS_NOWHERE
                 ? "{} was in a buffer that was destroyed after the build was recorded"
                 : "{} is in a buffer whose memory was freed after the build was recorded",
             hex(input->address));
    report(replay, journal, input->position, rule, &location, &finding);
}

void replay_deaths(struct replay *replay, const struct journal *journal)
{
    bool any_died = journal->deaths != resources_deaths(replay->resources);
    struct journal_cursor cursor = journal_start(journal);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));) {
        if (entry->kind == JOURNAL_EXECUTE)
            replay_deaths(replay, entry->secondary);
        else if (any_died)
            check_entry(replay, journal, entry);
    }
    for (const struct journal_chunk *chunk = journal->inputs.first; any_died && chunk;
         chunk = chunk->next)
        for (uint32_t i = 0; i < chunk->count; i++)
            check_input(replay, journal, &((const struct journal_input_chunk *)chunk)->items[i]);
}
