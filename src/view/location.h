/* SPDX-License-Identifier: Apache-2.0 */
/* The location of a finding within a build call. */
#ifndef ASSAY_VIEW_LOCATION_H
#define ASSAY_VIEW_LOCATION_H

#include <stdbool.h>
#include <stdint.h>

#include "vuid-tables/rules.h"

enum subject {
    SUBJECT_CALL,
    SUBJECT_PARAMETER, /* of COMMAND_NV, whose calls make one build */
    SUBJECT_BUILD,
    SUBJECT_GEOMETRY,
    SUBJECT_RANGE,
    SUBJECT_ELEMENT,  /* an element of another array of the call that has one element per build */
    SUBJECT_ARGUMENT, /* of a command that builds no structures */
};

struct location {
    enum build_command command;
    enum subject subject;
    uint32_t build, geometry;
    bool geometry_by_pointer; /* ppGeometries[j]-> instead of pGeometries[j]. */
    /* SUBJECT_ARGUMENT: the parameter, or NULL for the parameters themselves. If `is_element`, the
     * element of index `build` of the array; otherwise what the parameter points to. `geometry` is
     * the index that stands for [] in the field. */
    bool is_element;
    const char *argument;
};

static inline bool location_is_of_build(const struct location *location)
{
    return location->subject != SUBJECT_CALL && location->subject != SUBJECT_ARGUMENT;
}

#endif
