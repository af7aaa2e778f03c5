/* SPDX-License-Identifier: Apache-2.0 */
/* Devices: creation and destruction. */
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "layer/consumers.h"
#include "layer/cpu/overlay.h"
#include "layer/execution/build_records.h"
#include "layer/execution/input_checks.h"
#include "layer/execution/query_writes.h"
#include "layer/execution/submissions.h"
#include "layer/execution/submitted_builds.h"
#include "layer/harsh.h"
#include "layer/hazards/builds.h"
#include "layer/hazards/executed/checks.h"
#include "layer/hazards/executed/host_writes.h"
#include "layer/hazards/recording.h"
#include "layer/intercepts/intercepts.h"
#include "layer/layer.h"
#include "layer/physical_device.h"
#include "layer/postmortem/postmortem.h"
#include "layer/snapshots/guard/execution.h"
#include "layer/snapshots/snapshots.h"
#include "observers.h"
#include "src/state/commands/call_sites.h"
#include "src/state/resources/update_templates.h"

static void apply_settings(struct layer_device *device)
{
    const struct settings *settings = reporter_settings(device->instance->reporter);
    device->level = settings->level;
    device->finds_hazards = settings->hazards && !device->facts.is_group;
    device->records_builds = settings->record_builds;
    device->notes_figures = settings->record_builds;
    if (device->level >= LEVEL_EXECUTION)
        device->build_recorder =
            device->finds_hazards ? hazards_build_recorder() : build_notes_recorder();
    for (enum build_command command = 0; command < COMMAND_COUNT; command++) {
        check_select(command, settings->level, settings->muted, device->active_rules[command]);
        device->checks[command] = checks_are_active(device, command);
    }
}

void layer_free_device(struct layer_device *device)
{
    deferred_operations_destroy(device->deferred);
    execution_order_end(device->order);
    hazard_checks_destroy(device->hazard_checks);
    device->hazard_checks = NULL;
    host_writes_destroy(device->host_writes);
    device->host_writes = NULL;
    input_checks_destroy(device->input_checks);
    submitted_builds_destroy(device->submitted_builds);
    snapshots_release_held(device->snapshots);
    execution_order_destroy(device->order);
    consumers_stop(device);
    submissions_destroy(device->submissions);
    query_writes_destroy(device->query_writes);
    structures_destroy(device->structures);
    command_buffers_destroy(device->command_buffers); /* and their recordings */
    consumers_destroy(device);
    cpu_overlay_end_transfers(device->cpu);
    cpu_overlay_destroy(device->cpu);
    snapshots_destroy(device->snapshots);
    resources_destroy(device->resources);
    size_cache_destroy(device->sizes);
    size_queries_destroy(device->size_queries);
    places_destroy(device->places);
    destroyed_objects_destroy(device->destroyed);
    object_names_destroy(device->names);
    queue_labels_destroy(device->queue_labels);
    query_pools_destroy(device->query_pools);
    update_templates_destroy(device->update_templates);
    events_destroy(device->events);
    call_sites_destroy(device->call_sites);
    hazard_objects_destroy(device->hazard_objects);
    for (unsigned i = 0; i < READER_LOCK_STRIPES; i++)
        check_free_sweep(atomic_load(&device->spare_sweeps[i].sweep));
    free(device->queue_families);
    free(device);
}

/* Allocates everything that may run out of memory, before the device is created below. */
struct layer_device *layer_allocate_device(void)
{
    struct layer_device *device = calloc(1, sizeof(*device));
    if (!device)
        return NULL;
    device->update_templates = update_templates_create();
    if (resources_create(&device->resources) == VK_SUCCESS &&
        command_buffers_create(&device->command_buffers) == VK_SUCCESS &&
        size_cache_create(&device->sizes) == VK_SUCCESS &&
        size_queries_create(&device->size_queries) == VK_SUCCESS &&
        destroyed_objects_create(&device->destroyed) == VK_SUCCESS &&
        object_names_create(&device->names) == VK_SUCCESS &&
        queue_labels_create(&device->queue_labels) == VK_SUCCESS &&
        query_pools_create(&device->query_pools) == VK_SUCCESS &&
        events_create(&device->events) == VK_SUCCESS &&
        deferred_operations_create(&device->deferred, host_work_end) == VK_SUCCESS)
        return device;
    layer_free_device(device);
    return NULL;
}

