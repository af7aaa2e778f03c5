/* SPDX-License-Identifier: Apache-2.0 */
/* The report of a lost device, with the driver's vendor-independent fault information. */
#include "layer/postmortem/postmortem.h"

#include "layer/execution/input_checks.h"
#include "layer/snapshots/snapshots.h"
#include "src/base/text_buffer.h"
#include "src/report/message.h"
#include "src/report/words.h"

static const char *words_of(VkDeviceFaultAddressTypeEXT type)
{
    switch (type) {
    case VK_DEVICE_FAULT_ADDRESS_TYPE_READ_INVALID_EXT:
        return "invalid read at ";
    case VK_DEVICE_FAULT_ADDRESS_TYPE_WRITE_INVALID_EXT:
        return "invalid write at ";
    case VK_DEVICE_FAULT_ADDRESS_TYPE_EXECUTE_INVALID_EXT:
        return "attempt to execute at ";
    case VK_DEVICE_FAULT_ADDRESS_TYPE_INSTRUCTION_POINTER_UNKNOWN_EXT:
        return "instruction at ";
    case VK_DEVICE_FAULT_ADDRESS_TYPE_INSTRUCTION_POINTER_INVALID_EXT:
        return "invalid instruction at ";
    case VK_DEVICE_FAULT_ADDRESS_TYPE_INSTRUCTION_POINTER_FAULT_EXT:
        return "faulting instruction at ";
    default:
        return "address ";
    }
}

static bool is_of_data(VkDeviceFaultAddressTypeEXT type)
{
    return type == VK_DEVICE_FAULT_ADDRESS_TYPE_READ_INVALID_EXT ||
           type == VK_DEVICE_FAULT_ADDRESS_TYPE_WRITE_INVALID_EXT;
}

/* Appends the objects whose range has the address, or part of the range that the driver's precision
 * leaves. */
static void append_objects(const struct layer_device *device,
                           const VkDeviceFaultAddressInfoEXT *fault, struct text_buffer *text)
{
    struct destroyed_object destroyed;
    const struct words words = {.text = text, .names = device->names};
    const struct resources_at at = resources_find_at(device->resources, fault->reportedAddress);
    if (at.structure)
        words_say(&words, ", in {}",
                  object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, handle_number(at.structure)));
    if (at.buffer) {
        words_say(&words, ", in {}", object(VK_OBJECT_TYPE_BUFFER, handle_number(at.buffer)));
    } else if (destroyed_objects_find_range(device->destroyed, fault->reportedAddress,
                                            &destroyed)) {
        text_append(text, ", in ");
        words_append_object(&words, destroyed.type, destroyed.handle, destroyed.name);
        text_append(text, ", which was destroyed");
    }
}

static void append_address(const struct layer_device *device,
                           const VkDeviceFaultAddressInfoEXT *fault, struct text_buffer *text)
{
    text_say(text, "\n  {}{}", phrase(words_of(fault->addressType)), hex(fault->reportedAddress));
    if (fault->addressPrecision > 1)
        text_say(text, " (somewhere in the {} around it)",
                 count_of(fault->addressPrecision, "byte"));
    if (is_of_data(fault->addressType))
        append_objects(device, fault, text);
}

/* What the driver says of the fault. */
struct device_fault {
    VkDeviceFaultAddressInfoEXT addresses[FAULTS_MAX];
    VkDeviceFaultInfoEXT info;
    uint32_t count;
};

/* Returns false if the application has not enabled the feature deviceFault, or if the driver has
 * nothing to say. */
static bool find_device_fault(const struct layer_device *device, struct device_fault *fault)
{
    VkDeviceFaultCountsEXT counts = {.sType = VK_STRUCTURE_TYPE_DEVICE_FAULT_COUNTS_EXT};
    if (!device->facts.device_fault || !device->vk.GetDeviceFaultInfoEXT ||
        device->vk.GetDeviceFaultInfoEXT(device->handle, &counts, NULL) < VK_SUCCESS)
        return false;
    if (counts.addressInfoCount > FAULTS_MAX)
        counts.addressInfoCount = FAULTS_MAX;
    counts.vendorInfoCount = 0;
    counts.vendorBinarySize = 0;
    fault->info = (VkDeviceFaultInfoEXT){.sType = VK_STRUCTURE_TYPE_DEVICE_FAULT_INFO_EXT,
                                         .pAddressInfos = fault->addresses};
    if (device->vk.GetDeviceFaultInfoEXT(device->handle, &counts, &fault->info) < VK_SUCCESS)
        return false;
    fault->count = counts.addressInfoCount;
    return fault->count || fault->info.description[0];
}

/* The precision is the size of the aligned bytes among which the address is, a power of two. */
static struct pending_faults addresses_of_data(const struct layer_device *device,
                                               const struct device_fault *fault)
{
    struct pending_faults faults = {0};
    for (uint32_t i = 0; i < fault->count; i++) {
        const VkDeviceFaultAddressInfoEXT *at = &fault->addresses[i];
        const uint64_t size = at->addressPrecision ? at->addressPrecision : 1;
        const uint64_t begin = at->reportedAddress & ~(size - 1);
        if (!is_of_data(at->addressType))
            continue;
        const struct resources_at there = resources_find_at(device->resources, at->reportedAddress);
        faults.ranges[i].begin = begin;
        faults.ranges[i].end = begin + size;
        faults.ranges[i].structure = handle_number(there.structure);
    }
    return faults;
}

/* Appends the driver's description and addresses, each with the buffer and structure in whose range
 * it lies, live or destroyed. */
static void append_device_fault(const struct layer_device *device, const struct device_fault *fault,
                                struct text_buffer *text)
{
    text_say(text, "The driver reports: {}",
             quoted(fault->info.description, sizeof(fault->info.description)));
    for (uint32_t i = 0; i < fault->count; i++)
        append_address(device, &fault->addresses[i], text);
}

/* ---- the report */

static void report_loss(struct layer_device *device)
{
    char line[MESSAGE_SIZE];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_append(&text, "The device was lost. ");
    struct device_fault fault = {.count = 0};
    const bool has_fault = find_device_fault(device, &fault);
    const struct pending_faults faults = addresses_of_data(device, &fault);
    const uint32_t count = pending_list_append(device, true, fault.count ? &faults : NULL, &text);
    if (has_fault) {
        text_append(&text, count ? "\n" : "");
        append_device_fault(device, &fault, &text);
    }
    if (count || has_fault)
        reporter_report_event(device->instance->reporter, "ASSAY-device-lost", line);
}

void postmortem_report_loss(struct layer_device *device)
{
    if (device->level < LEVEL_EXECUTION || atomic_exchange(&device->loss_reported, true)) {
        execution_order_set_unknown(device->order, ORDER_UNKNOWN_DEVICE_LOST);
        return;
    }
    if (device->snapshots)
        atomic_store(&device->snapshots->device_lost, true);
    snapshots_deliver(device);
    input_checks_read_marked(device->input_checks, "read after the device was lost");
    report_loss(device);
    execution_order_set_unknown(device->order, ORDER_UNKNOWN_DEVICE_LOST);
}
