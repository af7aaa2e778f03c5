/* SPDX-License-Identifier: Apache-2.0 */
/* Setting advice: judges the input data of one build while content_check_geometry() reads it. Only
 * legal data: other rules report what is invalid. */
#ifndef ASSAY_CHECK_CONTENT_ADVICE_H
#define ASSAY_CHECK_CONTENT_ADVICE_H

#include "src/check/content/content.h"
#include "src/figures/instances.h"
#include "src/figures/layouts.h"
#include "src/state/builds/structures.h"
#include "src/view/finding.h"
#include "vuid-tables/advice.h"

/* What was found of a build. */
struct content_advice {
    const struct advice_limits *limits;
    uint32_t number;                    /* of the structure's builds and updates, from 1 on */
    struct structure_contents contents; /* of all geometries so far */
    uint32_t geometry_count;            /* that were read */
    bool is_unknown;                    /* not all their primitives could be judged */
    bool has_unknown_box;               /* contents.box is not around all of them */
    struct kept_advice {
        uint64_t weight; /* 0: none was kept */
        struct finding finding;
    } kept[ADVICE_COUNT];              /* of the geometry that weighs most */
    struct instance_figures instances; /* of the geometry that is read */
    struct vertex_layouts layouts;     /* of the geometries before it */
    /* The boxes of the structures that instances refer to, in the order of `instance_uses`. */
    struct known_box {
        bool was_looked_up, is_known;
        struct figure_box box;
    } * boxes;
    uint32_t box_count, box_capacity;
    /* The samples of the largest geometry that the build updates; NULL if there is none. */
    struct refit {
        uint32_t geometry;
        struct triangle_sample *built, *now;
    } refit;
};

/* Call before the instances of a geometry are read, and for each of them. */
void content_advise_begin(struct content *content);
void content_advise_instance(struct content *content,
                             const VkAccelerationStructureInstanceKHR *instance);
/* Judges a geometry that was read. */
void content_advise(struct content *content);
/* Judges the build, which has so many geometries. Returns whether all its primitives are known. */
bool content_advice_end(struct content_advice *advice, uint32_t geometry_count);
void content_advice_free(struct content_advice *advice);

#endif
