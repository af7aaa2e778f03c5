/* SPDX-License-Identifier: Apache-2.0 */
/* assay-scene report: one file for each part of the report. Each part adds its objects to `root`,
 * which becomes the JSON file and, embedded in a page, the HTML file.
 *
 * All that is random comes from fixed seeds, so that the same capture gives the same report but for
 * times. Members whose names begin with "ns", "us" or "ms" are times. */
#ifndef ASSAY_SCENE_REPORT_REPORT_H
#define ASSAY_SCENE_REPORT_REPORT_H

#include <jansson.h>

#include "src/bvh/input/source.h"
#include "src/bvh/trace.h"
#include "src/scene/contents.h"
#include "src/scene/tool.h"

enum {
    REPORT_THREADS = 2,
    REPORT_RAYS = 20000, /* of a set */
    REPORT_PICTURE_WIDTH = 640,
    REPORT_PICTURE_HEIGHT = 400,
};

/* One build of a bottom-level structure, as input of the reference builder: captured rows, one
 * after the other, without indices. */
struct report_mesh {
    uint32_t structure, command;
    uint32_t instances; /* that refer to it */
    uint64_t primitives;
    struct builder_input input; /* owns its geometries and their data */
    struct source *sources;     /* one for each geometry; for triangles and AABBs */
    uint32_t *missing;          /* for each geometry: triangles whose corners are not captured */
    void *tree;
    struct builder_report built;
};

struct camera {
    double eye[3],
        axes[3][3]; /* right, up and forward; the first two reach to the picture's edge */
};

struct report {
    struct capture *capture;
    const struct report_options *options;
    struct capture_error *error;
    uint32_t command_count, top; /* `top`: the structure; CAPTURE_NONE: all meshes at the origin */
    uint32_t *builds;            /* of contents_find_builds() */
    struct report_mesh *meshes;
    uint32_t mesh_count;
    uint32_t *mesh_of; /* for each structure; CAPTURE_NONE: it has none */
    /* The top level. References are numbers of meshes, from 1 on. */
    struct builder_geometry top_geometry;
    VkAccelerationStructureBuildRangeInfoKHR top_range;
    uint32_t instance_count;
    VkAccelerationStructureInstanceKHR *instances; /* of motion, with the first matrix */
    void *motion_instances;                        /* NULL without motion */
    void *tree;
    bool has_motion;
    uint64_t left_out[LEFT_OUT];
    double center[3], radius; /* of most of the scene */
    struct camera camera;
    double camera_work; /* nodes and primitives of a camera ray */
    json_t *root;
};

/* ---- assemble.c: the scene */

/* Reads the input of all structures that the top-level structure refers to. Returns false with an
 * error. The caller calls report_release() in both cases. */
bool report_assemble(struct report *report);
void report_release(struct report *report);

/* What it took to build all of the scene. */
struct report_built {
    double ms; /* of processor time */
    uint64_t bytes, nodes;
    double sah; /* mean of all meshes, each as often as it has instances */
    uint32_t depth;
};
/* Builds the trees of all meshes, without `without` of the flags, and the tree above them. What was
 * built before is freed. */
void report_build(struct report *report, enum builder_quality quality,
                  VkBuildAccelerationStructureFlagsKHR without, struct report_built *built);
/* Reads what a command has built. `mesh` need not be one of the report. */
void report_read_mesh(struct report *report, uint32_t command, struct report_mesh *mesh);
void report_free_mesh(struct report_mesh *mesh);
/* Builds the tree of a mesh. Returns its size. */
uint64_t report_build_mesh(struct report_mesh *mesh, enum builder_quality quality,
                           VkBuildAccelerationStructureFlagsKHR without, uint32_t threads);
/* Applies an update to the tree of a mesh. Returns false if it does not fit. */
bool report_refit_mesh(struct report_mesh *mesh, const struct builder_input *update);
/* The input of the top level, which stays valid until the next call. */
struct builder_input report_top_input(struct report *report,
                                      VkBuildAccelerationStructureFlagsKHR without);
/* Builds the tree above those of the meshes. Returns its size. */
uint64_t report_build_top(struct report *report, enum builder_quality quality,
                          VkBuildAccelerationStructureFlagsKHR without);
struct trace_scene report_scene(struct report *report, enum trace_accuracy accuracy);

/* Calls `work` for 0 to `count` - 1, on REPORT_THREADS threads. */
void report_parallel(uint32_t count, void (*work)(void *context, uint32_t index), void *context);
void report_progress(const struct report *report, const char *part);
double report_cpu_ns(void); /* of this thread */
/* The name of a structure, or "structure ID". The caller uses it before the next call. */
const char *report_name(const struct report *report, uint32_t structure);

