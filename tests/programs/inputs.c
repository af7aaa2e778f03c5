/* SPDX-License-Identifier: Apache-2.0 */
/* Input data of programs, which the host writes:
 *
 *     init PLACE grid SIDE STEP [X]    a plane of SIDE * SIDE squares from X, three floats a vertex
 *     init PLACE mesh SIDE             the indices of their triangles, of 32 bits
 *     init PLACE short-mesh SIDE       of 16 bits
 *     init PLACE soup COUNT [SEED]     triangles anywhere in a cube, three vertices each
 *     init PLACE row COUNT STEP NAME   instances of a structure along x
 *     init PLACE floats NUMBER...
 *     init PLACE numbers NUMBER...     of 32 bits */
#include "play.h"

#include <stdlib.h>

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
        play_write_instances(play, &to[i], (char *[]){words[5], NULL}, false);
        to[i].transform.matrix[0][3] = step * (float)i;
    }
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
