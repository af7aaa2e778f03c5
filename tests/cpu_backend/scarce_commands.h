/* SPDX-License-Identifier: Apache-2.0 */
/* What the applications of tests/scarce have on backend cpu beside their structures. */
#ifndef CPU_BACKEND_SCARCE_COMMANDS_H
#define CPU_BACKEND_SCARCE_COMMANDS_H

#include "../scarce/application_parts.h"
#include "tests/fixture/make.h"
#include "tests/fixture/trace.h"

struct scarce_commands {
    VkCommandPool pool;
    VkCommandBuffer primary, secondary;
    VkQueryPool queries; /* QUERIES of them */
};
void scarce_commands_create(struct application *app, VkQueryType type,
                            struct scarce_commands *commands);
void scarce_commands_destroy(struct application *app, const struct scarce_commands *commands);

/* NULL where the backend is the driver's. */
PFN_vkTraceRaysASSAY scarce_find_tracing(struct application *app);

/* Traces a ray, and asks for the results of the queries. A structure that was lost when it was
 * submitted can't be traced; others can. */
void scarce_trace(struct application *app, PFN_vkTraceRaysASSAY trace_rays, uint64_t structure);
void scarce_get_results(struct application *app, const struct scarce_commands *commands);

#endif
