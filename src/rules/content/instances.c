/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about VkAccelerationStructureInstanceKHR, and about the structures that instances of any
 * kind refer to. */
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/enabled.h"
#include "src/view/names.h"

static const struct device_facts *device_of(const struct instance_view *view)
{
    return view->geometry->build->call->device;
}

/* Says what the data looks like, if it is not what the build reads. */
__attribute__((cold, noinline)) static bool remarks_on_look(struct finding *finding,
                                                            const struct data_look *look)
{
    switch (look->kind) {
    case LOOKS_LIKE_INSTANCES:
        return remarks_plainly(finding,
                               "These bytes look like instances, not like pointers to them: "
                               "arrayOfPointers is VK_TRUE");
    case LOOKS_LIKE_POINTERS:
        return remarks_plainly(finding,
                               "These bytes look like pointers to instances, not like "
                               "instances: arrayOfPointers is VK_FALSE");
    case LOOKS_STRIDED:
        return remarks(finding,
                       "These bytes look like instances that are {} apart; a build reads instances "
                       "that are 64 bytes apart",
                       count_of(look->stride, "byte"));
    case LOOKS_UNWRITTEN:
        return remarks_plainly(finding,
                               "The buffer does not look written there: write all "
                               "instances that primitiveCount counts");
    case LOOKS_AS_ASKED:
        break;
    }
    return false;
}

/* Instances with motion have their own rule about flags, and so have the flag bits of micromaps. */
bool instance_flags_are_valid(const struct instance_view *instance, struct finding *finding)
{
    const struct device_facts *device = device_of(instance);
    VkGeometryInstanceFlagsKHR flags = instance->instance.flags;
    VkGeometryInstanceFlagsKHR unknown =
        flags & ~instance_flags_enabled(device) & ~micromap_instance_flags;
    return !unknown || instance->has_motion || device->newer_than_registry ||
           violated(finding, content_field(instance->geometry, INPUT_INSTANCES),
                    "leads to instance {}, whose flags {} have bits {}, which "
                    "VkGeometryInstanceFlagBitsKHR does not define",
                    number(instance->index), instance_flags(flags), hex(unknown)) ||
           remarks_on_look(finding, &instance->look);
}

bool instance_micromap_flags_have_their_feature(const struct instance_view *instance,
                                                struct finding *finding)
{
    const struct device_facts *device = device_of(instance);
    VkGeometryInstanceFlagsKHR flags = instance->instance.flags & micromap_instance_flags;
    return !flags || device->micromap.ext || device->micromap.khr || device->newer_than_registry ||
           violated(finding, content_field(instance->geometry, INPUT_INSTANCES),
                    "leads to instance {}, whose flags {} have the micromap bits {}, but the "
                    "feature micromap is not enabled",
                    number(instance->index), instance_flags(instance->instance.flags), hex(flags));
}

static bool may_disable_micromaps(const struct instance_view *instance, struct finding *finding)
{
    return instance->allows_disabling != NO ||
           violated(finding, content_field(instance->geometry, INPUT_INSTANCES),
                    "leads to instance {}, whose flags {} disable micromaps, but {} was built "
                    "without VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT",
                    number(instance->index), instance_flags(instance->instance.flags),
                    object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                           handle_number(instance->referenced->handle)));
}

/* The registry has this valid usage for the instance and for the commands that read instances from
 * buffers, whose message names both ids. */
bool instance_disables_micromaps_only_if_its_blas_allows(const struct instance_view *instance,
                                                         struct finding *finding)
{
    return may_disable_micromaps(instance, finding) ||
           is_reported_with(finding, RULE_instances_disable_micromaps_only_if_their_blas_allows);
}

bool instances_disable_micromaps_only_if_their_blas_allows(const struct instance_view *instance,
                                                           struct finding *finding)
{
    return may_disable_micromaps(instance, finding) ||
           also_violates(finding, RULE_instance_disables_micromaps_only_if_its_blas_allows);
}

static struct value accel(VkAccelerationStructureKHR handle)
{
    return object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, handle_number(handle));
}

__attribute__((cold, noinline)) static bool
shows_what_was_written(const VkAccelerationStructureInstanceKHR *instance,
                       const struct data_look *look, struct finding *finding)
{
    return shows_instance(finding, instance) || remarks_on_look(finding, look);
}

