/* SPDX-License-Identifier: Apache-2.0 */
/* Counts the findings of reading primitives. */
#include "src/bvh/input/report.h"

static void add_count(uint64_t *count, struct builder_place *first, uint64_t more,
                      struct builder_place its_first)
{
    bool is_before =
        its_first.geometry < first->geometry ||
        (its_first.geometry == first->geometry && its_first.primitive < first->primitive);
    if (more > 0 && (*count == 0 || is_before))
        *first = its_first;
    *count += more;
}

void report_place(uint64_t *count, struct builder_place *first, struct builder_place place)
{
    add_count(count, first, 1, place);
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

void report_merge(struct builder_report *report, const struct builder_report *more)
{
    report->active += more->active;
    report->inactive += more->inactive;
    add_count(&report->undefined, &report->first_undefined, more->undefined, more->first_undefined);
    add_count(&report->out_of_range, &report->first_out_of_range, more->out_of_range,
              more->first_out_of_range);
    add_count(&report->unresolved, &report->first_unresolved, more->unresolved,
              more->first_unresolved);
    add_count(&report->singular, &report->first_singular, more->singular, more->first_singular);
}
