/* SPDX-License-Identifier: Apache-2.0 */

#include "src/hazards/engine.h"

#include <string.h>

static inline bool has_stage(stage_set stages, enum sync_stage stage)
{
    return stages >> stage & 1;
}

static inline bool has_kind(kind_set kinds, enum access_kind kind)
{
    return kinds >> kind & 1;
}

/* Raises the elements of a row, at the bits of a set, to a number. */
static void row_raise(uint64_t *row, uint32_t set, uint64_t number)
{
    for (; set; set &= set - 1) {
        uint64_t *element = &row[__builtin_ctz(set)];
        *element = later_of(*element, number);
    }
}

kind_set kinds_at(stage_set stages)
{
    kind_set kinds = 0;
    for (unsigned i = 0; i < ACCESS_KINDS; i++)
        if (has_stage(stages, access_stage((enum access_kind)i)))
            kinds |= (kind_set)1 << i;
    return kinds;
}

/* ---- first scopes */

static const struct reached *scope_reached(const struct first_scope *scope, uint32_t queue)
{
    return scope->event ? scope->event->reached[queue] : NULL;
}

uint64_t scope_executed(const struct first_scope *scope, const uint64_t executed[SYNC_STAGES],
                        uint32_t queue, bool is_own, stage_set src, enum sync_stage x)
{
    const struct reached *reached = scope_reached(scope, queue);
    if (scope->event)
        return reached ? reached->executed[x] : 0;
    return later_of(is_own && has_stage(src, x) ? scope->before : 0, row_reach(executed, src));
}

uint64_t scope_available(const struct first_scope *scope, const uint64_t available[SYNC_STAGES],
                         uint32_t queue, stage_set src, enum access_kind k)
{
    const struct reached *reached = scope_reached(scope, queue);
    if (scope->event)
        return reached ? reached->available[k] : 0;
    return row_reach(available, src);
}

static uint64_t scope_shared(const struct first_scope *scope, const uint64_t shared[SYNC_STAGES],
                             uint32_t queue, stage_set src, enum access_kind k)
{
    const struct reached *reached = scope_reached(scope, queue);
    if (scope->event)
        return reached ? reached->shared[k] : 0;
    return row_reach(shared, src);
}

uint64_t scope_direct(const struct first_scope *scope, const struct dependency *dependency,
                      enum access_kind k)
{
    const enum sync_stage stage = access_stage(k);
    if (!has_stage(dependency->src, stage) || !has_kind(dependency->src_kinds, k))
        return 0;
    if (!scope->event)
        return scope->before;
    return has_stage(scope->event->src, stage) ? scope->event->before : 0;
}

uint64_t scope_chain(const struct first_scope *scope, const uint64_t reached[SYNC_STAGES],
                     stage_set src, enum sync_stage x)
{
    if (scope->event)
        return scope->event->chains[x];
    return later_of(has_stage(src, x) ? scope->before : 0, row_reach(reached, src));
}

/* ---- crossing dependencies: each row is copied first, because all barriers of a command continue
 * from what was before the command */

static void cross_stage(struct frontier *frontier, enum sync_stage x,
                        const struct crossing *crossing)
{
    uint64_t old[SYNC_STAGES];
    memcpy(old, frontier->executed[x], sizeof(old));
    for (uint32_t i = 0; i < crossing->count; i++) {
        const struct dependency *dependency = &crossing->barriers[i].dependency;
        row_raise(frontier->executed[x], dependency->dst,
                  scope_executed(&crossing->scope, old, crossing->past_queue, crossing->is_own,
                                 dependency->src, x));
    }
}

static void cross_available(struct frontier *frontier, enum access_kind k,
                            const struct crossing *crossing)
{
    uint64_t old[SYNC_STAGES];
    memcpy(old, frontier->available[k], sizeof(old));
    for (uint32_t i = 0; i < crossing->count; i++) {
        const struct hazard_barrier *barrier = &crossing->barriers[i];
        const struct dependency *dependency = &barrier->dependency;
        const bool is_global = barrier->is_global || access_is_anywhere(k);
        uint64_t reach =
            scope_available(&crossing->scope, old, crossing->past_queue, dependency->src, k);
        if (crossing->is_own && is_global)
            reach = later_of(reach, scope_direct(&crossing->scope, dependency, k));
        if (is_global && barrier->is_acquisition)
            reach = later_of(reach,
                             scope_executed(&crossing->scope, frontier->executed[access_stage(k)],
                                            crossing->past_queue, crossing->is_own, dependency->src,
                                            access_stage(k)));
        row_raise(frontier->available[k], dependency->dst, reach);
        if (is_global)
            row_raise(frontier->visible[k], dependency->dst_kinds & kinds_at(dependency->dst),
                      reach);
    }
}

static void cross_shared(struct frontier *frontier, enum access_kind k,
                         const struct crossing *crossing)
{
    uint64_t old[SYNC_STAGES];
    memcpy(old, frontier->shared[k], sizeof(old));
    for (uint32_t i = 0; i < crossing->count; i++) {
        const struct dependency *dependency = &crossing->barriers[i].dependency;
        row_raise(frontier->shared[k], dependency->dst,
                  scope_shared(&crossing->scope, old, crossing->past_queue, dependency->src, k));
    }
}

void frontier_cross(struct frontier *frontier, const struct past *past,
                    const struct crossing *crossing)
{
    /* Acquisitions read the rows of stages: these change last. */
    for (kind_set rest = past->writes; rest; rest &= rest - 1) {
        const enum access_kind k = (enum access_kind)__builtin_ctz(rest);
        cross_available(frontier, k, crossing);
        cross_shared(frontier, k, crossing);
    }
    for (stage_set rest = past->stages; rest; rest &= rest - 1)
        cross_stage(frontier, (enum sync_stage)__builtin_ctz(rest), crossing);
}

void chains_cross(struct chains *chains, const struct crossing *crossing)
{
    for (stage_set rest = chains->rows; rest; rest &= rest - 1) {
        const enum sync_stage x = (enum sync_stage)__builtin_ctz(rest);
        uint64_t old[SYNC_STAGES];
        memcpy(old, chains->reached[x], sizeof(old));
        for (uint32_t i = 0; i < crossing->count; i++) {
            const struct hazard_barrier *barrier = &crossing->barriers[i];
            const struct dependency *dependency = &barrier->dependency;
            const uint64_t reach = scope_chain(&crossing->scope, old, dependency->src, x);
            row_raise(chains->reached[x], dependency->dst, reach);
            if (barrier->is_global)
                row_raise(chains->visible[x], dependency->dst_kinds & kinds_at(dependency->dst),
                          reach);
        }
    }
}

void frontier_receive(struct frontier *frontier, const struct past *past,
                      const uint64_t executed[SYNC_ACCESS_STAGES], stage_set dst)
{
    for (stage_set rest = past->stages; rest; rest &= rest - 1) {
        const unsigned x = (unsigned)__builtin_ctz(rest);
        row_raise(frontier->executed[x], dst, executed[x]);
    }
    for (kind_set rest = past->writes; rest; rest &= rest - 1) {
        const unsigned k = (unsigned)__builtin_ctz(rest);
        const uint64_t number = executed[access_stage((enum access_kind)k)];
        row_raise(frontier->available[k], dst, number);
        row_raise(frontier->shared[k], dst, number);
    }
}
