/* SPDX-License-Identifier: Apache-2.0 */
/* A build of a command buffer: its parameters, and where the device copied the memory that they
 * name to when it came to the build. */
#ifndef ASSAY_SNAPSHOTS_RECORDED_BUILD_H
#define ASSAY_SNAPSHOTS_RECORDED_BUILD_H

#include "src/base/handle_table.h"
#include "src/snapshots/build_parameters.h"
#include "src/snapshots/memory.h"
#include "vuid-tables/rules.h"

/* What one workgroup of copy.comp copies. It lies in a chunk, as the shader reads it: the host
 * writes it before each submission, and the device sets `is_done`. */
struct copy_order {
    uint64_t source, target; /* device addresses; source 0: vkCmdCopyBuffer copies */
    uint64_t left;           /* bytes that can be read at the source; 0: it is not known */
    uint32_t size;           /* of these the shader copies this many at most */
    uint32_t is_done;        /* 1 when the device has executed the copy */
};
_Static_assert(sizeof(struct copy_order) == 32, "as the shader has it");

enum { COPY_SIZE_MAX = 1 << 16 };

/* Where copy orders lie: `count` in a row. */
struct copy_orders {
    uint32_t chunk, count;
    uint64_t offset;
};

/* Bytes of a chunk (recording.h) that hold those of [address, address + size), as far as the copy
 * orders say. A snapshot of size 0 has one order, whose `left` says how many bytes the buffer has
 * from the address on. */
struct snapshot {
    uint64_t address, size;
    uint32_t chunk;
    uint64_t offset;
    struct copy_orders orders; /* consecutive parts, COPY_SIZE_MAX bytes each but the last */
};

/* What an array of pointers points to: `count` elements, one behind the other, of the addresses in
 * a snapshot. In builds with motion an address's low 4 bits are the element's type, and elements
 * are as far apart as the largest type needs. */
struct gathering {
    struct snapshot addresses, elements;
    struct snapshot ranges; /* begins and ends of what could be read, ascending; zeros were gathered
                               from elsewhere */
    uint32_t count;
    bool is_typed;
};

/* Which of the application's builds it is. */
struct recorded_place {
    enum build_command command;
    uint32_t info;            /* index in pInfos */
    uint32_t position;        /* in the command buffer, whose builds are counted from 0 */
    bool geometry_by_pointer; /* of ppGeometries */
};

/* Why snapshots don't have all that a build reads. */
enum left_out {
    LEFT_OUT_NOTHING,
    LEFT_OUT_MEMORY, /* there was none for them */
    LEFT_OUT_BUDGET, /* they would have been beyond content_budget_mib */
    LEFT_OUT_BUFFER, /* a buffer can't be read: it is protected, for example */
    LEFT_OUT_PLACE,  /* commands of the layer's own would disturb what the application does there */
};

/* Of addresses and offsets of its own: see recorded_build_normalize(). */
struct recorded_build {
    struct build_parameters parameters, given; /* given: as they were before; none where they are
                                                  the same */
    struct recorded_place place;
    enum left_out left_out;
    /* Then its ranges are at an address, and parameters.ranges have the maximum counts. */
    bool is_indirect;
    uint64_t indirect_address, indirect_stride;
    struct snapshot *snapshots;
    uint32_t snapshot_count, snapshot_capacity;
    struct gathering gathering; /* count 0: none; of a TLAS, which has one geometry */
};

/* Adds the offsets of ranges to the addresses, so that what the build reads of each array begins at
 * its address. Not for indirect builds, whose ranges aren't known yet. False without memory. */
bool recorded_build_normalize(struct recorded_build *build);

/* The parameters as the application gave them. */
const struct build_parameters *recorded_build_given(const struct recorded_build *build);

/* False without memory. */
bool recorded_build_add(struct recorded_build *build, const struct snapshot *snapshot);

void recorded_build_free(struct recorded_build *build); /* NULL: nothing */

/* Reads the range of one geometry of an indirect build; false where it can't be read. */
bool recorded_build_read_range(const struct recorded_build *build,
                               const struct input_memory *memory, uint32_t geometry,
                               VkAccelerationStructureBuildRangeInfoKHR *range);
/* Reads all of them; zeros where one can't be read, and counts above the maximum are cut. */
void recorded_build_read_ranges(const struct recorded_build *build,
                                const struct input_memory *memory,
                                VkAccelerationStructureBuildRangeInfoKHR *ranges);

/* ---- snapshots */

/* The one that has the bytes at an address, or NULL. */
const struct snapshot *snapshot_find(const struct snapshot *snapshots, uint32_t count,
                                     uint64_t address);

/* Snapshots as the memory that a build reads; `bases` has the bytes of each chunk. Once opened it
 * knows how much of each snapshot was copied. */
struct snapshot_memory {
    const struct snapshot *snapshots;
    uint32_t count;
    unsigned char *const *bases;
    const struct gathering *gathering; /* or NULL */
    bool omits_unread;                 /* what could not be read isn't there, and not zeros */
    struct handle_table gathered;      /* these three are made by snapshot_memory_open(): from
                                          addresses to elements; */
    uint64_t *copied;                  /* bytes of each snapshot; */
    bool lacks_copies;                 /* the device has not executed all copies */
};
bool snapshot_memory_open(struct snapshot_memory *memory); /* false without memory */
void snapshot_memory_close(struct snapshot_memory *memory);
struct input_memory snapshot_memory_of(struct snapshot_memory *memory);

#endif
