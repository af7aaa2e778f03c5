/* SPDX-License-Identifier: Apache-2.0 */
/* Compiled for processors with AVX2 (CMakeLists.txt). */
#include "src/capture/hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

struct capture_hash capture_hash_by_avx2(const void *bytes, size_t size, uint64_t seed)
{
    const XXH128_hash_t hash = XXH3_128bits_withSeed(bytes, size, seed);
    return (struct capture_hash){hash.high64, hash.low64};
}
