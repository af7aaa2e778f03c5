/* SPDX-License-Identifier: Apache-2.0 */
/* Patterns of names, as fnmatch of Python has them: * stands for any characters, ? for one, [abc],
 * [a-c] and [!abc] for one of or not of a set. A backslash stands for itself. */
#ifndef ASSAY_BASE_GLOB_H
#define ASSAY_BASE_GLOB_H

#include <stdbool.h>

/* Both texts are UTF-8; a byte that is not counts as a character. */
bool glob_matches(const char *glob, const char *text);

#endif
