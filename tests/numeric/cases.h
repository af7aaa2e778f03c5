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

struct numeric_case {
    int number;
    uint32_t may_be_wrong[2]; /* of 1,000 checks, at accuracies fast and robust; exact: none */
    const char *name;
    void (*run)(const struct setting *setting);
};
extern const struct numeric_case activity_cases[], shape_cases[], ray_cases[], box_cases[],
    instance_cases[], structure_cases[], motion_cases[], micromap_cases[], sphere_cases[],
    dense_cases[], displaced_cases[], displaced_mesh_cases[]; /* each ends with number 0 */

/* Counts, against the case that runs, and prints the first of each setting. */
void expect(bool is_so, const char *what);
#define EXPECT(condition) expect(condition, #condition)

/* fixture_build() with the setting's quality and threads; ends the program where it fails. */
void *case_build(const struct setting *setting, struct fixture_input *input,
                 struct builder_report *report);
void *case_triangles(const struct setting *setting, const float *corners, uint32_t count,
                     struct builder_report *report);

struct trace_ray case_ray(float x, float y, float z, float dx, float dy, float dz);
/* From `origin` to a point of the triangle's inside. */
struct trace_ray case_ray_into(const float corners[9], const float origin[3], uint64_t *random);

/* All candidates, against brute force: everything that is inside is hit, with its t; nothing that
 * is outside is. Returns how many are hit. */
uint32_t case_check_ray(const struct setting *setting, const void *structure, const float *corners,
                        uint32_t count, const struct trace_ray *ray);
/* Random rays from around the triangles into them, checked; `far` is how far around. */
void case_check_rays(const struct setting *setting, const float *corners, uint32_t count, float far,
                     uint32_t rays);

#endif
