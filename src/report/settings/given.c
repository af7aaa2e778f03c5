/* SPDX-License-Identifier: Apache-2.0 */
/* Settings of VK_EXT_layer_settings as text. In a process with elevated privileges only these
 * count, and the utility library cannot be used: it always reads the environment and a file. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/report/settings/source.h"

enum { NUMBER_SIZE = 32 }; /* bytes of any number; a large double is cut */

static const VkLayerSettingEXT *find(const struct settings_source *source, const char *key)
{
    for (uint32_t i = 0; i < source->given_info.settingCount; i++)
        if (strcmp(source->given[i].pSettingName, key) == 0)
            return &source->given[i];
    return NULL;
}

/* Returns false if the type is not a number type of Vulkan. */
static bool write_number(const VkLayerSettingEXT *setting, uint32_t i, char text[NUMBER_SIZE])
{
#define VALUE(type) (((const type *)setting->pValues)[i])
    switch (setting->type) {
    case VK_LAYER_SETTING_TYPE_BOOL32_EXT:
        snprintf(text, NUMBER_SIZE, "%s", VALUE(VkBool32) ? "true" : "false");
        return true;
    case VK_LAYER_SETTING_TYPE_INT32_EXT:
        snprintf(text, NUMBER_SIZE, "%" PRId32, VALUE(int32_t));
        return true;
    case VK_LAYER_SETTING_TYPE_INT64_EXT:
        snprintf(text, NUMBER_SIZE, "%" PRId64, VALUE(int64_t));
        return true;
    case VK_LAYER_SETTING_TYPE_UINT32_EXT:
        snprintf(text, NUMBER_SIZE, "%" PRIu32, VALUE(uint32_t));
        return true;
    case VK_LAYER_SETTING_TYPE_UINT64_EXT:
        snprintf(text, NUMBER_SIZE, "%" PRIu64, VALUE(uint64_t));
        return true;
    case VK_LAYER_SETTING_TYPE_FLOAT32_EXT:
        snprintf(text, NUMBER_SIZE, "%f", (double)VALUE(float));
        return true;
    case VK_LAYER_SETTING_TYPE_FLOAT64_EXT:
        snprintf(text, NUMBER_SIZE, "%f", VALUE(double));
        return true;
    case VK_LAYER_SETTING_TYPE_STRING_EXT:
    case VK_LAYER_SETTING_TYPE_MAX_ENUM_EXT:
        return false;
    }
#undef VALUE
    return false;
}

static size_t text_size(const VkLayerSettingEXT *setting)
{
    size_t size = 1;
    for (uint32_t i = 0; i < setting->valueCount; i++)
        size += setting->type == VK_LAYER_SETTING_TYPE_STRING_EXT
                    ? strlen(((const char *const *)setting->pValues)[i]) + 1
                    : NUMBER_SIZE;
    return size;
}

VkResult settings_source_given(const struct settings_source *source, const char *key, char **list)
{
    const VkLayerSettingEXT *setting = find(source, key);
    *list = NULL;
    if (!setting || !setting->valueCount)
        return VK_SUCCESS;
    char *end = *list = malloc(text_size(setting));
    if (!end)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    *end = '\0';
    for (uint32_t i = 0; i < setting->valueCount; i++) {
        char number[NUMBER_SIZE];
        const char *text = number;
        if (setting->type == VK_LAYER_SETTING_TYPE_STRING_EXT) {
            text = ((const char *const *)setting->pValues)[i];
        } else if (!write_number(setting, i, number)) {
            free(*list);
            *list = NULL;
            return VK_SUCCESS;
        }
        if (i)
            *end++ = ',';
        const size_t length = strlen(text);
        memcpy(end, text, length + 1);
        end += length;
    }
    return VK_SUCCESS;
}
