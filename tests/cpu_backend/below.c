/* SPDX-License-Identifier: Apache-2.0 */
/* The device, in place of the registry and of the reporter. */
#include "below.h"

#include "layer/cpu/overlay.h"

static struct cpu_overlay overlay;
static struct layer_instance instance;
static struct layer_device device = {.instance = &instance, .cpu = &overlay};
struct cpu_overlay *const below = &overlay;
const char *refused_command;
unsigned calls, refusals;

void below_clear(void)
{
    calls = refusals = 0;
    refused_command = "";
}

struct layer_device *layer_find_device(const void *dispatchable)
{
    return &device;
}

struct layer_device *layer_find_recording_device(VkCommandBuffer handle)
{
    return &device;
}

struct layer_instance *layer_find_instance(const void *dispatchable)
{
    return &instance;
}

bool cpu_advertises(struct layer_instance *of, VkPhysicalDevice physical_device)
{
    return true;
}

void cpu_report_unsupported(const struct layer_instance *of_instance, const char *command,
                            const char *what)
{
    refused_command = command;
    refusals++;
}
