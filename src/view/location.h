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
    SUBJECT_ELEMENT, /* an element of another array of the call that has one element per build */
};

struct location {
    enum build_command command;
    enum subject subject;
    uint32_t build, geometry;
    bool geometry_by_pointer; /* ppGeometries[j]-> instead of pGeometries[j]. */
};

#endif
