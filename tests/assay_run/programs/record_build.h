/* SPDX-License-Identifier: Apache-2.0 */
/* Build commands, each on a line that call_sites_test.py looks for. */
#ifndef ASSAY_TESTS_ASSAY_RUN_RECORD_BUILD_H
#define ASSAY_TESTS_ASSAY_RUN_RECORD_BUILD_H

#include "tests/player/scene/scene.h"

/* Makes the scene's call. Also in a library of its own. */
__attribute__((visibility("default"))) VkResult record_build(const struct scene *scene);

#endif
