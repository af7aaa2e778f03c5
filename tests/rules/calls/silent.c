/* SPDX-License-Identifier: Apache-2.0 */
/* Valid programs that other validation has called wrong, or that are easily called so. */
#include "tests/rules/calls/placing.h"
#include "tests/rules/case.h"

#include "silent.inc"
