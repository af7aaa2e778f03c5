/* SPDX-License-Identifier: Apache-2.0 */
/* Which batches write which queries and set which events. If the application has read the result of
 * a query, or that an event is set, it may know that the batch which did that, and what that batch
 * follows, is complete. It knows nothing more: batches behind that one are still pending. Has its
 * own lock. */
#ifndef ASSAY_LAYER_EXECUTION_QUERY_WRITES_H
#define ASSAY_LAYER_EXECUTION_QUERY_WRITES_H

#include "src/state/order/order.h"

struct query_writes;

/* Returns NULL if memory runs out. */
struct query_writes *query_writes_create(void);
void query_writes_destroy(struct query_writes *writes); /* accepts NULL */

/* For the consumer of submissions: the batch is about to be submitted; its execution point is
 * reached; its call has failed. */
void query_writes_submit(struct query_writes *writes, struct order_batch *batch);
void query_writes_run(struct query_writes *writes, const struct order_batch *batch);
void query_writes_fail(struct query_writes *writes, const struct order_batch *batch);

/* Sets `clock` to what the application may know to be complete if it has read these queries.
 * Returns false if that is unknown. */
bool query_writes_find(struct query_writes *writes, VkQueryPool pool, uint32_t first,
                       uint32_t count, struct execution_clock *clock);
void query_writes_forget(struct query_writes *writes, VkQueryPool pool);
/* Sets `clock` to what the application may know to be complete if it has seen that the event is
 * set. Returns false if that is unknown. */
bool query_writes_find_event(struct query_writes *writes, VkEvent event,
                             struct execution_clock *clock);
void query_writes_forget_event(struct query_writes *writes, VkEvent event);

#endif
