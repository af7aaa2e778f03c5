/* SPDX-License-Identifier: Apache-2.0 */
/* Tracks the buffers, memory, acceleration structures and micromaps of one device, and the device
 * addresses of buffers. Owns their records and one lock over all of them. Every function takes that
 * lock unless its comment says otherwise.
 *
 * The bytes of a structure are identified by memory and offset, not by device address. They are
 * found through the binding of its buffer, which may come before or after the structure's creation,
 * and which ends when the memory is freed. Records refer to each other by pointer. The record of a
 * destroyed object is marked as destroyed and stays until nothing refers to it, so a handle that
 * the driver reuses is never mistaken for its predecessor.
 *
 * If there is no memory for a record, the state is `incomplete`: from then on an object that isn't
 * found counts as unknown, and so does every address, because the missing buffer may share it. */
#ifndef ASSAY_STATE_RESOURCES_RESOURCES_H
#define ASSAY_STATE_RESOURCES_RESOURCES_H

#include <stdbool.h>
#include <vulkan/vulkan_core.h>

#include "src/state/facts.h"
#include "src/state/order/clock.h"

struct resources;
struct nv_shape;

/* The caller destroys `*resources`. Returns VK_ERROR_OUT_OF_HOST_MEMORY if there is no memory. */
VkResult resources_create(struct resources **resources);
/* Accepts NULL. No other thread may use `resources`. Takes no lock. */
void resources_destroy(struct resources *resources);

/* Memory, of which memory type (its index) and what properties. `multi_instance`: the memory has
 * one instance for each physical device of the group. */
void resources_add_memory(struct resources *resources, VkDeviceMemory handle, VkDeviceSize size,
                          uint32_t type, VkMemoryPropertyFlags properties, bool multi_instance);
void resources_remove_memory(struct resources *resources, VkDeviceMemory handle);

/* vkMapMemory maps `size` bytes at `offset`, or all bytes after `offset` if `size` is
 * VK_WHOLE_SIZE; vkUnmapMemory unmaps them. */
void resources_map_memory(struct resources *resources, VkDeviceMemory handle, VkDeviceSize offset,
                          VkDeviceSize size, const void *pointer);
void resources_unmap_memory(struct resources *resources, VkDeviceMemory handle);

/* Buffers. */
void resources_add_buffer(struct resources *resources, VkBuffer handle,
                          const VkBufferCreateInfo *create_info);
void resources_remove_buffer(struct resources *resources, VkBuffer handle);
/* Sets the device address of a buffer; 0 if it has none. */
void resources_set_address(struct resources *resources, VkBuffer handle, VkDeviceAddress address);

/* Called after a bind command succeeded. `instances_differ`: the binding chooses a memory instance
 * for each physical device, so equal offsets need not be equal bytes. */
void resources_bind_buffer(struct resources *resources, VkBuffer handle, VkDeviceMemory memory,
                           VkDeviceSize offset, bool instances_differ);
/* Called after a bind command failed: the binding is unknown from then on. */
void resources_forget_binding(struct resources *resources, VkBuffer handle);

/* Sparse buffers. Bindings take effect in execution order. A binding is announced before it is
 * submitted, bound when the submission executes, and settled after that or when it is certain never
 * to execute. All facts about the buffer are unknown while a binding is announced. */
struct sparse_binding resources_announce_sparse(struct resources *resources, VkBuffer handle,
                                                const VkSparseMemoryBind *bind);
void resources_bind_sparse(struct resources *resources, const struct sparse_binding *binding,
                           struct timestamp when, const struct execution_clock *follows);
void resources_settle_sparse(struct resources *resources, const struct sparse_binding *binding);
/* Called for a binding that the layer doesn't track: the memory of the buffer is unknown from then
 * on. */
void resources_forget_sparse(struct resources *resources, VkBuffer handle);

/* Acceleration structures. */
void resources_add_accel(struct resources *resources, VkAccelerationStructureKHR handle,
                         const VkAccelerationStructureCreateInfoKHR *create_info);
/* For a structure created over an address range (vkCreateAccelerationStructure2KHR). */
void resources_add_accel_at(struct resources *resources, VkAccelerationStructureKHR handle,
                            const VkAccelerationStructureCreateInfo2KHR *create_info);
/* Returns the id of the structure, or 0 if the handle is unknown. */
uint64_t resources_remove_accel(struct resources *resources, VkAccelerationStructureKHR handle);

/* Sets the device address that instances refer to a structure by; 0 if unknown. The caller sets it
 * for every structure of the device or for none. */
void resources_set_accel_address(struct resources *resources, VkAccelerationStructureKHR handle,
                                 VkDeviceAddress address);
/* Calls `query` for a structure, or for all if `handle` is VK_NULL_HANDLE, if the address is
 * unknown and may be queried, and sets the address that it returns. The lock is held meanwhile, so
 * that no other thread destroys the structure, its buffer or its memory. */
