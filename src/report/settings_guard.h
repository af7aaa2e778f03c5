/* SPDX-License-Identifier: Apache-2.0 */
/* The utility library's functions that allocate. It is written in C++ and throws where it gets no
 * memory, which would end the application; here that is VK_ERROR_OUT_OF_HOST_MEMORY. */
#ifndef ASSAY_REPORT_SETTINGS_GUARD_H
#define ASSAY_REPORT_SETTINGS_GUARD_H

#include <vulkan/layer/vk_layer_settings.h>

#ifdef __cplusplus
extern "C" {
#endif

VkResult settings_guard_create(const char *layer, const VkLayerSettingsCreateInfoEXT *first,
                               VkuLayerSettingSet *set);
VkResult settings_guard_texts(VkuLayerSettingSet set, const char *key, uint32_t *count,
                              const char **texts);

#ifdef __cplusplus
}
#endif

#endif
