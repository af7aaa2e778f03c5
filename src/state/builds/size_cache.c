/* SPDX-License-Identifier: Apache-2.0 */
/* The cache of build sizes: direct-mapped. Readers take no lock and write nothing, because every
 * build of every thread reads it. */
#include "src/state/builds/size_cache.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/recording_path.h"
#include "src/model/geometry_shape.h"
#include "src/platform/aligned.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

enum { ENTRIES = 1024, CACHE_LINE = 64 };
enum { SHAPE_LOW, SHAPE_HIGH, STRUCTURE_SIZE, BUILD_SCRATCH, UPDATE_SCRATCH, WORDS };

/* The words are valid if the version is even, not 0, and the same before and after they are read. A
 * writer makes the version odd first and even last. */
struct size_entry {
    atomic_uint_fast64_t version;
    atomic_uint_fast64_t words[WORDS];
    uint64_t unused[2];
};
_Static_assert(sizeof(struct size_entry) == CACHE_LINE, "a look-up reads one line");

struct size_cache {
    struct size_entry entries[ENTRIES];
};

VkResult size_cache_create(struct size_cache **cache)
{
    *cache = aligned_allocate(CACHE_LINE, sizeof(**cache));
    if (!*cache)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    memset((void *)*cache, 0, sizeof(**cache));
    return VK_SUCCESS;
}

void size_cache_destroy(struct size_cache *cache)
{
    aligned_free(cache);
}

/* Returns false for types whose data is in a chain. Each member of the union begins with sType and
 * pNext. */
static bool has_no_chain(const VkAccelerationStructureGeometryKHR *geometry)
{
    const VkGeometryTypeKHR type = geometry->geometryType;
    return !geometry->pNext &&
           (type_is_triangles(type) || type_is_aabbs(type) || type_is_instances(type)) &&
           !geometry->geometry.triangles.pNext;
}

ON_RECORDING_PATH bool build_shape_of(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                                      const uint32_t *primitive_counts,
                                      VkAccelerationStructureBuildTypeKHR build_type,
                                      struct build_shape *shape)
{
    XXH128_hash_t hash = {
        .low64 = (uint64_t)build_type << 32 | (uint32_t)info->type,
        .high64 = (uint64_t)info->geometryCount << 32 | info->flags,
    };
    for (uint32_t i = 0; i < info->geometryCount; i++) {
        const VkAccelerationStructureGeometryKHR *geometry = build_geometry(info, i);
        const struct {
            XXH128_hash_t before;
            struct geometry_shape shape;
        } next = {hash, geometry_shape_of(geometry, &primitive_counts[i])};
        if (!has_no_chain(geometry))
            return false;
        hash = XXH3_128bits(&next, sizeof(next));
    }
    *shape = (struct build_shape){.low = hash.low64, .high = hash.high64};
    return !info->pNext;
}

/* Release and acquire: a reader that sees a word of a writer also sees the writer's version. */
static inline uint64_t read_word(const struct size_entry *entry, int word)
{
    return atomic_load_explicit(&entry->words[word], memory_order_acquire);
}

static inline void write_word(struct size_entry *entry, int word, uint64_t value)
{
    atomic_store_explicit(&entry->words[word], value, memory_order_release);
}

ON_RECORDING_PATH bool size_cache_find(const struct size_cache *cache,
                                       const struct build_shape *shape, struct size_facts *sizes)
{
    const struct size_entry *entry = &cache->entries[shape->low % ENTRIES];
    uint64_t version = atomic_load_explicit(&entry->version, memory_order_acquire);
    if (!version || version % 2 || read_word(entry, SHAPE_LOW) != shape->low ||
        read_word(entry, SHAPE_HIGH) != shape->high)
        return false;
    const struct size_facts found = {.known = true,
                                     .acceleration_structure = read_word(entry, STRUCTURE_SIZE),
                                     .build_scratch = read_word(entry, BUILD_SCRATCH),
                                     .update_scratch = read_word(entry, UPDATE_SCRATCH)};
    if (atomic_load_explicit(&entry->version, memory_order_relaxed) != version)
        return false;
    *sizes = found;
    return true;
}

void size_cache_add(struct size_cache *cache, const struct build_shape *shape,
                    const struct size_facts *sizes)
{
    struct size_entry *entry = &cache->entries[shape->low % ENTRIES];
    uint64_t version = atomic_load_explicit(&entry->version, memory_order_relaxed);
    if (version % 2 ||
        !atomic_compare_exchange_strong_explicit(&entry->version, &version, version + 1,
                                                 memory_order_acquire, memory_order_relaxed))
        return; /* another thread is writing the entry */
    write_word(entry, SHAPE_LOW, shape->low);
    write_word(entry, SHAPE_HIGH, shape->high);
    write_word(entry, STRUCTURE_SIZE, sizes->acceleration_structure);
    write_word(entry, BUILD_SCRATCH, sizes->build_scratch);
    write_word(entry, UPDATE_SCRATCH, sizes->update_scratch);
    atomic_store_explicit(&entry->version, version + 2, memory_order_release);
}
