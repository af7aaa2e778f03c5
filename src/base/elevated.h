/* SPDX-License-Identifier: Apache-2.0 */
/* Detects processes with elevated privileges: programs with the set-user-ID or set-group-ID bit, or
 * with file capabilities. The user who starts such a process chooses its environment and current
 * folder, and must not gain the privileges of the process through them. */
#ifndef ASSAY_BASE_ELEVATED_H
#define ASSAY_BASE_ELEVATED_H

#include <stdbool.h>
#include <sys/auxv.h>

static inline bool process_is_elevated(void)
{
    return getauxval(AT_SECURE) != 0;
}

#endif
