/* SPDX-License-Identifier: Apache-2.0 */
/* Instances: creation, destruction, and the layer's properties, also as a tool
 * (VK_EXT_tooling_info). */
#include <stdlib.h>
#include <string.h>

#include "layer/consumers.h"
#include "layer/cpu/overlay.h"
#include "layer/harsh.h"
#include "layer/layer.h"
#include "layer/snapshots/snapshots.h"
#include "observers.h"
#include "src/base/chain.h"
#include "src/platform/modules.h"
#include "src/state/commands/call_sites.h"

static const VkLayerProperties own_layer = {
    .layerName = ASSAY_LAYER_NAME,
    .specVersion = VK_HEADER_VERSION_COMPLETE,
    .implementationVersion = ASSAY_IMPLEMENTATION_VERSION,
    .description = ASSAY_LAYER_DESCRIPTION,
};

static const VkExtensionProperties own_extensions[] = {
    {VK_EXT_DEBUG_REPORT_EXTENSION_NAME, VK_EXT_DEBUG_REPORT_SPEC_VERSION},
    {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_DEBUG_UTILS_SPEC_VERSION},
    {VK_EXT_LAYER_SETTINGS_EXTENSION_NAME, VK_EXT_LAYER_SETTINGS_SPEC_VERSION},
};

enum { OWN_EXTENSIONS = sizeof(own_extensions) / sizeof(own_extensions[0]) };

static bool names_own_layer(const char *layer)
{
    return layer && strcmp(layer, ASSAY_LAYER_NAME) == 0;
}

