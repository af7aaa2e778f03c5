/* SPDX-License-Identifier: Apache-2.0 */
/* Adds accesses and barriers to the journal of a command buffer or host command, for setting
 * `hazards` (src/state/commands/hazard_entries.h).
 *
 * An access is recorded only if its bytes are certain to be accessed, and their memory is known: a
 * missing access can only hide a hazard. A barrier whose bytes are unknown counts for all bytes. */
#ifndef ASSAY_LAYER_HAZARDS_RECORDING_H
#define ASSAY_LAYER_HAZARDS_RECORDING_H

#include "layer/intercepts/intercepts.h"
#include "layer/layer.h"
#include "src/hazards/scopes.h"
#include "src/model/formats.h"
#include "src/state/commands/hazard_entries.h"

struct hazard_recording {
    struct layer_device *device;
    struct command_buffer *command_buffer; /* NULL: a host command */
    struct journal *journal;
    struct hazard_entry *command; /* that was begun last; NULL: none, or memory ran out */
};

/* Returns false if nothing is to be recorded: the setting is off, or the handle is invalid. */
bool hazard_recording_start(struct hazard_recording *recording, VkCommandBuffer handle);

/* Begins a command, whose accesses follow. `name` is static text. `site`: NULL unless it builds. */
void hazard_recording_command(struct hazard_recording *recording, const char *name,
                              const struct call_site *site);

/* Starts, and begins a command of the command buffer. Returns as hazard_recording_start(). */
bool hazard_recording_begin(struct hazard_recording *recording, VkCommandBuffer handle,
                            const char *name);

/* Whether there are the parameters of a call that is lowered. NULL: memory ran out for them, so the
 * journal lacks hazards. */
static inline bool hazard_recording_has(struct hazard_recording *recording, const void *lowered)
{
    if (!lowered)
        unknown_set(&recording->journal->accesses_unknown, UNKNOWN_ACCESSES);
    return lowered;
}

/* What accesses bytes, and in which member. */
struct hazard_use {
    enum access_kind kind;
    enum hazard_role role;
    uint32_t info, geometry;
    uint32_t index_size; /* bytes, of HAZARD_INDICES */
};

/* Adds an entry of the use, HAZARD_ACCESS or HAZARD_INDEXED. Returns NULL if memory runs out. */
struct hazard_entry *hazard_recording_add_entry(struct hazard_recording *recording,
                                                enum journal_kind kind,
                                                const struct hazard_use *use);
/* Adds an access to bytes of memory; none if there are no bytes. If the memory is 0, a write counts
 * as one anywhere, and a read is left out. `object`: a handle of that type, 0 if it is unknown. */
void hazard_recording_add(struct hazard_recording *recording, const struct hazard_use *use,
                          VkObjectType type, uint64_t object, const struct hazard_bytes *bytes);

/* Adds an access to bytes that are not known: a trace, or a write anywhere. */
void hazard_recording_add_anywhere(struct hazard_recording *recording,
                                   const struct hazard_use *use);

/* Adds an access to bytes [begin, end) behind an address. */
void hazard_recording_add_address(struct hazard_recording *recording, const struct hazard_use *use,
                                  const struct address_facts *facts, VkDeviceSize begin,
                                  VkDeviceSize end);

/* Adds an access to the first `size` bytes of a structure. */
void hazard_recording_add_accel(struct hazard_recording *recording, const struct hazard_use *use,
                                const struct accel_facts *facts, VkDeviceSize size);
/* Adds an access to all bytes of a structure. */
void hazard_recording_add_nv(struct hazard_recording *recording, const struct hazard_use *use,
                             const struct nv_accel_facts *facts);

/* ---- The places that rows of commands name in READS and WRITES: they add an access. Of serialized
 * data so many bytes are certain: UUIDs of the driver and of the format; of a structure also two
 * sizes and the number of references. */

enum {
    SERIALIZED_MICROMAP = 2 * VK_UUID_SIZE,
    SERIALIZED_ACCEL = 2 * VK_UUID_SIZE + 3 * sizeof(uint64_t)
};

