/* SPDX-License-Identifier: Apache-2.0 */
/* Wraps the functions of the Vulkan utility library that allocate. The library is written in C++
 * and throws if memory runs out, which would end the application; these functions return
 * VK_ERROR_OUT_OF_HOST_MEMORY instead. */
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
