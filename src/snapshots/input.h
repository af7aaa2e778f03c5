/* SPDX-License-Identifier: Apache-2.0 */
/* The input that a build gives to the builder. */
#ifndef ASSAY_SNAPSHOTS_INPUT_H
#define ASSAY_SNAPSHOTS_INPUT_H

#include "src/bvh/micromap.h"
#include "src/snapshots/build_parameters.h"
#include "src/snapshots/memory.h"

/* The input with its data, as far as that can be read now. Sizes exclude what cannot be read, so
 * that the builder finds it out of range. The caller fills in resolvers and threads. */
struct build_input {
    struct builder_input input;
    struct builder_geometry *geometries;        /* owned */
    struct builder_opacity *opacities;          /* owned; NULL: no geometry has opacity */
    struct builder_displacement *displacements; /* owned; NULL: no geometry has displacement */
    struct input_memory memory;                 /* resolves arrays of pointers */
    bool is_micromap;                           /* only `micromap` is built */
    struct micromap_input micromap;
};

#endif
