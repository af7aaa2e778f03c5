/* SPDX-License-Identifier: Apache-2.0 */
/* Handles as numbers: some are pointers, others integers. */
#ifndef ASSAY_BASE_HANDLE_H
#define ASSAY_BASE_HANDLE_H

#include <stdint.h>

#define handle_number(handle) ((uint64_t)(uintptr_t)(handle))

#endif
