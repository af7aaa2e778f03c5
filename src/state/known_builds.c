/* SPDX-License-Identifier: Apache-2.0 */
/* Keeping builds that were found valid. */
#include "state/known_builds.h"

#include <stdlib.h>
#include <string.h>

enum { FIRST_CAPACITY = 16, FEW_HANDLES = 1024 };

/* The table's records are indices of builds, plus 1; this one stands for what was built once. */
static void *const built_once = (void *)UINTPTR_MAX;

static void *record_of(uint32_t index)
{
    return (void *)((uintptr_t)index + 1);
}

static struct known_build *build_of(const struct known_builds *known, void *record)
{
    return record && record != built_once ? &known->builds[(uintptr_t)record - 1] : NULL;
}

struct known_build *known_builds_search(struct known_builds *known, VkAccelerationStructureKHR dst)
{
    struct known_build *build =
        build_of(known, handle_table_find(&known->by_dst, (uint64_t)(uintptr_t)dst));
    if (build)
        known->next = (uint32_t)(build - known->builds) + 1;
    return build;
}

static bool grow(struct known_builds *known)
{
    uint32_t capacity = known->capacity ? known->capacity * 2 : FIRST_CAPACITY;
    if (known->capacity > UINT32_MAX / 2)
        return false;
    struct known_build *builds =
        aligned_alloc(KNOWN_BUILD_ALIGNMENT, (size_t)capacity * sizeof(*builds));
    if (!builds)
        return false;
    if (known->count)
        memcpy(builds, known->builds, known->count * sizeof(*builds));
    free(known->builds);
    known->builds = builds;
    known->capacity = capacity;
    return true;
}

/* A new one, behind the others. */
static struct known_build *add(struct known_builds *known, VkAccelerationStructureKHR dst)
{
    if (known->count == known->capacity && !grow(known))
        return NULL;
    struct known_build *build = &known->builds[known->count];
    build->dst = dst;
    handle_table_set(&known->by_dst, (uint64_t)(uintptr_t)dst,
                     record_of(known->count++)); /* it has a place there */
    return build;
}

struct known_build *known_builds_room(struct known_builds *known, VkAccelerationStructureKHR dst)
{
    void *record = handle_table_find(&known->by_dst, (uint64_t)(uintptr_t)dst);
    if (!record) {
        handle_table_set(&known->by_dst, (uint64_t)(uintptr_t)dst, built_once);
        return NULL;
    }
    struct known_build *build = record == built_once ? add(known, dst) : build_of(known, record);
    if (build)
        build->in_vain = true;
    return build;
}

void known_builds_trim(struct known_builds *known, size_t alive)
{
    if (known->by_dst.count / 2 > alive)
        known_builds_release(known);
    known->most = alive > FEW_HANDLES / 4 ? alive * 4 : FEW_HANDLES;
}

void known_builds_release(struct known_builds *known)
{
    handle_table_release(&known->by_dst);
    free(known->builds);
    known->by_dst = (struct handle_table){0};
    known->builds = NULL;
    known->count = known->capacity = known->next = 0;
}
