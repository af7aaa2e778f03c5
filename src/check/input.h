/* SPDX-License-Identifier: Apache-2.0 */
/* The addresses that builds use, by what they are to the build. */
#ifndef ASSAY_CHECK_INPUT_H
#define ASSAY_CHECK_INPUT_H

#include "state/journal.h"

/* The member that gives the address, relative to its geometry, or to the build for scratch. */
const char *input_field(enum input_role role);

#endif
