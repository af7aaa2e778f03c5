/* SPDX-License-Identifier: Apache-2.0 */
/* Vertex formats: the formats that every implementation supports, and all other formats of 8, 16
 * and 32 bits per component that the specification allows. A missing Z is 0, and a fourth
 * component is ignored (VkAccelerationStructureGeometryTrianglesDataKHR). And indices. */
#include "src/bvh/input/formats.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* The 10 fraction bits of a half fit the 23 bits of a float, and all exponents of a half are normal
 * in a float. */
float float_from_half(uint16_t half)
{
    uint32_t sign = (uint32_t)(half & 0x8000) << 16, exponent = half >> 10 & 0x1f;
    uint32_t fraction = half & 0x3ff, bits;
    if (exponent == 0) {
        float tiny = (float)fraction * 0x1p-24f;
        memcpy(&bits, &tiny, sizeof(bits));
    } else if (exponent == 0x1f) {
        bits = 0x7f800000 | fraction << 13;
    } else {
        bits = (exponent + 112) << 23 | fraction << 13;
    }
    bits |= sign;
    float value;
    memcpy(&value, &bits, sizeof(value));
    return value;
}

/* "Conversion From Normalized Fixed-Point to Floating-Point": the lowest SNORM value also
 * represents -1. */
static float from_snorm(int32_t value, int32_t largest)
{
    return value < -largest ? -1.0f : (float)value / (float)largest;
}

static void read_float(const uint8_t *from, float *to, int count)
{
    memcpy(to, from, (size_t)count * sizeof(float));
}

static void read_half(const uint8_t *from, float *to, int count)
{
    for (int i = 0; i < count; i++) {
        uint16_t bits;
        memcpy(&bits, from + 2 * i, sizeof(bits));
        to[i] = float_from_half(bits);
    }
}

static void read_snorm16(const uint8_t *from, float *to, int count)
{
    for (int i = 0; i < count; i++) {
        int16_t value;
        memcpy(&value, from + 2 * i, sizeof(value));
        to[i] = from_snorm(value, INT16_MAX);
    }
}

static void read_unorm16(const uint8_t *from, float *to, int count)
{
    for (int i = 0; i < count; i++) {
        uint16_t value;
        memcpy(&value, from + 2 * i, sizeof(value));
        to[i] = (float)value / (float)UINT16_MAX;
    }
}

static void read_snorm8(const uint8_t *from, float *to, int count)
{
    for (int i = 0; i < count; i++)
        to[i] = from_snorm((int8_t)from[i], INT8_MAX);
}

static void read_unorm8(const uint8_t *from, float *to, int count)
{
    for (int i = 0; i < count; i++)
        to[i] = (float)from[i] / (float)UINT8_MAX;
}

/* A2B10G10R10: X is in the lowest bits. */
static void read_unorm10(const uint8_t *from, float *to, int count)
{
    uint32_t bits;
    memcpy(&bits, from, sizeof(bits));
    for (int i = 0; i < count; i++)
        to[i] = (float)(bits >> 10 * i & 0x3ff) / 1023.0f;
}

static void read_snorm10(const uint8_t *from, float *to, int count)
{
    uint32_t bits;
    memcpy(&bits, from, sizeof(bits));
    for (int i = 0; i < count; i++) {
        int32_t value = (int32_t)(bits >> 10 * i & 0x3ff);
        to[i] = from_snorm(value < 512 ? value : value - 1024, 511);
    }
}

#define READERS(type)                                                                              \
    static void read_##type##_2(const uint8_t *from, float position[3])                            \
    {                                                                                              \
        read_##type(from, position, 2);                                                            \
        position[2] = 0;                                                                           \
    }                                                                                              \
    static void read_##type##_3(const uint8_t *from, float position[3])                            \
    {                                                                                              \
        read_##type(from, position, 3);                                                            \
    }
READERS(float)
READERS(half)
READERS(snorm16)
READERS(unorm16)
READERS(snorm8)
READERS(unorm8)

static void read_unorm10_3(const uint8_t *from, float position[3])
{
    read_unorm10(from, position, 3);
}

static void read_snorm10_3(const uint8_t *from, float position[3])
{
    read_snorm10(from, position, 3);
}

static const struct vertex_format formats[] = {
    {VK_FORMAT_R32G32B32_SFLOAT, 12, true, read_float_3},
    {VK_FORMAT_R32G32_SFLOAT, 8, true, read_float_2},
    {VK_FORMAT_R32G32B32A32_SFLOAT, 12, true, read_float_3},
    {VK_FORMAT_R16G16_SFLOAT, 4, true, read_half_2},
    {VK_FORMAT_R16G16B16_SFLOAT, 6, true, read_half_3},
    {VK_FORMAT_R16G16B16A16_SFLOAT, 6, true, read_half_3},
    {VK_FORMAT_R16G16_SNORM, 4, false, read_snorm16_2},
    {VK_FORMAT_R16G16B16_SNORM, 6, false, read_snorm16_3},
    {VK_FORMAT_R16G16B16A16_SNORM, 6, false, read_snorm16_3},
    {VK_FORMAT_R16G16_UNORM, 4, false, read_unorm16_2},
    {VK_FORMAT_R16G16B16_UNORM, 6, false, read_unorm16_3},
    {VK_FORMAT_R16G16B16A16_UNORM, 6, false, read_unorm16_3},
    {VK_FORMAT_R8G8_SNORM, 2, false, read_snorm8_2},
    {VK_FORMAT_R8G8B8_SNORM, 3, false, read_snorm8_3},
    {VK_FORMAT_R8G8B8A8_SNORM, 3, false, read_snorm8_3},
    {VK_FORMAT_R8G8_UNORM, 2, false, read_unorm8_2},
    {VK_FORMAT_R8G8B8_UNORM, 3, false, read_unorm8_3},
    {VK_FORMAT_R8G8B8A8_UNORM, 3, false, read_unorm8_3},
    {VK_FORMAT_A2B10G10R10_UNORM_PACK32, 4, false, read_unorm10_3},
    {VK_FORMAT_A2B10G10R10_SNORM_PACK32, 4, false, read_snorm10_3},
};

const struct vertex_format *vertex_format_find(VkFormat format)
{
    for (size_t i = 0; i < sizeof(formats) / sizeof(formats[0]); i++)
        if (formats[i].format == format)
            return &formats[i];
    return NULL;
}

uint32_t radius_format_size(VkFormat format)
{
    switch (format) {
    case VK_FORMAT_R32_SFLOAT:
        return sizeof(float);
    case VK_FORMAT_R16_SFLOAT:
        return sizeof(uint16_t);
    default:
        return 0;
    }
}

/* ---- loops of a fixed number of lanes, which compilers turn into vector instructions */

enum { LANES = 16 };

#define MAX_OF(name, type)                                                                         \
    __attribute__((always_inline)) static inline uint32_t name(const uint8_t *indices,             \
                                                               uint64_t count)                     \
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
