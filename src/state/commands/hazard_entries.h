/* SPDX-License-Identifier: Apache-2.0 */
/* What the commands of a command buffer access, and how they are synchronized: entries of a journal
 * if setting `hazards` is on. Memory is found when a command is recorded, so objects may be
 * destroyed before the journal is replayed. */
#ifndef ASSAY_STATE_COMMANDS_HAZARD_ENTRIES_H
#define ASSAY_STATE_COMMANDS_HAZARD_ENTRIES_H

#include "src/hazards/hazards.h"
#include "src/state/commands/journal.h"
#include "src/state/resources/resources.h"

/* What a command uses bytes for; names the member in messages. */
enum hazard_role {
    HAZARD_DST,     /* dst of a build or copy; dstBuffer */
    HAZARD_TOP_DST, /* of a build of a top-level structure, or of a copy to one */
    HAZARD_SRC,     /* src of a build, copy or query; srcBuffer */
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
    HAZARD_SHADER,      /* a shader of a dispatch, trace or draw; bytes that it may write */
    HAZARD_TRACED,      /* a structure that such a shader may trace, in front of the trace */
    HAZARD_USED,        /* a structure of a descriptor that such a shader uses statically */
    /* Builds of structures at addresses have these. */
    HAZARD_DST_ADDRESSES, /* dstAddressesArray */
    HAZARD_DST_SIZES,
    HAZARD_INFOS,
    HAZARD_COUNT,
    HAZARD_ROLES,
};

struct hazard_entry {
    unsigned char kind;   /* enum journal_kind */
    unsigned char size;   /* as in struct journal_entry */
    unsigned char access; /* HAZARD_ACCESS, HAZARD_INDEXED: enum access_kind */
    union {
        unsigned char role; /* HAZARD_ACCESS, HAZARD_INDEXED: enum hazard_role */
        struct {
            /* HAZARD_COMMAND: it builds top-level structures of the device; it is a build at
             * addresses, which accesses what level content finds. */
            bool reads_references : 1, has_accesses : 1;
            bool is_global : 1, is_acquisition : 1; /* HAZARD_BARRIER */
        };
    };
    union {
        /* HAZARD_BARRIER: the number of entries, this one included; 0 in all but the first.
         * HAZARD_WAIT_EVENT: the number of HAZARD_BARRIER entries that follow; theirs is 0. */
        uint32_t barrier_count;
        uint32_t index_size;    /* HAZARD_ACCESS: in bytes; 0: it does not read indices */
        uint32_t vertex_stride; /* HAZARD_INDEXED */
    };
    union {
        struct {                     /* HAZARD_ACCESS, HAZARD_INDEXED */
            uint32_t info, geometry; /* indices in the call */
            uint32_t vertex_size;    /* HAZARD_INDEXED */
            VkObjectType object_type;
        };
        struct { /* HAZARD_COMMAND */
            uint32_t build_count;
            uint32_t first_build; /* its position in the command buffer; of a build at addresses,
                                   * its number in the journal */
            uint32_t origin;      /* see journal_note_origin() */
        };
        struct dependency dependency; /* HAZARD_BARRIER, HAZARD_SET_EVENT */
    };
    union {
        const char *command; /* HAZARD_COMMAND: static text, "vkCmdCopyBuffer" */
        uint64_t object;     /* HAZARD_ACCESS: handle of the structure or buffer, 0: unknown;
                              * of events: the VkEvent */
        const struct call_site *site; /* HAZARD_BARRIER: of its command; NULL: unknown */
    };
    /* HAZARD_ACCESS, HAZARD_INDEXED, HAZARD_BARRIER. Memory 0: an access that access_is_anywhere(),
     * a trace, or another write of unknown bytes. */
    struct hazard_bytes bytes;
};
_Static_assert(sizeof(struct hazard_entry) <= 56, "a command has many accesses");

/* Returns a new entry, whose other members are 0. Returns NULL if memory runs out; the journal
 * lacks hazards then. */
static inline struct hazard_entry *hazard_add(struct journal *journal, enum journal_kind kind)
{
    struct hazard_entry *entry = journal_append(journal, sizeof(*entry));
    if (!entry)
        unknown_set(&journal->accesses_unknown, UNKNOWN_ACCESSES);
    if (entry)
        *entry = (struct hazard_entry){.kind = (unsigned char)kind,
                                       .size = sizeof(*entry) / JOURNAL_UNIT};
    return entry;
}

/* Does what journal_next() does, for walks over HAZARD entries. */
static inline const struct hazard_entry *hazard_next(struct journal_walk *walk)
{
    return (const void *)journal_next(walk);
}

/* How a build at addresses accesses elements; of ADDRESSED_MEMBERS: a structure that it reads or
 * builds. No sentence says with which access partitioned builds read their arrays, and builds of
 * clusters their explicit destinations: that is not certain. */
struct addressed_access {
    bool is_certain;
    enum access_kind kind;
    enum hazard_role role;
};
static inline struct addressed_access hazard_access_of(bool is_partitioned,
                                                       const struct addressed_range *range)
{
    static const enum hazard_role roles[ADDRESSED_MEMBERS] = {
        [ADDRESSED_DST] = HAZARD_DST,         [ADDRESSED_SRC] = HAZARD_SRC,
        [ADDRESSED_SCRATCH] = HAZARD_SCRATCH, [ADDRESSED_ADDRESSES] = HAZARD_DST_ADDRESSES,
        [ADDRESSED_SIZES] = HAZARD_DST_SIZES, [ADDRESSED_INFOS] = HAZARD_INFOS,
        [ADDRESSED_COUNT] = HAZARD_COUNT,
    };
    const bool is_input = range->member == ADDRESSED_INFOS || range->member == ADDRESSED_COUNT,
               is_structure = range->member == ADDRESSED_MEMBERS;
    return (struct addressed_access){.is_certain = range->is_written ||
                                                   range->member == ADDRESSED_SRC || is_structure ||
                                                   (is_input && !is_partitioned),
                                     .kind = range->is_written ? ACCESS_BUILD_ACCEL_WRITE
                                             : is_input        ? ACCESS_BUILD_INDIRECT_READ
                                                               : ACCESS_BUILD_ACCEL_READ,
                                     .role = !is_structure       ? roles[range->member]
                                             : range->is_written ? HAZARD_DST
                                                                 : HAZARD_REFERENCE};
}

/* Returns the id of memory, or 0 if its bytes cannot be distinguished: see
 * resources_find_memory_id(). The journal remembers some ids, so that few accesses look one up. */
uint64_t hazard_memory_id(struct journal *journal, struct resources *resources,
                          VkDeviceMemory memory);

#endif
