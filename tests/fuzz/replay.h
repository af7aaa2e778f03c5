/* SPDX-License-Identifier: Apache-2.0 */
/* Runs a fuzz target without a fuzzer. */
#ifndef ASSAY_TESTS_FUZZ_REPLAY_H
#define ASSAY_TESTS_FUZZ_REPLAY_H

#include <stdint.h>

/* Runs the target on each file named, and on each file of the folders named. Returns the number of
 * those that can't be read, or 1 if there is no file at all. */
int replay(int count, char **paths);

/* Runs the target on `count` files of the folder, chosen and changed at random. Returns 0, or 1 if
 * a file can't be read. */
int replay_mutated(const char *folder, uint32_t count);

/* Runs the target `count` times with random bytes. Returns 0. */
int replay_random(uint32_t count);

#endif
