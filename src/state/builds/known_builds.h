/* SPDX-License-Identifier: Apache-2.0 */
/* Builds that were found valid, and what was known of all that they name. What moves is built again
 * in every frame, and mostly with the same buffers: a build that is asked for as it was before need
 * not be judged again, nor looked up, while nothing has changed of what that was found from
 * (resources_generation).
 *
 * Only what is built more than once is kept; of a structure that was built once, its handle. Who
 * uses them takes them, for one at a time may. */
#ifndef ASSAY_STATE_BUILDS_KNOWN_BUILDS_H
#define ASSAY_STATE_BUILDS_KNOWN_BUILDS_H

#include <stdalign.h>
#include <stdatomic.h>

#include "src/base/handle_table.h"
#include "src/state/builds/small_shape.h"
#include "src/state/facts.h"

/* Addresses of a geometry: of its vertices, AABBs or instances; of indices; of a transform. */
enum { KNOWN_INPUTS = 3, KNOWN_BUILD_ALIGNMENT = 64 };

/* A build by the device, of one geometry without chains, which has no source but its dst. */
struct known_build {
    /* What was asked for, */
    alignas(KNOWN_BUILD_ALIGNMENT) VkAccelerationStructureKHR dst;
    VkAccelerationStructureKHR src;
    uint64_t changes; /* and resources_generation then */
    VkDeviceAddress scratch_address, inputs[KNOWN_INPUTS];
    VkBuildAccelerationStructureModeKHR mode;
    uint32_t primitive_offset, first_vertex, transform_offset;
    struct small_shape shape;

    /* What was found: of dst, which is alive and backed by memory; */
    struct {
        uint64_t id;
        VkDeviceSize size, begin;
        VkDeviceMemory memory;
    } accel;
    /* of addresses, each in a buffer. */
    struct {
        uint64_t buffer_id;
        VkDeviceSize bytes_left, begin;
        VkDeviceMemory memory;
    } scratch;
    uint64_t input_buffers[KNOWN_INPUTS]; /* ids */
    struct size_facts sizes;
    bool in_vain; /* it hasn't been found since it was kept */
};
_Static_assert(sizeof(struct known_build) == 4 * (size_t)KNOWN_BUILD_ALIGNMENT,
               "four cache lines are fetched for each");

/* Zero-initialized: none. */
struct known_builds {
    atomic_bool is_taken;
    uint32_t count, capacity;
    struct known_build *builds; /* in the order in which they were kept, and gaps */
    uint32_t next;              /* behind the one that was found last: builds mostly come in the
                                   order in which they came before, time and again */
    uint32_t kept;              /* behind the one that was kept last */
    uint32_t jumps;             /* how many in a row were not kept behind the one before */
    uint32_t gaps;              /* builds of no structure, which nobody asks for */
    int balance;                /* these three: see known_builds_rest */
    uint32_t rest, pause;
    uint32_t keeps;             /* since known_builds_trim */
    struct handle_table by_dst; /* to its build */
};

/* NULL where somebody else has taken them: then nothing is known. */
static inline struct known_builds *known_builds_take(struct known_builds *known)
{
    return atomic_exchange_explicit(&known->is_taken, true, memory_order_acquire) ? NULL : known;
}

static inline void known_builds_give_back(struct known_builds *known)
{
    if (known)
        atomic_store_explicit(&known->is_taken, false, memory_order_release);
}

/* Whether so many builds, the next, are neither to be looked for nor kept. Where most of what is
 * looked for is out of date, as builds change every time, or things come and go all the time, it is
 * more work than it spares: then there are pauses, each twice as long as the one before. */
static inline bool known_builds_rest(struct known_builds *known, uint32_t count)
{
    bool rests = known->rest >= count;
    known->rest = rests ? known->rest - count : 0;
    return rests;
}

/* How many of them were found, which spares about twice what it takes to keep one in vain, and how
 * many were out of date that had been. */
enum { KNOWN_BALANCE = 256, KNOWN_LONGEST_PAUSE = 8192 };
static inline void known_builds_note(struct known_builds *known, uint32_t found, uint32_t in_vain)
{
    known->balance += 2 * (int)found - (int)in_vain;
    if (known->balance >= KNOWN_BALANCE) {
        known->balance = KNOWN_BALANCE;
        known->pause = KNOWN_BALANCE;
    } else if (known->balance <= -KNOWN_BALANCE) {
        known->balance = 0;
        known->rest = known->pause;
        if (known->pause < KNOWN_LONGEST_PAUSE)
            known->pause = known->pause ? known->pause * 2 : KNOWN_BALANCE;
    }
}

/* The rest of known_builds_find. */
struct known_build *known_builds_search(struct known_builds *known, VkAccelerationStructureKHR dst);

/* What was kept of a structure, on its way into the processor's cache, until another is kept; NULL:
 * nothing. */
static inline struct known_build *known_builds_find(struct known_builds *known,
                                                    VkAccelerationStructureKHR dst)
{
    uint32_t next = known->next < known->count ? known->next : 0;
    struct known_build *build;
    if (known->count && known->builds[next].dst == dst) {
        build = &known->builds[next];
        known->next = next + 1;
    } else {
        build = known_builds_search(known, dst);
    }
    for (size_t i = 1; build && i < sizeof(*build) / KNOWN_BUILD_ALIGNMENT; i++)
        __builtin_prefetch((const char *)build + i * KNOWN_BUILD_ALIGNMENT);
    return build;
}

/* Where to keep a build of a structure, all but whose dst and in_vain is to be filled in; NULL:
 * nowhere, as it is the first, or there is no memory. */
struct known_build *known_builds_room(struct known_builds *known, VkAccelerationStructureKHR dst);

/* Whether so many were kept that it is time to ask how many structures are alive. */
enum { KNOWN_KEEPS_BEFORE_TRIM = 1024 };
static inline bool known_builds_wants_trim(const struct known_builds *known)
{
    return known->keeps >= KNOWN_KEEPS_BEFORE_TRIM;
}

/* Where few of those that it has handles of are alive, forgets all: those that are, are soon kept
 * again. */
void known_builds_trim(struct known_builds *known, size_t alive);

void known_builds_release(struct known_builds *known);

#endif
