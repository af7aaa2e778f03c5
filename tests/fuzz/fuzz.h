/* SPDX-License-Identifier: Apache-2.0 */
/* What libFuzzer calls, what comes of it, and runs without a fuzzer. */
#ifndef ASSAY_TESTS_FUZZ_FUZZ_H
#define ASSAY_TESTS_FUZZ_FUZZ_H

#include <stddef.h>
#include <stdint.h>

/* The digest of what the target has built, traced and decoded since the program began. Builds and
 * traces are the same everywhere, so a digest of a corpus shows whether they have changed. */
extern uint64_t fuzz_digest;

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* A signal handler: prints the program that fuzz_programs plays, and ends the process. */
void fuzz_programs_crash(int number);

/* ---- without a fuzzer */

/* Runs the target on each file named, and on each file of the folders named. Returns the number of
 * those that can't be read, or 1 if there is no file at all. */
int replay(int count, char **paths);

/* Runs the target `count` times with random bytes. Returns 0. */
int replay_random(uint32_t count);

#endif
