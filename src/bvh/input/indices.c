/* SPDX-License-Identifier: Apache-2.0 */
/* Loops of a fixed number of lanes, which compilers turn into vector instructions. */
#include "src/bvh/input/indices.h"

#include <math.h>
#include <string.h>

enum { LANES = 16 };

#define MAX_OF(name, type)                                                                         \
    static uint32_t name(const uint8_t *indices, uint64_t count)                                   \
    {                                                                                              \
        type most[LANES] = {0}, some[LANES] = {0};                                                 \
        for (; count >= LANES; count -= LANES, indices += sizeof(some)) {                          \
            memcpy(some, indices, sizeof(some));                                                   \
            for (int i = 0; i < LANES; i++)                                                        \
                most[i] = most[i] > some[i] ? most[i] : some[i];                                   \
        }                                                                                          \
        memset(some, 0, sizeof(some));                                                             \
        memcpy(some, indices, count * sizeof(type));                                               \
        type max = 0;                                                                              \
        for (int i = 0; i < LANES; i++) {                                                          \
            max = max > most[i] ? max : most[i];                                                   \
            max = max > some[i] ? max : some[i];                                                   \
        }                                                                                          \
        return max;                                                                                \
    }

MAX_OF(max_of_8_bits, uint8_t)
MAX_OF(max_of_16_bits, uint16_t)
MAX_OF(max_of_32_bits, uint32_t)

uint32_t indices_max(const uint8_t *indices, uint32_t size, uint64_t count)
{
    if (!count)
        return 0;
    switch (size) {
    case sizeof(uint32_t):
        return max_of_32_bits(indices, count);
    case sizeof(uint16_t):
        return max_of_16_bits(indices, count);
    default:
        return max_of_8_bits(indices, count);
    }
}

/* A float is NaN if its exponent is all ones and its fraction is not 0: shifted left by one, which
 * drops the sign, it exceeds the bits of infinity. */
static bool have_nan(const uint8_t *floats, uint64_t count)
{
    uint32_t found[LANES] = {0}, some[LANES];
    for (; count >= LANES; count -= LANES, floats += sizeof(some)) {
        memcpy(some, floats, sizeof(some));
        for (int i = 0; i < LANES; i++)
            found[i] |= some[i] << 1 > UINT32_C(0xff000000);
    }
    memset(some, 0, sizeof(some));
    memcpy(some, floats, count * sizeof(float));
    uint32_t any = 0;
    for (int i = 0; i < LANES; i++)
        any |= found[i] | (some[i] << 1 > UINT32_C(0xff000000));
    return any != 0;
}

bool positions_have_nan(const uint8_t *positions, uint64_t stride, uint64_t count)
{
    const uint64_t size = 3 * sizeof(float);
    if (!count)
        return false;
    if (stride == size)
        return have_nan(positions, 3 * count);
    for (uint64_t i = 0; i < count; i++) {
        float position[3];
        memcpy(position, positions + stride * i, sizeof(position));
        if (isnan(position[0]) || isnan(position[1]) || isnan(position[2]))
            return true;
    }
    return false;
}
