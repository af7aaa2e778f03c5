/* SPDX-License-Identifier: Apache-2.0 */
/* Statements about handles that the rules of vkCmdBuildAccelerationStructureNV share. */
#ifndef ASSAY_RULES_NV_OBJECTS_H
#define ASSAY_RULES_NV_OBJECTS_H

#include "src/state/facts.h"
#include "src/view/finding.h"

static inline struct value nv_structure(VkAccelerationStructureNV handle)
{
    return object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV, handle_number(handle));
}

static inline struct value nv_buffer(VkBuffer handle)
{
    return object(VK_OBJECT_TYPE_BUFFER, handle_number(handle));
}

/* Returns true for VK_NULL_HANDLE, too: the callers decide if that is valid. */
static inline bool nv_is_a_buffer(const struct buffer_facts *facts, struct finding *finding,
                                  const char *field)
{
    return facts->alive != NO || facts->of_another_device ||
           violated_by_handle(finding, field, nv_buffer(facts->handle), "a buffer of this device");
}

#endif
