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
};

/* Call before the instances of a geometry are read, and for each of them. `use`: the structure that
 * it refers to. */
void content_advise_begin(struct content *content);
struct instance_use;
void content_advise_instance(struct content *content, struct instance_use *use,
                             const VkAccelerationStructureInstanceKHR *instance);
/* Judges a geometry that was read. */
void content_advise(struct content *content);
/* Judges the build, which has so many geometries. Returns whether all its primitives are known. */
bool content_advice_end(struct content_advice *advice, uint32_t geometry_count);

#endif
