/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of clusters and of partitioned structures. */
#include "tests/player/calls/case.h"
#include "tests/player/scene/placing.h"

#include "clusters.inc"
