/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about descriptors of structures. */
#include "src/rules/predicates.h"
#include "src/view/names.h"

static bool is_nv(const struct descriptor_view *descriptor)
{
    return descriptor->structure.object_type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV;
}

static bool violated_by(const struct descriptor_view *descriptor, struct finding *finding,
                        const char *says)
{
    const struct life_object *structure = &descriptor->structure;
    return violated(
        finding,
        is_nv(descriptor)
            ? "pNext<VkWriteDescriptorSetAccelerationStructureNV>.pAccelerationStructures[]"
            : "pNext<VkWriteDescriptorSetAccelerationStructureKHR>.pAccelerationStructures[]",
        says, life_object_value(structure),
        accel_type((VkAccelerationStructureTypeKHR)structure->type));
}

_Static_assert((int)VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR ==
                   (int)VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV,
               "types of both extensions");

static bool may_be_top_level(const struct descriptor_view *descriptor, struct finding *finding)
{
    const struct life_object *structure = &descriptor->structure;
    return !structure->details_known ||
           structure->type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR ||
           violated_by(descriptor, finding, "{} was created with type {}, which is not top-level");
}

static bool has_a_structure(const struct descriptor_view *descriptor, struct finding *finding)
{
    return descriptor->structure.handle || descriptor->call->device->null_descriptor ||
           violated_by(descriptor, finding,
                       "is VK_NULL_HANDLE, and the feature nullDescriptor is not enabled");
}

/* A structure of the generic type may have been built as either. */
bool descriptor_is_of_a_top_level(const struct descriptor_view *descriptor, struct finding *finding)
{
    return is_nv(descriptor) ||
           descriptor->structure.type == VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR ||
           may_be_top_level(descriptor, finding);
}

bool nv_descriptor_is_of_a_top_level(const struct descriptor_view *descriptor,
                                     struct finding *finding)
{
    return !is_nv(descriptor) || may_be_top_level(descriptor, finding);
}

bool descriptor_has_a_structure(const struct descriptor_view *descriptor, struct finding *finding)
{
    return is_nv(descriptor) || has_a_structure(descriptor, finding);
}

bool nv_descriptor_has_a_structure(const struct descriptor_view *descriptor,
                                   struct finding *finding)
{
    return !is_nv(descriptor) || has_a_structure(descriptor, finding);
}

/* ---- updates with templates */

bool templated_descriptor_is_a_structure(const struct templated_view *templated,
                                         struct finding *finding)
{
    const struct life_object *structure = &templated->structure;
    if (templated->unreadable)
        return violated(finding, "", "does not point to host memory at byte {}",
                        number(templated->offset));
    if (!structure->handle)
        return templated->call->device->null_descriptor ||
               violated(finding, "",
                        "has VK_NULL_HANDLE at byte {}, and the feature nullDescriptor is not "
                        "enabled",
                        number(templated->offset));
    return structure->alive != NO ||
           violated(finding, "", "has {} at byte {}, which was destroyed or never created",
                    object(structure->object_type, structure->handle), number(templated->offset));
}
