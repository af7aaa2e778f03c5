/* SPDX-License-Identifier: Apache-2.0 */
/* Collects what the application gives through VK_EXT_layer_settings. library.c or plain.c reads the
 * values. */
#include "src/report/settings/source.h"

#include <stdlib.h>
#include <string.h>

#include "src/platform/process.h"

static bool is_readable(const VkLayerSettingEXT *setting)
{
    if (!setting->pLayerName || strcmp(setting->pLayerName, SETTINGS_LAYER) != 0 ||
        !setting->pSettingName || !setting->pSettingName[0] ||
        (setting->valueCount && !setting->pValues))
        return false;
    if (setting->type != VK_LAYER_SETTING_TYPE_STRING_EXT)
        return true;
    const char *const *texts = setting->pValues;
    for (uint32_t i = 0; i < setting->valueCount; i++)
        if (!texts[i])
            return false;
    return true;
}

static uint32_t collect(const VkInstanceCreateInfo *create_info, VkLayerSettingEXT *given)
{
    uint32_t count = 0;
    for (const VkBaseInStructure *link = create_info->pNext; link; link = link->pNext) {
        const VkLayerSettingsCreateInfoEXT *info = (const VkLayerSettingsCreateInfoEXT *)link;
        if (link->sType != VK_STRUCTURE_TYPE_LAYER_SETTINGS_CREATE_INFO_EXT || !info->pSettings)
            continue;
        for (uint32_t i = 0; i < info->settingCount; i++) {
            if (!is_readable(&info->pSettings[i]))
                continue;
            if (given)
                given[count] = info->pSettings[i];
            count++;
        }
    }
    return count;
}

VkResult settings_source_open(struct settings_source *source,
                              const VkInstanceCreateInfo *create_info)
{
    *source = (struct settings_source){
        .given_info = {.sType = VK_STRUCTURE_TYPE_LAYER_SETTINGS_CREATE_INFO_EXT},
    };
    uint32_t count = collect(create_info, NULL);
    if (count) {
        source->given = malloc(count * sizeof(*source->given));
        if (!source->given)
            return VK_ERROR_OUT_OF_HOST_MEMORY;
        source->given_info.settingCount = collect(create_info, source->given);
        source->given_info.pSettings = source->given;
    }
    if (process_is_elevated())
        return VK_SUCCESS;
    VkResult result = settings_reader_open(source);
    if (result != VK_SUCCESS)
        free(source->given);
    return result;
}

void settings_source_close(struct settings_source *source)
{
    settings_reader_close(source);
    free(source->given);
}
