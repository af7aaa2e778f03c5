/* SPDX-License-Identifier: Apache-2.0 */
/* Judges the input data of one build while content_check_geometry() reads it. Only
 * legal data: other rules report what is invalid. */
#ifndef ASSAY_ADVICE_READING_H
#define ASSAY_ADVICE_READING_H

#include "src/advice/digest.h"
#include "src/advice/figures/instances.h"
#include "src/advice/figures/layouts.h"
#include "src/check/content/content.h"
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

/* The reader of one build. */
struct advice_reading {
    struct build_reader reader;    /* the caller sets end() */
    struct content_advice *advice; /* NULL: it is not judged */
    bool has_digest;
    struct input_digesting digesting; /* if has_digest */
};

/* `limits`: to judge the build by; NULL: it is not judged, nor is it without memory. */
void advice_reading_begin(struct advice_reading *reading, const struct build_parameters *given,
                          const struct advice_limits *limits, uint32_t number, bool wants_digest);
/* Judges the build once all its geometries are read. Returns whether all its primitives are known.
 */
bool advice_reading_end(struct advice_reading *reading, const struct build_parameters *given);
void advice_reading_free(struct advice_reading *reading);

#endif
