/* SPDX-License-Identifier: Apache-2.0 */
/* What a build gives to the builder. */
#ifndef ASSAY_SNAPSHOTS_INPUT_H
#define ASSAY_SNAPSHOTS_INPUT_H

#include "src/bvh/micromap.h"
#include "src/snapshots/build_parameters.h"
#include "src/snapshots/memory.h"

/* The input with its data, as far as that can be read now; what can't be is left out of the sizes,
 * so that the builder finds it out of range. Resolvers and threads are the caller's to fill in. */
struct build_input {
    struct builder_input input;
    struct builder_geometry *geometries;        /* owned */
    struct builder_opacity *opacities;          /* owned; NULL: no geometry has any */
    struct builder_displacement *displacements; /* likewise */
    struct input_memory memory;                 /* of arrays of pointers */
    bool is_micromap;                           /* then all that is built is: */
    struct micromap_input micromap;
};

#endif
