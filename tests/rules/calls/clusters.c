/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of clusters and of partitioned structures. */
#include "tests/rules/calls/placing.h"
#include "tests/rules/case.h"

#include "cluster_builds.inc"
#include "cluster_inputs.inc"
#include "partition_builds.inc"
#include "partition_descriptors.inc"
