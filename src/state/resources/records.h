/* SPDX-License-Identifier: Apache-2.0 */
/* The records behind resources.h; private to resources*.c. All fields are guarded by the lock of
 * struct resources. */
#ifndef ASSAY_STATE_RESOURCES_RECORDS_H
#define ASSAY_STATE_RESOURCES_RECORDS_H

#include <stdatomic.h>

#include "src/base/handle_table.h"
#include "src/base/reader_lock.h"
#include "src/state/order/clock.h"
#include "src/state/resources/address_map.h"
#include "src/state/resources/nv_shape.h"
#include "src/state/resources/resources.h"

struct memory_record {
    uint32_t references; /* of buffers, and one of the table while alive */
    bool alive;
    uint64_t id;
    VkDeviceMemory handle;
    VkDeviceSize size;
    VkMemoryPropertyFlags properties;
    bool multi_instance;
    struct buffer_record *buffers; /* bound to it; not sparse ones */
    /* Where the host has it mapped, from `mapped_offset` on; equal: nowhere. */
    uint64_t mapped_begin, mapped_end;
    VkDeviceSize mapped_offset;
    struct memory_record *previous_mapped, *next_mapped;
};

/* What was bound last to a range of a sparse buffer; the ranges of a buffer are sorted and do not
 * overlap, and between them nothing was ever bound. */
struct sparse_range {
    VkDeviceSize begin, end;      /* in the buffer */
    struct memory_record *memory; /* NULL: unbound again */
    VkDeviceSize memory_offset;   /* of `begin` */
    struct timestamp written;     /* timestamp_never(): it isn't known what was bound last */
};

struct buffer_record {
    /* Its place: what there is to say of its first byte, whether it has an address or not (0: not
     * retrieved). Follows from the rest, see resources_refresh. */
    struct address_facts where;
    enum tristate backed; /* likewise; not of a sparse buffer */

    uint32_t references; /* of acceleration structures, and one of the table while alive */
    bool alive;
    VkBufferCreateFlags flags;

    /* Not sparse: YES if bound to `memory` at `memory_offset`. */
    enum tristate bound;
    struct memory_record *memory;
    VkDeviceSize memory_offset;
    bool instances_differ;
    struct buffer_record *previous, *next; /* of the same memory */

    struct sparse_range *sparse;
    uint32_t sparse_count, sparse_capacity;
    uint32_t sparse_announced; /* bindings that are not settled yet */
    bool sparse_incomplete;    /* a binding was lost, or is of one device of a group */

    struct accel_record *accels; /* that lie in it */
};

enum { CACHE_LINE = 64 };

/* Allocated by aligned_alloc, for look-ups read one cache line of it. Where the structure lies
 * follows from its buffer, see resources_refresh. */
struct accel_record {
    _Alignas(CACHE_LINE) struct accel_facts facts;

    struct buffer_record *buffer;         /* NULL: not known */
    VkDeviceSize offset;                  /* in it */
    struct accel_record *previous, *next; /* in the same buffer */

    /* Where the address that instances refer to it by is known; else 0. */
    VkDeviceAddress address;
    bool address_is_unknown; /* it is 0, and counted as such */
    struct accel_record *same_address;
};
_Static_assert(offsetof(struct accel_facts, handle) == CACHE_LINE,
               "all that a look-up doesn't know yet is one line");

/* A VkMicromapEXT. */
struct micromap_record {
    uint64_t id;
    VkMicromapTypeEXT type;
};

struct nv_accel_record {
    uint64_t id;
    enum tristate bound; /* YES: to `memory` at `memory_offset` */
    bool instances_differ;
    struct memory_record *memory;
    VkDeviceSize memory_offset;
    struct nv_size_facts sizes;
    struct nv_shape *created;              /* NULL: not known */
    struct nv_reference_record *reference; /* NULL: not known */
};

/* What vkGetAccelerationStructureHandleNV has said of one or more structures: a driver may use a
 * value again once its structure is destroyed. Never freed before the table. */
struct nv_reference_record {
    enum nv_reference level; /* NV_REFERENCE_UNKNOWN if they were of both levels */
    uint32_t alive;          /* structures; those whose record is unknown stay alive */
    uint64_t destroyed_at;   /* resources_destroy_count when the last one died */
};

struct resources {
    struct reader_lock lock;
    struct handle_table memories, buffers, accels, micromaps, nv_accels;
    struct handle_table
        nv_references; /* what instances refer to by vkGetAccelerationStructureHandleNV:
                          of struct nv_reference_record */
    struct handle_table accel_addresses; /* see resources_references.c; only of those set */
    struct address_map addresses;        /* copies of the places of buffers that have one */
    struct memory_record *mapped;        /* all that the host has mapped */
    atomic_uint_fast64_t destroy_count;  /* of records of any kind */
    bool incomplete;
    uint32_t unknown_references; /* structures whose address isn't known, where they are set */
    /* A buffer may have been given an address that the application never retrieves: what is in no
     * known one may be in that. */
    bool replays_addresses;
    uint64_t last_id; /* of memory, buffers, structures of either kind, micromaps; 0 is nobody's */
};

/* Puts a new record into a table; without memory for it the state is incomplete from now on. */
bool resources_publish(struct resources *resources, struct handle_table *table, uint64_t handle,
                       void *record);
void resources_count_destroyed(struct resources *resources);
/* From now on what isn't found counts as unknown. */
void resources_become_incomplete(struct resources *resources);
void resources_release_nv(struct resources *resources);
void resources_release_references(struct resources *resources);

void memory_record_release(struct memory_record *memory);
void buffer_record_release(struct buffer_record *buffer);
void accel_record_free(struct accel_record *accel);
/* The structure dies, and that is noted. */
void accel_record_forget_address(struct resources *resources, struct accel_record *accel);

/* NULL where it isn't known. */
struct buffer_record *resources_buffer(const struct resources *resources, VkBuffer handle);
struct memory_record *resources_memory(const struct resources *resources, VkDeviceMemory handle);

/* Derives what look-ups read of a buffer, and of the structures in it, after a change. */
void resources_refresh(struct resources *resources, struct buffer_record *buffer);
void resources_refresh_accel(struct accel_record *accel);

/* Ends a mapping, if there is one (resources_mapped.c). */
void memory_record_unmap(struct resources *resources, struct memory_record *memory);

#endif
