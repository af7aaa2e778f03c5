/* SPDX-License-Identifier: Apache-2.0 */
/* Allocations that fail on demand: the linker sends malloc and its kin of the test program here. */
#ifndef REPORT_SCARCE_MEMORY_H
#define REPORT_SCARCE_MEMORY_H

#include <stdbool.h>

/* The calling thread's allocation after `count` others fails, once. */
void memory_fail_after(int count);

/* The same, and all later ones. */
void memory_fail_from(int count);

/* Until memory_resume() with what memory_pause() returned, no allocation of the thread fails or
 * counts. */
int memory_pause(void);
void memory_resume(int before);

/* The condition of a loop over counts from 0 on: true until no allocation failed in the last round.
 * In the round that begins, memory_fail_after(count) holds. Fails the test if there were fewer than
 * three rounds. */
bool memory_is_scarce(int count);

/* Turns that off again. Returns true if an allocation has failed. */
bool memory_fail_no_more(void);

/* The first allocation of the statement fails, and there is one. */
#define WITHOUT_MEMORY(...)                                                                        \
    do {                                                                                           \
        memory_fail_after(0);                                                                      \
        __VA_ARGS__;                                                                               \
        assert_true(memory_fail_no_more());                                                        \
    } while (0)

/* The statement allocates nothing. */
#define ALLOCATES_NOTHING(...)                                                                     \
    do {                                                                                           \
        memory_fail_after(0);                                                                      \
        __VA_ARGS__;                                                                               \
        assert_false(memory_fail_no_more());                                                       \
    } while (0)

#endif
