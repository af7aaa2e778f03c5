/* SPDX-License-Identifier: Apache-2.0 */
/* Reads a mesh, checks what the rest of the demo relies on, and moves its vertices. */
#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "scene.h"

/* How far the top of the twisted mesh is turned against its base, in radians a unit of height. */
#define TWIST 1.6f

/* So that bytes of positions and of indices are counted in 32 bits. */
#define COUNT_MAX (UINT32_MAX / 16)

static void mesh_check_file(const char *path)
{
    struct stat info;
    if (stat(path, &info))
        tool_fail("mesh %s: %s", path, strerror(errno));
    if (!S_ISREG(info.st_mode))
        tool_fail("mesh %s: not a regular file", path);
    if (info.st_size == 0)
        tool_fail("mesh %s: the file is empty", path);
}

static void mesh_check_part(const struct aiMesh *part, const char *path)
{
    for (uint32_t f = 0; f < part->mNumFaces; ++f) {
        const struct aiFace *face = &part->mFaces[f];
        for (uint32_t corner = 0; corner < face->mNumIndices; ++corner)
            if (face->mIndices[corner] >= part->mNumVertices)
                tool_fail("mesh %s: index %u of a face is beyond the %u vertices of its part", path,
                          face->mIndices[corner], part->mNumVertices);
    }
    for (uint32_t v = 0; v < part->mNumVertices; ++v) {
        const struct aiVector3D *at = &part->mVertices[v];
        if (!isfinite(at->x) || !isfinite(at->y) || !isfinite(at->z))
            tool_fail("mesh %s: a vertex has a position that is not finite (%g %g %g)", path,
                      (double)at->x, (double)at->y, (double)at->z);
    }
}

static const struct aiScene *mesh_import(const char *path, unsigned steps)
{
    const struct aiScene *scene = aiImportFile(path, steps);
    if (!scene)
        tool_fail("mesh %s: assimp can't read it: %s", path, aiGetErrorString());
    uint64_t face_count = 0;
    for (uint32_t m = 0; m < scene->mNumMeshes; ++m) {
        mesh_check_part(scene->mMeshes[m], path);
        face_count += scene->mMeshes[m]->mNumFaces;
    }
    if (face_count == 0)
        tool_fail("mesh %s: no faces in it", path);
    return scene;
}

static void mesh_count(struct mesh *mesh, const struct aiScene *scene, const char *path)
{
    uint64_t vertex_count = 0;
    uint64_t triangle_count = 0;
    for (uint32_t m = 0; m < scene->mNumMeshes; ++m) {
        const struct aiMesh *part = scene->mMeshes[m];
        vertex_count += part->mNumVertices;
        for (uint32_t f = 0; f < part->mNumFaces; ++f)
            triangle_count += part->mFaces[f].mNumIndices == 3;
    }
    if (triangle_count == 0)
        tool_fail("mesh %s: no triangles in it", path);
    if (vertex_count > COUNT_MAX || triangle_count > COUNT_MAX)
        tool_fail("mesh %s: too large (%llu vertices, %llu triangles)", path,
                  (unsigned long long)vertex_count, (unsigned long long)triangle_count);
    mesh->vertex_count = (uint32_t)vertex_count;
    mesh->triangle_count = (uint32_t)triangle_count;
}

static void mesh_copy_scene(struct mesh *mesh, const struct aiScene *scene)
{
    mesh->positions = tool_alloc(mesh->vertex_count, sizeof(*mesh->positions));
    mesh->indices = tool_alloc(mesh->triangle_count, 3 * sizeof(*mesh->indices));

    uint32_t base = 0;
    uint32_t *index = mesh->indices;
    for (uint32_t m = 0; m < scene->mNumMeshes; ++m) {
        const struct aiMesh *part = scene->mMeshes[m];
        for (uint32_t f = 0; f < part->mNumFaces; ++f) {
            const struct aiFace *face = &part->mFaces[f];
            if (face->mNumIndices != 3)
                continue;
            for (uint32_t corner = 0; corner < 3; ++corner)
                *index++ = base + face->mIndices[corner];
        }
        for (uint32_t v = 0; v < part->mNumVertices; ++v) {
            mesh->positions[base + v][0] = part->mVertices[v].x;
            mesh->positions[base + v][1] = part->mVertices[v].y;
            mesh->positions[base + v][2] = part->mVertices[v].z;
        }
        base += part->mNumVertices;
    }
}

