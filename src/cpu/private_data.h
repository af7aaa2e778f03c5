/* SPDX-License-Identifier: Apache-2.0 */
/* Private data (vkSetPrivateData) of the backend's own objects, which the driver does not have. */
#ifndef ASSAY_CPU_PRIVATE_DATA_H
#define ASSAY_CPU_PRIVATE_DATA_H

#include <vulkan/vulkan_core.h>

#include "src/base/handle_table.h"
#include "src/platform/threads.h"

struct cpu_private_data {
    pthread_mutex_t lock;        /* only held for look-ups */
    struct handle_table objects; /* lists of values, by the object's handle */
};

void cpu_private_data_init(struct cpu_private_data *data);
void cpu_private_data_release(struct cpu_private_data *data);

VkResult cpu_private_data_set(struct cpu_private_data *data, uint64_t object, uint64_t slot,
                              uint64_t value);
uint64_t cpu_private_data_get(struct cpu_private_data *data, uint64_t object, uint64_t slot);
void cpu_private_data_forget_object(struct cpu_private_data *data, uint64_t object);
void cpu_private_data_forget_slot(struct cpu_private_data *data, uint64_t slot);

#endif
