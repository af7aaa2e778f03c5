/* SPDX-License-Identifier: Apache-2.0 */
/* Where things stand in the scene: the boxes and the instances. */
#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "scene.h"

#define GOLDEN_ANGLE 2.39996323f

/* A mesh of size 1 that stands on the ground, turned about the y axis. */
struct place {
    float x, z;
    float scale;
    float turn;
    bool twisted;
    uint32_t material;
};

static const struct place places[] = {
    {0.0f, 0.0f, 2.1f, 0.1f, false, 0},    {-2.35f, -0.75f, 1.65f, 0.5f, true, 1},
    {2.3f, -0.8f, 1.6f, -0.6f, false, 2},  {-1.25f, 1.75f, 0.75f, 0.9f, false, 3},
    {1.55f, 1.65f, 0.75f, -0.9f, true, 4},
};
#define PLACE_COUNT (sizeof(places) / sizeof(*places))

static bool layout_is_free(float x, float z, float radius)
{
    for (uint32_t i = 0; i < PLACE_COUNT; ++i) {
        float keep = 0.56f * places[i].scale + radius;
        float dx = x - places[i].x;
        float dz = z - places[i].z;
        if (dx * dx + dz * dz < keep * keep)
            return false;
    }
    return true;
}

/* On the ground in a sunflower's pattern, larger outwards, wherever no mesh stands. */
void layout_boxes(VkAabbPositionsKHR boxes[LAYOUT_BOX_COUNT])
{
    VkAabbPositionsKHR unordered[LAYOUT_BOX_COUNT];
    float centres[LAYOUT_BOX_COUNT][3];
    uint32_t order[LAYOUT_BOX_COUNT];
    uint32_t count = 0;
    for (uint32_t seed = 1; count < LAYOUT_BOX_COUNT; ++seed) {
        float distance = 0.25f * sqrtf((float)seed);
        float radius = 0.055f + 0.012f * distance;
        float x = distance * cosf((float)seed * GOLDEN_ANGLE);
        float z = distance * sinf((float)seed * GOLDEN_ANGLE);
        if (!layout_is_free(x, z, radius))
            continue;
        centres[count][0] = x;
        centres[count][1] = radius;
        centres[count][2] = z;
        unordered[count++] = (VkAabbPositionsKHR){.minX = x - radius,
                                                  .minY = 0.0f,
                                                  .minZ = z - radius,
                                                  .maxX = x + radius,
                                                  .maxY = 2.0f * radius,
                                                  .maxZ = z + radius};
    }
    order_by_place(centres, count, order);
    for (uint32_t i = 0; i < count; ++i)
        boxes[i] = unordered[order[i]];
}

void layout_instances(VkAccelerationStructureInstanceKHR instances[LAYOUT_INSTANCE_COUNT],
                      const struct layout_references *references)
{
    static_assert(PLACE_COUNT + 2 == LAYOUT_INSTANCE_COUNT, "the meshes and two fields of boxes");
    for (uint32_t i = 0; i < PLACE_COUNT; ++i) {
        const struct place *place = &places[i];
        float c = place->scale * cosf(place->turn);
        float s = place->scale * sinf(place->turn);
        instances[i] = (VkAccelerationStructureInstanceKHR){
            .transform = {{{c, 0.0f, s, place->x},
                           {0.0f, place->scale, 0.0f, 0.0f},
                           {-s, 0.0f, c, place->z}}},
            .instanceCustomIndex = place->material | (place->twisted ? LAYOUT_TWISTED_BIT : 0),
            .mask = 0xFF,
            .accelerationStructureReference =
                place->twisted ? references->twisted : references->mesh,
        };
    }
    instances[PLACE_COUNT] = (VkAccelerationStructureInstanceKHR){
        .transform = {{{1.0f, 0.0f, 0.0f, 0.0f},
                       {0.0f, 1.0f, 0.0f, 0.0f},
                       {0.0f, 0.0f, 1.0f, 0.0f}}},
        .mask = 0xFF,
        .accelerationStructureReference = references->box_field,
    };
    /* The same field again, larger, behind the first. */
    instances[PLACE_COUNT + 1] = (VkAccelerationStructureInstanceKHR){
        .transform = {{{0.0f, 0.0f, -1.6f, 0.0f},
                       {0.0f, 1.6f, 0.0f, 0.0f},
                       {1.6f, 0.0f, 0.0f, -15.5f}}},
        .mask = 0xFF,
        .accelerationStructureReference = references->box_field,
    };
}
