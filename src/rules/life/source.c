/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the source of copies, queries and serializations when they execute. */
#include "src/rules/predicates.h"
#include "src/state/commands/journal.h"
#include "src/view/names.h"

static bool is_query(const struct used_source_view *source)
{
    return source->read->query != VK_QUERY_TYPE_MAX_ENUM;
}

static bool is_micromap(const struct used_source_view *source)
{
    return source->object_type == VK_OBJECT_TYPE_MICROMAP_EXT;
}

static const char *field_of_source(const struct used_source_view *source)
{
    return is_query(source) ? "" : "src";
}

static struct value value_of_source(const struct used_source_view *source)
{
    return object(source->object_type, source->handle);
}

bool source_was_constructed_before(const struct used_source_view *used_source,
                                   struct finding *finding)
{
    return used_source->built->state != BUILT_NEVER ||
           violated(finding, field_of_source(used_source), "{} has never been built",
                    value_of_source(used_source)) ||
           (used_source->object_type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV &&
            also_violates(finding, RULE_nv_source_was_built_before));
}

bool nv_source_was_built_before(const struct used_source_view *used_source, struct finding *finding)
{
    return source_was_constructed_before(used_source, finding) ||
           is_reported_with(finding, RULE_source_was_constructed_before);
}

static bool needs_compaction(const struct journal_read *read)
{
    return read->compacts ||
           read->query == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR ||
           read->query == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV ||
           read->query == VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT;
}

_Static_assert((int)VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR ==
                   (int)VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_NV,
               "flags of both extensions");

/* A compacted copy has the flags of a build that allowed it. */
bool source_allows_compaction(const struct used_source_view *used_source, struct finding *finding)
{
    const struct built *built = used_source->built;
    const char *field = field_of_source(used_source);
    if (!needs_compaction(used_source->read) || built->compacted)
        return true;
    if (is_micromap(used_source))
        return !built->is_micromap || (built->flags & VK_BUILD_MICROMAP_ALLOW_COMPACTION_BIT_EXT) ||
               violated(finding, field,
                        "{} was last built with flags {}, without "
                        "VK_BUILD_MICROMAP_ALLOW_COMPACTION_BIT_EXT",
                        value_of_source(used_source), hex(built->flags));
    return built->state != BUILT_BEFORE ||
           (built->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR) ||
           violated(finding, field,
                    "{} was last built with flags {}, without "
                    "VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR ({})",
                    value_of_source(used_source), build_flags(built->flags), built_at(built));
}

bool referenced_micromaps_were_deserialized(const struct used_source_view *used_source,
                                            struct finding *finding)
{
    return !used_source->micromap ||
           violated(finding, field_of_source(used_source),
                    "{} was deserialized and refers to micromap {}, which was never deserialized",
                    value_of_source(used_source),
                    object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, used_source->micromap));
}

/* ---- the query that the command writes */

bool written_query_is_unavailable(const struct written_query_view *written_query,
                                  struct finding *finding)
{
    return violated(finding, "queryPool", "{} has query {}, which {}",
                    object(VK_OBJECT_TYPE_QUERY_POOL, handle_number(written_query->pool)),
                    number(written_query->number),
                    phrase(written_query->is_available
                               ? "an earlier command wrote and nothing reset since"
                               : "nothing has reset since the pool was created"));
}

/* ---- the size of dst */

static bool has_size(const struct sized_copy_view *copy, VkDeviceSize size, const char *which,
                     struct finding *finding)
{
    return copy->dst_size >= size ||
           violated(finding, "dst", "{} was created with size {}, less than {} src {} ({})",
                    object(copy->object_type, copy->dst), number(copy->dst_size), phrase(which),
                    object(copy->object_type, copy->src), number(size));
}

bool compacting_dst_is_large_enough(const struct sized_copy_view *sized_copy,
                                    struct finding *finding)
{
    return sized_copy->serializes || !sized_copy->compacts ||
           has_size(sized_copy, sized_copy->queried_size, "the queried compacted size of", finding);
}

/* No structure is smaller than its compacted size. */
bool clone_dst_is_large_enough(const struct sized_copy_view *sized_copy, struct finding *finding)
{
    return sized_copy->serializes || sized_copy->compacts ||
           has_size(sized_copy, sized_copy->queried_size,
                    sized_copy->is_full ? "the queried size of" : "the queried compacted size of",
                    finding);
}

/* "dst [...] must have been created with the same parameters as src", but no id says so. */
bool clone_dst_holds_the_build(const struct sized_copy_view *sized_copy, struct finding *finding)
{
    return sized_copy->dst_size < sized_copy->queried_size ||
           has_size(sized_copy, sized_copy->needed_size, "the accelerationStructureSize of",
                    finding);
}

bool serialized_data_fits_the_memory(const struct sized_copy_view *sized_copy,
                                     struct finding *finding)
{
    return !sized_copy->serializes || sized_copy->dst_size >= sized_copy->queried_size ||
           violated(finding, "dst.deviceAddress",
                    "{} is {} before the end of its VkBuffer, less than the queried serialization "
                    "size of src {} ({})",
                    hex(sized_copy->dst), count_of(sized_copy->dst_size, "byte"),
                    object(sized_copy->object_type, sized_copy->src),
                    number(sized_copy->queried_size));
}