static struct structures *create_structures(const struct layer_device *device)
{
    const bool has_micromaps = device->facts.micromap.ext || device->facts.micromap.khr;
    enum structures_keeping keeping = KEEPS_NOTHING;
    if (device->level >= LEVEL_CONTENT)
        keeping = has_micromaps ? KEEPS_FLAGS : KEEPS_SERIALS;
    return structures_create(keeping, consumers_inputs(device));
}

VkResult layer_track_submissions(struct layer_device *device)
{
    if (device->level < LEVEL_EXECUTION && !device->cpu)
        return VK_SUCCESS;
    device->structures = create_structures(device);
    VkResult result = device->structures ? submissions_create(device, &device->submissions)
                                         : VK_ERROR_OUT_OF_HOST_MEMORY;
    if (result != VK_SUCCESS)
        return result;
    if (device->level >= LEVEL_EXECUTION)
        device->query_writes = query_writes_create();
    const struct execution_hooks hooks = submissions_hooks(device->submissions);
    result = execution_order_create(&device->order, &hooks);
    if (result == VK_SUCCESS)
        result = hazard_checks_create(device);
    if (result == VK_SUCCESS)
        result = host_writes_create(device);
    if (result == VK_SUCCESS && device->level >= LEVEL_EXECUTION)
        result = submitted_builds_create(device, &device->submitted_builds);
    return result;
}

/* Creates the device below the layer. */
static VkResult create_device(struct layer_device *device, PFN_vkCreateDevice create,
                              const VkDeviceCreateInfo *create_info,
                              const VkAllocationCallbacks *allocator, VkDevice *handle)
{
    VkLayerDeviceCreateInfo *link =
        layer_link(create_info->pNext, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    VkLayerDeviceLink *below = link->u.pLayerInfo;
    if (device->instance->backend == BACKEND_CPU)
        return cpu_create_device(device, create, create_info, allocator, handle);
    const VkDeviceCreateInfo *info = create_info;
    VkResult result = consumers_begin(device, &info);
    if (result == VK_SUCCESS)
        result = create(device->physical_device, info, allocator, handle);
    if (result != VK_SUCCESS && info != create_info) {
        consumers_refuse(device);
        link->u.pLayerInfo = below; /* the first attempt may have changed it */
        result = create(device->physical_device, create_info, allocator, handle);
    }
    return result;
}

/* Adds consumers in the order in which they are called: builds are executed before they are
 * validated. */
VkResult layer_register_consumers(struct layer_device *device)
{
    struct execution_order *order = device->order;
    bool has_room = true;
    if (!order)
        return VK_SUCCESS;
#define ADD(is_present, consumer)                                                                  \
    if (is_present)                                                                                \
        has_room &= execution_order_add_consumer(order, consumer);
    ADD(true, submissions_consumer(device->submissions))
    ADD(device->snapshots && device->snapshots->guard, guard_consumer(device))
    ADD(device->records_builds, build_records_consumer(device))
    has_room &= consumers_add_to_order(device);
    ADD(device->submitted_builds, submitted_builds_consumer(device->submitted_builds))
    ADD(device->hazard_checks, hazard_checks_consumer(device->hazard_checks))
    ADD(device->host_writes, host_writes_consumer(device->host_writes))
    ADD(device->snapshots, snapshots_consumer(device->snapshots))
    ADD(device->cpu, cpu_overlay_consumer(device))
    ADD(device->input_checks, input_checks_consumer(device->input_checks))
#undef ADD
    return has_room ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
}

static bool has_driver_properties(const struct layer_device *device)
{
    const struct layer_instance *instance = device->instance;
    if (physical_device_api_version(instance, device->physical_device) >= VK_API_VERSION_1_2)
        return true;
    return physical_device_has_extension(device, VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME);
}

/* Adds the device to the record of log_format = json. */
static void report_device(const struct layer_device *device)
{
    const struct layer_instance *instance = device->instance;
    if (reporter_settings(instance->reporter)->log_format != LOG_FORMAT_JSON)
        return;
    VkPhysicalDeviceDriverProperties driver = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES,
    };
    VkPhysicalDeviceProperties2 properties = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
    };
    PFN_vkGetPhysicalDeviceProperties2 query =
        physical_device_properties2(instance, &instance->vk, device->physical_device);
    if (query && has_driver_properties(device)) {
        properties.pNext = &driver;
        query(device->physical_device, &properties);
    } else {
        instance->vk.GetPhysicalDeviceProperties(device->physical_device, &properties.properties);
    }
    reporter_add_device(instance->reporter, device->handle, properties.properties.deviceName,
                        &driver);
}

