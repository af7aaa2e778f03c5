/* SPDX-License-Identifier: Apache-2.0 */
/* Catches exceptions of the Vulkan utility library. The only C++ of the layer. */
#include "src/report/settings/guard.h"

#include <exception>

VkResult settings_guard_create(const char *layer, const VkLayerSettingsCreateInfoEXT *first,
                               VkuLayerSettingSet *set)
try {
    /* No error callback: the library reports no errors for values that are read as text. */
    return vkuCreateLayerSettingSet(layer, first, nullptr, nullptr, set);
} catch (const std::exception &) {
    return VK_ERROR_OUT_OF_HOST_MEMORY;
}

VkResult settings_guard_texts(VkuLayerSettingSet set, const char *key, uint32_t *count,
                              const char **texts)
try {
    return vkuGetLayerSettingValues(set, key, VKU_LAYER_SETTING_TYPE_STRING, count, texts);
} catch (const std::exception &) {
    return VK_ERROR_OUT_OF_HOST_MEMORY;
}
