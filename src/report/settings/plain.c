/* SPDX-License-Identifier: Apache-2.0 */
/* Reads settings as the Vulkan utility library does, for systems without that library. */
#include <stdlib.h>
#include <string.h>

#include "src/platform/files.h"
#include "src/platform/process.h"
#include "src/report/settings/source.h"

VkResult settings_reader_open(struct settings_source *source)
{
    (void)source;
    return VK_SUCCESS;
}

void settings_reader_close(struct settings_source *source)
{
    (void)source;
}

VkResult settings_source_text(const struct settings_source *source, const char *key, char **text)
{
    *text = NULL;
    if (!process_is_elevated()) {
        VkResult result = settings_find_outside(key, text);
        if (*text && !**text) { /* a line without a value: not set */
            free(*text);
            *text = NULL;
            return VK_SUCCESS;
        }
        if (result != VK_SUCCESS || *text)
            return result;
    }
    return settings_source_given(source, key, text);
}

VkResult settings_source_list(const struct settings_source *source, const char *key, char **list)
{
    VkResult result = settings_source_text(source, key, list);
    if (*list && !strchr(*list, ','))
        for (char *c = *list; *c; c++)
            if (*c == FILES_LIST_SEPARATOR)
                *c = ',';
    return result;
}
