/* SPDX-License-Identifier: Apache-2.0 */
/* The first look-ups of a process, by several threads at once: one of them prepares the registry of
 * instances and devices, and the others wait for it. Each child process has first look-ups. */
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vulkan/vk_layer.h>

#include "tests/unit/unit_test.h"

enum { CHILDREN = 200, THREADS = 2 };

VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *pVersionStruct);

static VkNegotiateLayerInterface layer = {.sType = LAYER_NEGOTIATE_INTERFACE_STRUCT,
                                          .loaderLayerInterfaceVersion = 2};

/* The instance is unknown. All threads begin when the last one is ready. */
static void *look_up(void *element)
{
    static const int key;
    static atomic_int ready;
    const void *instance = &key;
    PFN_vkVoidFunction *found = element;
    atomic_fetch_add(&ready, 1);
    while (atomic_load(&ready) < THREADS) {
    }
    *found = layer.pfnGetInstanceProcAddr((VkInstance)&instance, "vkCreateDevice");
    return NULL;
}

static void look_up_first(void)
{
    PFN_vkVoidFunction found[THREADS];
    unit_test_run_threads(THREADS, look_up, found, sizeof(found[0]));
    for (int i = 0; i < THREADS; i++)
        if (!found[i])
            _exit(1);
    exit(0); /* the thread sanitizer then reports what it has found */
}

TEST(the_first_look_ups_of_threads)
{
    assert_int_equal(vkNegotiateLoaderLayerInterfaceVersion(&layer), VK_SUCCESS);
    for (int i = 0; i < CHILDREN; i++) {
        int status = 0;
        fflush(NULL);
        const pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0)
            look_up_first();
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_int_equal(status, 0);
    }
}
