/* SPDX-License-Identifier: Apache-2.0 */
/* What tests of the order share: handles are small numbers of the test's choice. */
#ifndef ASSAY_TESTS_ORDER_ORDER_H
#define ASSAY_TESTS_ORDER_ORDER_H

#include "src/state/order/order.h"
#include "tests/unit/unit_test.h"

#define QUEUE(number) ((VkQueue)(uintptr_t)(number))
#define COMMAND_BUFFER(number) ((VkCommandBuffer)(uintptr_t)(number))
#define SEMAPHORE(number) ((VkSemaphore)(uintptr_t)(number))
#define FENCE(number) ((VkFence)(uintptr_t)(number))

/* The call succeeds; fence 0: none. */
static inline void finish_batches(struct submission *submission, uint32_t fence)
{
    submission_set_fence(submission, FENCE(fence));
    assert_false(submission_prepare(submission));
    submission_finish(submission, VK_SUCCESS);
}

#endif
