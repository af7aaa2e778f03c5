/* SPDX-License-Identifier: Apache-2.0 */
/* Checks at submission whether the objects that recorded commands use are still alive: structures
 * and buffers may have been destroyed, and memory freed, since the command was recorded. An address
 * stays valid if another buffer has it now. */
#include "src/check/replay/entry_rules.h"
#include "src/check/replay/object_states.h"
#include "src/check/replay/replay.h"
#include "src/rules/shared.h"
#include "src/view/cluster_view.h"

/* ---- structures */

/* RULE_COUNT: none. An update in place violates the rules of the dst and of the src: the message
 * about the dst names the id about the src. */
struct structure_rules {
    const char *field;
    bool is_src;
    enum rule alive, backed, alive_of_other, backed_of_other;
};

static bool is_in_place(const struct journal_entry *entry)
{
    return journal_is_update(entry) && entry->src_id && entry->src_id == entry->dst_id;
}

static void relate(struct finding *finding, const struct structure_rules *rules, enum rule other)
{
    if (other == RULE_COUNT)
        return;
    if (rules->is_src)
        is_reported_with(finding, other);
    else
        also_violates(finding, other);
}

static void check_structure(struct replay *replay, const struct journal *journal,
                            const struct journal_entry *entry, uint64_t handle, uint64_t id,
                            bool was_backed, const struct structure_rules *own)
{
    bool is_nv = entry->command == COMMAND_NV;
    const VkObjectType type = is_nv ? VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV
                                    : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    const struct object_state state =
        object_state_find(replay->resources, type, handle, id, was_backed);
    const bool is_destroyed = state.is_destroyed;
    if (!is_destroyed && (!state.has_no_memory || own->backed == RULE_COUNT))
        return;
    struct entry_rules rules;
    struct finding finding;
    entry_rules_begin_entry(&rules, replay, journal, entry);
    finding_says(&finding, own->field,
                 is_destroyed ? "{} was destroyed after the build was recorded"
                 : state.buffer_is_destroyed
                     ? "{} lost its memory after the build was recorded: its VkBuffer was destroyed"
                     : "{} lost its memory after the build was recorded: its VkDeviceMemory was "
                       "freed",
                 is_destroyed ? destroyed_object(type, handle, id) : object(type, handle));
    if (is_in_place(entry))
        relate(&finding, own, is_destroyed ? own->alive_of_other : own->backed_of_other);
    entry_rules_report(&rules, is_destroyed ? own->alive : own->backed, &finding);
}

static const struct structure_rules rules_of_dst = {
    .field = "dstAccelerationStructure",
    .alive = RULE_dst_is_a_valid_handle,
    .backed = RULE_dst_is_backed_by_memory,
    .alive_of_other = RULE_src_is_a_valid_handle,
    .backed_of_other = RULE_update_src_is_backed_by_memory,
};
static const struct structure_rules rules_of_src = {
    .field = "srcAccelerationStructure",
    .is_src = true,
    .alive = RULE_src_is_a_valid_handle,
    .backed = RULE_update_src_is_backed_by_memory,
    .alive_of_other = RULE_dst_is_a_valid_handle,
    .backed_of_other = RULE_dst_is_backed_by_memory,
};
static const struct structure_rules rules_of_nv_dst = {
    .field = "dst",
    .alive = RULE_nv_dst_is_a_valid_handle,
    .backed = RULE_nv_dst_is_bound_to_memory,
    .alive_of_other = RULE_nv_src_is_a_valid_handle,
    .backed_of_other = RULE_COUNT,
};
/* No rule requires that the source is bound, so its memory is not checked. */
static const struct structure_rules rules_of_nv_src = {
    .field = "src",
    .is_src = true,
    .alive = RULE_nv_src_is_a_valid_handle,
    .backed = RULE_COUNT,
    .alive_of_other = RULE_nv_dst_is_a_valid_handle,
    .backed_of_other = RULE_COUNT,
};

static void check_build(struct journal_walk *walk, const struct journal_entry *entry)
{
    bool is_nv = entry->command == COMMAND_NV;
    check_structure(walk->user, walk->journal, entry, entry->dst, entry->dst_id, entry->dst_backing,
                    is_nv ? &rules_of_nv_dst : &rules_of_dst);
    if (journal_is_update(entry) && entry->src_id)
        check_structure(walk->user, walk->journal, entry, entry->src, entry->src_id,
                        entry->src_backing, is_nv ? &rules_of_nv_src : &rules_of_src);
}

/* ---- inputs */

static bool is_of_partitions(const struct journal_input *input)
{
    return addressed_command_is_partitioned((enum build_command)input->command);
}

static enum rule rule_of_input(const struct journal_input *input, enum address_status status)
{
    if (input->role == INPUT_ROLES)
        return addressed_buffer_rule((enum build_command)input->command,
                                     (enum addressed_member)input->info);
    if (status == ADDRESS_UNBOUND)
        return RULE_input_buffer_is_bound;
    if (input->role == INPUT_SCRATCH)
        return RULE_build_scratch_is_in_one_buffer;
    if (input->role == INPUT_UPDATE_SCRATCH)
        return RULE_update_scratch_is_in_one_buffer;
    if (input->role == INPUT_INDIRECT)
        return RULE_indirect_ranges_are_in_one_buffer;
    return input->role == INPUT_MATRIX ? RULE_transform_address_is_valid
                                       : RULE_input_address_is_in_a_buffer;
}

