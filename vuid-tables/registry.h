/* SPDX-License-Identifier: Apache-2.0 */
/* Tables of the registry that Assay was built with, except the ids. Generated at build time from
 * vk.xml and validusage.json. */
#ifndef ASSAY_VUID_TABLES_REGISTRY_H
#define ASSAY_VUID_TABLES_REGISTRY_H

#include <stdbool.h>
#include <stddef.h>
#include <vulkan/vulkan.h>

/* The version of validusage.json, such as "1.4.363". */
extern const char registry_version[];

/* Names of instance and device extensions, in the order of strcmp. */
extern const char *const registry_extensions[];
extern const size_t registry_extension_count;

/* Returns false for an extension that is newer than the registry, whose structures are unknown. */
bool registry_knows_extension(const char *name);

/* Names of VK_KHR_acceleration_structure, VK_KHR_deferred_host_operations, VK_NV_ray_tracing, and
 * of every device extension that needs one of them, sorted. */
extern const char *const registry_ray_tracing[];
extern const size_t registry_ray_tracing_count;

bool registry_is_ray_tracing(const char *extension);

/* Extensions that add values to the enumerants, bits to the flags, or structures to the chains of
 * commands about structures: at most 64. */
extern const char *const registry_owners[];
extern const size_t registry_owner_count;

/* Structures of pNext chains, except those of one platform. */
struct registry_structure {
    VkStructureType type;
    size_t size;
    const char *ray_tracing; /* its name if it has features or properties of ray tracing, or NULL */
    unsigned feature_count;  /* VkBool32 members, from sizeof(VkBaseInStructure) on */
};
extern const struct registry_structure registry_structures[];
extern const size_t registry_structure_count;

/* Returns NULL for a type that is newer than the registry. */
const struct registry_structure *registry_find_structure(VkStructureType type);

#endif
