/* SPDX-License-Identifier: Apache-2.0 */
/* Keeping builds that were found valid. */
#include "src/state/builds/known_builds.h"

#include <stdlib.h>
#include <string.h>

/* Gaps are closed before the array grows if they are more than a GAPS_SHARE-th of it; and of its
 * handles one of HANDLES_SHARE is of what is alive. In the order in which they lie, builds come but
 * for a few jumps in a row. */
enum { FIRST_CAPACITY = 16, GAPS_SHARE = 4, HANDLES_SHARE = 4, JUMPS_IN_ORDER = 4 };

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

static struct known_build *find_build(const struct known_builds *known,
                                      VkAccelerationStructureKHR dst)
{
    return build_of(known, handle_table_find(&known->by_dst, (uint64_t)(uintptr_t)dst));
}

struct known_build *known_builds_search(struct known_builds *known, VkAccelerationStructureKHR dst)
{
    struct known_build *build = find_build(known, dst);
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

/* A handle in the table has a place there: this can't fail. */
static void note_place(struct known_builds *known, uint32_t index)
{
    handle_table_set(&known->by_dst, (uint64_t)(uintptr_t)known->builds[index].dst,
                     record_of(index));
}

static void close_gaps(struct known_builds *known)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < known->count; i++) {
        if (!known->builds[i].dst)
            continue;
        known->builds[count] = known->builds[i];
        note_place(known, count++);
    }
    known->count = count;
    known->gaps = 0;
}

static bool make_room(struct known_builds *known)
{
    if (known->count < known->capacity)
        return true;
    if (known->gaps <= known->capacity / GAPS_SHARE)
        return grow(known);
    close_gaps(known);
    return true;
}

/* A place behind the others, instead of the one that there is; NULL without memory: then nothing
 * has changed. */
static struct known_build *put_behind(struct known_builds *known, VkAccelerationStructureKHR dst)
{
    if (!make_room(known))
        return NULL;
    struct known_build *build = find_build(known, dst);
    if (build) {
        build->dst = VK_NULL_HANDLE;
        build->changes = UINT64_MAX;
        known->gaps++;
    }
    build = &known->builds[known->count];
    build->dst = dst;
    note_place(known, known->count++);
    known->kept = known->count;
    return build;
}

/* Notes which build is kept again; returns whether they still are in the order in which they lie.
 */
static bool note_order(struct known_builds *known, const struct known_build *build)
{
    uint32_t index = (uint32_t)(build - known->builds);
    known->jumps = index == known->kept ? 0 : known->jumps + 1;
    known->kept = index + 1;
    return known->jumps <= JUMPS_IN_ORDER || known->kept == known->count;
}

struct known_build *known_builds_room(struct known_builds *known, VkAccelerationStructureKHR dst)
{
    uint64_t handle = (uint64_t)(uintptr_t)dst;
    void *record = handle_table_find(&known->by_dst, handle);
    known->keeps++;
    if (!record) {
        handle_table_set(&known->by_dst, handle, built_once);
        return NULL;
    }
    struct known_build *build = build_of(known, record), *behind = NULL;
    if (!build || !note_order(known, build))
        behind = put_behind(known, dst);
    if (behind)
        build = behind;
    if (build)
        build->in_vain = true;
    return build;
}

void known_builds_trim(struct known_builds *known, size_t alive)
{
    if (known->by_dst.count / HANDLES_SHARE > alive)
        known_builds_release(known);
    known->keeps = 0;
}

void known_builds_release(struct known_builds *known)
{
    handle_table_release(&known->by_dst);
    free(known->builds);
    known->by_dst = (struct handle_table){0};
    known->builds = NULL;
    known->count = known->capacity = known->next = 0;
    known->kept = known->jumps = known->gaps = 0;
}
