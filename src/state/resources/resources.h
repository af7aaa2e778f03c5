/* SPDX-License-Identifier: Apache-2.0 */
/* The buffers, memory and acceleration structures of one device, and which device addresses they
 * have. It owns their records and one lock over all of them.
 *
 * Memory, not addresses: a structure's bytes are found through its buffer's binding, which may come
 * before or after the structure's creation, and which ends when the memory is freed. Records refer
 * to each other by pointer and are kept until nothing refers to them, marked dead meanwhile, so a
 * handle that the driver reuses is never mistaken for its predecessor.
 *
 * A record that could not be kept for lack of memory makes the whole `incomplete`: from then on
 * what isn't found counts as unknown, and so does every address, which the lost one may share. */
#ifndef ASSAY_STATE_RESOURCES_RESOURCES_H
#define ASSAY_STATE_RESOURCES_RESOURCES_H

#include <stdbool.h>
#include <vulkan/vulkan_core.h>

#include "src/state/facts.h"
#include "src/state/order/clock.h"

struct resources;
struct nv_shape;

VkResult resources_create(struct resources **resources);
void resources_destroy(struct resources *resources);

/* Memory. `multi_instance`: several instances, one a physical device of the group. */
void resources_add_memory(struct resources *resources, VkDeviceMemory handle, VkDeviceSize size,
                          VkMemoryPropertyFlags properties, bool multi_instance);
void resources_remove_memory(struct resources *resources, VkDeviceMemory handle);

/* The host has mapped `size` bytes, or all to the end for VK_WHOLE_SIZE; or unmaps it. */
void resources_map_memory(struct resources *resources, VkDeviceMemory handle, VkDeviceSize offset,
                          VkDeviceSize size, const void *pointer);
void resources_unmap_memory(struct resources *resources, VkDeviceMemory handle);

/* Buffers. */
void resources_add_buffer(struct resources *resources, VkBuffer handle,
                          const VkBufferCreateInfo *create_info);
void resources_remove_buffer(struct resources *resources, VkBuffer handle);
void resources_set_address(struct resources *resources, VkBuffer handle, VkDeviceAddress address);

/* A bind command returned success. `instances_differ`: the binding gives each physical device an
 * instance of its choice, so that equal offsets need not be equal bytes. */
void resources_bind_buffer(struct resources *resources, VkBuffer handle, VkDeviceMemory memory,
                           VkDeviceSize offset, bool instances_differ);
/* A bind command failed: what is bound is not known. */
void resources_forget_binding(struct resources *resources, VkBuffer handle);

/* Sparse buffers. What is bound counts in the order of execution: a binding is announced before it
 * is submitted, bound when its turn has come, and settled then, or when it is certain that it never
 * will be bound. While any is announced nothing is said of the buffer. */
struct sparse_binding resources_announce_sparse(struct resources *resources, VkBuffer handle,
                                                const VkSparseMemoryBind *bind);
void resources_bind_sparse(struct resources *resources, const struct sparse_binding *binding,
                           struct timestamp when, const struct execution_clock *follows);
void resources_settle_sparse(struct resources *resources, const struct sparse_binding *binding);
/* Bound in a way that isn't followed: where its bytes lie is not known any more. */
void resources_forget_sparse(struct resources *resources, VkBuffer handle);

/* Acceleration structures. */
void resources_add_accel(struct resources *resources, VkAccelerationStructureKHR handle,
                         const VkAccelerationStructureCreateInfoKHR *create_info);
/* Created over an address range (vkCreateAccelerationStructure2KHR). */
void resources_add_accel_at(struct resources *resources, VkAccelerationStructureKHR handle,
                            const VkAccelerationStructureCreateInfo2KHR *create_info);
/* Returns the id that the structure had, or 0. */
uint64_t resources_remove_accel(struct resources *resources, VkAccelerationStructureKHR handle);

/* The address that instances refer to a structure by; 0: it isn't known yet. Of every structure, or
 * of none. */
void resources_set_accel_address(struct resources *resources, VkAccelerationStructureKHR handle,
                                 VkDeviceAddress address);
/* What an instance with that reference, not 0, refers to. What has died since
 * resources_destroy_count was `deaths` may still have been alive for who refers to it: of that
 * nothing is said. Takes the lock itself. */
void resources_find_referenced(struct resources *resources, VkDeviceAddress address,
                               uint64_t destroy_count, struct accel_facts *facts);

/* Micromaps of VK_EXT_opacity_micromap (resources_micromap.c). */
void resources_add_micromap(struct resources *resources, VkMicromapEXT handle,
                            VkMicromapTypeEXT type);
/* Returns the id that the micromap had, or 0. */
uint64_t resources_remove_micromap(struct resources *resources, VkMicromapEXT handle);
/* Takes the lock itself. */
void resources_find_micromap(struct resources *resources, VkMicromapEXT handle,
                             struct micromap_facts *facts);

