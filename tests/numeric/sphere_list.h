/* SPDX-License-Identifier: Apache-2.0 */
/* Spheres, swept or not, as input of a build. */
#ifndef NUMERIC_SPHERE_LIST_H
#define NUMERIC_SPHERE_LIST_H

#include "cases.h"

/* The vertices' arrays are the caller's. */
struct sphere_list {
    struct fixture_input input;
    const float *centers, *radii;
    uint32_t vertices;
};
void sphere_list_describe(struct sphere_list *list, VkGeometryTypeKHR type, uint32_t primitives);

#endif
