/* SPDX-License-Identifier: Apache-2.0 */
/* The records behind resources.h; private to src/state/resources. The lock of struct resources
 * guards all fields. */
#ifndef ASSAY_STATE_RESOURCES_RECORDS_H
#define ASSAY_STATE_RESOURCES_RECORDS_H

#include <stdatomic.h>

#include "src/base/handle_table.h"
#include "src/base/reader_lock.h"
#include "src/base/unknown.h"
#include "src/state/order/clock.h"
#include "src/state/resources/address_map.h"
#include "src/state/resources/nv_shape.h"
#include "src/state/resources/resources.h"

struct memory_record {
    uint32_t references; /* from buffers, and one from the table while alive */
    bool alive;
    uint64_t id;
    VkDeviceMemory handle;
    VkDeviceSize size;
    uint32_t type; /* index of its memory type */
    VkMemoryPropertyFlags properties;
    bool multi_instance;
    bool is_shared;                /* see resources_share_memory() */
    bool is_foreign;               /* the same, but for mappings by the host */
    struct buffer_record *buffers; /* list of the non-sparse buffers bound to it */
    /* The host address range that maps it, from offset `mapped_offset` on; empty if not mapped. */
    uint64_t mapped_begin, mapped_end;
    VkDeviceSize mapped_offset;
    struct memory_record *previous_mapped, *next_mapped;
};

/* The last binding of a range of a sparse buffer. The ranges of a buffer are sorted and don't
 * overlap; bytes between them were never bound. */
struct sparse_range {
    VkDeviceSize begin, end;      /* in the buffer */
    struct memory_record *memory; /* NULL: unbound again */
    VkDeviceSize memory_offset;   /* of the byte at `begin` */
    struct timestamp written;     /* when bound; timestamp_never() if the last binding is unknown */
};

struct buffer_record {
    /* Facts about its first byte; address is 0 if the application hasn't retrieved it. Derived by
     * resources_refresh(). */
    struct address_facts where;
    enum tristate backed; /* derived by resources_refresh(); not valid for a sparse buffer */

    uint32_t references; /* from acceleration structures, and one from the table while alive */
    bool alive;
    bool is_external; /* created for external memory */
    VkBufferCreateFlags flags;

    /* Non-sparse buffers only. YES: bound to `memory` at `memory_offset`. */
    enum tristate bound;
    struct memory_record *memory;
    VkDeviceSize memory_offset;
    bool instances_differ;
    struct buffer_record *previous, *next; /* in the list of the same memory */

    struct sparse_range *sparse;
    uint32_t sparse_count, sparse_capacity;
    uint32_t sparse_announced; /* bindings announced and not settled yet */
    struct unknown
        sparse_unknown; /* a binding was not tracked, or binds one device of a group only */

    struct accel_record *accels; /* list of the structures created in it */
};

enum { CACHE_LINE = 64 };

/* Allocated by aligned_allocate(), because a look-up reads one cache line of it.
 * resources_refresh() derives from the buffer where the structure's bytes lie. */
struct accel_record {
    _Alignas(CACHE_LINE) struct accel_facts facts;

    struct buffer_record *buffer;         /* NULL: unknown */
    VkDeviceSize offset;                  /* in the buffer */
    struct accel_record *previous, *next; /* in the same buffer */

    /* The device address that instances refer to it by; 0 if unknown. */
    VkDeviceAddress address;
    bool address_is_unknown; /* counted in unknown_references */
    bool has_callbacks;      /* it was created with VkAllocationCallbacks */
    struct accel_record *same_address;
};
_Static_assert(offsetof(struct accel_facts, handle) == CACHE_LINE,
               "all that a look-up doesn't know yet is one line");

/* A VkMicromapEXT. */
struct micromap_record {
    uint64_t id;
    bool has_callbacks; /* see struct accel_record */
    VkMicromapTypeEXT type;
    VkMicromapCreateFlagsEXT create_flags;
    VkBuffer buffer;
    uint64_t buffer_id; /* 0: unknown */
    VkDeviceSize offset, size;
};

struct nv_accel_record {
    uint64_t id;
    enum tristate bound; /* YES: bound to `memory` at `memory_offset` */
    bool instances_differ;
    bool has_callbacks; /* see struct accel_record */
    struct memory_record *memory;
    VkDeviceSize memory_offset;
    struct nv_size_facts sizes;
    struct nv_shape *created;              /* NULL: unknown */
    struct nv_reference_record *reference; /* NULL: unknown */
    uint64_t value;                        /* of `reference` */
};

