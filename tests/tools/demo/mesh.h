/* SPDX-License-Identifier: Apache-2.0 */
/* A triangle mesh from a file, made fit to stand in the demo's scene. */
#ifndef DEMO_MESH_H
#define DEMO_MESH_H

#include <stdint.h>

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

#endif
