/* SPDX-License-Identifier: Apache-2.0 */
/* Marks the functions that run for each build that is recorded. The linker keeps them together: a
 * call of one build waits for instructions, which the driver's have driven out of the processor's
 * caches, and finds them on few pages. */
#ifndef ASSAY_BASE_RECORDING_PATH_H
#define ASSAY_BASE_RECORDING_PATH_H

#define ON_RECORDING_PATH __attribute__((hot))

/* Marks what such a function calls for few builds: inlined there, it would keep the compiler from
 * inlining what every build needs. */
#define OFF_RECORDING_PATH __attribute__((noinline))

#endif
