/* SPDX-License-Identifier: Apache-2.0 */
/* A platform without a loader: the layer and the null driver are linked to the program, so that
 * their allocations can fail, and all allocations are counted. */
#ifndef FAULTS_LINKED_H
#define FAULTS_LINKED_H

#include "tests/rules/platform.h"

struct platform linked_platform(bool is_cpu);

#endif
