/* SPDX-License-Identifier: Apache-2.0 */
/* What the commands of a command buffer access, and how they are synchronized, in recorded order.
 * Part of a journal if setting `hazards` is on. Memory is found when a command is recorded, so
 * objects may be destroyed before the list is replayed. */
#ifndef ASSAY_STATE_COMMANDS_HAZARD_LIST_H
#define ASSAY_STATE_COMMANDS_HAZARD_LIST_H

#include "src/base/chunk_list.h"
#include "src/hazards/hazards.h"

struct journal;

enum hazard_item_kind {
    HAZARD_COMMAND, /* the accesses that follow are its own */
    HAZARD_ACCESS,
    HAZARD_BARRIER,   /* `count` consecutive items of this kind belong to one command */
    HAZARD_SET_EVENT, /* object: the event; barrier.dependency.src */
    HAZARD_RESET_EVENT,
    HAZARD_WAIT_EVENT, /* object: the event; followed by `count` HAZARD_BARRIER items */
    HAZARD_EXECUTE,    /* a secondary command buffer */
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
    unsigned char kind;    /* enum hazard_item_kind */
    unsigned char access;  /* HAZARD_ACCESS: enum access_kind */
    unsigned char role;    /* HAZARD_ACCESS: enum hazard_role */
    bool reads_references; /* HAZARD_COMMAND: a build of top-level structures of the device */
    uint32_t info;         /* index in pInfos; HAZARD_COMMAND of builds: number of builds */
    uint32_t geometry;     /* HAZARD_COMMAND of builds: position of the first one */
    uint32_t labels;       /* HAZARD_COMMAND: see journal_note_labels() */
    union {
        const char *command; /* HAZARD_COMMAND: static text, "vkCmdCopyBuffer" */
        uint64_t object;     /* HAZARD_ACCESS: handle of the structure or buffer; 0: unknown */
        struct journal *secondary; /* HAZARD_EXECUTE: owned */
    };
    union {
        VkObjectType object_type; /* HAZARD_ACCESS */
        uint32_t count;           /* HAZARD_BARRIER, HAZARD_WAIT_EVENT */
    };
    bool is_global, is_acquisition; /* HAZARD_BARRIER */
    struct hazard_bytes bytes;      /* HAZARD_ACCESS, HAZARD_BARRIER */
    struct dependency dependency;   /* HAZARD_BARRIER, HAZARD_SET_EVENT */
};

struct hazard_list {
    struct chunk_list items; /* of struct hazard_item */
    bool incomplete;         /* memory ran out: everything before counts as ordered */
    bool has_references;     /* or a secondary has: an item with reads_references */
};

struct hazard_list *hazard_list_create(void);
/* Accepts NULL. Releases secondaries. */
void hazard_list_destroy(struct hazard_list *list);
void hazard_list_clear(struct hazard_list *list);
/* Returns a zeroed item, or NULL if memory runs out; the list is incomplete then. */
struct hazard_item *hazard_list_add(struct hazard_list *list);
/* Items in order, from a zeroed place; NULL at the end. */
const struct hazard_item *hazard_list_next(const struct hazard_list *list,
                                           struct chunk_place *place);
/* A position, and removal of what was added after it: a call that a callback has skipped. */
struct chunk_place hazard_list_end(const struct hazard_list *list);
void hazard_list_take_back(struct hazard_list *list, struct chunk_place place);

#endif