/* Up to the end of the buffer; VK_WHOLE_SIZE: all bytes from `offset` on. */
void hazards_access_buffer(struct hazard_recording *recording, enum access_kind kind,
                           enum hazard_role role, VkBuffer buffer, VkDeviceSize offset,
                           VkDeviceSize size);
void hazards_access_address(struct hazard_recording *recording, enum access_kind kind,
                            enum hazard_role role, VkDeviceAddress address, VkDeviceSize size);
/* What is written behind `size` bytes may be anywhere. */
void hazards_access_serialized(struct hazard_recording *recording, enum access_kind kind,
                               enum hazard_role role, VkDeviceAddress address, VkDeviceSize size);
void hazards_access_host(struct hazard_recording *recording, enum access_kind kind,
                         enum hazard_role role, const void *pointer, uint64_t size);
void hazards_access_accel(struct hazard_recording *recording, enum access_kind kind,
                          enum hazard_role role, VkAccelerationStructureKHR handle);
void hazards_access_nv_accel(struct hazard_recording *recording, enum access_kind kind,
                             enum hazard_role role, VkAccelerationStructureNV handle);
void hazards_access_micromap(struct hazard_recording *recording, enum access_kind kind,
                             enum hazard_role role, VkMicromapEXT handle);

/* ---- Objects that only the hazard check tracks: formats of images, dependencies of render passes,
 * descriptor sets, shader modules and pipelines. Has locks of its own. */

struct hazard_objects;

/* Returns NULL if memory runs out. */
struct hazard_objects *hazard_objects_create(void);
/* Both accept NULL, as all functions here do: no object is known then. */
void hazard_objects_destroy(struct hazard_objects *objects);

/* If memory runs out, the object is unknown. */
void hazard_objects_add_image(struct hazard_objects *objects, VkImage image, VkFormat format);
void hazard_objects_remove_image(struct hazard_objects *objects, VkImage image);
/* Returns VK_FORMAT_UNDEFINED if the image is unknown. */
VkFormat hazard_objects_format(struct hazard_objects *objects, VkImage image);

struct subpass_dependency {
    uint32_t src, dst; /* subpasses, or VK_SUBPASS_EXTERNAL */
    struct dependency dependency;
};

/* Copies the dependencies. */
void hazard_objects_add_render_pass(struct hazard_objects *objects, VkRenderPass render_pass,
                                    const struct subpass_dependency *dependencies, uint32_t count);
void hazard_objects_remove_render_pass(struct hazard_objects *objects, VkRenderPass render_pass);
/* Returns the dependencies, which live until the render pass is destroyed; `*count` of them.
 * Returns NULL if the render pass is unknown. */
const struct subpass_dependency *hazard_objects_dependencies(struct hazard_objects *objects,
                                                             VkRenderPass render_pass,
                                                             uint32_t *count);

/* Both return NULL for NULL. */
struct descriptor_sets;
struct descriptor_sets *hazard_objects_sets(struct hazard_objects *objects);
struct shader_pipelines;
struct shader_pipelines *hazard_objects_pipelines(struct hazard_objects *objects);

/* ---- records what host commands access, and mapped memory behind host addresses */

/* Begins the journal of a host command, which the next host_work_begin() of this thread takes over.
 * Returns false if nothing is to be recorded. */
bool hazards_start_host(struct hazard_recording *recording, struct layer_device *device,
                        const char *name);

/* Adds accesses to the host memory behind a pointer, as far as it is mapped device memory. */
void hazards_add_host(struct hazard_recording *recording, const struct hazard_use *use,
                      const void *pointer, uint64_t size);

/* ---- translates the dependencies of synchronization commands into entries of a journal */

/* A dependency of a render pass, for all bytes. */
void barriers_add_global(struct hazard_recording *recording, const struct dependency *dependency);

/* Adds the access flags of a VkMemoryBarrierAccessFlags3KHR in a chain. */
struct dependency barriers_with_flags_3(struct dependency dependency, const void *chain);

/* All commands before, and all after, with all their accesses. */
struct dependency barriers_full_dependency(void);

#endif