void resources_query_addresses(struct resources *resources, VkAccelerationStructureKHR handle,
                               VkDeviceAddress (*query)(void *user,
                                                        VkAccelerationStructureKHR structure),
                               void *user);
/* Finds the structure that an instance with reference `address`, not 0, refers to. Structures
 * destroyed since resources_destroy_count() was `destroy_count` may have been alive at the time in
 * question: their facts are unknown. */
void resources_find_referenced(struct resources *resources, VkDeviceAddress address,
                               uint64_t destroy_count, struct accel_facts *facts);
/* Returns whether all structures at an address were destroyed, as far as none of them may have been
 * alive under another, unknown address. */
bool resources_reference_is_destroyed(struct resources *resources, VkDeviceAddress address,
                                      uint64_t destroy_count);

/* Micromaps of VK_EXT_opacity_micromap (micromap.c). */
void resources_add_micromap(struct resources *resources, VkMicromapEXT handle,
                            const VkMicromapCreateInfoEXT *create_info);
/* Returns the id of the micromap, or 0 if the handle is unknown. */
uint64_t resources_remove_micromap(struct resources *resources, VkMicromapEXT handle);
void resources_find_micromap(struct resources *resources, VkMicromapEXT handle,
                             struct micromap_facts *facts);

/* Acceleration structures of VK_NV_ray_tracing. Takes over the caller's reference to `created`. */
void resources_add_nv_accel(struct resources *resources, VkAccelerationStructureNV handle,
                            struct nv_shape *created, const struct nv_size_facts *sizes);
/* Returns the id of the structure, or 0 if the handle is unknown. */
uint64_t resources_remove_nv_accel(struct resources *resources, VkAccelerationStructureNV handle);
/* See resources_bind_buffer(). */
void resources_bind_nv_accel(struct resources *resources, VkAccelerationStructureNV handle,
                             VkDeviceMemory memory, VkDeviceSize offset, bool instances_differ);
/* Records a value that vkGetAccelerationStructureHandleNV returned for a structure. */
void resources_add_nv_reference(struct resources *resources, VkAccelerationStructureNV handle,
                                uint64_t reference);
/* The application may know values that the layer has not seen whole. */
void resources_forget_nv_references(struct resources *resources);
/* Returns which kind of structure has or had a reference, which isn't 0. A structure destroyed
 * after resources_destroy_count() was `destroy_count` counts as alive. */
enum nv_reference {
    NV_REFERENCE_UNKNOWN,
    NV_REFERENCE_BOTTOM_LEVEL,
    NV_REFERENCE_TOP_LEVEL, /* alive or destroyed */
    NV_REFERENCE_DESTROYED, /* destroyed, and not top-level */
    NV_REFERENCE_INVALID
};
enum nv_reference resources_find_nv_reference(struct resources *resources, uint64_t reference,
                                              uint64_t destroy_count);
/* Called after a bind command failed: the binding is unknown from then on. */
void resources_forget_nv_binding(struct resources *resources, VkAccelerationStructureNV handle);

/* Look-ups of several objects under one read lock. Between begin and end the caller must call only
 * the four functions below and take no lock of another module. Pass the token that begin returns to
 * end. */
unsigned resources_begin_reading(struct resources *resources);
void resources_end_reading(struct resources *resources, unsigned token);
void resources_find_accel(const struct resources *resources, VkAccelerationStructureKHR handle,
                          struct accel_facts *facts);
void resources_find_address(const struct resources *resources, VkDeviceAddress address,
                            struct address_facts *facts);
void resources_find_buffer(const struct resources *resources, VkBuffer handle,
                           struct buffer_facts *facts);
void resources_find_nv_accel(const struct resources *resources, VkAccelerationStructureNV handle,
                             struct nv_accel_facts *facts);

/* Look-ups of one object. */
void resources_look_up_accel(struct resources *resources, VkAccelerationStructureKHR handle,
                             struct accel_facts *facts);
/* Returns the last id that an object was given: later ones get greater ids. */
uint64_t resources_last_id(struct resources *resources);
/* Returns the facts of all live structures as an array that the caller frees; NULL: there are none,
 * or no memory. */
struct accel_facts *resources_list_accels(struct resources *resources, uint32_t *count);
/* Returns whether a live structure certainly shares no memory with another buffer or structure that
 * is alive. */
bool resources_accel_is_alone(struct resources *resources, VkAccelerationStructureKHR handle);
void resources_look_up_address(struct resources *resources, VkDeviceAddress address,
                               struct address_facts *facts);
void resources_look_up_buffer(struct resources *resources, VkBuffer handle,
                              struct buffer_facts *facts);
