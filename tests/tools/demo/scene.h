/* SPDX-License-Identifier: Apache-2.0 */
/* The scene: a mesh as loaded, the same mesh twisted by an update, boxes, and instances of them. */
#ifndef DEMO_SCENE_H
#define DEMO_SCENE_H

#include "build_call.h"
#include "gpu.h"
#include "mesh.h"

/* A structure that a build writes, with the scratch that this build alone uses. */
struct scene_target {
    struct gpu_structure structure;
    struct gpu_buffer scratch;
};

struct scene {
    uint32_t vertex_count;
    uint32_t triangle_count;
    uint32_t box_count;
    uint32_t instance_count;
    struct gpu_buffer vertices; /* as loaded, then twisted: vertex_count positions each */
    struct gpu_buffer normals;  /* in the same order */
    struct gpu_buffer indices;
    struct gpu_buffer boxes; /* VkAabbPositionsKHR */
    struct gpu_buffer instances;
    struct scene_target mesh;             /* BLAS of the mesh as loaded */
    struct scene_target twisted;          /* BLAS of the twisted mesh: `mesh` updated */
    struct scene_target box_field;        /* BLAS of the boxes */
    struct gpu_structure compacted_field; /* the same, compacted: what instances refer to */
    struct scene_target top;
};

/* Upload, build, update, compact: when this returns, everything is built and `top` can be traced by
 * a compute shader. */
void scene_create(struct scene *scene, struct gpu *gpu, const struct mesh *mesh);
void scene_destroy(struct scene *scene, struct gpu *gpu);

/* The calls that scene_create() records: both BLAS at once, the update, the TLAS. */
void scene_describe_bottom(const struct scene *scene, const struct gpu *gpu,
                           struct build_call *call);
void scene_describe_update(const struct scene *scene, const struct gpu *gpu,
                           struct build_call *call);
void scene_describe_top(const struct scene *scene, const struct gpu *gpu, struct build_call *call);

#endif
