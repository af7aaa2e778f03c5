/* SPDX-License-Identifier: Apache-2.0 */
/* A BLAS of triangles that can be compacted, on a device fixture, and a pool of queries about it.
 */
#ifndef CPU_BACKEND_RESULT_SCENE_H
#define CPU_BACKEND_RESULT_SCENE_H

#include "device_fixture.h"

static const VkQueryType COMPACTED_SIZE = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;

enum { QUERIES = 3, TRIANGLES = 50 };

extern struct result_scene {
    struct fixture_build host;
    struct device_build build;
    struct fixture_structure blas;
    VkQueryPool pool; /* QUERIES of them */
} scene;

void result_scene_open(VkQueryType type);

void result_scene_record_build(VkCommandBuffer commands);
/* Queries 0 and 1 of the BLAS; 2 stays unwritten. */
void result_scene_record_queries(VkCommandBuffer commands, VkQueryType type);

#endif
