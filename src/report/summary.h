/* SPDX-License-Identifier: Apache-2.0 */
/* Counts of findings: limits of duplicates, and the summary. */
#ifndef ASSAY_REPORT_SUMMARY_H
#define ASSAY_REPORT_SUMMARY_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "src/base/handle_table.h"
#include "src/base/text_buffer.h"
#include "src/platform/threads.h"
#include "src/report/message.h"
#include "src/report/settings.h"

/* The ids of messages: VUIDs and warnings (enum vuid), then other ids (message_id.h), then retired
 * ids, which only count findings. */
enum { REPORTED_IDS = MESSAGE_ID_COUNT + OTHER_ID_COUNT + RETIRED_COUNT };
static inline uint32_t reported_other(unsigned other)
{
    return MESSAGE_ID_COUNT + (uint32_t)other;
}
/* Returns the id that the message of a finding has: `vuid`, or a retired one. */
uint32_t reported_vuid(enum vuid vuid, const struct message_style *style,
                       const struct location *location, const struct finding *finding);
/* Returns the id as text, in static storage. */
const char *reported_id_name(uint32_t id);

struct reported_id {
    bool is_enabled;                /* constant */
    _Atomic uint32_t left;          /* messages that may still be sent */
    _Atomic uint32_t held_in_a_row; /* findings held back since the last message */
    _Atomic uint64_t found, held;   /* findings, and those of them that were held back */
};

struct duplicates {
    uint32_t limit;  /* messages for one object; 0: no limit */
    bool counts_all; /* findings are counted even if no more messages may be sent */
    struct reported_id ids[REPORTED_IDS];
    pthread_mutex_t lock;
    struct handle_table objects; /* numbers of findings by id and object; guarded by `lock` */
};

/* `duplicates` is zero-initialized; no id is enabled. */
void duplicates_init(struct duplicates *duplicates);
/* Enables ids as the settings say. */
void duplicates_enable(struct duplicates *duplicates, const struct settings *settings);
void duplicates_destroy(struct duplicates *duplicates);

/* Decrements a count of messages left, unless it is UINT32_MAX, and sets `left` to the new count.
 * Returns false if none was left. */
bool duplicates_take(_Atomic uint32_t *messages, uint32_t *left);

/* Returns false if further findings of this id, in this call of the application, make no
 * difference. A call may have millions of findings, so the answer is also false after many that
 * were held back in a row, unless all are counted. */
bool duplicates_wanted(const struct duplicates *duplicates, uint32_t id);

/* Counts a finding, which is about an object of the device, for the summary as one of `shown`: its
 * id or, with vuid_names = listed, a retired one. Returns false if it is held back; otherwise sets
 * what the style of its message says about later ones. */
bool duplicates_add(struct duplicates *duplicates, uint32_t id, uint32_t shown, VkDevice device,
                    const struct message_subject *subject, struct message_style *style);

/* Counts findings whose message is left out. */
void duplicates_hold(struct duplicates *duplicates, uint32_t id, uint32_t count);

/* ---- What the summary of an instance says; and the two lines of report_flags = info: about the
 * layer when an instance is created, and about its findings at its end. */

enum {
    UNCHECKED_MAX = 64,                 /* reasons that are counted; there are no more */
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
/* Adds what has become unknown in this process (src/base/unknown.h). */
void unchecked_add_unknown(struct unchecked_counts *unchecked);

/* Appends the n-th reason why something was not validated; nothing if that one does not apply. */
void summary_append_reason(struct text_buffer *text, unsigned n, const struct settings *settings,
                           struct unchecked_counts *unchecked);

void summary_append_start(struct text_buffer *text, const char *version,
                          const struct settings *settings);
void summary_append_end(struct text_buffer *text, const struct settings *settings,
                        const struct duplicates *duplicates, struct unchecked_counts *unchecked);

#endif
