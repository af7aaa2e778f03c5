/* SPDX-License-Identifier: Apache-2.0 */
/* Expands the rows to chains of comparisons. */
#include "src/check/walk/fast_path.h"

#include "rows_by_subject.h"
#include "src/base/recording_path.h"
#include "src/rules/predicates.h"
#include "src/view/geometry_data.h"

/* Leaves the chain if a row of the level and the command is violated. */
#define PASS(name, row_level, view, same_shape)                                                    \
    if (LEVEL_##row_level == level && COMMANDS_OF_##name & 1 << COMMAND_DEVICE &&                  \
        !(same_shape && READS_SHAPE_##row_level) && !name(view, NULL))                             \
        return false;
#define ROWS_PASS static inline __attribute__((always_inline)) bool

ROWS_PASS call_rows_pass(const struct call_view *call, enum level level)
{
    ROWS_OF_call(PASS, call, false);
    return true;
}

ROWS_PASS build_rows_pass(const struct build_view *build, enum level level, bool same_shape)
{
    ROWS_OF_build(PASS, build, same_shape);
    return true;
}

ROWS_PASS geometry_rows_pass(const struct geometry_view *geometry, enum level level,
                             bool same_shape)
{
    ROWS_OF_geometry(PASS, geometry, same_shape);
    return true;
}

ROWS_PASS range_rows_pass(const struct range_view *range, enum level level)
{
    ROWS_OF_range(PASS, range, false);
    return true;
}

ROWS_PASS address_rows_pass(const struct address_view *address)
{
    const enum level level = LEVEL_STATE;
    ROWS_OF_address(PASS, address, false);
    return true;
}

/* Evaluates one address of a geometry. */
ROWS_PASS input_passes(const struct geometry_view *geometry, enum input_role role,
                       const struct address_facts *facts)
{
    const struct address_view address = {
        .build = geometry->build, .geometry = geometry, .role = role, .facts = facts};
    return address_rows_pass(&address);
}

ROWS_PASS geometry_addresses_pass(const struct geometry_view *geometry)
{
    const struct chained_inputs *chained = geometry->chained;
    for (uint32_t i = 0; chained && i < chained->count; i++)
        if (!input_passes(geometry, chained->items[i].role, &chained->items[i].facts))
            return false;
    return input_passes(geometry, INPUT_VERTEX, &geometry->vertex) &&
           input_passes(geometry, INPUT_INDEX, &geometry->index_data) &&
           input_passes(geometry, INPUT_TRANSFORM, &geometry->transform) &&
           input_passes(geometry, data_role(geometry), &geometry->data);
}

ROWS_PASS scratch_address_passes(const struct build_view *build)
{
    const struct address_view address = {
        .build = build, .role = INPUT_SCRATCH, .facts = &build->scratch};
    return address_rows_pass(&address);
}

static bool is_device_build(const struct call_view *call)
{
    return call->command == COMMAND_DEVICE;
}

ON_RECORDING_PATH __attribute__((flatten)) bool call_passes(const struct call_view *call)
{
    return is_device_build(call) && call_rows_pass(call, LEVEL_PARAMETERS) &&
           call_rows_pass(call, LEVEL_STATE);
}

ON_RECORDING_PATH __attribute__((flatten)) bool
build_parameters_pass(const struct build_view *build, bool same_shape)
{
    return is_device_build(build->call) &&
           (same_shape ? build_rows_pass(build, LEVEL_PARAMETERS, true)
                       : build_rows_pass(build, LEVEL_PARAMETERS, false));
}

ON_RECORDING_PATH __attribute__((flatten)) bool build_state_passes(const struct build_view *build)
{
    return is_device_build(build->call) && build_rows_pass(build, LEVEL_STATE, false) &&
           scratch_address_passes(build);
}

ROWS_PASS geometry_and_range_pass(const struct range_view *range, bool has_count, bool with_state,
                                  bool same_shape)
{
    return geometry_rows_pass(range->geometry, LEVEL_PARAMETERS, same_shape) &&
           (!has_count || range_rows_pass(range, LEVEL_PARAMETERS)) &&
           (!with_state || (geometry_rows_pass(range->geometry, LEVEL_STATE, false) &&
                            geometry_addresses_pass(range->geometry) &&
                            (!has_count || range_rows_pass(range, LEVEL_STATE))));
}

/* Most geometries are triangles: a separate chain for them leaves out the rules of other types. */
ON_RECORDING_PATH __attribute__((flatten)) bool
geometry_passes(const struct range_view *range, bool has_count, bool with_state, bool same_shape)
{
    if (!is_device_build(range->geometry->build->call))
        return false;
    if (!triangles_in(range->geometry->geometry))
        return geometry_and_range_pass(range, has_count, with_state, false);
    return same_shape ? geometry_and_range_pass(range, has_count, with_state, true)
                      : geometry_and_range_pass(range, has_count, with_state, false);
}
