/* SPDX-License-Identifier: Apache-2.0 */
/* The hash of an array: XXH3 with 128 bits. Capturing takes most of its time for it. */
#ifndef ASSAY_CAPTURE_HASH_H
#define ASSAY_CAPTURE_HASH_H

#include <stddef.h>
#include <stdint.h>

struct capture_hash {
    uint64_t high, low;
};

struct capture_hash capture_hash(const void *bytes, size_t size, uint64_t seed);
/* Its two ways, which give the same hash: for any processor, and, if CAPTURE_HAS_AVX2 is defined,
 * for one with AVX2. */
struct capture_hash capture_hash_anywhere(const void *bytes, size_t size, uint64_t seed);
struct capture_hash capture_hash_by_avx2(const void *bytes, size_t size, uint64_t seed);

#endif
