/* SPDX-License-Identifier: Apache-2.0 */
/* Adds accesses and barriers to the journal of a command buffer or host command, for setting
 * `hazards` (src/state/commands/hazard_entries.h).
 *
 * An access is recorded only if its bytes are certain to be accessed, and their memory is known: a
 * missing access can only hide a hazard. A barrier whose bytes are unknown counts for all bytes. */
#ifndef ASSAY_LAYER_HAZARDS_RECORDING_H
#define ASSAY_LAYER_HAZARDS_RECORDING_H

#include "layer/layer.h"
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

/* What accesses bytes, and in which member. */
struct hazard_use {
    enum access_kind kind;
    enum hazard_role role;
    uint32_t info, geometry;
};

/* Adds an access to bytes of memory; no access if the memory is 0 or there are no bytes. `object`:
 * a handle of that type, 0 if it is unknown. */
void hazard_recording_add(struct hazard_recording *recording, const struct hazard_use *use,
                          VkObjectType type, uint64_t object, const struct hazard_bytes *bytes);

/* Adds an access to bytes [offset, offset + size) of a buffer, up to its end; VK_WHOLE_SIZE: all
 * bytes from `offset` on. */
void hazard_recording_add_buffer(struct hazard_recording *recording, enum access_kind kind,
                                 enum hazard_role role, VkBuffer buffer, VkDeviceSize offset,
                                 VkDeviceSize size);

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

#endif
