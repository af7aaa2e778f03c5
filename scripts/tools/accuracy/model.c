/* SPDX-License-Identifier: Apache-2.0 */
/* Meshes from files that assimp reads. */
#include "embree.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <stdio.h>
#include <string.h>

/* Normals and texture coordinates would keep vertices of one position apart. */
static const struct aiScene *import_positions(const char *path)
{
    struct aiPropertyStore *properties = aiCreatePropertyStore();
    aiSetImportPropertyInteger(properties, AI_CONFIG_PP_RVC_FLAGS,
                               aiComponent_NORMALS | aiComponent_TEXCOORDS | aiComponent_COLORS |
                                   aiComponent_MATERIALS | aiComponent_TANGENTS_AND_BITANGENTS);
    aiSetImportPropertyInteger(properties, AI_CONFIG_PP_SBP_REMOVE,
                               aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    const struct aiScene *scene = aiImportFileExWithProperties(
        path,
        aiProcess_RemoveComponent | aiProcess_PreTransformVertices | aiProcess_Triangulate |
            aiProcess_SortByPType | aiProcess_JoinIdenticalVertices,
        NULL, properties);
    aiReleasePropertyStore(properties);
    return scene;
}

static void copy_part(const struct aiMesh *part, struct fixture_mesh *mesh)
{
    uint32_t first = mesh->vertex_count;
    for (uint32_t i = 0; i < part->mNumVertices; i++) {
        const struct aiVector3D *at = &part->mVertices[i];
        float position[3] = {at->x, at->y, at->z};
        memcpy(mesh->positions + 3 * (size_t)mesh->vertex_count++, position, sizeof(position));
    }
    for (uint32_t i = 0; i < part->mNumFaces; i++) {
        const struct aiFace *face = &part->mFaces[i];
        uint32_t *to = mesh->indices + 3 * (size_t)mesh->triangle_count;
        for (uint32_t corner = 0; corner < 3 && face->mNumIndices == 3; corner++)
            to[corner] = first + face->mIndices[corner];
        mesh->triangle_count += face->mNumIndices == 3;
    }
}

bool model_load(const char *path, struct fixture_mesh *mesh)
{
    const struct aiScene *scene = import_positions(path);
    if (!scene) {
        fprintf(stderr, "%s: %s\n", path, aiGetErrorString());
        return false;
    }
    uint32_t vertices = 0, faces = 0;
    for (uint32_t i = 0; i < scene->mNumMeshes; i++) {
        vertices += scene->mMeshes[i]->mNumVertices;
        faces += scene->mMeshes[i]->mNumFaces;
    }
    *mesh = fixture_mesh_make(vertices, faces);
    mesh->vertex_count = mesh->triangle_count = 0;
    for (uint32_t i = 0; i < scene->mNumMeshes; i++)
        copy_part(scene->mMeshes[i], mesh);
    aiReleaseImport(scene);
    return mesh->triangle_count > 0;
}

struct trace_ray model_random_ray(const float lower[3], const float upper[3], float margin,
                                  uint64_t *random)
{
    struct trace_ray ray = fixture_ray(0, 0, 0, 0, 0, 0);
    for (int i = 0; i < 3; i++) {
        const float about = margin * (upper[i] - lower[i]);
        ray.origin[i] = fixture_uniform(random, lower[i] - about, upper[i] + about);
        ray.direction[i] = fixture_uniform(random, lower[i], upper[i]) - ray.origin[i];
    }
    return ray;
}