static VkResult set_up(struct layer_device *device, const VkDeviceCreateInfo *create_info,
                       PFN_vkGetDeviceProcAddr next_proc_addr)
{
    vkuInitDeviceDispatchTable(device->handle, &device->vk, next_proc_addr);
    VkResult result = layer_collect_device_facts(device, create_info);
    if (result == VK_SUCCESS && device->facts.has_other_builders) {
        device->places = places_create(device->resources);
        result = device->places ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    if (result != VK_SUCCESS)
        return result;
    apply_settings(device);
    call_sites_enable(device);
    if (device->finds_hazards)
        device->hazard_objects = hazard_objects_create();
    if (device->instance->backend == BACKEND_CPU)
        result = cpu_overlay_create(device, create_info);
    harsh_cover_device(device);
    if (result == VK_SUCCESS)
        result = snapshots_create(device, create_info, device->cpu ? &device->cpu->down : NULL);
    if (result == VK_SUCCESS)
        result = input_checks_create(device);
    if (result == VK_SUCCESS)
        result = consumers_start(device);
    if (result == VK_SUCCESS)
        result = layer_track_submissions(device);
    if (result == VK_SUCCESS)
        result = layer_register_consumers(device);
    if (result != VK_SUCCESS)
        return result;
    layer_add_device(device);
    crash_add_device(device);
    report_device(device);
    return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_CreateDevice(VkPhysicalDevice physicalDevice,
                                                  const VkDeviceCreateInfo *pCreateInfo,
                                                  const VkAllocationCallbacks *pAllocator,
                                                  VkDevice *pDevice)
{
    struct layer_instance *instance = layer_find_instance(physicalDevice);
    VkLayerDeviceCreateInfo *link =
        layer_link(pCreateInfo->pNext, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    if (!instance || !link || !link->u.pLayerInfo)
        return VK_ERROR_INITIALIZATION_FAILED;
    PFN_vkGetInstanceProcAddr next_instance_proc_addr =
        link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    PFN_vkGetDeviceProcAddr next_proc_addr = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    PFN_vkCreateDevice create =
        (PFN_vkCreateDevice)next_instance_proc_addr(instance->handle, "vkCreateDevice");
    if (!create)
        return VK_ERROR_INITIALIZATION_FAILED;

    struct layer_device *device = layer_allocate_device();
    if (!device)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    device->physical_device = physicalDevice;
    device->instance = instance;
    VkResult result = create_device(device, create, pCreateInfo, pAllocator, pDevice);
    if (result != VK_SUCCESS)
        goto fail_create;

    device->handle = *pDevice;
    result = set_up(device, pCreateInfo, next_proc_addr);
    if (result != VK_SUCCESS)
        goto fail_set_up;
    return VK_SUCCESS;

fail_set_up:;
    PFN_vkDestroyDevice destroy = device->vk.DestroyDevice;
    layer_free_device(device);
    destroy(*pDevice, pAllocator);
    *pDevice = VK_NULL_HANDLE;
    return result;
fail_create:
    layer_free_device(device);
    return result;
}

VKAPI_ATTR void VKAPI_CALL assay_DestroyDevice(VkDevice device,
                                               const VkAllocationCallbacks *pAllocator)
{
    struct layer_device *state = device ? layer_find_device(device) : NULL;
    if (!state)
        return;
    while (state->snapshots && execution_order_wait(state->order))
        continue;
    snapshots_deliver(state);
    consumers_conclude(state, true);
    crash_remove_device(state);
    layer_remove_device(state);
    PFN_vkDestroyDevice destroy = state->vk.DestroyDevice;
    layer_free_device(state); /* first, because it owns objects of the device */
    destroy(device, pAllocator);
}
