/* SPDX-License-Identifier: Apache-2.0 */
/* A build of a command buffer: its parameters, and where the device copied the build's inputs just
 * before it. */
#ifndef ASSAY_SNAPSHOTS_RECORDED_BUILD_H
#define ASSAY_SNAPSHOTS_RECORDED_BUILD_H

#include <stdatomic.h>

#include "src/base/handle_table.h"
#include "src/model/build_parameters.h"
#include "src/model/clusters.h"
#include "src/snapshots/memory.h"
#include "vuid-tables/rules.h"

/* The copy that one workgroup of copy.comp executes. It lies in a chunk, in the shader's layout.
 * The host writes it before each submission, and the device sets `is_done`. */
struct copy_order {
    uint64_t source, target; /* device addresses; source 0: vkCmdCopyBuffer copies */
    uint64_t left;    /* bytes that can be read at the source; 0: unknown, so nothing is copied */
    uint32_t size;    /* the most bytes that the shader copies */
    uint32_t is_done; /* 1 when the device has executed the copy */
};
_Static_assert(sizeof(struct copy_order) == 32, "as the shader has it");

/* Short orders run at the same time. */
enum { COPY_SIZE_MAX = 1 << 14 };

/* Location of `count` consecutive copy orders. */
struct copy_orders {
    uint32_t chunk, count;
    uint64_t offset;
};

/* The bytes of a chunk (recording.h) that hold a copy of [address, address + size), as far as the
 * copy orders allowed. A snapshot of size 0 has one order, whose `left` is the number of bytes from
 * the address to the end of the buffer. */
struct snapshot {
    uint64_t address, size;
    uint32_t chunk;
    uint64_t offset;
    /* One for each consecutive part. All parts but the last have COPY_SIZE_MAX bytes. */
    struct copy_orders orders;
};

/* Copies of `count` consecutive elements to which the addresses in a snapshot point. In builds with
 * motion the low 4 bits of an address are the element's type, and all elements have the size of the
 * largest type. */
struct gathering {
    struct snapshot addresses, elements;
    struct snapshot ranges; /* begins and ends of readable memory, ascending; elements elsewhere
                               were gathered as zeros */
    uint32_t count;
    bool is_typed;
    uint32_t first, stride; /* of the addresses, in words of 8 bytes */
    uint32_t parts;         /* consecutive elements behind each address */
    struct gathering *next; /* of the same build; owned */
};
/* The members for an array of addresses: each takes one word, and has one element behind it. */
#define GATHERING_OF_POINTERS .stride = 1, .parts = 1

/* ---- guards (setting guard): a shader copies the instances of a top-level build just before it,
 * without references to structures that are not live, and the build reads the copy. */

/* A value of `readable`, `range_count`, `place_count` and `limit` of struct guard_order. If it is
 * the limit, each live structure counts as built. */
enum { GUARD_UNLIMITED = UINT32_MAX };

/* What guard.comp reads and returns for one build. It lies in a chunk, in the shader's layout. The
 * host writes it before each submission. For a partitioned structure, the source is its operations,
 * the range of an indirect build is their count, and the ranges are for the arrays to which they
 * lead. */
struct guard_order {
    uint64_t source, ranges, places, indirect; /* device addresses */
    uint32_t readable;       /* bytes that can be read at the source; GUARD_UNLIMITED: unknown */
    uint32_t range_count;    /* ranges of readable memory; GUARD_UNLIMITED: unknown. It may become
                                unlimited while the device reads the order. */
    uint32_t limit;          /* structures that were built at this count or before are built. It may
                                grow while the device reads the order. */
    uint32_t can_read_range; /* the range of an indirect build is not known to be unreadable */
    uint32_t place_count; /* ranges in which structures without a handle may be, so that references
                             into them are kept; GUARD_UNLIMITED: they may be anywhere. It may
                             become unlimited while the device reads the order. */
    /* Written by the device. */
    uint32_t replaced;       /* references that became 0 */
    uint32_t first_replaced; /* index of the first instance among them */
    uint32_t unreadable;     /* instances in memory that cannot be read: they became zeros */
    uint32_t is_done;
    uint32_t reserved;
};
_Static_assert(sizeof(struct guard_order) == 72, "as the shader has it");

/* A list of size 0 does not exist: without pointers there is none of ranges. */
struct build_guard {
    bool is_nv;
    struct snapshot order, ranges, places; /* without an address */
    uint64_t source, source_size, indirect, indirect_size;
    /* The limit that the last checked submission has set (layer/snapshots/guard/execution.h);
     * GUARD_UNLIMITED if there was none. The limit only grows. Another thread may submit the build
     * at the same time. */
    _Atomic uint32_t limit;
};

/* ---- builds */

