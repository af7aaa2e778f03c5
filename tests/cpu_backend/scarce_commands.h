/* SPDX-License-Identifier: Apache-2.0 */
/* What the applications of tests/scarce have on backend cpu beside their structures. */
#ifndef CPU_BACKEND_SCARCE_COMMANDS_H
#define CPU_BACKEND_SCARCE_COMMANDS_H

#include "../scarce/application_parts.h"
#include "tests/fixture/make.h"
#include "tests/fixture/trace.h"

extern VkCommandBuffer primary, secondary;
extern VkQueryPool queries;             /* QUERIES of them */
extern PFN_vkTraceRaysASSAY trace_rays; /* NULL where the backend is the driver's */

void scarce_create_commands(VkQueryType type);
void scarce_find_tracing(void);

/* A micromap of so many triangles of level 0, each of the first format of its type: opaque, or not
 * displaced. */
void scarce_build_micromap(VkMicromapEXT micromap, VkMicromapTypeEXT type,
                           const VkMicromapUsageEXT *usage);
/* Triangles that use the micromap. */
VkAccelerationStructureTrianglesDisplacementMicromapNV
scarce_displacement(VkMicromapEXT micromap, const VkMicromapUsageEXT *usage,
                    VkDeviceAddress vectors);

/* Traces a ray, and asks for the results of the queries. A structure that was lost when it was
 * submitted can't be traced; others can. */
void scarce_trace(uint64_t structure);
void scarce_get_results(void);

#endif
