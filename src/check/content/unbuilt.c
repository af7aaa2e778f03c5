/* SPDX-License-Identifier: Apache-2.0 */
/* Finds structures without contents, and makes one view of those that a build refers to. */
#include "src/check/content/unbuilt.h"

#include <stdlib.h>

#include "src/base/array.h"
#include "src/check/walk/rows.h"
#include "src/state/builds/structures.h"

/* External memory may hold what another device has built, and memory that is bound to a sparse
 * buffer what was built through another one. Other rules are about structures without memory, and
 * about top-level structures. */
static bool may_have_contents(const struct accel_facts *referenced)
{
    return referenced->is_external || referenced->is_sparse || referenced->backed == NO ||
           (referenced->type != VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR &&
            referenced->type != VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR);
}

/* A structure that was destroyed meanwhile may have lost its record, so it is looked up last, if no
 * record shows that it was written. */
static enum structure_written find_written(const struct walk *walk,
                                           const struct accel_facts *referenced)
{
    const struct check_context *context = walk->context;
    if (may_have_contents(referenced))
        return WRITTEN_PERHAPS;
    const enum structure_written written =
        structures_were_written(context->structures, referenced->id, walk->point);
    if (written == WRITTEN_PERHAPS)
        return written;
    const uint64_t id =
        resources_find_id(context->resources, RESOURCE_ACCEL, handle_number(referenced->handle));
    return id == referenced->id ? written : WRITTEN_PERHAPS;
}

void unbuilt_uses_add(struct unbuilt_uses *unbuilt, const struct walk *walk,
                      const struct build_view *build, const struct instance_uses *uses)
{
    if (build->geometry_count != 1 || build->call->device->newer_than_registry ||
        places_are_used(walk->context->places, PLACE_BOTTOM_LEVEL))
        return;
    for (uint32_t i = 0; i < uses->count; i++) {
        const enum structure_written written = find_written(walk, &uses->items[i].referenced);
        if (written == WRITTEN_PERHAPS || !uses->items[i].count ||
            !ARRAY_HAS_ROOM(unbuilt->items, unbuilt->count, unbuilt->capacity))
            continue;
        unbuilt->items[unbuilt->count++] = (struct unbuilt_use){
            .build = build->index,
            .use = uses->items[i],
            .is_built_later = written == WRITTEN_LATER,
            .geometry = build->geometries,
            .info = build->info,
        };
    }
}

static void add_to_view(struct unbuilt_view *view, const struct unbuilt_use *unbuilt)
{
    if (!view->structure_count++ || unbuilt->use.first < view->first) {
        view->first = unbuilt->use.first;
        view->referenced = &unbuilt->use.referenced;
        view->is_built_later = unbuilt->is_built_later;
    }
    view->instance_count += unbuilt->use.count;
}

static WALK_ALL(unbuilt)

    void unbuilt_uses_check(struct unbuilt_uses *unbuilt, struct walk *walk,
                            const struct call_view *call,
                            bool (*is_built)(void *context, uint64_t id), void *context)
{
    for (uint32_t i = 0; i < unbuilt->count;) {
        const struct unbuilt_use *first = &unbuilt->items[i];
        const struct build_view build = {
            .call = call, .index = first->build, .info = first->info, .geometry_count = 1};
        const struct geometry_view geometry = {.build = &build, .geometry = first->geometry};
        struct unbuilt_view view = {.geometry = &geometry};
        for (; i < unbuilt->count && unbuilt->items[i].build == first->build; i++)
            if (!is_built(context, unbuilt->items[i].use.referenced.id))
                add_to_view(&view, &unbuilt->items[i]);
        const struct location location = walk_location(&geometry, SUBJECT_GEOMETRY);
        walk_unbuilt(walk, &view, &location);
    }
    free(unbuilt->items);
    *unbuilt = (struct unbuilt_uses){0};
}
