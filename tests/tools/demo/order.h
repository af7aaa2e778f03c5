/* SPDX-License-Identifier: Apache-2.0 */
/* Puts primitives in an order in which neighbours in space are neighbours in memory. */
#ifndef DEMO_ORDER_H
#define DEMO_ORDER_H

#include <stdint.h>

/* Write to `order` a permutation of 0 .. count - 1: halved at its middle, halved again, and so on,
 * every part is compact. lavapipe builds its tree by such halves and doesn't sort, so that a mesh
 * in its file's order takes a hundred times as long to trace. */
void order_by_place(const float (*centres)[3], uint32_t count, uint32_t *order);

#endif
