/* SPDX-License-Identifier: Apache-2.0 */
/* What the commands of a command buffer access, and how they are synchronized, in recorded order.
 * Part of a journal if setting `hazards` is on. Memory is found when a command is recorded, so
 * objects may be destroyed before the list is replayed. */
#ifndef ASSAY_STATE_COMMANDS_HAZARD_LIST_H
#define ASSAY_STATE_COMMANDS_HAZARD_LIST_H

#include "src/base/chunk_list.h"
#include "src/hazards/hazards.h"
#include "src/state/resources/resources.h"

struct journal;

enum hazard_item_kind {
    HAZARD_COMMAND, /* the accesses that follow are its own */
    HAZARD_ACCESS,
    /* Reads of two vertices, those of the smallest and the largest index of a geometry, which level
     * content reads. bytes: from the vertex of index 0 to the end of the buffer. */
    HAZARD_INDEXED,
    HAZARD_BARRIER,   /* the first of `count` items of this kind that belong to one command */
    HAZARD_SET_EVENT, /* object: the event; barrier.dependency.src */
    HAZARD_RESET_EVENT,
    HAZARD_WAIT_EVENT, /* object: the event; `count` HAZARD_BARRIER items follow */
    HAZARD_EXECUTE,    /* a secondary command buffer, which has a hazard list */
};

/* What a command uses bytes for; names the member in messages. */
enum hazard_role {
    HAZARD_DST, /* dst of a build or copy; dstBuffer */
    HAZARD_SRC, /* src of a build, copy or query; srcBuffer */
    HAZARD_SCRATCH,
    HAZARD_VERTICES,
    HAZARD_INDICES,
    HAZARD_TRANSFORM,
    HAZARD_BOXES,
    HAZARD_INSTANCES,
    HAZARD_INSTANCE_POINTERS,
    HAZARD_OTHER_INPUT, /* of an extension's structure */
    HAZARD_RANGES,      /* indirect */
    HAZARD_MICROMAP,    /* attached to a geometry */
    HAZARD_REFERENCE,   /* a structure that an instance refers to */
    HAZARD_MEMORY,      /* deviceAddress of a serialization or deserialization */
    HAZARD_ROLES,
};

struct hazard_item {
    unsigned char kind;        /* enum hazard_item_kind */
    unsigned char access;      /* HAZARD_ACCESS, HAZARD_INDEXED: enum access_kind */
    unsigned char role;        /* HAZARD_ACCESS, HAZARD_INDEXED: enum hazard_role */
    bool reads_references : 1; /* HAZARD_COMMAND: a build of top-level structures of the device */
    bool is_global : 1, is_acquisition : 1; /* HAZARD_BARRIER */
    /* HAZARD_BARRIER: the number of items, this one included; 0 in all but the first.
     * HAZARD_WAIT_EVENT: the number of HAZARD_BARRIER items that follow; theirs is 0.
     * HAZARD_INDEXED: the stride of vertices. */
    uint32_t count;
    union {
        struct {                      /* HAZARD_ACCESS, HAZARD_INDEXED, HAZARD_COMMAND */
            uint32_t info;            /* index in pInfos; of a command: number of builds */
            uint32_t geometry;        /* of a command: position of the first build */
            uint32_t labels;          /* of a command: see journal_note_labels(); of
                                       * HAZARD_INDEXED: the size of a vertex */
            VkObjectType object_type; /* of an access */
        };
        struct dependency dependency; /* HAZARD_BARRIER, HAZARD_SET_EVENT */
    };
    union {
        const char *command;       /* HAZARD_COMMAND: static text, "vkCmdCopyBuffer" */
        uint64_t object;           /* HAZARD_ACCESS: handle of the structure or buffer, 0: unknown;
                                    * of events: the VkEvent */
        struct journal *secondary; /* HAZARD_EXECUTE: owned */
    };
    struct hazard_bytes bytes; /* HAZARD_ACCESS, HAZARD_INDEXED, HAZARD_BARRIER */
};

