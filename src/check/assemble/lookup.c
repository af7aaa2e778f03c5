/* SPDX-License-Identifier: Apache-2.0 */
/* Looks up the handles and addresses of views in the state, in batches. */
#include "src/check/assemble/views.h"
#include "src/model/geometry.h"
#include "src/model/inputs.h"

enum { ACCELS_OF_BUILD = 2, ADDRESSES_OF_BUILD = 1, ADDRESSES_OF_GEOMETRY = 3 };
_Static_assert(VIEWS_MAX *ACCELS_OF_BUILD <= RESOURCE_ACCEL_QUERIES &&
                   VIEWS_MAX * (ADDRESSES_OF_BUILD + ADDRESSES_OF_GEOMETRY) <=
                       RESOURCE_ADDRESS_QUERIES,
               "all of the views are asked for together");

static void queue_accel(struct resource_queries *queries, VkAccelerationStructureKHR accel,
                        struct accel_facts *facts)
{
    if (!accel) {
        *facts = (struct accel_facts){0};
        return;
    }
    queries->accels[queries->accel_count].handle = accel;
    queries->accels[queries->accel_count++].facts = facts;
}

static void queue_address(struct resource_queries *queries, VkDeviceAddress address,
                          struct address_facts *facts)
{
    queries->addresses[queries->address_count].address = address;
    queries->addresses[queries->address_count++].facts = facts;
}

static void queue_build(struct resource_queries *queries, struct build_view *build)
{
    queue_accel(queries, build->info->dstAccelerationStructure, &build->dst);
    queue_accel(queries, build->info->srcAccelerationStructure, &build->src);
    if (build->call->command != COMMAND_HOST)
        queue_address(queries, build->info->scratchData.deviceAddress, &build->scratch);
}

static inline void queue_geometry(struct resource_queries *queries, struct geometry_view *geometry)
{
    const VkAccelerationStructureGeometryKHR *given = geometry->geometry;
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles = triangles_in(given);
    if (geometry->build->call->command == COMMAND_HOST || geometry_is_empty(geometry))
        return;
    if (triangles) {
        queue_address(queries, input_address(given, INPUT_VERTEX), &geometry->vertex);
        if (index_type_size(triangles->indexType))
            queue_address(queries, input_address(given, INPUT_INDEX), &geometry->index_data);
        if (input_address(given, INPUT_MATRIX))
            queue_address(queries, input_address(given, INPUT_MATRIX), &geometry->transform);
    }
    if (aabbs_in(given))
        queue_address(queries, input_address(given, INPUT_AABBS), &geometry->data);
    if (instances_in(given))
        queue_address(queries, input_address(given, INPUT_INSTANCES), &geometry->data);
}

void view_builds_found(struct check_context *context, struct build_view *builds,
                       struct geometry_view *first_geometries, unsigned count)
{
    struct resource_queries queries;
    queries.accel_count = queries.address_count = 0;
    for (unsigned i = 0; i < count; i++) {
        queue_build(&queries, &builds[i]);
        if (builds[i].geometry_count)
            queue_geometry(&queries, &first_geometries[i]);
    }
    resources_find_all(context->resources, &queries);
}

void view_geometry_found(struct check_context *context, struct geometry_view *geometry)
{
    struct resource_queries queries;
    queries.accel_count = queries.address_count = 0;
    queue_geometry(&queries, geometry);
    resources_find_all(context->resources, &queries);
}
