/* SPDX-License-Identifier: Apache-2.0 */
/* scene_assimp FILE: prints how many triangles assimp reads from a file, and their bounds, where
 * its nodes place them. */
#include <math.h>
#include <stdio.h>

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

struct sum {
    const struct aiScene *scene;
    unsigned triangles;
    double least[3], most[3];
};

static void add_mesh(struct sum *sum, const struct aiMesh *mesh, const struct aiMatrix4x4 *at)
{
    sum->triangles += mesh->mNumFaces;
    for (unsigned i = 0; i < mesh->mNumFaces; i++)
        for (unsigned j = 0; j < mesh->mFaces[i].mNumIndices; j++) {
            struct aiVector3D point = mesh->mVertices[mesh->mFaces[i].mIndices[j]];
            aiTransformVecByMatrix4(&point, at);
            const double corner[3] = {point.x, point.y, point.z};
            for (int k = 0; k < 3; k++) {
                sum->least[k] = fmin(sum->least[k], corner[k]);
                sum->most[k] = fmax(sum->most[k], corner[k]);
            }
        }
}

static void add_node(struct sum *sum, const struct aiNode *node, struct aiMatrix4x4 at)
{
    aiMultiplyMatrix4(&at, &node->mTransformation);
    for (unsigned i = 0; i < node->mNumMeshes; i++)
        add_mesh(sum, sum->scene->mMeshes[node->mMeshes[i]], &at);
    for (unsigned i = 0; i < node->mNumChildren; i++)
        add_node(sum, node->mChildren[i], at);
}

int main(int count, char **words)
{
    struct sum sum = {.least = {INFINITY, INFINITY, INFINITY},
                      .most = {-INFINITY, -INFINITY, -INFINITY}};
    sum.scene = count == 2 ? aiImportFile(words[1], aiProcess_ValidateDataStructure) : NULL;
    if (!sum.scene) {
        puts(aiGetErrorString());
        return 1;
    }
    struct aiMatrix4x4 at;
    aiIdentityMatrix4(&at);
    add_node(&sum, sum.scene->mRootNode, at);
    printf("[%u, [[%.9g, %.9g, %.9g], [%.9g, %.9g, %.9g]]]\n", sum.triangles, sum.least[0],
           sum.least[1], sum.least[2], sum.most[0], sum.most[1], sum.most[2]);
    aiReleaseImport(sum.scene);
    return 0;
}
