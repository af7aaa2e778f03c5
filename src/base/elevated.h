/* SPDX-License-Identifier: Apache-2.0 */
/* Processes with elevated privileges: programs with the set-user-ID or set-group-ID bit, or with
 * capabilities of their file. Who starts one chooses its environment and its current folder, and
 * must not gain its privileges by them. */
#ifndef ASSAY_BASE_ELEVATED_H
#define ASSAY_BASE_ELEVATED_H

#include <stdbool.h>
#include <sys/auxv.h>

static inline bool process_is_elevated(void)
{
    return getauxval(AT_SECURE) != 0;
}

#endif
