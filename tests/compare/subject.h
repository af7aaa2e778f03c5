/* SPDX-License-Identifier: Apache-2.0 */
/* Inputs of builds in the host's memory, whose addresses stand for the application's. */
#ifndef TESTS_COMPARE_SUBJECT_H
#define TESTS_COMPARE_SUBJECT_H

#include "src/compare/judge.h"
#include "src/compare/top.h"
#include "tests/fixture/make.h"
#include "tests/fixture/objects.h"
#include "tests/unit/unit_test.h"

enum { GEOMETRIES = 4 };

/* Random numbers from 0 to 1, the same on all systems, unlike those of rand(). */
float fraction_next(uint32_t *seed);

struct subject {
    struct build_parameters parameters;
    VkAccelerationStructureGeometryKHR geometries[GEOMETRIES];
    VkAccelerationStructureBuildRangeInfoKHR ranges[GEOMETRIES];
    struct input_memory memory;
    struct compare_input input;
};

/* The subject stays where it is. Floats, three a vertex; `indices` may be NULL. */
void subject_begin(struct subject *subject);
void subject_triangles(struct subject *subject, const float *vertices, uint32_t vertex_count,
                       const uint32_t *indices, uint32_t triangle_count);
/* A new subject: the ring. */
void subject_ring(struct subject *subject);
void subject_boxes(struct subject *subject, const VkAabbPositionsKHR *boxes, uint32_t count);

/* A closed fan of 8 triangles around the origin, in a plane. */
enum { FAN_VERTICES = 9, FAN_TRIANGLES = 8 };
extern const float ring_vertices[3 * FAN_VERTICES];
extern const uint32_t ring_indices[3 * FAN_TRIANGLES];

/* A new subject of 27 boxes, apart, which it fills in. */
enum { BOXES = 27 };
void subject_grid(struct subject *subject, VkAabbPositionsKHR boxes[BOXES]);

/* What the reference's exact traversal answers to each ray; with `top`, in a TLAS. */
void answer_exactly(const void *structure, struct top_reference *top,
                    const struct compare_ray *rays, uint32_t count, struct compare_answer *answers);

#endif
