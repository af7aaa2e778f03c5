/* SPDX-License-Identifier: Apache-2.0 */
/* Meshes from files that assimp reads, with one vertex a position. */
#ifndef ASSAY_TESTS_BENCH_BUILDER_MODEL_H
#define ASSAY_TESTS_BENCH_BUILDER_MODEL_H

#include "tests/builder/fixture.h"

/* Says on stderr why not. */
bool model_load(const char *path, struct fixture_mesh *mesh);

#endif
