/* SPDX-License-Identifier: Apache-2.0 */
/* The part of destroyed.c that is about commands which build no structures: copies, queries,
 * serializations, deserializations and builds of micromaps. */
#include "src/check/replay/entry_rules.h"
#include "src/check/replay/object_states.h"
#include "src/check/replay/replay.h"
#include "src/rules/shared.h"
#include "src/state/commands/query_pools.h"

/* The rules about src and dst of a command; RULE_COUNT: it has none, or no rule. dst of a query is
 * its VkQueryPool. */
struct command_rules {
    enum rule src_alive, src_backed, dst_alive, dst_backed;
};

static const struct command_rules rules_of_commands[COMMAND_COUNT] = {
#define NO_USES USES(COUNT, COUNT, COUNT, COUNT)
#define USES(src, src_backed, dst, dst_backed)                                                     \
    {                                                                                              \
        RULE_##src, RULE_##src_backed, RULE_##dst, RULE_##dst_backed                               \
    }
#define COMMAND(name)
#define JOURNALED(name, type, uses) [COMMAND_##name] = uses,
#include "vuid-tables/commands.def"
};

/* An object that a command uses. */
struct command_use {
    const char *field;
    uint64_t handle, id;
    bool was_backed;
    enum rule alive, backed;
};

static void check_use(struct replay *replay, const struct journal *journal,
                      const struct journal_entry *entry, const struct command_use *use)
{
    const VkObjectType type = journal_entry_type(entry);
    if (!use->id || use->alive == RULE_COUNT)
        return;
    const struct object_state state =
        object_state_find(replay->resources, type, use->handle, use->id, use->was_backed);
    const bool is_destroyed = state.is_destroyed;
    struct entry_rules rules;
    struct finding finding;
    if (!is_destroyed && !state.has_no_memory)
        return;
    entry_rules_begin_read(&rules, replay, journal, entry);
    finding_says(&finding, use->field,
                 is_destroyed ? "{} was destroyed after the command was recorded"
                 : state.buffer_is_destroyed
                     ? "{} lost its memory after the command was recorded: its VkBuffer was "
                       "destroyed"
                     : "{} lost its memory after the command was recorded: its VkDeviceMemory was "
                       "freed",
                 is_destroyed ? destroyed_object(type, use->handle, use->id)
                              : object(type, use->handle));
    entry_rules_report(&rules, is_destroyed ? use->alive : use->backed, &finding);
}

/* The memory at a device address, which was in a buffer when the command was recorded. */
static void check_memory(struct replay *replay, const struct journal *journal,
                         const struct journal_entry *entry, const char *field,
                         VkDeviceAddress address)
{
    struct address_facts facts;
    struct entry_rules rules;
    struct finding finding;
    resources_look_up_address(replay->resources, address, &facts);
    if (facts.status != ADDRESS_NOWHERE && facts.status != ADDRESS_UNBOUND)
        return;
    entry_rules_begin_read(&rules, replay, journal, entry);
    if (facts.status == ADDRESS_NOWHERE)
        finding_says(&finding, field,
                     "{} was in a buffer that was destroyed after the command was recorded",
                     address_of_missing(VK_OBJECT_TYPE_BUFFER, address));
    else
        finding_says(&finding, field,
                     "{} is in {}, whose memory was freed after the command was recorded",
                     hex(address), object(VK_OBJECT_TYPE_BUFFER, handle_number(facts.buffer)));
    entry_rules_report(&rules,
                       facts.status == ADDRESS_NOWHERE ? RULE_copy_memory_address_is_valid
                                                       : RULE_copy_memory_is_backed,
                       &finding);
}

/* One message for all queries of a command. */
static void check_query_pool(struct replay *replay, const struct journal *journal,
                             const struct journal_entry *entry, enum rule alive)
{
    struct entry_rules rules;
    struct finding finding;
    if (entry->info || !entry->dst_id ||
        query_pools_has(replay->query_pools, (VkQueryPool)(uintptr_t)entry->dst, entry->dst_id) !=
            NO)
        return;
    entry_rules_begin_query(&rules, replay, journal, entry);
    finding_says(&finding, "queryPool", "{} was destroyed after the command was recorded",
                 destroyed_object(VK_OBJECT_TYPE_QUERY_POOL, entry->dst,
                                  entry->dst_id - entry->read.number));
    entry_rules_report(&rules, alive, &finding);
}

void replay_destroyed_command(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct replay *replay = walk->user;
    const struct journal *journal = walk->journal;
    const struct command_rules rules = rules_of_commands[entry->command];
    const bool is_query = journal_entry_is_query(entry);
    if (journal_entry_use(entry) & READS_SRC)
        check_use(replay, journal, entry,
                  &(struct command_use){is_query ? "" : "src", entry->src, entry->src_id,
                                        entry->src_backing, rules.src_alive, rules.src_backed});
    if (journal_entry_writes(entry))
        check_use(replay, journal, entry,
                  &(struct command_use){
                      entry->command == COMMAND_CmdBuildMicromapsEXT ? "dstMicromap" : "dst",
                      entry->dst, entry->dst_id, entry->dst_backing, rules.dst_alive,
                      rules.dst_backed});
    if (is_query)
        check_query_pool(replay, journal, entry, rules.dst_alive);
    if (journal_is_read(entry) && !is_query && entry->read.dst_size)
        check_memory(replay, journal, entry, "dst.deviceAddress", entry->dst);
    if (journal_is_fill(entry) && journal_fill_reads_memory(entry) && entry->src_id)
        check_memory(replay, journal, entry, "src.deviceAddress", entry->src_id);
}
