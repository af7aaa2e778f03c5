/* SPDX-License-Identifier: Apache-2.0 */
/* Marks the functions that run for each recorded build. The linker places them together: between
 * two builds the driver evicts the layer's instructions from the processor's caches, and fewer
 * pages mean fewer misses. */
#ifndef ASSAY_BASE_RECORDING_PATH_H
#define ASSAY_BASE_RECORDING_PATH_H

#define ON_RECORDING_PATH __attribute__((hot))

/* Marks what such a function calls for few builds: inlined there, it would keep the compiler from
 * inlining what every build needs. */
#define OFF_RECORDING_PATH __attribute__((noinline))

#endif