/* Whether the item belongs to the command before it. */
static inline bool hazard_item_is_access(const struct hazard_item *item)
{
    return item->kind == HAZARD_ACCESS || item->kind == HAZARD_INDEXED;
}

/* The memory of recent accesses, so that few of them look up its id. */
enum { HAZARD_RECENT_BITS = 4, HAZARD_RECENT_MEMORIES = 1 << HAZARD_RECENT_BITS };

struct hazard_list {
    struct chunk_list items; /* of struct hazard_item */
    bool incomplete;         /* memory ran out: everything before counts as ordered */
    bool has_references;     /* or a secondary has: reads_references, or HAZARD_INDEXED */
    bool executes;           /* has HAZARD_EXECUTE items */
    void (*release_secondary)(struct journal *secondary);
    uint64_t render_pass; /* the handle in the last vkCmdBeginRenderPass */
    /* The last HAZARD_COMMAND, until it is taken back, and the position before it. */
    struct hazard_item *command;
    struct chunk_place before_command;
    uint64_t destroy_count; /* resources_destroy_count() when `recent` was filled */
    struct {
        VkDeviceMemory memory;
        uint64_t id;
    } recent[HAZARD_RECENT_MEMORIES];
};

/* Returns NULL if memory runs out. */
struct hazard_list *hazard_list_create(void (*release_secondary)(struct journal *secondary));
/* Accepts NULL. Releases secondaries. */
void hazard_list_destroy(struct hazard_list *list);
/* Keeps memory for the next recording. */
void hazard_list_clear(struct hazard_list *list);
/* Returns a zeroed item, or NULL if memory runs out; the list is incomplete then. */
struct hazard_item *hazard_list_add(struct hazard_list *list);
/* Returns an item that is not zeroed: the caller sets all of it. */
static inline struct hazard_item *hazard_list_add_unset(struct hazard_list *list)
{
    if (!chunk_list_make_room(&list->items, sizeof(struct hazard_item))) {
        list->incomplete = true;
        return NULL;
    }
    struct hazard_item *item = (void *)list->items.next;
    list->items.next += sizeof(*item);
    return item;
}
/* Adds a HAZARD_COMMAND item. `command` is static text. */
struct hazard_item *hazard_list_add_command(struct hazard_list *list, const char *command);
/* Adds a HAZARD_EXECUTE item. Takes over a reference to the journal. */
void hazard_list_add_secondary(struct hazard_list *list, struct journal *secondary,
                               bool has_references);
/* Items in order, from a zeroed place; NULL at the end. */
const struct hazard_item *hazard_list_next(const struct hazard_list *list,
                                           struct chunk_place *place);
/* A position, and removal of what was added after it. */
struct chunk_place hazard_list_end(const struct hazard_list *list);
void hazard_list_take_back(struct hazard_list *list, struct chunk_place place);

/* Looks up the id of memory, and remembers it unless it is 0. */
uint64_t hazard_list_look_up_memory(struct hazard_list *list, struct resources *resources,
                                    VkDeviceMemory memory);

static inline uint32_t hazard_list_recent_slot(VkDeviceMemory memory)
{
    return (uint64_t)(uintptr_t)memory * 0x9e3779b97f4a7c15u >> (64 - HAZARD_RECENT_BITS);
}

/* Returns the id of memory, or 0 if its bytes cannot be told apart: see
 * resources_find_memory_id(). */
static inline uint64_t hazard_list_memory_id(struct hazard_list *list, struct resources *resources,
                                             VkDeviceMemory memory)
{
    uint32_t slot = hazard_list_recent_slot(memory);
    if (!memory)
        return 0;
    return list->recent[slot].memory == memory &&
                   list->destroy_count == resources_destroy_count(resources)
               ? list->recent[slot].id
               : hazard_list_look_up_memory(list, resources, memory);
}

#endif
