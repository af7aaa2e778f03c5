/* SPDX-License-Identifier: Apache-2.0 */
/* The hard cases, by number. Each runs at every quality and accuracy, with one thread and two. */
#ifndef ASSAY_TESTS_NUMERIC_CASES_H
#define ASSAY_TESTS_NUMERIC_CASES_H

#include "tests/builder/fixture.h"

struct setting {
    enum builder_quality quality;
    enum trace_accuracy accuracy;
    uint32_t threads;
};
extern struct setting setting; /* of the case that runs */

struct numeric_case {
    int number;
    uint32_t may_be_wrong[2]; /* of 1,000 checks, at accuracies fast and robust; exact: none */
    const char *name;
    void (*run)(void);
};
extern const struct numeric_case activity_cases[], shape_cases[], ray_cases[], box_cases[],
    instance_cases[], structure_cases[], motion_cases[], micromap_cases[], sphere_cases[],
    dense_cases[], displaced_cases[], displaced_mesh_cases[]; /* each ends with number 0 */

/* Counts, against the case that runs, and prints the first of each setting. */
void expect(bool is_so, const char *what);
#define EXPECT(condition) expect(condition, #condition)

/* fixture_build() with the setting's quality and threads; ends the program if the build fails. All
 * that the fixture allocates is freed after the case. */
void *case_build(struct fixture_input *input, struct builder_report *report);
void *case_triangles(const float *corners, uint32_t count, struct builder_report *report);
void *case_mesh(const struct fixture_mesh *mesh);
void *case_instances(const VkAccelerationStructureInstanceKHR *instances, uint32_t count,
                     struct builder_report *report);

/* fixture_trace() and fixture_trace_all() with the setting's accuracy. */
bool case_meets(const void *structure, struct trace_ray ray);
/* The closest hit. If there is none, its t is -1, and its numbers are UINT32_MAX. */
struct trace_hit case_closest(const void *structure, struct trace_ray ray);
bool case_trace(const void *structure, struct trace_ray ray, struct trace_hit *hit);
void case_trace_all(const void *structure, struct trace_ray ray, struct fixture_hits *hits);
uint32_t case_count(const void *structure, struct trace_ray ray); /* of all candidates */

struct trace_ray case_ray_down(float x, float y); /* from z = 1, straight down */
/* From `origin` to a point of the triangle's inside. */
struct trace_ray case_ray_into(const float corners[9], const float origin[3], uint64_t *random);

/* All candidates, against brute force: everything that is inside is hit, with its t; nothing that
 * is outside is. Returns how many are hit. */
uint32_t case_check_ray(const void *structure, const float *corners, uint32_t count,
                        struct trace_ray ray);
/* Random rays from around the triangles into them, checked; `far` is how far around. */
void case_check_rays(const float *corners, uint32_t count, float far, uint32_t rays);

#endif