/* Identifies the build among the application's builds. */
struct recorded_place {
    enum build_command command;
    uint32_t info;            /* index in pInfos */
    uint32_t position;        /* number of the build in the command buffer, from 0 */
    bool geometry_by_pointer; /* the application used ppGeometries */
};

/* Builds of micromaps and deserializations have no number among the builds of a command buffer. */
#define POSITION_OF_OTHERS UINT32_MAX
static inline struct recorded_place recorded_place_of_micromap(uint32_t info)
{
    return (struct recorded_place){
        .command = COMMAND_CmdBuildMicromapsEXT, .info = info, .position = POSITION_OF_OTHERS};
}

/* Why snapshots lack inputs of a build. */
enum left_out {
    LEFT_OUT_NOTHING,
    LEFT_OUT_MEMORY, /* out of memory */
    LEFT_OUT_BUDGET, /* content_budget_mib was exhausted */
    LEFT_OUT_BUFFER, /* a buffer can't be read, for example because it is protected */
    LEFT_OUT_PLACE,  /* commands of the layer's own would disturb the application's commands at this
                        point */
};

/* What a deserialization writes: a structure or a micromap. */
struct deserialization {
    uint64_t dst;          /* its handle */
    VkDeviceSize dst_size; /* bytes, of its create info; 0: unknown */
    uint64_t address;      /* of the serialized data */
};

/* A build, or a deserialization or a build at addresses, which have no parameters of a build.
 * Addresses and offsets are changed by recorded_build_normalize(). */
struct recorded_build {
    /* `given`: the parameters before normalization; empty if both are the same. */
    struct build_parameters parameters, given;
    struct deserialization *deserialization; /* owned; NULL: it is a build */
    struct addressed_build *addressed;       /* owned; NULL: it builds what has a handle */
    struct recorded_place place;
    enum left_out left_out;
    /* If set, the ranges lie at indirect_address, and parameters.ranges have the maximum counts. */
    bool is_indirect;
    uint64_t indirect_address, indirect_stride;
    struct snapshot *snapshots;
    uint32_t snapshot_count, snapshot_capacity;
    struct gathering gathering;  /* count 0: none; a TLAS has one */
    struct build_guard *guard;   /* owned; NULL: it is not guarded */
    bool begins_call;            /* the first build of its call that is recorded */
    uint32_t mark;               /* see recording_mark_state() */
    atomic_bool has_findings;    /* about the inputs of one of its executions */
    struct recorded_build *next; /* in the list of its recording */
};

/* Adds the offsets of ranges to the addresses, so that the data which the build reads from each
 * array begins at its address. Not for indirect builds, whose ranges are unknown yet. Returns false
 * without memory. */
bool recorded_build_normalize(struct recorded_build *build);

/* The parameters as the application gave them. */
const struct build_parameters *recorded_build_given(const struct recorded_build *build);

/* Adds a snapshot. Returns false without memory. */
bool recorded_build_add(struct recorded_build *build, const struct snapshot *snapshot);

/* Adds a gathering, and returns where it is kept, or NULL without memory. */
struct gathering *recorded_build_add_gathering(struct recorded_build *build,
                                               const struct gathering *gathering);

void recorded_build_free(struct recorded_build *build); /* accepts NULL */

/* Reads the range of one geometry of an indirect build. Returns false if it can't be read. */
bool recorded_build_read_range(const struct recorded_build *build,
                               const struct input_memory *memory, uint32_t geometry,
                               VkAccelerationStructureBuildRangeInfoKHR *range);
/* Reads all ranges of an indirect build. A range that can't be read becomes zeros; a count above
 * the maximum is reduced to it. */
void recorded_build_read_ranges(const struct recorded_build *build,
                                const struct input_memory *memory,
                                VkAccelerationStructureBuildRangeInfoKHR *ranges);

/* ---- snapshots */

/* The snapshot that has the bytes at an address. Returns NULL if there is none. */
const struct snapshot *snapshot_find(const struct snapshot *snapshots, uint32_t count,
                                     uint64_t address);

/* Snapshots as the memory that a build reads. `bases` points to the bytes of each chunk.
 * snapshot_memory_open() fills in the last three members. */
struct snapshot_memory {
    const struct snapshot *snapshots;
    uint32_t count;
    unsigned char *const *bases;
    const struct gathering *gathering; /* or NULL */
    bool omits_unread;            /* memory that could not be read is missing, instead of zeros */
    struct handle_table gathered; /* elements by their addresses */
    uint64_t *copied;             /* copied bytes of each snapshot */
    bool lacks_copies;            /* the device has not executed all copies */
};
bool snapshot_memory_open(struct snapshot_memory *memory); /* returns false without memory */
void snapshot_memory_close(struct snapshot_memory *memory);
struct input_memory snapshot_memory_of(struct snapshot_memory *memory);

#endif
