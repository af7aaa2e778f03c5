/* SPDX-License-Identifier: Apache-2.0 */
/* The debug callback, and the list that it fills. */
#define _GNU_SOURCE /* dl_iterate_phdr() */
#include <link.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plants.h"
#include "tests/fixture/messenger.h"

static char *findings_copy(const char *text)
{
    char *copy = tool_alloc(text ? strlen(text) + 1 : 1, 1);
    return text ? strcpy(copy, text) : copy;
}

MESSENGER_CALLBACK(findings_callback)
{
    struct findings *findings = user;
    if (!findings->planted) {
        ++findings->clean_count;
        printf("finding in the clean scene:\n");
        findings_print(data->pMessage, "    ");
        return VK_FALSE;
    }
    if (findings->count < FINDINGS_KEPT)
        findings->kept[findings->count] =
            (struct finding){findings_copy(data->pMessageIdName), findings_copy(data->pMessage)};
    ++findings->count;
    return !findings->executes;
}

void findings_clear(struct findings *findings)
{
    for (uint32_t i = 0; i < findings->count && i < FINDINGS_KEPT; ++i) {
        free(findings->kept[i].id);
        free(findings->kept[i].text);
    }
    findings->count = 0;
}

bool findings_have(const struct findings *findings, const char *vuid)
{
    for (uint32_t i = 0; i < findings->count && i < FINDINGS_KEPT; ++i)
        if (strcmp(findings->kept[i].id, vuid) == 0)
            return true;
    return false;
}

VkDebugUtilsMessengerCreateInfoEXT findings_messenger(struct findings *findings)
{
    return MAKE(VkDebugUtilsMessengerCreateInfoEXT,
                .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                                   VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
                .pfnUserCallback = findings_callback, .pUserData = findings);
}

void findings_print(const char *text, const char *margin)
{
    while (text && *text) {
        size_t length = strcspn(text, "\n");
        printf("%s%.*s\n", margin, (int)length, text);
        text += length + (text[length] == '\n');
    }
}

/* ---- the layer */

static int findings_is_layer(struct dl_phdr_info *library, size_t size, void *unused)
{
    return strstr(library->dlpi_name, GPU_LAYER_LIBRARY) != NULL;
}

/* Without the layer no message would come, and silence would prove nothing. The loader goes on
 * without a layer whose manifest or library it doesn't find; so look for the library itself. */
void findings_require_layer(void)
{
    if (!dl_iterate_phdr(findings_is_layer, NULL))
        tool_fail("the layer " GPU_LAYER
                  " is not loaded: run scripts/demo, or set "
                  "VK_INSTANCE_LAYERS to its name and VK_LAYER_PATH to its manifest's folder");
}
