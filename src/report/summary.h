/* SPDX-License-Identifier: Apache-2.0 */
/* What the summary of an instance says; and the two lines of report_flags = info: about the layer
 * when an instance is created, and about its findings at its end. */
#ifndef ASSAY_REPORT_SUMMARY_H
#define ASSAY_REPORT_SUMMARY_H

#include "src/base/text_buffer.h"
#include "src/platform/threads.h"
#include "src/report/duplicates.h"
#include "src/report/settings.h"

enum {
    UNCHECKED_MAX = 16,                 /* reasons that are counted; there are no more */
    SUMMARY_REASONS = UNCHECKED_MAX + 3 /* and those of the settings */
};

/* What was not validated, and why. Thread-safe. */
struct unchecked_counts {
    pthread_mutex_t lock; /* guards the members below */
    struct {
        const char *what; /* static text */
        uint64_t count;
    } items[UNCHECKED_MAX];
    unsigned used;
};

void unchecked_init(struct unchecked_counts *unchecked);
void unchecked_destroy(struct unchecked_counts *unchecked);
void unchecked_add(struct unchecked_counts *unchecked, const char *what, uint32_t count);

/* Appends the n-th reason why something was not validated; nothing if that one does not apply. */
void summary_append_reason(struct text_buffer *text, unsigned n, const struct settings *settings,
                           struct unchecked_counts *unchecked);

void summary_append_start(struct text_buffer *text, const char *version,
                          const struct settings *settings);
void summary_append_end(struct text_buffer *text, const struct settings *settings,
                        const struct duplicates *duplicates, struct unchecked_counts *unchecked);

#endif
