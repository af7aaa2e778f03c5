/* SPDX-License-Identifier: Apache-2.0 */
/* The report of a lost device. */
#include "layer/postmortem/loss.h"

#include "layer/execution/input_checks.h"
#include "layer/postmortem/device_fault.h"
#include "layer/postmortem/pending_list.h"
#include "layer/snapshots/snapshots.h"
#include "src/report/message.h"

static void report(struct layer_device *device)
{
    char line[MESSAGE_SIZE];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_append(&text, "The device was lost. ");
    uint32_t count = pending_list_append(device, true, &text);
    bool has_fault = device_fault_append(device, count != 0, &text);
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
    report(device);
    execution_order_set_unknown(device->order, ORDER_UNKNOWN_DEVICE_LOST);
}
