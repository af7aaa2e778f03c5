/* SPDX-License-Identifier: Apache-2.0 */
/* Inputs, and the exact answers to rays. */
#include "subject.h"

#include <math.h>
#include <string.h>

#include "tests/fixture/geometry.h"

const float ring_vertices[3 * FAN_VERTICES] = {0, 0,  0, 1, 0,  0,  1, 1, 0,  0, 1, 0,  -1, 1,
                                               0, -1, 0, 0, -1, -1, 0, 0, -1, 0, 1, -1, 0};
const uint32_t ring_indices[3 * FAN_TRIANGLES] = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5,
                                                  0, 5, 6, 0, 6, 7, 0, 7, 8, 0, 8, 1};

float fraction_next(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (float)(*seed >> 8) / (1 << 24);
}

static uint64_t find(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    *bytes = (const void *)(uintptr_t)address;
    return size;
}

void subject_begin(struct subject *subject)
{
    *subject = (struct subject){.memory = {.find = find}};
    subject->input = (struct compare_input){&subject->parameters, &subject->memory};
    subject->parameters.info = MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
                                    .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                                    .pGeometries = subject->geometries);
    subject->parameters.geometries = subject->geometries;
    subject->parameters.ranges = subject->ranges;
}

static void add(struct subject *subject, const VkAccelerationStructureGeometryKHR *geometry,
                uint32_t count)
{
    uint32_t i = subject->parameters.info.geometryCount++;
    assert_true(i < GEOMETRIES);
    subject->geometries[i] = *geometry;
    subject->ranges[i] = (VkAccelerationStructureBuildRangeInfoKHR){.primitiveCount = count};
}

void subject_triangles(struct subject *subject, const float *vertices, uint32_t vertex_count,
                       const uint32_t *indices, uint32_t triangle_count)
{
    const VkAccelerationStructureGeometryKHR geometry = triangles_geometry(
        (uintptr_t)vertices, vertex_count - 1,
        indices ? VK_INDEX_TYPE_UINT32 : VK_INDEX_TYPE_NONE_KHR, (uintptr_t)indices);
    add(subject, &geometry, triangle_count);
}

void subject_ring(struct subject *subject)
{
    subject_begin(subject);
    subject_triangles(subject, ring_vertices, FAN_VERTICES, ring_indices, FAN_TRIANGLES);
}

void subject_boxes(struct subject *subject, const VkAabbPositionsKHR *boxes, uint32_t count)
{
    const VkAccelerationStructureGeometryKHR geometry =
        boxes_geometry((uintptr_t)boxes, sizeof(VkAabbPositionsKHR));
    add(subject, &geometry, count);
}

void subject_grid(struct subject *subject, VkAabbPositionsKHR boxes[BOXES])
{
    for (int i = 0; i < BOXES; i++) {
        int layer = i / 9, row = i / 3 % 3, column = i % 3;
        float x = 2 * (float)column, y = 2 * (float)row, z = 2 * (float)layer;
        boxes[i] = (VkAabbPositionsKHR){x, y, z, x + 1, y + 1, z + 1};
    }
    subject_begin(subject);
    subject_boxes(subject, boxes, BOXES);
}

/* ---- answers */

static enum trace_answer keep(void *context, struct trace_hit *candidate)
{
    struct compare_answer *answer = context;
    const struct compare_hit hit = {
        .t = candidate->t,
        .u = candidate->u,
        .v = candidate->v,
        .kind = COMPARE_HIT | (candidate->is_aabb      ? COMPARE_AABB
                               : candidate->front_face ? COMPARE_FRONT
                                                       : 0),
        .geometry = candidate->geometry,
        .primitive = candidate->primitive,
        .instance = candidate->instance,
    };
    if (answer->candidate_count < COMPARE_CANDIDATES)
        answer->candidates[answer->candidate_count] = hit;
    answer->candidate_count++;
    if (!candidate->is_aabb && (!answer->closest.kind || hit.t < answer->closest.t))
        answer->closest = hit;
    return TRACE_IGNORE;
}

static const void *find_bottom(void *context, uint64_t number)
{
    const struct top_reference *top = context;
    return number ? top->bottoms[number - 1].structure : NULL;
}

void answer_exactly(const void *structure, struct top_reference *top,
                    const struct compare_ray *rays, uint32_t count, struct compare_answer *answers)
{
    struct trace_scene scene = {.structure = structure, .accuracy = TRACE_EXACT};
    if (top)
        scene.resolver = (struct builder_resolver){find_bottom, top};
    memset(answers, 0, count * sizeof(*answers));
    for (uint32_t i = 0; i < count; i++) {
        struct trace_ray ray = {.t_min = rays[i].t_min, .t_max = rays[i].t_max, .cull_mask = 0xff};
        memcpy(ray.origin, rays[i].origin, sizeof(ray.origin));
        memcpy(ray.direction, rays[i].direction, sizeof(ray.direction));
        trace_candidates(&scene, &ray, &(struct trace_visitor){keep, &answers[i]});
    }
}
