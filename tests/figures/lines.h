/* SPDX-License-Identifier: Apache-2.0 */
/* Random lines through boxes: of all that meet a box, those that meet a smaller one in it are as
 * many as its surface has of the surface of the other. */
#ifndef FIGURES_LINES_H
#define FIGURES_LINES_H

#include <math.h>

#include "tests/unit/random.h"

struct line {
    double origin[3], direction[3];
};

static inline double random_between(struct random *random, double least, double most)
{
    return least + (most - least) * (double)(random_next(random) >> 11) * 0x1p-53;
}

static inline void random_direction(struct random *random, double direction[3])
{
    double square;
    do {
        square = 0;
        for (int i = 0; i < 3; i++) {
            direction[i] = random_between(random, -1, 1);
            square += direction[i] * direction[i];
        }
    } while (square > 1 || square < 0.01);
    const double size = sqrt(square);
    for (int i = 0; i < 3; i++)
        direction[i] /= size;
}

/* Two vectors at right angles to a direction and to each other. */
static inline void random_plane(const double direction[3], double one[3], double other[3])
{
    const int axis = fabs(direction[0]) < 0.5 ? 0 : fabs(direction[1]) < 0.5 ? 1 : 2;
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    const double size = sqrt(1 - direction[axis] * direction[axis]);
    one[axis] = 0;
    one[next] = -direction[last] / size;
    one[last] = direction[next] / size;
    for (int i = 0; i < 3; i++)
        other[i] =
            direction[(i + 1) % 3] * one[(i + 2) % 3] - direction[(i + 2) % 3] * one[(i + 1) % 3];
}

/* Lines of each direction are spread evenly over the sphere around the box, so not all of them meet
 * it. The origin is outside of the box. */
static inline struct line line_through(struct random *random, const double lower[3],
                                       const double upper[3])
{
    struct line line;
    double radius = 0, one[3], other[3], a, b;
    for (int i = 0; i < 3; i++)
        radius += (upper[i] - lower[i]) * (upper[i] - lower[i]) / 4;
    radius = sqrt(radius);
    random_direction(random, line.direction);
    random_plane(line.direction, one, other);
    do {
        a = random_between(random, -1, 1);
        b = random_between(random, -1, 1);
    } while (a * a + b * b > 1);
    for (int i = 0; i < 3; i++)
        line.origin[i] = (lower[i] + upper[i]) / 2 +
                         radius * (a * one[i] + b * other[i] - 2 * line.direction[i]);
    return line;
}

static inline bool line_meets(const struct line *line, const double lower[3], const double upper[3])
{
    double first = -INFINITY, last = INFINITY;
    for (int i = 0; i < 3; i++) {
        const double a = (lower[i] - line->origin[i]) / line->direction[i],
                     b = (upper[i] - line->origin[i]) / line->direction[i];
        first = fmax(first, fmin(a, b));
        last = fmin(last, fmax(a, b));
    }
    return first <= last;
}

#endif