/* Structures of VK_NV_ray_tracing. Takes over the reference to what it was created for. */
void resources_add_nv_accel(struct resources *resources, VkAccelerationStructureNV handle,
                            struct nv_shape *created, const struct nv_size_facts *sizes);
/* Returns the id that the structure had, or 0. */
uint64_t resources_remove_nv_accel(struct resources *resources, VkAccelerationStructureNV handle);
/* As for buffers. */
void resources_bind_nv_accel(struct resources *resources, VkAccelerationStructureNV handle,
                             VkDeviceMemory memory, VkDeviceSize offset, bool instances_differ);
/* What vkGetAccelerationStructureHandleNV has said of a structure. */
void resources_add_nv_reference(struct resources *resources, VkAccelerationStructureNV handle,
                                uint64_t reference);
/* Whether any structure has or had that reference, which isn't 0. A structure that was destroyed
 * after `deaths` (see resources_find_referenced) counts as alive. Takes the lock itself. */
enum nv_reference {
    NV_REFERENCE_UNKNOWN,
    NV_REFERENCE_BOTTOM_LEVEL,
    NV_REFERENCE_TOP_LEVEL, /* of a structure that is alive, or was destroyed */
    NV_REFERENCE_DESTROYED, /* of a structure that was destroyed, and not top-level */
    NV_REFERENCE_OF_NOBODY
};
enum nv_reference resources_find_nv_reference(struct resources *resources, uint64_t reference,
                                              uint64_t destroy_count);
void resources_forget_nv_binding(struct resources *resources, VkAccelerationStructureNV handle);

/* Look-ups. Between begin and end the caller calls nothing but the four below, and no lock of
 * another module. `begin` returns what `end` wants. */
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

/* Look-ups of one thing that take the lock themselves. */
void resources_look_up_accel(struct resources *resources, VkAccelerationStructureKHR handle,
                             struct accel_facts *facts);
void resources_look_up_address(struct resources *resources, VkDeviceAddress address,
                               struct address_facts *facts);
void resources_ask_buffer(struct resources *resources, VkBuffer handle, struct buffer_facts *facts);
void resources_ask_nv_accel(struct resources *resources, VkAccelerationStructureNV handle,
                            struct nv_accel_facts *facts);

/* Look-ups to be answered together. */
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

/* Answers them, faster than one by one: records that are not in the processor's cache are fetched
 * together. Takes the lock itself. */
void resources_find_all(struct resources *resources, const struct resource_queries *queries);

/* Whether all of the bytes lie in live memory for who follows a clock. NO: `missing` gets the first
 * that don't. Takes the lock itself. */
enum tristate resources_sparse_backing(struct resources *resources,
                                       const struct sparse_bytes *bytes,
                                       const struct execution_clock *clock,
                                       struct sparse_bytes *missing);
/* Where they lie, piece by piece, as far as that is certain. Takes the lock itself; `visit` must
 * not call back. */
void resources_find_pieces(struct resources *resources, const struct sparse_bytes *bytes,
                           const struct execution_clock *clock,
                           void (*visit)(void *user, const struct memory_span *piece), void *user);

/* Where device addresses lead to bound memory: ranges that don't touch each other, in ascending
 * order; without those of sparse and of protected buffers. Takes the lock itself; `visit` must not
 * call back. */
void resources_find_ranges(struct resources *resources,
                           void (*visit)(void *user, uint64_t begin, uint64_t end), void *user);

/* How many bytes at a device address, `size` at most, an unprotected command can read that executes
 * after all that `clock` has. 0 if that is not known. Of a sparse buffer it is all of them or none.
 * Takes the lock itself. */
uint64_t resources_find_readable(struct resources *resources, VkDeviceAddress address,
                                 uint64_t size, const struct execution_clock *clock);

/* What the bytes at a host address are, piece by piece: bytes of mapped memory, or of
 * memory_of_host(). Takes the lock itself; `visit` must not call back. */
void resources_find_host_pieces(struct resources *resources, const void *pointer, VkDeviceSize size,
                                void (*visit)(void *user, const struct memory_span *piece),
                                void *user);

/* The bytes at a device address where the host has them mapped, as it wrote them: of coherent
 * memory, and of a buffer that isn't sparse. Returns how many, `size` at most; they stay as long as
 * the mapping. Takes the lock itself. */
uint64_t resources_find_mapped(struct resources *resources, VkDeviceAddress address, uint64_t size,
                               const void **bytes);

/* How many records have died so far; while it stays, all that was found alive still is. */
uint64_t resources_destroy_count(struct resources *resources);

/* The id of a thing that the device has by that handle, or 0; takes the lock itself. */
enum resource_kind { RESOURCE_ACCEL, RESOURCE_ACCEL_NV, RESOURCE_BUFFER, RESOURCE_MICROMAP };
uint64_t resources_find_id(struct resources *resources, enum resource_kind kind, uint64_t handle);

#endif
