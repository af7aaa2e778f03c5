/* SPDX-License-Identifier: Apache-2.0 */
/* Compares what the layer knows of an application's objects with the model of the application. The
 * layer is linked to the program, so the test calls its look-ups. */
#ifndef FAULTS_PICTURE_H
#define FAULTS_PICTURE_H

#include "model.h"

/* Returns the number of differences, which it prints. If `may_be_unknown`, memory has run out, and
 * whatever the layer does not know counts as equal. */
unsigned picture_compare(const struct model *model, bool may_be_unknown);

#endif
