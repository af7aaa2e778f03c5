/* SPDX-License-Identifier: Apache-2.0 */
/* Counting what reading primitives found. */
#include "build/report.h"

void report_place(uint64_t *count, struct builder_place *first, struct builder_place place)
{
    if ((*count)++ == 0)
        *first = place;
}

void report_state(struct builder_report *report, enum source_state found,
                  struct builder_place place)
{
    switch (found) {
    case SOURCE_ACTIVE:
        report->active++;
        return;
    case SOURCE_INACTIVE:
        break;
    case SOURCE_UNDEFINED:
        report_place(&report->undefined, &report->first_undefined, place);
        break;
    case SOURCE_OUT_OF_RANGE:
        report_place(&report->out_of_range, &report->first_out_of_range, place);
        break;
    case SOURCE_UNRESOLVED:
        report_place(&report->unresolved, &report->first_unresolved, place);
        break;
    }
    report->inactive++;
}

static void merge_count(uint64_t *count, struct builder_place *first, uint64_t more,
                        struct builder_place its_first)
{
    if (*count == 0)
        *first = its_first;
    *count += more;
}

void report_merge(struct builder_report *report, const struct builder_report *more)
{
    report->active += more->active;
    report->inactive += more->inactive;
    merge_count(&report->undefined, &report->first_undefined, more->undefined,
                more->first_undefined);
    merge_count(&report->out_of_range, &report->first_out_of_range, more->out_of_range,
                more->first_out_of_range);
    merge_count(&report->unresolved, &report->first_unresolved, more->unresolved,
                more->first_unresolved);
    merge_count(&report->singular, &report->first_singular, more->singular, more->first_singular);
}
