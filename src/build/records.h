/* SPDX-License-Identifier: Apache-2.0 */
/* Records of instances: what traversal needs to go into their space. */
#ifndef ASSAY_BUILD_RECORDS_H
#define ASSAY_BUILD_RECORDS_H

#include "build/structure.h"

#define RECORD_CHUNK 4096u /* that a thread writes at once */

/* All 0 where the matrix is singular. */
void record_invert(const VkTransformMatrixKHR *transform, double inverse[9]);

#endif
