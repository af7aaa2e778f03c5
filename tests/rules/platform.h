/* SPDX-License-Identifier: Apache-2.0 */
/* What the cases run on: the installed loader, with the layer of this build tree, over the null
 * driver, over lavapipe, or over a driver that the environment names; its VK_LAYER_PATH, too, stays
 * as it is. Builds are carried out by the driver, or, where "cpu_" is before its name, by the
 * layer. Where "guard_" is before its name, the driver carries out guarded builds.
 */
#ifndef RULES_PLATFORM_H
#define RULES_PLATFORM_H

#include <stdbool.h>
#include <vulkan/utility/vk_dispatch_table.h>
#include <vulkan/vulkan.h>

#include "../null_driver/null_driver.h"

#define LAYER_NAME "VK_LAYER_ASSAY_validation"

struct platform {
    const char *name;
    bool is_null;    /* the null driver, which can be configured and asked for call counts */
    bool is_named;   /* a driver that the environment names, of a GPU perhaps */
    bool is_cpu;     /* the layer's backend is cpu; the null driver then has no ray tracing */
    bool is_guarded; /* setting guard is on */
    struct null_driver_api null_driver;
    PFN_vkGetInstanceProcAddr get_instance_proc_addr;
    /* Makes an allocation of the layer in this thread fail after `after` others have succeeded.
     * `for_good`: all later ones fail, too. -1 as `after`: none fails. NULL: this platform cannot
     * make allocations fail. */
    void (*fail_allocations)(int after, bool for_good);
    /* Between these two calls, allocations of this thread neither fail nor count. NULL if
     * fail_allocations is. */
    int (*pause_allocations)(void);
    void (*resume_allocations)(int before);
};

#define PLATFORM_NAMES "[cpu_|guard_](null|lavapipe|environment)"

/* Opens the loader and sets the environment for it. Returns NULL, or why the platform cannot be
 * used here. A name that is none ends the program. */
const char *platform_open(struct platform *platform, const char *name);
/* Opens the loader alone, and leaves the environment as it is. Returns NULL, or why it cannot. */
const char *platform_open_loader(struct platform *platform);

#endif
