/* SPDX-License-Identifier: Apache-2.0 */
#include "src/capture/hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

struct capture_hash capture_hash_anywhere(const void *bytes, size_t size, uint64_t seed)
{
    const XXH128_hash_t hash = XXH3_128bits_withSeed(bytes, size, seed);
    return (struct capture_hash){hash.high64, hash.low64};
}

struct capture_hash capture_hash(const void *bytes, size_t size, uint64_t seed)
{
#ifdef CAPTURE_HAS_AVX2
    if (__builtin_cpu_supports("avx2"))
        return capture_hash_by_avx2(bytes, size, seed);
#endif
    return capture_hash_anywhere(bytes, size, seed);
}
