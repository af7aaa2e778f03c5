/* SPDX-License-Identifier: Apache-2.0 */
/* Reads settings through the Vulkan utility library, which converts values of any type to text. */
#include <stdlib.h>
#include <string.h>

#include "src/report/settings/guard.h"
#include "src/report/settings/source.h"

VkResult settings_reader_open(struct settings_source *source)
{
    return settings_guard_create(SETTINGS_LAYER, &source->given_info, &source->set);
}

void settings_reader_close(struct settings_source *source)
{
    if (source->set)
        vkuDestroyLayerSettingSet(source->set, NULL);
}

static VkResult join(const char *const *texts, uint32_t count, char separator, char **joined)
{
    size_t size = 1;
    for (uint32_t i = 0; i < count; i++) {
        if (!texts[i]) /* the library has counted the values of one source and read another's */
            return VK_ERROR_OUT_OF_HOST_MEMORY;
        size += strlen(texts[i]) + 1;
    }
    char *end = *joined = malloc(size);
    if (!end)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (uint32_t i = 0; i < count; i++) {
        if (i)
            *end++ = separator;
        const size_t length = strlen(texts[i]);
        memcpy(end, texts[i], length + 1);
        end += length;
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
