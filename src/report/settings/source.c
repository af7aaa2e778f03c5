/* SPDX-License-Identifier: Apache-2.0 */
/* Reads settings as text; the utility library converts values of any type to text. */
#include "src/report/settings/source.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/elevated.h"
#include "src/report/settings/guard.h"

#define LAYER_NAME "VK_LAYER_ASSAY_validation"

static bool is_readable(const VkLayerSettingEXT *setting)
{
    if (!setting->pLayerName || strcmp(setting->pLayerName, LAYER_NAME) != 0 ||
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
    for (const VkLayerSettingsCreateInfoEXT *info = vkuFindLayerSettingsCreateInfo(create_info);
         info; info = vkuNextLayerSettingsCreateInfo(info)) {
        for (uint32_t i = 0; info->pSettings && i < info->settingCount; i++) {
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
    VkResult result = settings_guard_create(LAYER_NAME, &source->given_info, &source->set);
    if (result != VK_SUCCESS)
        free(source->given);
    return result;
}

void settings_source_close(struct settings_source *source)
{
    if (source->set)
        vkuDestroyLayerSettingSet(source->set, NULL);
    free(source->given);
}

static VkResult join(const char *const *texts, uint32_t count, char separator, char **joined)
{
    size_t size = 1;
    for (uint32_t i = 0; i < count; i++)
        size += strlen(texts[i]) + 1;
    char *end = *joined = malloc(size);
    if (!end)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (uint32_t i = 0; i < count; i++) {
        if (i)
            *end++ = separator;
        end = stpcpy(end, texts[i]);
    }
    return VK_SUCCESS;
}

static VkResult read_texts(const struct settings_source *source, const char *key, bool is_text,
                           char **joined)
{
    if (!source->set)
        return settings_source_given(source, key, joined);
    *joined = NULL;
    uint32_t count = 0;
    if (settings_guard_texts(source->set, key, &count, NULL) == VK_ERROR_OUT_OF_HOST_MEMORY)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    if (count == 0)
        return VK_SUCCESS;

    const char **texts = calloc(count, sizeof(*texts));
    if (!texts)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    VkResult result = settings_guard_texts(source->set, key, &count, texts);
    if (result == VK_SUCCESS) {
        /* The library has split the text at its commas or, if it has none, at its colons. */
        bool was_split_at_colons = is_text && count > 1 && !settings_has_comma(key);
        result = join(texts, count, was_split_at_colons ? ':' : ',', joined);
    }
    free(texts);
    /* A value of an unknown type counts as not set. */
    return result == VK_ERROR_OUT_OF_HOST_MEMORY ? result : VK_SUCCESS;
}

VkResult settings_source_list(const struct settings_source *source, const char *key, char **list)
{
    return read_texts(source, key, false, list);
}

VkResult settings_source_text(const struct settings_source *source, const char *key, char **text)
{
    return read_texts(source, key, true, text);
}
