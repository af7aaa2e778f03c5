/* SPDX-License-Identifier: Apache-2.0 */
/* A number that stands for bytes: FNV-1a (Fowler, Noll, Vo) of 64 bits. */
#ifndef ASSAY_TESTS_BUILDER_DIGEST_H
#define ASSAY_TESTS_BUILDER_DIGEST_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "src/bvh/trace.h"

#define DIGEST_BEGIN UINT64_C(0xcbf29ce484222325)

static inline void digest_add(uint64_t *digest, const void *bytes, size_t size)
{
    const uint8_t *at = bytes;
    for (size_t i = 0; i < size; i++)
        *digest = (*digest ^ at[i]) * UINT64_C(0x100000001b3);
}

/* The same for words that may be floats. Which NaN an operation gives, and which zero fminf() gives
 * of two, is up to the compiler. */
static inline void digest_add_words(uint64_t *digest, const void *bytes, size_t size)
{
    const uint8_t *at = bytes;
    for (size_t i = 0; i + 4 <= size; i += 4) {
        uint32_t word;
        memcpy(&word, at + i, sizeof(word));
        if ((word & 0x7fffffff) > 0x7f800000)
            word = 0x7fc00000;
        if (word == 0x80000000)
            word = 0;
        digest_add(digest, &word, sizeof(word));
    }
}

/* Member by member: the bytes between them are anything. */
static inline void digest_add_hit(uint64_t *digest, const struct trace_hit *hit)
{
    const uint32_t numbers[] = {hit->geometry, hit->primitive, hit->instance, hit->custom_index,
                                hit->sbt_offset};
    const bool flags[] = {hit->is_aabb, hit->front_face, hit->opaque, hit->is_sphere,
                          hit->is_swept};
    digest_add_words(digest, &hit->t, sizeof(hit->t));
    digest_add_words(digest, &hit->u, sizeof(hit->u));
    digest_add_words(digest, &hit->v, sizeof(hit->v));
    digest_add(digest, numbers, sizeof(numbers));
    digest_add(digest, flags, sizeof(flags));
}

#endif