/* An instance without a structure is valid and inactive. Instances with motion have their own
 * rule. */
bool instance_references_are_valid_handles(const struct instance_view *instance,
                                           struct finding *finding)
{
    const struct accel_facts *referenced = instance->referenced;
    const uint64_t reference = handle_number(referenced->handle);
    if (instance->has_motion || !referenced->handle || referenced->alive != NO)
        return true;
    if (instance->confused)
        return violated(finding, content_field(instance->geometry, INPUT_INSTANCES),
                        "leads to instance {}, whose accelerationStructureReference {} is not an "
                        "acceleration structure of this device, but the device address of {}",
                        number(instance->index), hex(reference), accel(instance->confused));
    return violated(finding, content_field(instance->geometry, INPUT_INSTANCES),
                    "leads to instance {}, whose accelerationStructureReference {} is not an "
                    "acceleration structure of this device: it was destroyed or never created",
                    number(instance->index),
                    destroyed_object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, reference, 0)) ||
           shows_what_was_written(&instance->instance, &instance->look, finding);
}

/* An instance with reference 0 is inactive. */
bool nv_instance_references_are_blas_handles(const struct nv_instance_view *nv_instance,
                                             struct finding *finding)
{
    enum nv_reference refers_to = nv_instance->refers_to;
    return (refers_to != NV_REFERENCE_TOP_LEVEL && refers_to != NV_REFERENCE_INVALID) ||
           violated(
               finding, "instanceData",
               "leads to instance {}, whose accelerationStructureReference {} {}",
               number(nv_instance->index), hex(nv_instance->reference),
               phrase(refers_to == NV_REFERENCE_TOP_LEVEL ? "is the handle of a top-level structure"
                      : nv_instance->is_handle
                          ? "is a VkAccelerationStructureNV, not the value that "
                            "vkGetAccelerationStructureHandleNV returns for it"
                          : "is not a value that vkGetAccelerationStructureHandleNV returned for "
                            "a live structure")) ||
           (refers_to == NV_REFERENCE_INVALID && !nv_instance->is_handle &&
            shows_what_was_written(nv_instance->instance, &nv_instance->look, finding));
}

bool nv_instance_references_are_of_live_structures(const struct nv_instance_view *nv_instance,
                                                   struct finding *finding)
{
    return nv_instance->refers_to != NV_REFERENCE_DESTROYED ||
           violated(finding, "instanceData",
                    "leads to instance {}, whose accelerationStructureReference {} was returned by "
                    "vkGetAccelerationStructureHandleNV for a structure that was destroyed before "
                    "the build was submitted",
                    number(nv_instance->index), hex(nv_instance->reference));
}

/* Micromaps are VkAccelerationStructureKHR, too. A generic structure may have been built as a
 * BLAS. */
static bool is_not_a_blas(const struct accel_facts *referenced)
{
    return referenced->alive == YES && referenced->details_known &&
           referenced->type != VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR &&
           referenced->type != VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR;
}

bool instance_references_are_zero_or_a_blas(const struct instance_view *instance,
                                            struct finding *finding)
{
    const struct accel_facts *referenced = instance->referenced;
    uint64_t reference = instance->instance.accelerationStructureReference;
    if (!reference || device_of(instance)->newer_than_registry || instance->may_be_placed)
        return true;
    /* A bottom-level structure of clusters may lie in the memory of another structure. */
    if (is_not_a_blas(referenced) && !device_of(instance)->clusters.feature)
        return violated(finding, content_field(instance->geometry, INPUT_INSTANCES),
                        "leads to instance {}, whose accelerationStructureReference {} is the "
                        "address of {}, which is not a bottom-level acceleration structure",
                        number(instance->index), hex(reference), accel(referenced->handle));
    if (referenced->alive == NO && instance->confused)
        return violated(finding, content_field(instance->geometry, INPUT_INSTANCES),
                        "leads to instance {}, whose accelerationStructureReference {} is not the "
                        "address of an acceleration structure of this device, but the handle of {}",
                        number(instance->index), hex(reference), accel(instance->confused));
    return referenced->alive != NO ||
           violated(finding, content_field(instance->geometry, INPUT_INSTANCES),
                    "leads to instance {}, whose accelerationStructureReference {} is not the "
                    "address of an acceleration structure of this device",
                    number(instance->index),
                    address_of_missing(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, reference)) ||
           shows_what_was_written(&instance->instance, &instance->look, finding);
}