void resources_look_up_nv_accel(struct resources *resources, VkAccelerationStructureNV handle,
                                struct nv_accel_facts *facts);

/* A batch of look-ups. */
enum { RESOURCE_ACCEL_QUERIES = 32, RESOURCE_ADDRESS_QUERIES = 64 };
struct resource_queries {
    unsigned accel_count, address_count;
    struct {
        VkAccelerationStructureKHR handle;
        struct accel_facts *facts;
    } accels[RESOURCE_ACCEL_QUERIES];
    struct {
        VkDeviceAddress address;
        struct address_facts *facts;
    } addresses[RESOURCE_ADDRESS_QUERIES];
};

/* Answers all look-ups of a batch. Faster than single look-ups, because records that are not in the
 * processor's cache are fetched together. */
void resources_find_all(struct resources *resources, const struct resource_queries *queries);

/* Returns whether live memory backs all of the bytes for an execution point that follows `clock`.
 * NO: `missing` gets the first bytes without memory. */
enum tristate resources_sparse_backing(struct resources *resources,
                                       const struct sparse_bytes *bytes,
                                       const struct execution_clock *clock,
                                       struct sparse_bytes *missing);
/* Calls `visit` for each span of memory that backs the bytes, as far as that is certain. `visit`
 * must not call this module. */
void resources_find_pieces(struct resources *resources, const struct sparse_bytes *bytes,
                           const struct execution_clock *clock,
                           void (*visit)(void *user, const struct memory_span *piece), void *user);

/* Calls `visit` for each range of device addresses that is bound to memory: disjoint ranges in
 * ascending order, without sparse and protected buffers. `visit` must not call this module. */
void resources_find_ranges(struct resources *resources,
                           void (*visit)(void *user, uint64_t begin, uint64_t end), void *user);

/* Whether memory outside those ranges may be readable, too. */
bool resources_has_unknown_ranges(struct resources *resources);

/* Returns how many bytes at a device address, `size` at most, an unprotected command can read that
 * executes after everything in `clock`. Returns 0 if unknown. For a sparse buffer, returns either 0
 * or all bytes up to the end of `size` or of the buffer. */
uint64_t resources_find_readable(struct resources *resources, VkDeviceAddress address,
                                 uint64_t size, const struct execution_clock *clock);

/* Calls `visit` for each span of the bytes at a host address: spans of mapped memory, or of
 * memory_of_host(). `visit` must not call this module. */
void resources_find_host_pieces(struct resources *resources, const void *pointer, VkDeviceSize size,
                                void (*visit)(void *user, const struct memory_span *piece),
                                void *user);

/* Finds the host mapping of the bytes at a device address. Only for coherent memory and non-sparse
 * buffers. Returns how many bytes are mapped, `size` at most. `bytes` stays valid as long as the
 * mapping. */
uint64_t resources_find_mapped(struct resources *resources, VkDeviceAddress address, uint64_t size,
                               const void **bytes);

/* Whether no command writes to a buffer with these usages: STORAGE_BUFFER and TRANSFER_DST write.
 */
static inline bool buffer_is_only_read(VkBufferUsageFlags2 usage)
{
    const VkBufferUsageFlags2 reading =
        VK_BUFFER_USAGE_2_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_2_UNIFORM_TEXEL_BUFFER_BIT |
        VK_BUFFER_USAGE_2_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_2_INDEX_BUFFER_BIT |
        VK_BUFFER_USAGE_2_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_2_INDIRECT_BUFFER_BIT |
        VK_BUFFER_USAGE_2_CONDITIONAL_RENDERING_BIT_EXT |
        VK_BUFFER_USAGE_2_SHADER_BINDING_TABLE_BIT_KHR |
        VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
        VK_BUFFER_USAGE_2_SHADER_DEVICE_ADDRESS_BIT;
    return !(usage & ~reading);
}

/* Bytes of memory that a buffer is bound to. */
struct mapped_bytes {
    VkBuffer buffer;
    uint64_t memory_id; /* see resources_find_memory_id() */
    uint64_t begin, size;
};
/* Shows `visit` the bytes where the host has mapped them, which must not call this module. Returns
 * false if they are not mapped as a whole, not coherent, or if others than the host may write them:
 * commands, through a buffer or an image, or another device. Shaders that write through addresses
 * are not considered. */
bool resources_visit_mapped(struct resources *resources, const struct mapped_bytes *wanted,
                            void (*visit)(void *user, const void *bytes, uint64_t size),
                            void *user);

/* Returns the id of live memory, which is never reused. Returns 0 if the handle is unknown, or if
 * the memory has several instances: then equal offsets need not be equal bytes. */
uint64_t resources_find_memory_id(struct resources *resources, VkDeviceMemory handle);

