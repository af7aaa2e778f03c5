/* SPDX-License-Identifier: Apache-2.0 */
/* Writes messages from a signal handler. */
#ifndef ASSAY_LAYER_POSTMORTEM_CRASH_OUTPUT_H
#define ASSAY_LAYER_POSTMORTEM_CRASH_OUTPUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Where an instance logs. */
struct crash_output {
    int descriptor; /* -1: nowhere */
    bool is_json;
};

/* Writes a message of severity warning to the log and, if that is JSON or another file, as text to
 * stderr. Neither allocates nor locks; not for two threads at once. */
void crash_output_write(const struct crash_output *output, const char *id, int32_t id_number,
                        const char *text);

#endif
