/* SPDX-License-Identifier: Apache-2.0 */
/* Compares executed builds (setting compare_rays): the driver builds the same input again in memory
 * of the layer, and rays are traced through that structure and through the reference.
 *
 * Only the thread that delivers executions uses a comparer. The inputs that it retains for
 * structures may be released on any thread. */
#ifndef ASSAY_LAYER_COMPARE_COMPARER_H
#define ASSAY_LAYER_COMPARE_COMPARER_H

#include "layer/consumers.h"

extern const struct consumer comparison;

#endif
