/* SPDX-License-Identifier: Apache-2.0 */
/* The extensions and features of a world's device, by its setup. */
#ifndef ASSAY_TESTS_RULES_SCENE_DEVICE_FEATURES_H
#define ASSAY_TESTS_RULES_SCENE_DEVICE_FEATURES_H

#include "tests/rules/scene/fixture.h"

/* What the device of the fixture is created with. */
void features_wish(struct device_wish *wish, const struct fixture *fixture);

/* NULL, or which extension or feature of the setup the physical device lacks. */
const char *features_missing(const struct fixture *fixture);

/* Configures the null driver so that it offers the setup. */
void features_configure(struct null_driver_config *config, const struct setup *setup);

#endif
