/* SPDX-License-Identifier: Apache-2.0 */
/* The rows as chains of comparisons: rules.def is included once a subject. */
#include "src/check/walk/hold.h"

#include "rows_by_subject.h"
#include "src/base/recording_path.h"
#include "src/rules/address.h"
#include "src/rules/predicates.h"
#include "src/view/geometry_data.h"

/* Leaves a chain where a row of the level and the command doesn't hold. */
#define HOLD(name, row_level, view, alike)                                                         \
    if (LEVEL_##row_level == level && COMMANDS_OF_##name & 1 << COMMAND_DEVICE &&                  \
        !(alike && READS_SHAPE_##row_level) && !name(view, NULL))                                  \
        return false;
#define ROWS_HOLD static inline __attribute__((always_inline)) bool

#define HOLD_CALL(name, level) HOLD(name, level, call, false)

ROWS_HOLD call_rows_hold(const struct call_view *call, enum level level)
{
    ROWS_OF_call(HOLD_CALL);
    return true;
}

#define HOLD_BUILD(name, level) HOLD(name, level, build, alike)

ROWS_HOLD build_rows_hold(const struct build_view *build, enum level level, bool alike)
{
    ROWS_OF_build(HOLD_BUILD);
    return true;
}

#define HOLD_GEOMETRY(name, level) HOLD(name, level, geometry, alike)

ROWS_HOLD geometry_rows_hold(const struct geometry_view *geometry, enum level level, bool alike)
{
    ROWS_OF_geometry(HOLD_GEOMETRY);
    return true;
}

#define HOLD_RANGE(name, level) HOLD(name, level, range, false)

ROWS_HOLD range_rows_hold(const struct range_view *range, enum level level)
{
    ROWS_OF_range(HOLD_RANGE);
    return true;
}

static bool is_asked(const struct call_view *call)
{
    return call->command == COMMAND_DEVICE;
}

ON_RECORDING_PATH __attribute__((flatten)) bool call_holds(const struct call_view *call)
{
    return is_asked(call) && call_rows_hold(call, LEVEL_PARAMETERS) &&
           call_rows_hold(call, LEVEL_STATE);
}

ON_RECORDING_PATH __attribute__((flatten)) bool
build_parameters_hold(const struct build_view *build, bool alike)
{
    return is_asked(build->call) && (alike ? build_rows_hold(build, LEVEL_PARAMETERS, true)
                                           : build_rows_hold(build, LEVEL_PARAMETERS, false));
}

ON_RECORDING_PATH __attribute__((flatten)) bool build_state_holds(const struct build_view *build)
{
    return is_asked(build->call) && build_rows_hold(build, LEVEL_STATE, false) &&
           scratch_address_holds(build);
}

ROWS_HOLD geometry_and_range_hold(const struct range_view *range, bool has_count, bool with_state,
                                  bool alike)
{
    return geometry_rows_hold(range->geometry, LEVEL_PARAMETERS, alike) &&
           (!has_count || range_rows_hold(range, LEVEL_PARAMETERS)) &&
           (!with_state || (geometry_rows_hold(range->geometry, LEVEL_STATE, false) &&
                            geometry_addresses_hold(range->geometry) &&
                            (!has_count || range_rows_hold(range, LEVEL_STATE))));
}

/* Most geometries are triangles: chains of their own leave out what is asked of others. */
ON_RECORDING_PATH __attribute__((flatten)) bool
geometry_holds(const struct range_view *range, bool has_count, bool with_state, bool alike)
{
    if (!is_asked(range->geometry->build->call))
        return false;
    if (!triangles_in(range->geometry->geometry))
        return geometry_and_range_hold(range, has_count, with_state, false);
    return alike ? geometry_and_range_hold(range, has_count, with_state, true)
                 : geometry_and_range_hold(range, has_count, with_state, false);
}
