/* SPDX-License-Identifier: Apache-2.0 */
/* What the driver sees of stages and accesses of ray tracing: submissions and render passes. */
#include <string.h>

#include "backend.h"
#include "below.h"
#include "tests/fixture/objects.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/unit_test.h"

/* ---- the driver */

static struct {
    uint64_t src, dst;
    const void *array; /* only to compare */
    VkMemoryBarrier2 memory2;
    VkSubpassDependency dependency;
    VkSubpassDependency2 dependency2;
} seen;

PLAYED(QueueSubmit)
{
    calls++;
    seen.array = pSubmits;
    seen.src = pSubmits[0].waitSemaphoreCount ? pSubmits[0].pWaitDstStageMask[0] : 0;
    seen.dst = pSubmits[submitCount - 1].waitSemaphoreCount
                   ? pSubmits[submitCount - 1].pWaitDstStageMask[0]
                   : 0;
    return VK_SUCCESS;
}

PLAYED(QueueSubmit2)
{
    calls++;
    seen.array = pSubmits;
    seen.src = pSubmits[0].pWaitSemaphoreInfos[0].stageMask;
    seen.dst = pSubmits[0].pSignalSemaphoreInfos[0].stageMask;
    return VK_SUCCESS;
}

PLAYED(CreateRenderPass)
{
    calls++;
    seen.array = pCreateInfo;
    seen.dependency = *pCreateInfo->pDependencies;
    return VK_SUCCESS;
}

PLAYED(CreateRenderPass2)
{
    calls++;
    seen.array = pCreateInfo;
    seen.dependency2 = *pCreateInfo->pDependencies;
    if (pCreateInfo->pDependencies->pNext)
        seen.memory2 = *(const VkMemoryBarrier2 *)pCreateInfo->pDependencies->pNext;
    return VK_SUCCESS;
}

static void clear(void)
{
    memset(&seen, 0, sizeof(seen));
    below_clear();
}

/* ---- submissions */

TEST_OPENED(test_submissions, clear)
{
    const VkPipelineStageFlags plain = COMPUTE, traced = BUILD | COMPUTE;
    const VkSemaphore semaphore = VK_NULL_HANDLE;
    const VkSubmitInfo submits[] = {
        {.waitSemaphoreCount = 1, .pWaitSemaphores = &semaphore, .pWaitDstStageMask = &plain},
        {0},
        {.waitSemaphoreCount = 1, .pWaitSemaphores = &semaphore, .pWaitDstStageMask = &traced},
    };
    GET(cpu_QueueSubmit(QUEUE, 2, submits, VK_NULL_HANDLE));
    assert_ptr_equal(seen.array, submits);
    GET(cpu_QueueSubmit(QUEUE, 3, submits, VK_NULL_HANDLE));
    assert_int_equal(seen.src, COMPUTE);
    assert_int_equal(seen.dst, ALL | COMPUTE);
    assert_int_equal(traced, BUILD | COMPUTE);
}

TEST_OPENED(test_submissions2, clear)
{
    VkSemaphoreSubmitInfo wait = {.stageMask = COMPUTE}, signal = {.stageMask = COMPUTE};
    const VkSubmitInfo2 submit = {.waitSemaphoreInfoCount = 1,
                                  .pWaitSemaphoreInfos = &wait,
                                  .signalSemaphoreInfoCount = 1,
                                  .pSignalSemaphoreInfos = &signal};
    GET(cpu_QueueSubmit2(QUEUE, 1, &submit, VK_NULL_HANDLE));
    assert_ptr_equal(seen.array, &submit);
    signal.stageMask = BUILD;
    GET(cpu_QueueSubmit2(QUEUE, 1, &submit, VK_NULL_HANDLE));
    assert_int_equal(seen.src, COMPUTE);
    assert_int_equal(seen.dst, ALL);
    wait.stageMask = BUILD;
    signal.stageMask = COMPUTE;
    GET(cpu_QueueSubmit2(QUEUE, 1, &submit, VK_NULL_HANDLE));
    assert_int_equal(seen.src, ALL);
    assert_int_equal(seen.dst, COMPUTE);
}

TEST_OPENED(test_submissions_without_memory, clear)
{
    static VkSubmitInfo submits[MANY];
    static const VkPipelineStageFlags traced = BUILD;
    submits[0].waitSemaphoreCount = 1;
    submits[0].pWaitDstStageMask = &traced;
    memory_fail_after(0);
    assert_int_equal(cpu_QueueSubmit(QUEUE, MANY, submits, VK_NULL_HANDLE),
                     VK_ERROR_OUT_OF_HOST_MEMORY);
    assert_true(memory_fail_no_more());
    assert_int_equal(calls, 0);
}

/* ---- render passes */

TEST_OPENED(test_render_pass, clear)
{
    VkSubpassDependency dependency = {.srcSubpass = VK_SUBPASS_EXTERNAL,
                                      .srcStageMask = COMPUTE,
                                      .dstStageMask = COMPUTE,
                                      .srcAccessMask = SHADER_WRITE,
                                      .dstAccessMask = SHADER_READ};
    const VkRenderPassCreateInfo info = {.dependencyCount = 1, .pDependencies = &dependency};
    VkRenderPass pass;
    GET(cpu_CreateRenderPass(DEVICE, &info, NULL, &pass));
    assert_ptr_equal(seen.array, &info);
    dependency.srcStageMask = BUILD;
    dependency.srcAccessMask = WRITE;
    GET(cpu_CreateRenderPass(DEVICE, &info, NULL, &pass));
    assert_int_equal(seen.dependency.srcSubpass, VK_SUBPASS_EXTERNAL);
    assert_int_equal(seen.dependency.srcStageMask, ALL);
    assert_int_equal(seen.dependency.srcAccessMask, MEMORY_READ | MEMORY_WRITE);
    assert_int_equal(seen.dependency.dstAccessMask, SHADER_READ);
}

TEST_OPENED(test_render_pass2, clear)
{
    STRUCT(VkMemoryBarrier2, barrier2, .srcStageMask = COMPUTE, .dstStageMask = COMPUTE);
    const VkSubpassDependency2 dependency = {.pNext = &barrier2};
    const VkRenderPassCreateInfo2 info = {.dependencyCount = 1, .pDependencies = &dependency};
    VkRenderPass pass;
    GET(cpu_CreateRenderPass2(DEVICE, &info, NULL, &pass));
    assert_ptr_equal(seen.array, &info);
    barrier2.dstStageMask = BUILD;
    VkResult result = VK_ERROR_OUT_OF_HOST_MEMORY;
    for (int failing = 0; result != VK_SUCCESS; failing++) {
        memory_fail_after(failing);
        result = cpu_CreateRenderPass2(DEVICE, &info, NULL, &pass);
        assert_int_equal(result, memory_fail_no_more() ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_SUCCESS);
    }
    assert_int_equal(seen.memory2.dstStageMask, ALL);
    assert_int_equal(seen.memory2.srcStageMask, COMPUTE);
    assert_int_equal(barrier2.dstStageMask, BUILD);
}

TEST_OPENED(test_render_pass2_with_many_dependencies, clear)
{
    static VkSubpassDependency2 dependencies[MANY];
    const VkRenderPassCreateInfo2 info = {.dependencyCount = MANY, .pDependencies = dependencies};
    VkRenderPass pass;
    dependencies[0].dstStageMask = BUILD;
    GET(cpu_CreateRenderPass2(DEVICE, &info, NULL, &pass));
    assert_int_equal(seen.dependency2.dstStageMask, ALL);
}
