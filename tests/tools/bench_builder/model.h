/* SPDX-License-Identifier: Apache-2.0 */
/* Meshes from files that assimp reads, with one vertex a position, and rays about them. */
#ifndef ASSAY_TESTS_BENCH_BUILDER_MODEL_H
#define ASSAY_TESTS_BENCH_BUILDER_MODEL_H

#include "tests/builder/fixture.h"

/* Says on stderr why not. */
bool model_load(const char *path, struct fixture_mesh *mesh);

/* A ray from a point in or about a box to another one. The margins around the box are in terms of
 * its size. */
struct trace_ray model_random_ray(const float lower[3], const float upper[3], float margin,
                                  float margin_of_aim, uint64_t *random);

#endif
