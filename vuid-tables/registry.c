/* SPDX-License-Identifier: Apache-2.0 */
/* Look-ups in the tables of the registry. */
#include "vuid-tables/registry.h"

#include "registry_owners.inc"

#include <stdlib.h>
#include <string.h>

static int compare_name(const void *key, const void *element)
{
    return strcmp(key, *(const char *const *)element);
}

static bool has_name(const char *const *names, size_t count, const char *name)
{
    return bsearch(name, names, count, sizeof(names[0]), compare_name) != NULL;
}

bool registry_knows_extension(const char *name)
{
    return has_name(registry_extensions, registry_extension_count, name);
}

bool registry_is_ray_tracing(const char *extension)
{
    return has_name(registry_ray_tracing, registry_ray_tracing_count, extension);
}
