/* SPDX-License-Identifier: Apache-2.0 */
/* Input data of programs, which the host writes:
 *
 *     init PLACE grid SIDE STEP [X]    a plane of SIDE * SIDE squares from X, three floats a vertex
 *     init PLACE mesh SIDE             the indices of their triangles, of 32 bits
 *     init PLACE short-mesh SIDE       of 16 bits
 *     init PLACE soup COUNT [SEED]     triangles anywhere in a cube, three vertices each
 *     init PLACE row COUNT STEP NAME [host]    instances of a structure along x, whose custom
 *                                      indices begin with 100; `host`: for builds of the host
 *     init PLACE moving NAME [host]    three instances of a structure, 160 bytes apart: one that
 *                                      rests, one that moves by 8 along x, one by 16
 *     init PLACE blocks COUNT          dense geometry: tests/fixture/dense_blocks.h
 *     init PLACE zeros BYTES
 *     init PLACE floats NUMBER...
 *     init PLACE numbers NUMBER...     of 32 bits
 *
 * The instances that `moving` writes have y = 0, 2 and 4, custom indices 100 to 102 and the motion
 * types 0 to 2. */
#include "tests/fixture/dense_blocks.h"
#include "tests/player/play.h"

#include <stdlib.h>
#include <string.h>

static void write_grid(float (*to)[3], unsigned side, float step, float x)
{
    for (unsigned i = 0; i < (side + 1) * (side + 1); i++) {
        to[i][0] = x + step * (float)(i % (side + 1));
        to[i][1] = step * (float)(i / (side + 1));
        to[i][2] = 0;
    }
}

static uint32_t mesh_index(unsigned i, unsigned side)
{
    const uint32_t corners[] = {0, 1, side + 1, 1, side + 2, side + 1};
    return i / 6 / side * (side + 1) + i / 6 % side + corners[i % 6];
}

static void write_mesh(void *to, unsigned side, bool is_short)
{
    for (unsigned i = 0; i < 6 * side * side; i++) {
        if (is_short)
            ((uint16_t *)to)[i] = (uint16_t)mesh_index(i, side);
        else
            ((uint32_t *)to)[i] = mesh_index(i, side);
    }
}

/* Each triangle is a tenth as large as the cube. */
static void write_soup(float (*to)[3][3], unsigned count, uint32_t state)
{
    for (unsigned i = 0; i < 9 * count; i++) {
        state = state * 1664525 + 1013904223;
        const float number = (float)(state >> 8) / (float)(1 << 24);
        float *corner = &to[i / 9][i % 9 / 3][i % 3];
        *corner = i % 9 < 3 ? number : to[i / 9][0][i % 3] + number / 10;
    }
}

static void write_row(struct play *play, VkAccelerationStructureInstanceKHR *to, char **words)
{
    const unsigned count = (unsigned)atoi(words[3]);
    const float step = strtof(words[4], NULL);
    for (unsigned i = 0; i < count; i++) {
        play_write_instances(play, &to[i], (char *[]){words[5], NULL}, play_is(words[6], "host"));
        to[i].instanceCustomIndex = 100 + i;
        to[i].transform.matrix[0][3] = step * (float)i;
    }
}

static VkTransformMatrixKHR at(float x, float y)
{
    return (VkTransformMatrixKHR){{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, 0}}};
}

static VkSRTDataNV srt_at(float x, float y)
{
    return (VkSRTDataNV){.sx = 1, .sy = 1, .sz = 1, .qw = 1, .tx = x, .ty = y};
}

static void write_moving(struct play *play, unsigned char *to, char **words)
{
    enum { STRIDE = 160 };
    VkAccelerationStructureInstanceKHR instance;
    play_write_instances(play, &instance, (char *[]){words[3], NULL}, play_is(words[4], "host"));
    const uint64_t reference = instance.accelerationStructureReference;
    const VkAccelerationStructureMotionInstanceNV still = {
        .type = VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_STATIC_NV,
        .data.staticInstance = {.transform = at(0, 0),
                                .instanceCustomIndex = 100,
                                .mask = 0xff,
                                .accelerationStructureReference = reference}};
    const VkAccelerationStructureMotionInstanceNV matrix = {
        .type = VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV,
        .data.matrixMotionInstance = {.transformT0 = at(0, 2),
                                      .transformT1 = at(8, 2),
                                      .instanceCustomIndex = 101,
                                      .mask = 0xff,
                                      .accelerationStructureReference = reference}};
    const VkAccelerationStructureMotionInstanceNV srt = {
        .type = VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV,
        .data.srtMotionInstance = {.transformT0 = srt_at(0, 4),
                                   .transformT1 = srt_at(16, 4),
                                   .instanceCustomIndex = 102,
                                   .mask = 0xff,
                                   .accelerationStructureReference = reference}};
    memcpy(to, &still, sizeof(still));
    memcpy(to + STRIDE, &matrix, sizeof(matrix));
    memcpy(to + (size_t)2 * STRIDE, &srt, sizeof(srt));
}

bool play_init_input(struct play *play, char **words)
{
    unsigned char *to = play_bytes(play, words[1]);
    const char *kind = words[2];
    const unsigned side = words[3] ? (unsigned)atoi(words[3]) : 0;
    if (play_is(kind, "grid"))
        write_grid((float(*)[3])(void *)to, side, strtof(words[4], NULL),
                   words[5] ? strtof(words[5], NULL) : 0);
    else if (play_is(kind, "soup"))
        write_soup((float(*)[3][3])(void *)to, side, words[4] ? (uint32_t)atoi(words[4]) : 1);
    else if (play_is(kind, "row"))
        write_row(play, (VkAccelerationStructureInstanceKHR *)(void *)to, words);
    else if (play_is(kind, "mesh") || play_is(kind, "short-mesh"))
        write_mesh(to, side, play_is(kind, "short-mesh"));
    else if (play_is(kind, "moving"))
        write_moving(play, to, words);
    else if (play_is(kind, "blocks"))
        dense_blocks_write(to, side);
    else if (play_is(kind, "zeros"))
        memset(to, 0, side);
    else if (play_is(kind, "floats"))
        for (unsigned i = 0; words[3 + i]; i++)
            ((float *)(void *)to)[i] = strtof(words[3 + i], NULL);
    else if (play_is(kind, "numbers"))
        for (unsigned i = 0; words[3 + i]; i++)
            ((uint32_t *)(void *)to)[i] = (uint32_t)strtoul(words[3 + i], NULL, 0);
    else
        return false;
    return true;
}