/* A value that vkGetAccelerationStructureHandleNV returned for one or more structures: a driver may
 * return a value again after its structure is destroyed. */
struct nv_reference_record {
    enum nv_reference level; /* NV_REFERENCE_UNKNOWN if structures of both levels had the value */
    uint32_t alive;          /* number of live structures; a structure without a record counts
                              * forever */
    uint32_t without_memory; /* number of these whose memory was freed */
    uint64_t destroyed_at;   /* resources_destroy_count() when the last structure was destroyed */
};

/* Values that instances referred to structures by, and that no live structure has: the last
 * PAST_REFERENCES ones. Older values are forgotten, so that an application that creates and
 * destroys structures for ever needs no more memory. */
enum { PAST_REFERENCES = 1024 };
struct past_reference {
    uint64_t value;        /* 0: none */
    uint64_t destroyed_at; /* resources_destroy_count() when its last structure was destroyed */
};
struct past_references {
    struct past_reference *items; /* a ring; NULL: none yet, or no memory */
    uint32_t next;
    uint64_t forgotten_at; /* the latest destroyed_at of a forgotten value. What a submission from
                            * before that refers to is unknown. */
};

/* See reference_changes.h. */
struct watched_references {
    bool is_on;
    struct unknown unknown;           /* memory ran out for a change */
    struct reference_change *changes; /* owned */
    uint32_t count, capacity;
};

struct resources {
    struct reader_lock lock;
    struct handle_table memories, buffers, accels, micromaps, nv_accels;
    struct handle_table nv_references;   /* struct nv_reference_record by the value that
                                          * vkGetAccelerationStructureHandleNV returned */
    struct handle_table accel_addresses; /* struct accel_address by device address, see
                                          * references.c; known addresses only */
    struct past_references past_addresses, past_nv_references;
    struct address_map addresses;       /* copies of `where` of all buffers that have an address */
    struct memory_record *mapped;       /* list of the memory that the host has mapped */
    atomic_uint_fast64_t destroy_count; /* of destroyed records of any kind */
    struct unknown unknown;
    uint32_t unknown_references;   /* number of structures whose address was set to unknown */
    uint64_t unknown_destroyed_at; /* destroy_count when the last one of these was destroyed */
    struct unknown nv_unknown;     /* the application got a part of a value of VK_NV_ray_tracing */
    struct watched_references watched;
    /* The application may use a capture address that it never retrieved: an address in no known
     * buffer may be in such a buffer. */
    bool replays_addresses;
    uint64_t last_id; /* last id given to memory, a buffer, a structure or a micromap; 0 is no id */
};

/* Puts a new record into a table, which then owns it. If there is no memory, or `record` is NULL,
 * marks the state incomplete and returns false; the caller then frees the record. */
bool resources_publish(struct resources *resources, struct handle_table *table, uint64_t handle,
                       void *record);
/* From now on, an object that isn't found counts as unknown. */
void resources_become_unknown(struct resources *resources);
/* Free the records of nv.c and of references.c when the state is destroyed. */
void resources_release_nv(struct resources *resources);
void resources_release_references(struct resources *resources);
/* Adds a value. Returns the oldest one, or none: the caller forgets it if no structure has had it
 * since. */
struct past_reference past_references_add(struct past_references *past, uint64_t value,
                                          uint64_t destroyed_at);

/* Drop a reference and free the record with the last one. Both accept NULL. */
void memory_record_release(struct memory_record *memory);
void buffer_record_release(struct buffer_record *buffer);
/* Removes the record from its buffer and frees it. */
void accel_record_free(struct accel_record *accel);
/* Called when the structure is destroyed: removes it from the structures at its address and stores
 * the destroy count there. */
void accel_record_forget_address(struct resources *resources, struct accel_record *accel);

/* Notes that the memory of structures of VK_NV_ray_tracing was freed. */
void nv_accel_records_end_memory(struct resources *resources, const struct memory_record *memory);
/* Notes that what a value refers to has changed (reference_changes.h). */
void resources_note_reference(struct resources *resources, uint64_t reference, bool is_nv);

/* Both return NULL if the handle is unknown. */
struct buffer_record *resources_buffer(const struct resources *resources, VkBuffer handle);
struct memory_record *resources_memory(const struct resources *resources, VkDeviceMemory handle);

/* Recomputes, after a change, the derived facts of a buffer and of the structures in it. */
void resources_refresh(struct resources *resources, struct buffer_record *buffer);
void resources_refresh_accel(struct accel_record *accel);

/* Ends the mapping of the memory if it is mapped (memory.c). */
void memory_record_unmap(struct resources *resources, struct memory_record *memory);

#endif
