/* SPDX-License-Identifier: Apache-2.0 */
#include "program.h"

/* Counts candidates down to the wanted one. */
struct search {
    uint32_t left;
    struct mutation *mutation;
};

static bool is_wanted(struct search *search, enum mutated_field field, uint32_t bit)
{
    *search->mutation = (struct mutation){field, bit};
    return !search->left--;
}

static bool remove_kind(struct search *search, enum mutated_field field, kind_set *kinds)
{
    for (uint32_t kind = 0; kind < ACCESS_KINDS; kind++)
        if (*kinds >> kind & 1 && is_wanted(search, field, kind)) {
            *kinds &= ~(1u << kind);
            return true;
        }
    return false;
}

/* The accesses at the stage go, too. */
static bool remove_stage(struct search *search, enum mutated_field field, stage_set *stages,
                         kind_set *kinds)
{
    for (uint32_t stage = 0; stage < SYNC_STAGES; stage++) {
        bool is_used = stage < SYNC_ACCESS_STAGES || stage == SYNC_COMPUTE_SHADER;
        if (!is_used || !(*stages >> stage & 1) || !is_wanted(search, field, stage))
            continue;
        *stages &= ~((stage_set)1 << stage);
        for (uint32_t kind = 0; kind < ACCESS_KINDS; kind++)
            if (access_stage((enum access_kind)kind) == (enum sync_stage)stage)
                *kinds &= ~(1u << kind);
        return true;
    }
    return false;
}

static bool mutate_bytes(struct search *search, struct hazard_barrier *barrier)
{
    if (barrier->is_global) {
        if (is_wanted(search, MUTATE_IS_GLOBAL, 0)) {
            barrier->is_global = false;
            return true;
        }
    } else if (barrier->bytes.begin < barrier->bytes.end) {
        if (is_wanted(search, MUTATE_BYTES, 0)) {
            barrier->bytes.begin++;
            return true;
        }
        if (is_wanted(search, MUTATE_BYTES, 1)) {
            barrier->bytes.end--;
            return true;
        }
    }
    if (barrier->is_acquisition && is_wanted(search, MUTATE_IS_ACQUISITION, 0)) {
        barrier->is_acquisition = false;
        return true;
    }
    return false;
}

/* The stages before an event are those of the event. */
static bool mutate_barrier(struct search *search, struct hazard_barrier *barrier, bool is_of_event)
{
    struct dependency *dependency = &barrier->dependency;
    if (!is_of_event &&
        remove_stage(search, MUTATE_SRC_STAGES, &dependency->src, &dependency->src_kinds))
        return true;
    return remove_stage(search, is_of_event ? MUTATE_EVENT_DST_STAGES : MUTATE_DST_STAGES,
                        &dependency->dst, &dependency->dst_kinds) ||
           remove_kind(search, is_of_event ? MUTATE_EVENT_SRC_KINDS : MUTATE_SRC_KINDS,
                       &dependency->src_kinds) ||
           remove_kind(search, is_of_event ? MUTATE_EVENT_DST_KINDS : MUTATE_DST_KINDS,
                       &dependency->dst_kinds) ||
           mutate_bytes(search, barrier);
}

/* Batches after a prune have completed what it names. */
static bool mutate_batch(struct search *search, struct step *step, bool is_pruned)
{
    for (uint32_t queue = 0; queue < PROGRAM_QUEUES && !is_pruned; queue++)
        if (step->completed[queue]) {
            if (!is_wanted(search, MUTATE_COMPLETED, 0))
                break;
            for (queue = 0; queue < PROGRAM_QUEUES; queue++)
                step->completed[queue] = 0;
            return true;
        }
    if (step->is_certain || !is_wanted(search, MUTATE_UNCERTAIN, 0))
        return false;
    step->is_certain = true;
    return true;
}

static bool mutate_step(struct search *search, struct step *step, bool is_pruned)
{
    struct dependency *dependency = &step->dependency;
    for (uint32_t i = 0; i < step->barrier_count; i++)
        if (mutate_barrier(search, &step->barriers[i], step->type == STEP_WAIT_EVENT))
            return true;
    if (step->type == STEP_BATCH)
        return mutate_batch(search, step, is_pruned);
    if (step->type == STEP_WAIT)
        return remove_stage(search, MUTATE_WAIT_STAGES, &dependency->dst, &dependency->dst_kinds);
    if (step->type == STEP_SIGNAL || step->type == STEP_SET_EVENT)
        return remove_stage(search,
                            step->type == STEP_SIGNAL ? MUTATE_SIGNAL_STAGES : MUTATE_EVENT_STAGES,
                            &dependency->src, &dependency->src_kinds);
    return false;
}

bool program_mutate(struct program *program, uint32_t index, struct mutation *mutation)
{
    struct search search = {index, mutation};
    bool is_pruned = false;
    for (uint32_t i = 0; i < program->count; i++) {
        is_pruned = is_pruned || program->steps[i].type == STEP_PRUNE;
        if (mutate_step(&search, &program->steps[i], is_pruned))
            return true;
    }
    return false;
}
