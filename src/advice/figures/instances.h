/* SPDX-License-Identifier: Apache-2.0 */
/* Figures of the instances of one geometry without motion.
 *
 * The functions need the environment of src/base/float_environment.h. */
#ifndef ASSAY_ADVICE_FIGURES_INSTANCES_H
#define ASSAY_ADVICE_FIGURES_INSTANCES_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/advice/figures/boxes.h"

struct instance_figures {
    uint64_t count;
    uint64_t inactive; /* their reference is 0 */
    uint64_t masked;   /* others whose mask is 0 */
    /* The other instances: those whose transform is finite and invertible, and those whose
     * transform is finite and singular. */
    uint64_t placed, singular;

    /* Placed instances whose determinant is so small beside its terms that a float loses more than
     * 10 of its 24 bits. Scales do not matter. The first one, and what it loses. */
    uint64_t lossy;
    uint32_t first_lossy;
    double lost_bits;

    /* Placed instances that have the structure, transform, flags and SBT offset of an earlier one,
     * and a mask that overlaps. `twin` is the one that the first of them repeats. None are found if
     * there is no memory, or if there are more than a quarter of a million. */
    uint64_t repeated;
    uint32_t first_repeated, twin;

    /* Placed instances whose transform looks as if it was stored by columns. Sheared: the
     * translation is in the third row. Rotated: the 12 numbers are the columns of a rotation and a
     * scale, and a translation. */
    uint64_t sheared, rotated;
    uint32_t first_sheared, first_rotated;
    uint64_t unmoved;         /* placed, with a translation of 0 */
    float sheared_row[3];     /* of the first sheared one */
    bool sheared_rows_differ; /* not all sheared ones have that row */
    bool is_rotated_freely;   /* a rotated one has no element of 0 in these columns */

    /* Placed instances whose structure has a known box. Others that a ray may hit. */
    struct box_figures boxes;
    uint64_t unboxed;

    struct placements *placements; /* between begin and end */
};

/* The caller adds at most `capacity` instances, then calls instance_figures_end(). `box` is that of
 * the instance's structure; NULL: unknown. */
void instance_figures_begin(struct instance_figures *figures, uint32_t capacity);
void instance_figures_add(struct instance_figures *figures,
                          const VkAccelerationStructureInstanceKHR *instance,
                          const struct figure_box *box);
void instance_figures_end(struct instance_figures *figures);

/* Whether all transforms were certainly stored by columns, and the first such instance. */
bool instances_are_stored_by_columns(const struct instance_figures *figures, uint32_t *first);

#endif