/* In double, so that the extent of positions near the limits of float is still finite. */
static void mesh_stand_on_ground(struct mesh *mesh, const char *path)
{
    double low[3];
    double high[3];
    for (int axis = 0; axis < 3; ++axis)
        low[axis] = high[axis] = (double)mesh->positions[0][axis];
    for (uint32_t v = 1; v < mesh->vertex_count; ++v) {
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = fmin(low[axis], (double)mesh->positions[v][axis]);
            high[axis] = fmax(high[axis], (double)mesh->positions[v][axis]);
        }
    }
    double side = fmax(high[0] - low[0], fmax(high[1] - low[1], high[2] - low[2]));
    if (!(side > 0.0))
        tool_fail("mesh %s: all its vertices are in one place", path);

    const double origin[3] = {0.5 * (low[0] + high[0]), low[1], 0.5 * (low[2] + high[2])};
    for (uint32_t v = 0; v < mesh->vertex_count; ++v)
        for (int axis = 0; axis < 3; ++axis)
            mesh->positions[v][axis] =
                (float)(((double)mesh->positions[v][axis] - origin[axis]) / side);
}

static void mesh_order_triangles(struct mesh *mesh)
{
    float(*centres)[3] = tool_alloc(mesh->triangle_count, sizeof(*centres));
    uint32_t *order = tool_alloc(mesh->triangle_count, sizeof(*order));
    uint32_t *ordered = tool_alloc(mesh->triangle_count, 3 * sizeof(*ordered));
    for (uint32_t t = 0; t < mesh->triangle_count; ++t)
        for (int axis = 0; axis < 3; ++axis)
            for (int corner = 0; corner < 3; ++corner)
                centres[t][axis] += mesh->positions[mesh->indices[3 * t + corner]][axis] / 3.0f;

    order_by_place(centres, mesh->triangle_count, order);
    for (uint32_t t = 0; t < mesh->triangle_count; ++t)
        memcpy(&ordered[3 * t], &mesh->indices[3 * order[t]], 3 * sizeof(*ordered));
    free(mesh->indices);
    mesh->indices = ordered;
    free(order);
    free(centres);
}

void mesh_load(struct mesh *mesh, const char *path)
{
    mesh_check_file(path);
    /* First as it is in the file: to join vertices hides NaN, and trusts indices. */
    aiReleaseImport(mesh_import(path, 0));
    const struct aiScene *scene =
        mesh_import(path, aiProcess_Triangulate | aiProcess_JoinIdenticalVertices |
                              aiProcess_PreTransformVertices);

    *mesh = (struct mesh){0};
    mesh_count(mesh, scene, path);
    mesh_copy_scene(mesh, scene);
    aiReleaseImport(scene);
    mesh_stand_on_ground(mesh, path);
    mesh_order_triangles(mesh);
}

void mesh_free(struct mesh *mesh)
{
    free(mesh->positions);
    free(mesh->indices);
    *mesh = (struct mesh){0};
}

void mesh_twist(const struct mesh *mesh, float (*twisted)[3])
{
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        const float *at = mesh->positions[v];
        float angle = TWIST * at[1];
        twisted[v][0] = cosf(angle) * at[0] + sinf(angle) * at[2];
        twisted[v][1] = at[1];
        twisted[v][2] = cosf(angle) * at[2] - sinf(angle) * at[0];
    }
}

void mesh_normals(const struct mesh *mesh, const float (*positions)[3], float (*normals)[3])
{
    memset(normals, 0, mesh->vertex_count * sizeof(*normals));

    /* A face's cross product is as long as its area is large: the sum weighs by area. */
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *corner = &mesh->indices[3 * t];
        const float *a = positions[corner[0]];
        const float *b = positions[corner[1]];
        const float *c = positions[corner[2]];
        const float u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
        const float v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
        const float cross[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                                u[0] * v[1] - u[1] * v[0]};
        for (int i = 0; i < 3; ++i)
            for (int axis = 0; axis < 3; ++axis)
                normals[corner[i]][axis] += cross[axis];
    }
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        float *normal = normals[v];
        float length = sqrtf(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
        if (length > 0.0f)
            for (int axis = 0; axis < 3; ++axis)
                normal[axis] /= length;
        else
            normal[1] = 1.0f;
    }
}
