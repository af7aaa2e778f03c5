/* SPDX-License-Identifier: Apache-2.0 */
/* Walking the rows of a subject: each active predicate is asked, each finding handed on. */
#ifndef ASSAY_CHECK_WALK_WALK_H
#define ASSAY_CHECK_WALK_WALK_H

#include "src/check/walk/context.h"
#include "src/view/extension_view.h"
#include "src/view/micromap_view.h"

struct execution_point;
struct instance_uses;

/* The state of one check. */
struct walk {
    struct check_context *context;
    const bool *wants; /* RULE_COUNT: the active rules, less those that want no more findings */
    bool fewer[RULE_COUNT]; /* `wants`, where that isn't all of the context's active rules */
    uint32_t findings;
    bool hides_sizes; /* a finding about the build in hand is about what its sizes depend on */
    bool same_shape;  /* what holds of the recent build's shape holds of the build in hand (hold.h),
                       */
    bool passes;      /* and all of its parameters, and its geometries', as far as that was asked */
    struct micromap_uses micromaps;      /* of the build in hand, see check_micromap_build */
    struct build_inputs *inputs;         /* likewise, to be kept; NULL: nothing */
    const struct execution_point *point; /* likewise, when it executed; NULL: it isn't known */
    struct instance_uses *instances;     /* likewise, see check_host_inputs; NULL: none */
};

void walk_start(struct walk *walk, struct check_context *context);
/* Stops asking a rule. */
void walk_stop_rule(struct walk *walk, enum rule rule);
/* Where a geometry, or its build range, is. */
struct location walk_location(const struct geometry_view *geometry, enum subject subject);
/* Hands on a finding, and notes whether more of its rule are wanted. */
__attribute__((cold)) void walk_report(struct walk *walk, enum rule rule, struct location location,
                                       const struct finding *finding);

/* Each walks the rows of its subject at one of the two levels that a call decides. */
void walk_call(struct walk *walk, const struct call_view *call, enum level level);
void walk_build(struct walk *walk, const struct build_view *build, enum level level);
void walk_geometry(struct walk *walk, const struct geometry_view *geometry, enum level level);
void walk_range(struct walk *walk, const struct range_view *range, enum level level);
void walk_address(struct walk *walk, const struct address_view *address, enum level level);
void walk_indirect(struct walk *walk, const struct indirect_view *indirect, enum level level);
void walk_motion_build(struct walk *walk, const struct motion_build_view *motion_build,
                       enum level level);
void walk_motion_triangles(struct walk *walk, const struct motion_triangles_view *motion_triangles,
                           enum level level);
void walk_spheres(struct walk *walk, const struct spheres_view *spheres, enum level level);
void walk_swept_spheres(struct walk *walk, const struct swept_spheres_view *swept_spheres,
                        enum level level);
void walk_dense_build(struct walk *walk, const struct dense_build_view *dense_build,
                      enum level level);
void walk_dense(struct walk *walk, const struct dense_view *dense, enum level level);
void walk_micromap_build(struct walk *walk, const struct micromap_build_view *micromap_build,
                         enum level level);
void walk_micromap_geometry(struct walk *walk,
                            const struct micromap_geometry_view *micromap_geometry,
                            enum level level);
void walk_micromap_data(struct walk *walk, const struct micromap_data_view *micromap_data,
                        enum level level);
void walk_opacity(struct walk *walk, const struct opacity_view *opacity, enum level level);
void walk_opacity_ext(struct walk *walk, const struct opacity_ext_view *opacity_ext,
                      enum level level);
void walk_displacement(struct walk *walk, const struct displacement_view *displacement,
                       enum level level);
void walk_nv_call(struct walk *walk, const struct nv_call_view *nv_call, enum level level);
void walk_nv_info(struct walk *walk, const struct nv_info_view *nv_info, enum level level);
void walk_nv_geometry(struct walk *walk, const struct nv_geometry_view *nv_geometry,
                      enum level level);

/* Each walks all rows of its subject, for a finding at `location`. */
void walk_pair(struct walk *walk, const struct pair_view *pair, const struct location *location);
void walk_update(struct walk *walk, const struct update_view *update,
                 const struct location *location);
void walk_updated_geometry(struct walk *walk, const struct updated_geometry_view *updated_geometry,
                           const struct location *location);
void walk_updated_dense(struct walk *walk, const struct updated_dense_view *updated_dense,
                        const struct location *location);
void walk_updated_micromap(struct walk *walk, const struct updated_micromap_view *updated_micromap,
                           const struct location *location);
void walk_used_micromap(struct walk *walk, const struct used_micromap_view *used_micromap,
                        const struct location *location);

#endif
