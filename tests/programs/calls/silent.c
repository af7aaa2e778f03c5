/* SPDX-License-Identifier: Apache-2.0 */
/* Valid programs that other validation has called wrong, or that are easily called so. */
#include "tests/player/calls/case.h"
#include "tests/player/scene/placing.h"

#include "silent.inc"
