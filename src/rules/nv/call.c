/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the parameters of vkCmdBuildAccelerationStructureNV. */
#include "src/rules/nv/objects.h"
#include "src/rules/predicates.h"
#include "src/view/names.h"

bool nv_info_is_readable(const struct nv_call_view *nv_call, struct finding *finding)
{
    return nv_call->info ||
           violated(finding, "pInfo",
                    "{} does not point to a readable VkAccelerationStructureInfoNV",
                    hex((uint64_t)(uintptr_t)nv_call->info_argument));
}

bool nv_update_has_a_source(const struct nv_call_view *nv_call, struct finding *finding)
{
    return !nv_call->update || nv_call->src ||
           violated_plainly(finding, "src", "is VK_NULL_HANDLE, but update is VK_TRUE");
}

/* ---- handles */

static bool is_invalid(const struct nv_accel_facts *accel)
{
    return !accel->handle || (accel->alive == NO && !accel->of_another_device);
}

static bool is_a_structure(const struct nv_accel_facts *accel, struct finding *finding,
                           const char *field)
{
    return !is_invalid(accel) || violated_by_handle(finding, field, nv_structure(accel->handle),
                                                    "a VkAccelerationStructureNV of this device");
}

/* The message about the dst names the id about the src. */
static bool is_in_place(const struct nv_call_view *nv_call)
{
    return nv_call->src && nv_call->src == nv_call->dst;
}

bool nv_dst_is_a_valid_handle(const struct nv_call_view *nv_call, struct finding *finding)
{
    return is_a_structure(&nv_call->dst_facts, finding, "dst") ||
           (is_in_place(nv_call) && also_violates(finding, RULE_nv_src_is_a_valid_handle));
}

bool nv_src_is_a_valid_handle(const struct nv_call_view *nv_call, struct finding *finding)
{
    return !nv_call->src || is_a_structure(&nv_call->src_facts, finding, "src") ||
           (is_in_place(nv_call) && is_reported_with(finding, RULE_nv_dst_is_a_valid_handle));
}

bool nv_scratch_is_a_valid_buffer(const struct nv_call_view *nv_call, struct finding *finding)
{
    return nv_call->scratch ? nv_is_a_buffer(&nv_call->scratch_facts, finding, "scratch")
                            : violated_plainly(finding, "scratch", "is VK_NULL_HANDLE");
}

bool nv_instance_data_is_a_valid_buffer(const struct nv_call_view *nv_call, struct finding *finding)
{
    return nv_is_a_buffer(&nv_call->instance_facts, finding, "instanceData");
}

/* The source is ignored if the build is no update. */
bool nv_objects_share_the_device(const struct nv_call_view *nv_call, struct finding *finding)
{
    const char *says = "{} was created from another VkDevice";
    if (nv_call->dst_facts.of_another_device)
        return violated(finding, "dst", says, nv_structure(nv_call->dst));
    if (nv_call->update && nv_call->src_facts.of_another_device)
        return violated(finding, "src", says, nv_structure(nv_call->src));
    if (nv_call->scratch_facts.of_another_device)
        return violated(finding, "scratch", says, nv_buffer(nv_call->scratch));
    return !nv_call->instance_facts.of_another_device ||
           violated(finding, "instanceData", says, nv_buffer(nv_call->instance_data));
}

/* ---- memory */

static VkDeviceSize larger_of(VkDeviceSize a, VkDeviceSize b)
{
    return a > b ? a : b;
}

bool nv_update_src_and_dst_do_not_alias(const struct nv_call_view *nv_call, struct finding *finding)
{
    const struct memory_span *dst = &nv_call->dst_facts.span, *src = &nv_call->src_facts.span;
    VkDeviceSize begin = larger_of(dst->begin, src->begin), end = smaller_of(dst->end, src->end);
    if (!nv_call->update || nv_call->dst == nv_call->src || !dst->memory ||
        dst->memory != src->memory || begin >= end)
        return true;
    return violated(finding, "dst",
                    "{} shares bytes [{}, {}) of {} with src {}, and is not the same object",
                    nv_structure(nv_call->dst), hex(begin), hex(end),
                    object(VK_OBJECT_TYPE_DEVICE_MEMORY, handle_number(dst->memory)),
                    nv_structure(nv_call->src));
}

bool nv_dst_is_bound_to_memory(const struct nv_call_view *nv_call, struct finding *finding)
{
    const struct nv_accel_facts *dst = &nv_call->dst_facts;
    struct value memory = object(VK_OBJECT_TYPE_DEVICE_MEMORY, handle_number(dst->memory));
    switch (dst->binding) {
    case NV_BINDING_UNKNOWN:
    case NV_BOUND:
        return true;
    case NV_UNBOUND:
        return violated(finding, "dst", "{} is not bound to memory", nv_structure(dst->handle));
    case NV_MEMORY_FREED:
        return violated(finding, "dst", "{} is bound to {}, which was freed",
                        nv_structure(dst->handle), memory);
    case NV_MEMORY_TOO_SMALL:
        break;
    }
    return violated(finding, "dst",
                    "{} needs {}, more than {} has from the offset of the binding on",
                    nv_structure(dst->handle), count_of(dst->sizes.object, "byte"), memory);
}

/* ---- scratch */