static VkResult list_layers(uint32_t *count, VkLayerProperties *properties)
{
    if (!properties) {
        *count = 1;
        return VK_SUCCESS;
    }
    if (*count < 1)
        return VK_INCOMPLETE;
    *count = 1;
    properties[0] = own_layer;
    return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL
assay_EnumerateInstanceLayerProperties(uint32_t *pPropertyCount, VkLayerProperties *pProperties)
{
    return list_layers(pPropertyCount, pProperties);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_EnumerateDeviceLayerProperties(VkPhysicalDevice physicalDevice,
                                                                    uint32_t *pPropertyCount,
                                                                    VkLayerProperties *pProperties)
{
    (void)physicalDevice;
    return list_layers(pPropertyCount, pProperties);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_EnumerateInstanceExtensionProperties(
    const char *pLayerName, uint32_t *pPropertyCount, VkExtensionProperties *pProperties)
{
    if (!names_own_layer(pLayerName))
        return VK_ERROR_LAYER_NOT_PRESENT;
    if (!pProperties) {
        *pPropertyCount = OWN_EXTENSIONS;
        return VK_SUCCESS;
    }
    uint32_t room = *pPropertyCount;
    *pPropertyCount = room < OWN_EXTENSIONS ? room : OWN_EXTENSIONS;
    memcpy(pProperties, own_extensions, *pPropertyCount * sizeof(*pProperties));
    return room < OWN_EXTENSIONS ? VK_INCOMPLETE : VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_EnumerateDeviceExtensionProperties(
    VkPhysicalDevice physicalDevice, const char *pLayerName, uint32_t *pPropertyCount,
    VkExtensionProperties *pProperties)
{
    if (names_own_layer(pLayerName)) {
        *pPropertyCount = 0;
        return VK_SUCCESS;
    }
    struct layer_instance *state = layer_find_instance(physicalDevice);
    return state ? state->vk.EnumerateDeviceExtensionProperties(physicalDevice, pLayerName,
                                                                pPropertyCount, pProperties)
                 : VK_ERROR_INITIALIZATION_FAILED;
}

/* Both structures begin with the same members. */
void *layer_link(const void *chain, VkStructureType type)
{
    for (const VkLayerDeviceCreateInfo *link = chain; link; link = link->pNext)
        if (link->sType == type && link->function == VK_LAYER_LINK_INFO)
            return (void *)(uintptr_t)link;
    return NULL;
}

static uint32_t requested_api_version(const VkInstanceCreateInfo *create_info)
{
    const VkApplicationInfo *application = create_info->pApplicationInfo;
    return application && application->apiVersion ? application->apiVersion : VK_API_VERSION_1_0;
}

/* Whether the caller is a layer. The caller is the first address outside this library: the compiler
 * may or may not have left a frame of the library's own entry in front of it. */
static bool is_called_by_layer(const struct call_stack *stack)
{
    struct module_place own, place;
    if (!module_find((uintptr_t)&is_called_by_layer, &own))
        return false;
    for (uint32_t i = 0; i < stack->count && module_find(stack->addresses[i], &place); i++)
        if (strcmp(place.path, own.path) != 0)
            return place.is_layer;
    return false;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_CreateInstance(const VkInstanceCreateInfo *pCreateInfo,
                                                    const VkAllocationCallbacks *pAllocator,
                                                    VkInstance *pInstance)
{
    VkLayerInstanceCreateInfo *link =
        layer_link(pCreateInfo->pNext, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
    if (!link || !link->u.pLayerInfo)
        return VK_ERROR_INITIALIZATION_FAILED;
    PFN_vkGetInstanceProcAddr next_proc_addr = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    PFN_vkCreateInstance create =
        (PFN_vkCreateInstance)next_proc_addr(VK_NULL_HANDLE, "vkCreateInstance");
    if (!create)
        return VK_ERROR_INITIALIZATION_FAILED;

    struct call_stack stack;
    call_stack_walk_tables(__builtin_frame_address(0), __builtin_return_address(0), &stack);
    struct layer_instance *state = calloc(1, sizeof(*state));
    if (!state)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    state->next_physical_device_proc_addr = link->u.pLayerInfo->pfnNextGetPhysicalDeviceProcAddr;
    VkResult result = reporter_create(pCreateInfo, &state->reporter);
    if (result != VK_SUCCESS)
        goto fail_reporter;

    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    result = create(pCreateInfo, pAllocator, pInstance);
    if (result != VK_SUCCESS)
        goto fail_create;

    state->handle = *pInstance;
    state->api_version = requested_api_version(pCreateInfo);
    state->is_below_layer = is_called_by_layer(&stack);
    state->has_properties2 =
        enables_extension(pCreateInfo, VK_KHR_GET_PHYSICAL_DEVICE_PROPERTIES_2_EXTENSION_NAME);
    vkuInitInstanceDispatchTable(*pInstance, &state->vk, next_proc_addr);
    state->backend = reporter_settings(state->reporter)->backend;
    if (state->backend == BACKEND_CPU)
        cpu_overlay_instance(state);
    harsh_cover_instance(state);
    layer_add_instance(state);
    reporter_announce(state->reporter, ASSAY_VERSION);
    reporter_set_instance_alive(state->reporter, true);
    return VK_SUCCESS;

fail_create:
    reporter_destroy(state->reporter);
fail_reporter:
    free(state);
    return result;
}

enum { DEVICES_LEFT = 16 };

struct devices_left {
    struct layer_device *items[DEVICES_LEFT];
    uint32_t count;
};

static void note_left(void *user, struct layer_device *device)
{
    struct devices_left *left = user;
    if (left->count < DEVICES_LEFT)
        left->items[left->count++] = device;
}

static void conclude_devices_left(const struct layer_instance *instance)
{
    struct devices_left left = {.count = 0};
    layer_visit_devices(instance, note_left, &left);
    for (uint32_t i = 0; i < left.count; i++) {
        snapshots_deliver(left.items[i]);
        consumers_conclude(left.items[i], false);
    }
}

VKAPI_ATTR void VKAPI_CALL assay_DestroyInstance(VkInstance instance,
                                                 const VkAllocationCallbacks *pAllocator)
{
    struct layer_instance *state = instance ? layer_find_instance(instance) : NULL;
    if (!state)
        return;
    reporter_set_instance_alive(state->reporter, false);
    conclude_devices_left(state);
    layer_remove_instance(state);
    reporter_summarize(state->reporter);
    state->vk.DestroyInstance(instance, pAllocator);
    reporter_destroy(state->reporter);
    free(state);
}

/* ---- the layer as a tool */

/* Keeps sType and pNext, which are the application's. */
static void fill_properties(VkPhysicalDeviceToolProperties *properties,
                            const struct layer_instance *instance)
{
    VkPhysicalDeviceToolProperties own = {
        .sType = properties->sType,
        .pNext = properties->pNext,
        .name = "Assay",
        .version = ASSAY_VERSION,
        .purposes = VK_TOOL_PURPOSE_VALIDATION_BIT | VK_TOOL_PURPOSE_DEBUG_REPORTING_BIT_EXT,
        .description = ASSAY_LAYER_DESCRIPTION,
        .layer = ASSAY_LAYER_NAME,
    };
    if (instance->backend == BACKEND_CPU)
        own.purposes |=
            VK_TOOL_PURPOSE_ADDITIONAL_FEATURES_BIT | VK_TOOL_PURPOSE_MODIFYING_FEATURES_BIT;
    if (reporter_settings(instance->reporter)->limits == LIMITS_HARSH)
        own.purposes |= VK_TOOL_PURPOSE_MODIFYING_FEATURES_BIT;
    *properties = own;
}

/* Lists the layer, then the tools below. `next` is NULL if the driver lacks the command. The loader
 * may return success without a count if the driver lacks it, so the count begins as 0. */
VkResult list_tools(struct layer_instance *instance, PFN_vkGetPhysicalDeviceToolProperties next,
                    VkPhysicalDevice physical_device, uint32_t *count,
                    VkPhysicalDeviceToolProperties *properties)
{
    uint32_t below = 0, room = *count;
    VkResult result = next ? next(physical_device, &below, NULL) : VK_SUCCESS;
    if (result < VK_SUCCESS)
        return result;
    if (!properties) {
        *count = below + 1;
        return VK_SUCCESS;
    }
    *count = 0;
    if (room == 0)
        return VK_INCOMPLETE;
    if (below) {
        below = room - 1;
        result = next(physical_device, &below, properties + 1);
        if (result < VK_SUCCESS)
            return result;
    }
    fill_properties(&properties[0], instance);
    *count = below + 1;
    return result;
}