static enum subject subject_of_input(enum input_role role)
{
    if (role == INPUT_INDIRECT)
        return SUBJECT_ELEMENT;
    return role == INPUT_SCRATCH || role == INPUT_UPDATE_SCRATCH ? SUBJECT_BUILD : SUBJECT_GEOMETRY;
}

static struct location location_of_input(const struct journal_input *input)
{
    if (input->role == INPUT_ROLES)
        return (struct location){.command = (enum build_command)input->command,
                                 .subject = SUBJECT_ARGUMENT,
                                 .argument = addressed_argument_name(is_of_partitions(input))};
    return (struct location){.command = (enum build_command)input->command,
                             .subject = subject_of_input((enum input_role)input->role),
                             .build = input->info,
                             .geometry = input->geometry,
                             .geometry_by_pointer = input->geometry_by_pointer};
}

static void check_input(struct replay *replay, const struct journal *journal,
                        const struct journal_input *input)
{
    const struct location location = location_of_input(input);
    const char *field =
        input->role == INPUT_ROLES
            ? addressed_member_name((enum addressed_member)input->info, is_of_partitions(input))
            : input_field((enum input_role)input->role);
    struct address_facts facts;
    resources_look_up_address(replay->resources, input->address, &facts);
    const enum rule rule = rule_of_input(input, facts.status);
    if ((facts.status != ADDRESS_NOWHERE && facts.status != ADDRESS_UNBOUND) || rule == RULE_COUNT)
        return;
    struct entry_rules rules;
    struct finding finding;
    entry_rules_begin(&rules, replay, journal, input->position, &location);
    if (facts.status == ADDRESS_NOWHERE)
        finding_says(&finding, field,
                     "{} was in a buffer that was destroyed after the build was recorded",
                     address_of_missing(VK_OBJECT_TYPE_BUFFER, input->address));
    else
        finding_says(
            &finding, field, "{} is in {}, whose memory was freed after the build was recorded",
            hex(input->address), object(VK_OBJECT_TYPE_BUFFER, handle_number(facts.buffer)));
    entry_rules_report(&rules, rule, &finding);
}

/* The inputs of the NV command, which are handles. */
static const enum rule nv_rules[] = {
    [INPUT_VERTEX] = RULE_nv_vertex_data_is_a_valid_buffer,
    [INPUT_INDEX] = RULE_nv_index_data_is_null_or_a_valid_buffer,
    [INPUT_MATRIX] = RULE_nv_transform_data_is_a_valid_buffer,
    [INPUT_AABBS] = RULE_nv_aabb_data_is_a_valid_buffer,
    [INPUT_INSTANCES] = RULE_nv_instance_data_is_a_valid_buffer,
    [INPUT_SCRATCH] = RULE_nv_scratch_is_a_valid_buffer,
};

static void check_nv_input(struct replay *replay, const struct journal *journal,
                           const struct journal_input *input)
{
    struct buffer_facts facts;
    resources_look_up_buffer(replay->resources, input->buffer, &facts);
    bool is_destroyed = facts.alive == NO || (facts.alive == YES && facts.id != input->buffer_id);
    if (!is_destroyed)
        return;
    const enum input_role role = (enum input_role)input->role;
    const bool is_parameter = role == INPUT_INSTANCES || role == INPUT_SCRATCH;
    struct location location = {.command = COMMAND_NV,
                                .subject = is_parameter ? SUBJECT_PARAMETER : SUBJECT_GEOMETRY,
                                .geometry = input->geometry};
    struct entry_rules rules;
    struct finding finding;
    entry_rules_begin(&rules, replay, journal, input->position, &location);
    finding_says(
        &finding, input_name(role, INPUT_OF_NV), "{} was destroyed after the build was recorded",
        destroyed_object(VK_OBJECT_TYPE_BUFFER, handle_number(input->buffer), input->buffer_id));
    entry_rules_report(&rules, nv_rules[role], &finding);
}

static void check_any_input(struct journal_walk *walk, const struct journal_input *input)
{
    if (input->command == COMMAND_NV)
        check_nv_input(walk->user, walk->journal, input);
    else
        check_input(walk->user, walk->journal, input);
}

/* ---- structures without a handle: they are built in the memory that their address leads to now */

static void renew_place(struct journal_walk *walk, const struct journal_entry *entry)
{
    const struct replay *replay = walk->user;
    if (entry->placed.address)
        places_add(replay->places, &entry->placed);
}

/* ---- the journal */

static void check_use(struct journal_walk *walk, const struct journal_entry *entry)
{
    if (entry->command < BUILD_COMMAND_COUNT && journal_entry_writes(entry))
        check_build(walk, entry);
    else if (journal_is_use_micromap(entry))
        replay_destroyed_micromap(walk, entry);
    else
        replay_destroyed_command(walk, entry);
}

static void check_secondary(struct journal_walk *walk, const struct journal_entry *entry)
{
    replay_destroyed(walk->user, entry->secondary);
}

/* If no object was destroyed since the recording began, only secondary command buffers matter. */
void replay_destroyed(struct replay *replay, const struct journal *journal)
{
    static const struct journal_events uses = {ON_USES(check_use), .execute = check_secondary};
    static const struct journal_events inputs = {.use_buffer = check_any_input,
                                                 .place = renew_place};
    if (journal->destroy_count != resources_destroy_count(replay->resources)) {
        journal_walk(journal, &uses, replay);
        journal_walk(journal, &inputs, replay);
        return;
    }
    struct journal_walk walk = journal_start_secondaries(journal);
    for (const struct journal *secondary; (secondary = journal_next_secondary(&walk));)
        replay_destroyed(replay, secondary);
}
