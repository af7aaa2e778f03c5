/* SPDX-License-Identifier: Apache-2.0 */
/* Rules that compare the input data of an update with that of its source. */
#include <string.h>

#include "src/rules/predicates.h"

/* Returns false if the inputs of the update or of the source are unknown, or if they can't be
 * compared. */
static bool find_both(const struct updated_geometry_view *geometry,
                      const struct geometry_inputs **requested,
                      const struct geometry_inputs **source)
{
    *requested = build_inputs_of(built_inputs(geometry->update->requested), geometry->index);
    *source = build_inputs_of(built_inputs(geometry->update->source), geometry->index);
    return *requested && *source && geometry->requested->type == geometry->source->type &&
           (*requested)->primitive_count == (*source)->primitive_count;
}

/* Finds the first primitive that is in `a` and not in `b`. Returns false if there is none. */
static bool find_first(const uint64_t *a, const uint64_t *b, uint32_t count, uint32_t *first)
{
    if (!a || !b)
        return false;
    for (uint32_t word = 0; word <= count / 64; word++) {
        if (!(a[word] & ~b[word]))
            continue;
        *first = word * 64 + (uint32_t)__builtin_ctzll(a[word] & ~b[word]);
        return true;
    }
    return false;
}

static bool changed(const struct updated_geometry_view *geometry, struct finding *finding,
                    const char *says, uint32_t primitive)
{
    const struct update_view *update = geometry->update;
    bool is_nv = update->command == COMMAND_NV;
    bool is_parameter = is_nv && type_is_instances(geometry->requested->type);
    return violated(finding, is_parameter ? "instanceData" : "", says, number(primitive),
                    object(is_nv ? VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV
                                 : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                           update->src),
                    built_at(update->source));
}

bool inactive_primitives_stay_inactive(const struct updated_geometry_view *updated_geometry,
                                       struct finding *finding)
{
    const struct geometry_inputs *requested, *source;
    uint32_t first;
    return !find_both(updated_geometry, &requested, &source) ||
           !find_first(source->inactive, requested->inactive, requested->primitive_count, &first) ||
           changed(updated_geometry, finding,
                   "makes primitive {} active, but the primitive was inactive when {} was last "
                   "built ({})",
                   first);
}

bool active_primitives_stay_active(const struct updated_geometry_view *updated_geometry,
                                   struct finding *finding)
{
    const struct geometry_inputs *requested, *source;
    uint32_t first;
    return !find_both(updated_geometry, &requested, &source) ||
           !find_first(requested->inactive, source->inactive, requested->primitive_count, &first) ||
           changed(updated_geometry, finding,
                   "makes primitive {} inactive, but the primitive was active when {} was last "
                   "built ({})",
                   first);
}

bool index_values_match_source(const struct updated_geometry_view *updated_geometry,
                               struct finding *finding)
{
    const struct geometry_inputs *requested, *source;
    if (!find_both(updated_geometry, &requested, &source) || !requested->indices ||
        !source->indices || requested->indices == source->indices ||
        requested->indices->size != source->indices->size ||
        updated_geometry->requested->index_type != updated_geometry->source->index_type ||
        memcmp(requested->indices->bytes, source->indices->bytes, requested->indices->size) == 0)
        return true;
    uint64_t at = 0;
    while (requested->indices->bytes[at] == source->indices->bytes[at])
        at++;
    uint64_t bytes_each = requested->indices->size / requested->primitive_count;
    return changed(updated_geometry, finding,
                   "gives primitive {} other indices than it had when {} was last built ({})",
                   (uint32_t)(at / bytes_each));
}
