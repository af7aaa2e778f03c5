/* SPDX-License-Identifier: Apache-2.0 */
/* What libFuzzer calls, and what comes of it. */
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

#endif
