/* SPDX-License-Identifier: Apache-2.0 */
/* What is bound to sparse buffers, asked in one line each. */
#ifndef ASSAY_TESTS_STATE_SPARSE_FIXTURE_H
#define ASSAY_TESTS_STATE_SPARSE_FIXTURE_H

#include "tests/state/fixture.h"

enum { PAGE = 0x100, PAGES = 48, MEMORIES = 4 };

/* Pieces as they are visited. */
struct pieces {
    struct memory_span spans[64];
    unsigned count;
};

/* Adds one; `user` is struct pieces. */
void note_piece(void *user, const struct memory_span *piece);

/* Of buffer n. */
struct pieces pieces_of(struct resources *resources, unsigned n, VkDeviceSize begin,
                        VkDeviceSize end);

/* A sparse buffer 1 with structure 1 over its pages 1 to 6, and memories. */
struct resources *a_structure_in_pages(void);

/* A test of those `resources`. */
#define PAGES_TEST(name)                                                                           \
    TEST_WITH(name, struct resources *resources, a_structure_in_pages, resources_destroy)

/* Of structure 1, for who follows the clock. */
enum tristate backed_for(struct resources *resources, const struct execution_clock *clock);
/* For who follows all. */
enum tristate backed(struct resources *resources);

#endif
