/* SPDX-License-Identifier: Apache-2.0 */
/* The search in the table of extension names. */
#include "registry.h"

#include <stdlib.h>
#include <string.h>

static int compare_name(const void *key, const void *element)
{
    return strcmp(key, *(const char *const *)element);
}

bool registry_knows_extension(const char *name)
{
    return bsearch(name, registry_extensions, registry_extension_count,
                   sizeof(registry_extensions[0]), compare_name) != NULL;
}
