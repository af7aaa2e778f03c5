/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluates the rules of a subject: each active predicate, and reports the findings. A walk is used
 * by one thread and takes no lock. */
#ifndef ASSAY_CHECK_WALK_WALK_H
#define ASSAY_CHECK_WALK_WALK_H

#include "src/check/walk/context.h"
#include "src/view/extension_view.h"
#include "src/view/micromap_view.h"

struct build_reader;
struct execution_point;
struct instance_uses;

/* The state of one check. */
struct walk {
    struct check_context *context;
    const bool *active;         /* [RULE_COUNT]: the active rules, without those that need no more
                                 * findings */
    bool remaining[RULE_COUNT]; /* storage for `active` once it differs from the context's */
    uint32_t findings;
    bool hides_sizes; /* a finding makes the sizes of the current build invalid */
    bool passes;      /* all rules about parameters of the current build and its geometries
                       * evaluated so far hold */
    struct micromap_uses micromaps; /* of the current build, see check_micromap_build */
    struct build_inputs *inputs;    /* inputs of the current build to be retained; or NULL */
    const struct build_inputs *source_inputs; /* of the update's source; NULL: no update, unknown */
    const struct execution_point *point;      /* when the current build executed; NULL: unknown */
    struct instance_uses *instances;          /* structures that its instances refer to, see
                                               * check_host_inputs; NULL: none */
    bool references_are_known;     /* the instances of the last geometry refer to `instances`, or to
                                    * nothing
                                    */
    struct build_reader *readers;  /* of the current build; NULL: none */
    struct chained_inputs chained; /* of the geometry that was checked last, if it has any */
};

/* Starts a walk with all active rules of the context, which must outlive it. */
void walk_start(struct walk *walk, struct check_context *context);
/* Deactivates a rule. */
void walk_stop_rule(struct walk *walk, enum rule rule);
/* Returns the location of a geometry or its build range. */
struct location walk_location(const struct geometry_view *geometry, enum subject subject);
/* Reports a finding, unless the message of another active rule names its id. Deactivates its rule
 * if no more findings are needed. */
__attribute__((cold)) void walk_report(struct walk *walk, enum rule rule, struct location location,
                                       const struct finding *finding);

/* Each evaluates the rows of its subject at LEVEL_PARAMETERS or LEVEL_STATE. */
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

/* Each evaluates all rows of its subject and reports findings at `location`. */
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