/* Live memory. */
struct memory_facts {
    bool known;
    VkDeviceSize size; /* bytes; 0: unknown, because it was imported */
    uint32_t type;     /* index of its memory type */
    bool is_shared;    /* see resources_share_memory() */
};
/* Not only commands that use buffers may write to the memory: an image is bound to it, or it is
 * imported or exported. The same holds for memory that the host has ever mapped. */
void resources_share_memory(struct resources *resources, VkDeviceMemory handle);
struct memory_facts resources_find_memory(struct resources *resources, VkDeviceMemory handle);

/* Finds where all bytes of a buffer, or of a micromap, lie. Returns false if they are unknown, or
 * not in one piece of such memory. */
struct memory_bytes {
    uint64_t memory_id; /* see resources_find_memory_id() */
    VkDeviceSize begin, size;
};
bool resources_find_buffer_bytes(struct resources *resources, VkBuffer handle,
                                 struct memory_bytes *bytes);
/* Finds where the bytes from a device address to the end of its buffer lie. Returns NO if the
 * address certainly is in no bound buffer. `is_external`: not only commands of this device may
 * write there, because the memory is or may be imported or exported. */
enum tristate resources_find_address_bytes(struct resources *resources, VkDeviceAddress address,
                                           struct memory_bytes *bytes, bool *is_external);
/* Calls `visit` for the addresses of each buffer that is or may be bound, with the bytes there.
 * Bytes with a memory_id of 0 are unknown. Returns false if other addresses may lead to bytes, too.
 * `visit` must not call this module. */
struct addressed_bytes {
    VkDeviceAddress address;
    struct memory_bytes bytes;
    bool is_external;
};
bool resources_visit_addresses(struct resources *resources,
                               void (*visit)(void *user, const struct addressed_bytes *there),
                               void *user);
/* The memory of a buffer, and where the buffer's bytes lie in it. Returns false if they are
 * unknown, or not in one piece of memory with one instance. */
struct buffer_memory {
    VkDeviceMemory handle;
    VkMemoryPropertyFlags properties;
    VkDeviceSize begin, size;
};
bool resources_find_buffer_memory(struct resources *resources, VkBuffer handle,
                                  struct buffer_memory *memory);
bool resources_find_micromap_bytes(struct resources *resources, VkMicromapEXT handle,
                                   struct memory_bytes *bytes);

/* Returns the number of records destroyed so far. While it stays the same, every object that was
 * found alive is alive. Takes no lock. */
uint64_t resources_destroy_count(struct resources *resources);
/* Increments that number; also for objects that have their record elsewhere. */
void resources_count_destroyed(struct resources *resources);

/* Finds the device address, or 0, and the size of a live buffer or structure that has one. Returns
 * false if the handle is unknown or, unless `waits`, if the lock is taken: a signal handler may
 * then call this. */
struct resource_span {
    VkDeviceAddress address;
    VkDeviceSize size;
};
bool resources_find_span(struct resources *resources, VkObjectType type, uint64_t handle,
                         bool waits, struct resource_span *span);

/* Finds the live buffer at a device address, and the structure there: VK_NULL_HANDLE if there is
 * none. */
struct resources_at {
    VkBuffer buffer;
    VkAccelerationStructureKHR structure;
};
struct resources_at resources_find_at(struct resources *resources, VkDeviceAddress address);
/* Finds the structure that begins at a device address and may be a micromap. Returns false if there
 * is none, or may be another one. */
bool resources_find_micromap_at(struct resources *resources, VkDeviceAddress address,
                                struct accel_facts *facts);

/* Finds the buffer behind whose end an address lies that is in no buffer, and how many bytes behind
 * it. Returns false if there is none, or if the layer may not know all buffers. */
struct resources_before {
    VkBuffer buffer;
    VkDeviceSize distance;
};
bool resources_find_before(struct resources *resources, VkDeviceAddress address,
                           struct resources_before *before);

/* Returns the id of a live object of the device, or 0 if the handle is unknown. */
enum resource_kind {
    RESOURCE_ACCEL,
    RESOURCE_ACCEL_NV,
    RESOURCE_BUFFER,
    RESOURCE_MICROMAP,
    RESOURCE_MEMORY,
    RESOURCE_QUERY_POOL, /* not of this module */
};
uint64_t resources_find_id(struct resources *resources, enum resource_kind kind, uint64_t handle);
/* Whether there is such an object; UNKNOWN if a record may be missing. */
enum tristate resources_has(struct resources *resources, enum resource_kind kind, uint64_t handle);

/* Notes that a structure or micromap was created with VkAllocationCallbacks. */
void resources_note_callbacks(struct resources *resources, enum resource_kind kind,
                              uint64_t handle);
/* Returns UNKNOWN if there is no such object. */
enum tristate resources_has_callbacks(struct resources *resources, enum resource_kind kind,
                                      uint64_t handle);

#endif
