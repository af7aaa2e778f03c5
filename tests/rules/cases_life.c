/* SPDX-License-Identifier: Apache-2.0 */
/* Commands that build no structures. */
#include "case.h"

#include "copies.inc"
#include "life_features.inc"
#include "life_results.inc"
#include "queries.inc"
