/* SPDX-License-Identifier: Apache-2.0 */
/* The input that a build gives to the builder. */
#ifndef ASSAY_SNAPSHOTS_BUILD_INPUT_H
#define ASSAY_SNAPSHOTS_BUILD_INPUT_H

#include "src/bvh/micromap.h"
#include "src/model/build_parameters.h"
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

VkResult build_input_open(const struct build_parameters *build, const struct input_memory *memory,
                          struct build_input *input);
void build_input_close(struct build_input *input);

/* Fills in type, flags, formats and strides, without data. `chained` may be NULL. */
void build_input_describe(const VkAccelerationStructureGeometryKHR *geometry,
                          const struct chained_input *chained, struct builder_geometry *described);

/* ---- micromap_input.c */

/* Fills in the input of a micromap build. */
void build_input_find_micromap(const struct build_parameters *build,
                               const struct input_memory *memory, struct micromap_input *to);

/* Describes the micromaps of geometries that use them, without data, after the geometries. */
VkResult build_input_describe_micromaps(const struct build_parameters *build,
                                        struct build_input *input);

/* ---- sizes */

/* `counts` may be NULL: the counts of the ranges are used. Writes zeros for geometries that the
 * builder does not support. */
VkResult build_parameters_sizes(const struct build_parameters *build, const uint32_t *counts,
                                struct builder_sizes *sizes);

/* Implements vkGetAccelerationStructureBuildSizesKHR. Also writes zeros if a parameter can't be
 * read, or without memory. */
void cpu_build_sizes(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                     const uint32_t *counts, struct builder_sizes *sizes);

#endif
