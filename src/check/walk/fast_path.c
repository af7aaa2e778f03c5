/* SPDX-License-Identifier: Apache-2.0 */
/* Expands the rows to chains of comparisons. */
#include "src/check/walk/fast_path.h"

#include "rows_by_subject.h"
#include "src/base/recording_path.h"
#include "src/model/geometry.h"
#include "src/rules/predicates.h"

/* Leaves the chain if a row of the level and the command is violated. */
#define PASS(name, row_level, view)                                                                \
    if (LEVEL_##row_level == level && COMMANDS_OF_##name & 1 << COMMAND_DEVICE &&                  \
        !name(view, NULL))                                                                         \
        return false;
#define ROWS_PASS static inline __attribute__((always_inline)) bool

ROWS_PASS call_rows_pass(const struct call_view *call, enum level level)
{
    ROWS_OF_call(PASS, call);
    return true;
}

ROWS_PASS build_rows_pass(const struct build_view *build, enum level level)
{
    ROWS_OF_build(PASS, build);
    return true;
}

ROWS_PASS geometry_rows_pass(const struct geometry_view *geometry, enum level level)
{
    ROWS_OF_geometry(PASS, geometry);
    return true;
}

ROWS_PASS range_rows_pass(const struct range_view *range, enum level level)
{
    ROWS_OF_range(PASS, range);
    return true;
}

ROWS_PASS address_rows_pass(const struct address_view *address)
{
    const enum level level = LEVEL_STATE;
    ROWS_OF_address(PASS, address);
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
           input_passes(geometry, INPUT_MATRIX, &geometry->transform) &&
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
build_parameters_pass(const struct build_view *build)
{
    return is_device_build(build->call) && build_rows_pass(build, LEVEL_PARAMETERS);
}

ON_RECORDING_PATH __attribute__((flatten)) bool build_state_passes(const struct build_view *build)
{
    return is_device_build(build->call) && build_rows_pass(build, LEVEL_STATE) &&
           scratch_address_passes(build);
}

ON_RECORDING_PATH __attribute__((flatten)) bool geometry_passes(const struct range_view *range,
                                                                bool has_count, bool with_state)
{
    return is_device_build(range->geometry->build->call) &&
           geometry_rows_pass(range->geometry, LEVEL_PARAMETERS) &&
           (!has_count || range_rows_pass(range, LEVEL_PARAMETERS)) &&
           (!with_state || (geometry_rows_pass(range->geometry, LEVEL_STATE) &&
                            geometry_addresses_pass(range->geometry) &&
                            (!has_count || range_rows_pass(range, LEVEL_STATE))));
}
