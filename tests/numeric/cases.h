/* SPDX-License-Identifier: Apache-2.0 */
/* The hard cases, by number. Each runs at every quality and accuracy, with one thread and two. */
#ifndef ASSAY_TESTS_NUMERIC_CASES_H
#define ASSAY_TESTS_NUMERIC_CASES_H

#include "exact.h"
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
    const char *report_name; /* what assay-scene report calls its input, or its rays */
    void (*run)(void);
};
void case_register(const struct numeric_case *one); /* the program keeps the pointer */

/* A case that registers itself: CASE(number, may be wrong: fast, robust, name, name in reports) {
 * ... }. The report has no name for a case that builds nothing: NULL. */
#define CASE(number_, fast, robust, name_, report_name_)                                           \
    static void case_##number_(void);                                                              \
    __attribute__((constructor)) static void register_##number_(void)                              \
    {                                                                                              \
        static const struct numeric_case one = {                                                   \
            number_, {fast, robust}, name_, report_name_, case_##number_};                         \
        case_register(&one);                                                                       \
    }                                                                                              \
    static void case_##number_(void)

/* Counts, against the case that runs, and prints the first of each setting. */
void expect(bool is_so, const char *what);
#define EXPECT(condition) expect(condition, #condition)

extern struct builder_report report; /* of the last build */

/* fixture_build() with the setting's quality and threads; ends the program if the build fails. All
 * that the fixture allocates is freed after the case. */
void *case_build(struct fixture_input *input);
void *case_triangles(const float *corners, uint32_t count);
void *case_mesh(const struct fixture_mesh *mesh);
void *case_instances(const VkAccelerationStructureInstanceKHR *instances, uint32_t count);
bool case_fails(struct fixture_input *input); /* the build of it */

/* fixture_trace() and fixture_trace_all() with the setting's accuracy. */
bool case_meets(const void *structure, struct trace_ray ray);
/* The closest hit. If there is none, its t is -1, and its numbers are UINT32_MAX. */
struct trace_hit case_closest(const void *structure, struct trace_ray ray);
bool case_trace(const void *structure, struct trace_ray ray, struct trace_hit *hit);
struct fixture_hits case_hits(const void *structure, struct trace_ray ray); /* all candidates */
uint32_t case_count(const void *structure, struct trace_ray ray);           /* of all candidates */

void case_uniform(uint64_t *random, float low, float high, float to[3]);
struct trace_ray case_ray_down(float x, float y); /* from z = 1, straight down */
struct trace_ray case_ray_to(const float origin[3], const float target[3]); /* there at t = 1 */
struct trace_ray case_between(struct trace_ray ray, float t_min, float t_max);
/* From `origin` to a point of the triangle's inside. */
struct trace_ray case_ray_into(const float corners[9], const float origin[3], uint64_t *random);

/* Returns the candidate that is part of the primitive, or NULL. */
const struct trace_hit *case_find_hit(const struct fixture_hits *hits, uint32_t primitive);
/* The same structure with no more bytes than it needs, as bytes to store (in `size`), and made of
 * these again. */
void *case_compact(const void *structure);
void *case_serialize(const void *structure, const struct builder_uuids *uuids, uint64_t *size);
void *case_deserialize(const void *bytes, uint64_t size, const struct builder_uuids *uuids);
/* Both structures have the same bounds. */
void case_expect_same_bounds(const void *structure, const void *other);

/* All candidates, against brute force: everything that is inside is hit, with its t; nothing that
 * is outside is. Returns how many are hit. */
uint32_t case_check_ray(const void *structure, const float *corners, uint32_t count,
                        struct trace_ray ray);
/* Random rays from around the triangles into them, checked; `far` is how far around. */
void case_check_rays(const float *corners, uint32_t count, float far, uint32_t rays);

#endif
