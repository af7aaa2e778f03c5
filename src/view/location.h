/* SPDX-License-Identifier: Apache-2.0 */
/* Where in a build call a finding is. */
#ifndef ASSAY_VIEW_LOCATION_H
#define ASSAY_VIEW_LOCATION_H

#include <stdbool.h>
#include <stdint.h>

#include "vuid-tables/rules.h"

enum subject {
    SUBJECT_CALL,
    SUBJECT_PARAMETER, /* of the call, which makes one build: COMMAND_NV */
    SUBJECT_BUILD,
    SUBJECT_GEOMETRY,
    SUBJECT_RANGE,
    SUBJECT_ELEMENT, /* of another array of the call that has one for each build */
};

struct location {
    enum build_command command;
    enum subject subject;
    uint32_t build, geometry;
    bool geometry_by_pointer; /* ppGeometries[j]->, not pGeometries[j]. */
};

#endif
