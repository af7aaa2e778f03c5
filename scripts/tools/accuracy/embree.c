/* SPDX-License-Identifier: Apache-2.0 */
/* Embree 3, the measure of the reference builder. */
#include "embree.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scripts/tools/measure.h"

#define WIDTH 8
#define LEAF 4

/* A node of the tree that Embree builds through callbacks; is_leaf tells which. */
struct node {
    struct RTCBounds bounds[WIDTH];
    struct node *children[WIDTH];
    uint32_t count; /* of children, or of a leaf's primitives */
    bool is_leaf;
};

static void *create_node(RTCThreadLocalAllocator allocator, unsigned count, void *context)
{
    struct node *node = rtcThreadLocalAlloc(allocator, sizeof(*node), 16);
    node->count = count;
    node->is_leaf = false;
    return node;
}

static void set_children(void *node, void **children, unsigned count, void *context)
{
    for (unsigned i = 0; i < count; i++)
        ((struct node *)node)->children[i] = children[i];
}

static void set_bounds(void *node, const struct RTCBounds **bounds, unsigned count, void *context)
{
    for (unsigned i = 0; i < count; i++)
        ((struct node *)node)->bounds[i] = *bounds[i];
}

static void *create_leaf(RTCThreadLocalAllocator allocator,
                         const struct RTCBuildPrimitive *primitives, size_t count, void *context)
{
    uint32_t *leaf = rtcThreadLocalAlloc(allocator, 64, 16);
    for (size_t i = 0; i < count; i++)
        leaf[1 + i] = primitives[i].primID;
    struct node *node = rtcThreadLocalAlloc(allocator, sizeof(*node), 16);
    node->count = (uint32_t)count;
    node->is_leaf = true;
    node->children[0] = (void *)leaf;
    return node;
}

/* With room for those that splitting adds. */
static struct RTCBuildPrimitive *make_primitives(const struct fixture_mesh *mesh, uint64_t room)
{
    struct RTCBuildPrimitive *primitives = fixture_allocate(room * sizeof(*primitives));
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        float box[6] = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY};
        for (uint32_t corner = 0; corner < 3; corner++) {
            const float *at = &mesh->positions[3 * mesh->indices[3 * i + corner]];
            for (int axis = 0; axis < 3; axis++) {
                box[axis] = fminf(box[axis], at[axis]);
                box[3 + axis] = fmaxf(box[3 + axis], at[axis]);
            }
        }
        primitives[i] =
            (struct RTCBuildPrimitive){box[0], box[1], box[2], 0, box[3], box[4], box[5], i};
    }
    return primitives;
}

static double area(const struct RTCBounds *b)
{
    double x = b->upper_x - b->lower_x, y = b->upper_y - b->lower_y, z = b->upper_z - b->lower_z;
    return x * (y + z) + y * z;
}

static double sum_areas(const struct node *root, double *whole)
{
    const struct node *waiting[1024];
    uint32_t count = 1;
    double sum = 0;
    waiting[0] = root;
    struct RTCBounds all = root->bounds[0];
    for (uint32_t i = 0; i < root->count && !root->is_leaf; i++) {
        const struct RTCBounds *b = &root->bounds[i];
        all.lower_x = fminf(all.lower_x, b->lower_x);
        all.lower_y = fminf(all.lower_y, b->lower_y);
        all.lower_z = fminf(all.lower_z, b->lower_z);
        all.upper_x = fmaxf(all.upper_x, b->upper_x);
        all.upper_y = fmaxf(all.upper_y, b->upper_y);
        all.upper_z = fmaxf(all.upper_z, b->upper_z);
    }
    *whole = area(&all);
    while (count > 0) {
        const struct node *node = waiting[--count];
        for (uint32_t i = 0; i < node->count && !node->is_leaf; i++) {
            const struct node *child = node->children[i];
            sum += area(&node->bounds[i]) * (child->is_leaf ? child->count : 1);
            if (!child->is_leaf && count < 1024)
                waiting[count++] = child;
        }
    }
    return sum + *whole;
}

