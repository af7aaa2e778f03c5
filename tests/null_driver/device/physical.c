/* SPDX-License-Identifier: Apache-2.0 */
/* Queries of a physical device: features, properties, memory, queue families, extensions. */
#include "tests/null_driver/internal.h"

COMMAND(GetPhysicalDeviceQueueFamilyProperties)
{
    const struct null_driver_config *config = CONFIG(physicalDevice);
    enumerate(pQueueFamilyPropertyCount, pQueueFamilyProperties, config->queue_families,
              config->queue_family_count, sizeof(config->queue_families[0]));
}

COMMAND(GetPhysicalDeviceQueueFamilyProperties2)
{
    const struct null_driver_config *config = CONFIG(physicalDevice);
    if (pQueueFamilyProperties == NULL || *pQueueFamilyPropertyCount > config->queue_family_count)
        *pQueueFamilyPropertyCount = config->queue_family_count;
    if (pQueueFamilyProperties == NULL)
        return;
    for (uint32_t i = 0; i < *pQueueFamilyPropertyCount; i++)
        pQueueFamilyProperties[i].queueFamilyProperties = config->queue_families[i];
}

static void add_extension(VkExtensionProperties *extensions, uint32_t *count, const char *name)
{
    VkExtensionProperties *extension = &extensions[(*count)++];
    *extension = (VkExtensionProperties){.specVersion = 1};
    strncpy(extension->extensionName, name, sizeof(extension->extensionName) - 1);
}

/* Returns how many there are. */
static uint32_t
list_extensions(const struct null_driver_config *config,
                VkExtensionProperties extensions[EXTENSION_COUNT + NULL_DRIVER_MAX_EXTENSIONS])
{
    uint32_t count = 0;
    for (enum guard guard = FIRST_EXTENSION; guard < GUARD_COUNT; guard++) {
        if (guard_is_offered(config, guard))
            add_extension(extensions, &count, guard_extension_name(guard));
    }
    for (uint32_t i = 0; i < config->extra_extension_count; i++)
        add_extension(extensions, &count, config->extra_extensions[i]);
    return count;
}

COMMAND(EnumerateDeviceExtensionProperties)
{
    VkExtensionProperties extensions[EXTENSION_COUNT + NULL_DRIVER_MAX_EXTENSIONS];
    const uint32_t count = list_extensions(CONFIG(physicalDevice), extensions);
    return enumerate(pPropertyCount, pProperties, extensions, count, sizeof(extensions[0]));
}
