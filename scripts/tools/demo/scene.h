/* SPDX-License-Identifier: Apache-2.0 */
/* The scene: a mesh as loaded, the same mesh twisted by an update, boxes, and instances of them. */
#ifndef DEMO_SCENE_H
#define DEMO_SCENE_H

#include "scripts/tools/gpu.h"

/* ---- a triangle mesh from a file, made fit to stand in the scene (mesh.c) */

/* Every index is below vertex_count, every position is finite, and there is a triangle. */
struct mesh {
    uint32_t vertex_count;
    uint32_t triangle_count;
    float (*positions)[3];
    uint32_t *indices; /* three a triangle */
};

/* Load any format that assimp reads. The mesh stands on y = 0 around the y axis, its longest
 * side 1. Ends the process with one line on stderr where the file can't be used. */
void mesh_load(struct mesh *mesh, const char *path);
void mesh_free(struct mesh *mesh);

/* Write to `twisted` the positions turned about the y axis, the more the higher. */
void mesh_twist(const struct mesh *mesh, float (*twisted)[3]);

/* Write to `normals` a unit normal a vertex, of the mesh with these positions. */
void mesh_normals(const struct mesh *mesh, const float (*positions)[3], float (*normals)[3]);

/* Write to `order` a permutation of 0 .. count - 1: halved at its middle, halved again, and so on,
 * every part is compact. lavapipe builds its tree by such halves and doesn't sort, so that a mesh
 * in its file's order takes a hundred times as long to trace. */
void order_by_place(const float (*centres)[3], uint32_t count, uint32_t *order);

/* ---- builds */

/* The parameters of one vkCmdBuildAccelerationStructuresKHR, which can be changed before it is
 * recorded. */
#define BUILD_CALL_MAX 2 /* builds a call, and geometries a build */

/* Build i is infos[i] with geometries[i] and ranges[i]. The pointers between them are set at the
 * time of recording, so a call may be copied. */
struct build_call {
    uint32_t count;
    VkAccelerationStructureBuildGeometryInfoKHR infos[BUILD_CALL_MAX];
    VkAccelerationStructureGeometryKHR geometries[BUILD_CALL_MAX][BUILD_CALL_MAX];
    VkAccelerationStructureBuildRangeInfoKHR ranges[BUILD_CALL_MAX][BUILD_CALL_MAX];
};

/* Add a build of one geometry and that many primitives; dst and scratch are still to be set. */
VkAccelerationStructureBuildGeometryInfoKHR *
build_call_add(struct build_call *call, VkAccelerationStructureTypeKHR type,
               VkBuildAccelerationStructureFlagsKHR flags,
               const VkAccelerationStructureGeometryKHR *geometry, uint32_t primitive_count);

/* The sizes of build i, of a call that is valid. */
VkAccelerationStructureBuildSizesInfoKHR build_call_sizes(struct gpu *gpu, struct build_call *call,
                                                          uint32_t i);

void build_call_record(struct gpu *gpu, VkCommandBuffer commands, struct build_call *call);

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

/* ---- where things stand: the boxes and the instances (layout.c) */

#define LAYOUT_BOX_COUNT 480
#define LAYOUT_INSTANCE_COUNT 7

/* What scene.comp reads from an instance's custom index. */
#define LAYOUT_TWISTED_BIT                                                                         \
    0x100 /* shaded with the second set of normals; below it, the material                         \
           */

/* The BLAS that instances refer to. */
struct layout_references {
    VkDeviceAddress mesh;
    VkDeviceAddress twisted;
    VkDeviceAddress box_field;
};

void layout_boxes(VkAabbPositionsKHR boxes[LAYOUT_BOX_COUNT]);
void layout_instances(VkAccelerationStructureInstanceKHR instances[LAYOUT_INSTANCE_COUNT],
                      const struct layout_references *references);

/* ---- pictures in PNG files (picture.c) */

/* Write RGBA bytes, the top row first, to folder/name; folders that lack are made. Ends the process
 * with one line on stderr where that fails. */
void picture_write(const char *folder, const char *name, uint32_t width, uint32_t height,
                   const uint32_t *pixels);

/* Read such a picture; false where there is none of this size. */
bool picture_read(const char *folder, const char *name, uint32_t width, uint32_t height,
                  uint32_t *pixels);

struct comparison {
    uint32_t differing; /* pixels */
    uint32_t visible;   /* of them, those of which a channel differs by more than COMPARE_VISIBLE */
    uint32_t largest;   /* difference of a channel, 0 to 255 */
};
#define COMPARE_VISIBLE 8

/* `difference` gets the largest difference of a pixel's channels, as a grey, eightfold. */
struct comparison compare_pictures(const uint32_t *a, const uint32_t *b, uint32_t *difference,
                                   uint32_t pixel_count);

/* ---- drawing */

#define RENDER_GRID 3 /* samples a pixel, squared */

/* Fill pixels[width * height] with RGBA bytes, the top row first. */
void render_scene(struct gpu *gpu, const struct scene *scene, uint32_t width, uint32_t height,
                  uint32_t *pixels);

/* The same with the layer's reference tracing (assay.h), on a device of backend cpu. */
void trace_scene(struct gpu *gpu, const struct scene *scene, uint32_t width, uint32_t height,
                 uint32_t *pixels);

#endif
