/* SPDX-License-Identifier: Apache-2.0 */
/* What the registry that Assay was built with knows beside the ids; generated at build time from
 * vk.xml and validusage.json. */
#ifndef ASSAY_VUID_TABLES_REGISTRY_H
#define ASSAY_VUID_TABLES_REGISTRY_H

#include <stdbool.h>
#include <stddef.h>

/* "1.4.363": the version of validusage.json. */
extern const char registry_version[];

/* Names of instance and device extensions, in the order of strcmp. */
extern const char *const registry_extensions[];
extern const size_t registry_extension_count;

/* False for an extension that is newer than the registry, whose structures nobody here knows. */
bool registry_knows_extension(const char *name);

#endif