/* An offset beyond the end leaves no bytes. */
static bool scratch_is_large_enough(const struct nv_call_view *nv_call, struct finding *finding,
                                    VkDeviceSize needed, const char *type)
{
    const struct buffer_facts *scratch = &nv_call->scratch_facts;
    VkDeviceSize offset = nv_call->scratch_offset;
    if (!nv_call->dst_facts.sizes.known || scratch->alive != YES ||
        (offset <= scratch->size && scratch->size - offset >= needed))
        return true;
    return violated(finding, "scratchOffset",
                    "{} leaves less of {} ({}) than the {} that {} needs ({})", number(offset),
                    nv_buffer(nv_call->scratch), count_of(scratch->size, "byte"),
                    count_of(needed, "byte"), nv_structure(nv_call->dst), phrase(type));
}

bool nv_build_scratch_is_large_enough(const struct nv_call_view *nv_call, struct finding *finding)
{
    return nv_call->update ||
           scratch_is_large_enough(
               nv_call, finding, nv_call->dst_facts.sizes.build_scratch,
               "VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_BUILD_SCRATCH_NV");
}

bool nv_update_scratch_is_large_enough(const struct nv_call_view *nv_call, struct finding *finding)
{
    return !nv_call->update ||
           scratch_is_large_enough(
               nv_call, finding, nv_call->dst_facts.sizes.update_scratch,
               "VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_UPDATE_SCRATCH_NV");
}

static bool has_ray_tracing_usage(const struct buffer_facts *facts, struct finding *finding,
                                  const char *field)
{
    return facts->alive != YES || (facts->usage & VK_BUFFER_USAGE_RAY_TRACING_BIT_NV) ||
           violated(finding, field,
                    "{} was created with usage {}, without VK_BUFFER_USAGE_RAY_TRACING_BIT_NV",
                    nv_buffer(facts->handle), buffer_usage(facts->usage));
}

/* The registry has the valid usage of scratch and instanceData for the command and for
 * VkAccelerationStructureInfoNV. The message about the command names both ids. */

bool nv_scratch_has_ray_tracing_usage(const struct nv_call_view *nv_call, struct finding *finding)
{
    return has_ray_tracing_usage(&nv_call->scratch_facts, finding, "scratch") ||
           also_violates(finding, RULE_nv_info_scratch_has_ray_tracing_usage);
}

bool nv_info_scratch_has_ray_tracing_usage(const struct nv_call_view *nv_call,
                                           struct finding *finding)
{
    return has_ray_tracing_usage(&nv_call->scratch_facts, finding, "scratch") ||
           is_reported_with(finding, RULE_nv_scratch_has_ray_tracing_usage);
}

bool nv_instance_data_has_ray_tracing_usage(const struct nv_call_view *nv_call,
                                            struct finding *finding)
{
    return has_ray_tracing_usage(&nv_call->instance_facts, finding, "instanceData") ||
           also_violates(finding, RULE_nv_info_instance_data_has_ray_tracing_usage);
}

bool nv_info_instance_data_has_ray_tracing_usage(const struct nv_call_view *nv_call,
                                                 struct finding *finding)
{
    return has_ray_tracing_usage(&nv_call->instance_facts, finding, "instanceData") ||
           is_reported_with(finding, RULE_nv_instance_data_has_ray_tracing_usage);
}

/* ---- the create info of dst */

static bool compatible_counts(const struct nv_call_view *nv_call, struct finding *finding,
                              uint32_t index)
{
    const struct nv_counts *created = &nv_call->dst_facts.created->geometries[index];
    struct nv_counts requested = nv_counts_of(&nv_call->geometries[index]);
    const struct {
        const char *noun;
        uint32_t requested, created;
    } counts[] = {{"vertex", requested.vertices, created->vertices},
                  {"index", requested.indices, created->indices},
                  {"AABB", requested.aabbs, created->aabbs}};
    for (int i = 0; i < 3; i++)
        if (counts[i].requested > counts[i].created)
            return violated(finding, "dst",
                            "{} was created for {} in geometry {}, but pInfo has {} there",
                            nv_structure(nv_call->dst), count_of(counts[i].created, counts[i].noun),
                            number(index), count_of(counts[i].requested, counts[i].noun));
    return true;
}

static bool created_for_fewer(const struct nv_call_view *nv_call, struct finding *finding,
                              const char *member, uint32_t created, uint32_t requested)
{
    return violated(finding, "dst", "{} was created with {} {}, less than that of pInfo ({})",
                    nv_structure(nv_call->dst), phrase(member), number(created), number(requested));
}

bool nv_dst_was_created_compatible(const struct nv_call_view *nv_call, struct finding *finding)
{
    const struct nv_shape *created = nv_call->dst_facts.created;
    const VkAccelerationStructureInfoNV *info = nv_call->info;
    if (!created || !info)
        return true;
    if (created->type != info->type)
        return violated(finding, "dst", "{} was created with type {}, but pInfo has {}",
                        nv_structure(nv_call->dst), accel_type(created->type),
                        accel_type(info->type));
    if (created->flags != info->flags)
        return violated(finding, "dst", "{} was created with flags {}, but pInfo has {}",
                        nv_structure(nv_call->dst), build_flags(created->flags),
                        build_flags(info->flags));
    if (created->instance_count < info->instanceCount)
        return created_for_fewer(nv_call, finding, "instanceCount", created->instance_count,
                                 info->instanceCount);
    if (created->geometry_count < info->geometryCount)
        return created_for_fewer(nv_call, finding, "geometryCount", created->geometry_count,
                                 info->geometryCount);
    for (uint32_t i = 0; i < nv_call->geometry_count; i++)
        if (!compatible_counts(nv_call, finding, i))
            return false;
    return true;
}