static const enum RTCBuildQuality qualities[] = {
    [EMBREE_LOW] = RTC_BUILD_QUALITY_LOW,
    [EMBREE_MEDIUM] = RTC_BUILD_QUALITY_MEDIUM,
    [EMBREE_HIGH] = RTC_BUILD_QUALITY_HIGH,
};

/* Cuts a primitive's box in two; quality HIGH asks for that. */
static void split_box(const struct RTCBuildPrimitive *primitive, unsigned axis, float position,
                      struct RTCBounds *left, struct RTCBounds *right, void *context)
{
    *left = *right = *(const struct RTCBounds *)primitive;
    (&left->upper_x)[axis] = position;
    (&right->lower_x)[axis] = position;
}

struct embree_tree embree_build(const struct fixture_mesh *mesh, enum embree_quality quality)
{
    const uint64_t room = (quality == EMBREE_HIGH ? 2 : 1) * (uint64_t)mesh->triangle_count;
    RTCDevice device = rtcNewDevice("threads=1,set_affinity=0");
    RTCBVH bvh = rtcNewBVH(device);
    struct RTCBuildPrimitive *primitives = make_primitives(mesh, room);
    struct RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.buildQuality = qualities[quality];
    arguments.maxBranchingFactor = WIDTH;
    arguments.maxDepth = 64;
    arguments.sahBlockSize = LEAF; /* as in its scenes: leaves of up to four cost the same */
    arguments.minLeafSize = 1;
    arguments.maxLeafSize = LEAF;
    arguments.traversalCost = 1;
    arguments.intersectionCost = 1;
    arguments.bvh = bvh;
    arguments.primitives = primitives;
    arguments.primitiveCount = mesh->triangle_count;
    arguments.primitiveArrayCapacity = room;
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = create_leaf;
    arguments.splitPrimitive = split_box;
    const double begin = read_clock(CLOCK_PROCESS_CPUTIME_ID);
    const struct node *root = rtcBuildBVH(&arguments);
    const double seconds = (read_clock(CLOCK_PROCESS_CPUTIME_ID) - begin) / 1e9;
    double whole, sum = sum_areas(root, &whole);
    struct embree_tree tree = {seconds, sum / whole};
    free(primitives);
    rtcReleaseBVH(bvh);
    rtcReleaseDevice(device);
    return tree;
}

struct embree_scene {
    RTCDevice device;
    RTCScene scene;
};

struct embree_scene *embree_scene_create(const struct fixture_mesh *mesh,
                                         enum embree_quality quality)
{
    struct embree_scene *scene = fixture_allocate(sizeof(*scene));
    scene->device = rtcNewDevice("threads=1,set_affinity=0");
    scene->scene = rtcNewScene(scene->device);
    rtcSetSceneFlags(scene->scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene->scene, qualities[quality]);
    RTCGeometry geometry = rtcNewGeometry(scene->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
                                   mesh->vertex_count),
           mesh->positions, (size_t)mesh->vertex_count * 12);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12,
                                   mesh->triangle_count),
           mesh->indices, (size_t)mesh->triangle_count * 12);
    rtcSetGeometryBuildQuality(geometry, qualities[quality]);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene->scene);
    return scene;
}

void embree_scene_destroy(struct embree_scene *scene)
{
    rtcReleaseScene(scene->scene);
    rtcReleaseDevice(scene->device);
    free(scene);
}

bool embree_trace(struct embree_scene *scene, const struct trace_ray *ray, struct trace_hit *hit)
{
    struct RTCRayHit query = {
        .ray = {.org_x = ray->origin[0],
                .org_y = ray->origin[1],
                .org_z = ray->origin[2],
                .tnear = ray->t_min,
                .dir_x = ray->direction[0],
                .dir_y = ray->direction[1],
                .dir_z = ray->direction[2],
                .tfar = ray->t_max,
                .mask = 0xffffffff},
        .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .primID = RTC_INVALID_GEOMETRY_ID},
    };
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene->scene, &context, &query);
    *hit = (struct trace_hit){.t = query.ray.tfar, .primitive = query.hit.primID};
    return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
}