/* ---- pointers to instances */

bool instance_pointers_lead_to_memory(const struct instance_pointer_view *instance_pointer,
                                      struct finding *finding)
{
    const char *field = content_field(instance_pointer->geometry, INPUT_INSTANCES);
    const struct value index = number(instance_pointer->index);
    const uint64_t address = instance_pointer->address;
    if (!instance_pointer->leads_nowhere)
        return true;
    return (!address ? violated(finding, field, "leads to pointer {}, which is 0", index)
            : instance_pointer->is_host
                ? violated(finding, field,
                           "leads to pointer {}, whose value {} does not point to host memory",
                           index, hex(address))
                : violated(finding, field, "leads to pointer {}, whose value {} is in no buffer",
                           index, address_of_missing(VK_OBJECT_TYPE_BUFFER, address))) ||
           remarks_on_look(finding, &instance_pointer->look);
}

bool instances_behind_pointers_are_aligned(const struct instance_pointer_view *instance_pointer,
                                           struct finding *finding)
{
    return instance_pointer->address % 16 == 0 ||
           violated(finding, content_field(instance_pointer->geometry, INPUT_INSTANCES),
                    "leads to pointer {}, whose value {} is not a multiple of 16",
                    number(instance_pointer->index), hex(instance_pointer->address)) ||
           remarks_on_look(finding, &instance_pointer->look);
}

/* ---- structures that instances refer to */

static struct value structure(const struct reference_view *reference)
{
    return object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                  handle_number(reference->referenced->handle));
}

static struct value buffer(const struct reference_view *reference)
{
    return object(VK_OBJECT_TYPE_BUFFER, handle_number(reference->referenced->buffer));
}

#define REFERS_TO "leads to instance {}, which refers to {}, "

bool instances_are_backed_by_memory(const struct reference_view *reference, struct finding *finding)
{
    if (reference->referenced->backed != NO)
        return true;
    const struct holding_buffer held_by = holding_buffer_of_accel(reference->referenced);
    return violated(finding, content_field(reference->geometry, INPUT_INSTANCES),
                    REFERS_TO "which lies in {}, {}", number(reference->instance),
                    structure(reference), held_by.value, phrase(held_by.lacks));
}

bool instances_are_host_visible(const struct reference_view *reference, struct finding *finding)
{
    return reference->referenced->host_visible != NO ||
           violated(finding, content_field(reference->geometry, INPUT_INSTANCES),
                    REFERS_TO
                    "whose {} is bound to memory without "
                    "VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT",
                    number(reference->instance), structure(reference), buffer(reference));
}

bool instances_have_one_memory_instance(const struct reference_view *reference,
                                        struct finding *finding)
{
    return reference->referenced->multi_instance != YES ||
           violated(finding, content_field(reference->geometry, INPUT_INSTANCES),
                    REFERS_TO
                    "whose {} is bound to memory that was allocated with multiple instances",
                    number(reference->instance), structure(reference), buffer(reference));
}

bool instances_refer_to_built_structures(const struct unbuilt_view *unbuilt,
                                         struct finding *finding)
{
    return !unbuilt->structure_count ||
           violated(finding, content_field(unbuilt->geometry, INPUT_INSTANCES),
                    "leads to instance {}, which refers to {}. That structure {}. References of "
                    "this kind: {}, {}",
                    number(unbuilt->first), accel(unbuilt->referenced->handle),
                    phrase(unbuilt->is_built_later ? "was first built after this build"
                                                   : "was never built"),
                    count_of(unbuilt->instance_count, "instance"),
                    count_of(unbuilt->structure_count, "structure"));
}

bool instances_were_created_with_a_buffer(const struct reference_view *reference,
                                          struct finding *finding)
{
    return !reference->referenced->by_address ||
           violated(finding, content_field(reference->geometry, INPUT_INSTANCES),
                    REFERS_TO
                    "which was created with vkCreateAccelerationStructure2KHR, not "
                    "vkCreateAccelerationStructureKHR",
                    number(reference->instance), structure(reference));
}