/* ---- rays.c: what rays are traced */

#define RAY_SET_LIST(X)                                                                            \
    X(RAYS_CAMERA, "camera", "through random pixels of the picture")                               \
    X(RAYS_RANDOM, "random", "between random points of the scene's bounds")                        \
    X(RAYS_SURFACE, "surface",                                                                     \
      "from points of surfaces on, tmin 0 or the distance of a hit: shadow and secondary rays")    \
    X(RAYS_AXIS, "axis", "parallel to an axis, with directions of length 1e-15 to 1e15")           \
    X(RAYS_EDGES, "edges", "aimed at points of edges")                                             \
    X(RAYS_VERTICES, "vertices", "aimed at vertices")                                              \
    X(RAYS_GRAZING, "grazing", "aimed at edges, nearly in the plane of the triangle")              \
    X(RAYS_FAR, "far origin", "from 100 to 10,000 radii away, aimed at edges")
#define RAY_SET_NUMBER(name, text, says) name,
enum ray_set_kind { RAY_SET_LIST(RAY_SET_NUMBER) RAY_SETS };
struct ray_set {
    const char *name, *says;
    uint32_t count;
    struct trace_ray *rays;
};
void rays_make(const struct report *report, struct ray_set sets[RAY_SETS]);
void rays_free(struct ray_set sets[RAY_SETS]);
/* Fits the camera to the scene, or takes it from the options. */
void rays_fit_camera(struct report *report);
/* `x` and `y`: from -1 at the left and the top to 1. */
struct trace_ray camera_ray(const struct report *report, double x, double y);
/* A ray from around a primitive of a mesh at a point of its inside, or of an edge: in the space of
 * the mesh, or if `instance` is not NULL in the world. Returns false if the primitive is
 * inactive. */
bool rays_aim(const struct report_mesh *mesh, uint32_t geometry, uint32_t primitive, bool at_edge,
              const VkAccelerationStructureInstanceKHR *instance, uint64_t *random,
              struct trace_ray *ray);

uint64_t rays_random(uint64_t *random);
double rays_random_between(uint64_t *random, double low, double high);

/* ---- accuracy.c: answers, and how many are wrong */

enum { ANSWER_MOST = 24 }; /* of the nearest hits of a ray that are compared */
struct answer {
    uint32_t count; /* of all hits */
    float t[ANSWER_MOST];
};
struct wrong {
    uint64_t rays, wrong, missed, doubled, nearest;
};
void answer_find(const struct trace_scene *scene, const struct trace_ray *ray,
                 struct answer *answer);
/* Finds the answers of all rays of a set. */
void answers_find(struct report *report, enum trace_accuracy accuracy, const struct ray_set *set,
                  struct answer *answers);
/* Adds a ray whose answer should be `truth`. Returns whether it is wrong. */
bool wrong_add(struct wrong *wrong, const struct answer *truth, const struct answer *answer);
/* {"rays", "wrong", ...}; the last four in a million rays */
json_t *wrong_make(const struct wrong *wrong);
/* Returns the nanoseconds that trace_closest() takes for a ray of the set. */
double accuracy_time(struct report *report, enum trace_accuracy accuracy,
                     const struct ray_set *set);
extern const char *const accuracy_names[3], *const quality_names[3];

/* Also reduces the counts of sets that are too much work. */
void accuracy_report(struct report *report, struct ray_set sets[RAY_SETS]);

/* ---- fragile.c: inputs that are numerically fragile */

enum { FRAGILE_LISTED = 64 };
struct fragile {
    uint32_t kind, geometry; /* CAPTURE_NONE: about the whole structure */
    uint64_t count;
    double figure; /* the worst */
    uint32_t listed, primitives[FRAGILE_LISTED];
};
struct fragile_list {
    struct fragile *items; /* owned */
    uint32_t count, capacity;
};
/* Finds what is fragile in an input of any type. `tree` is what was built of it, or NULL. */
void fragile_find(const struct builder_input *input, const void *tree, struct fragile_list *list);
const char *fragile_name(uint32_t kind);
void fragile_report(struct report *report);

/* ---- the others */

void effects_report(struct report *report, const struct ray_set *camera_rays);
/* Returns the build that the updates up to a command began with; CAPTURE_NONE if it is not known.
 */
uint32_t report_find_root(const struct report *report, uint32_t command);
void waste_report(struct report *report);
void device_report(struct report *report, const struct ray_set sets[RAY_SETS]);
void pictures_report(struct report *report);
bool write_report(const struct report *report);

#endif
