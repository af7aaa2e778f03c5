/* SPDX-License-Identifier: Apache-2.0 */
/* The model. It keeps every write of every structure, and for every batch the set of batches that
 * certainly came before. */
#include "random_test.h"

#include <string.h>

static const struct content not_known = {.state = NOT_KNOWN};

static const char *command_of(const struct operation *operation)
{
    switch (operation->action) {
    case ACTION_HOST_BUILD:
    case ACTION_HOST_UPDATE:
        return "vkBuildAccelerationStructuresKHR()";
    case ACTION_HOST_CLONE:
    case ACTION_HOST_COMPACT:
        return "vkCopyAccelerationStructureKHR()";
    case ACTION_CLONE:
    case ACTION_COMPACT:
        return "vkCmdCopyAccelerationStructureKHR()";
    default:
        return operation->asked.counted ? "vkCmdBuildAccelerationStructuresKHR()"
                                        : "vkCmdBuildAccelerationStructuresIndirectKHR()";
    }
}

static void find_if(struct model *model, bool is_broken, const struct operation *operation,
                    enum rule rule)
{
    if (!is_broken)
        return;
    model->findings[model->finding_count].rule = rule;
    model->findings[model->finding_count++].command = command_of(operation);
}

static void judge_geometry(struct model *model, const struct operation *operation,
                           const struct content *last)
{
    const struct shape *now = &operation->asked.shape, *then = &last->shape;
    find_if(model, now->type == then->type && now->geometry_type != then->geometry_type, operation,
            RULE_geometry_type_matches_source);
    find_if(model, now->geometry_flags != then->geometry_flags, operation,
            RULE_geometry_flags_match_source);
    find_if(model,
            operation->asked.counted && last->counted &&
                now->primitive_count != then->primitive_count,
            operation, RULE_primitive_count_matches_source);
    if (now->geometry_type != VK_GEOMETRY_TYPE_TRIANGLES_KHR ||
        then->geometry_type != VK_GEOMETRY_TYPE_TRIANGLES_KHR)
        return;
    find_if(model, now->vertex_format != then->vertex_format, operation,
            RULE_vertex_format_matches_source);
    find_if(model, now->max_vertex != then->max_vertex, operation, RULE_max_vertex_matches_source);
    find_if(model, now->index_type != then->index_type, operation, RULE_index_type_matches_source);
    find_if(model, now->has_transform && !then->has_transform, operation,
            RULE_transform_is_absent_where_source_had_none);
    find_if(model, !now->has_transform && then->has_transform, operation,
            RULE_transform_is_given_where_source_had_one);
}

/* Geometries of a source that allows no updates are not looked at. */
static void judge(struct model *model, const struct operation *operation,
                  const struct content *last)
{
    const struct shape *now = &operation->asked.shape, *then = &last->shape;
    const bool allows = then->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
    if (last->state == NOT_KNOWN)
        return;
    find_if(model, last->state == NEVER_BUILT || !allows, operation,
            RULE_update_source_was_built_with_allow_update);
    if (last->state == NEVER_BUILT)
        return;
    find_if(model, now->geometry_count != then->geometry_count, operation,
            RULE_geometry_count_matches_source);
    find_if(model, allows && now->flags != then->flags, operation, RULE_build_flags_match_source);
    find_if(model, now->type != then->type, operation, RULE_build_type_matches_source);
    for (uint32_t i = 0;
         allows && now->geometry_count == then->geometry_count && i < now->geometry_count; i++)
        judge_geometry(model, operation, last);
}

static bool is_copy(enum action action)
{
    return action == ACTION_CLONE || action == ACTION_COMPACT || action == ACTION_HOST_CLONE ||
           action == ACTION_HOST_COMPACT;
}

static bool compacts(enum action action)
{
    return action == ACTION_COMPACT || action == ACTION_HOST_COMPACT;
}

static void judge_copy(struct model *model, const struct operation *operation,
                       const struct content *last)
{
    const bool allows =
        last->shape.flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR;
    find_if(model, last->state == NEVER_BUILT, operation, RULE_source_was_constructed_before);
    find_if(model,
            compacts(operation->action) && last->state == BUILT && !last->compacted && !allows,
            operation, RULE_source_allows_compaction);
}

static void judge_operation(struct model *model, const struct operation *operation,
                            const struct content *last)
{
    if (operation->action == ACTION_UPDATE || operation->action == ACTION_HOST_UPDATE)
        judge(model, operation, last);
    else if (is_copy(operation->action))
        judge_copy(model, operation, last);
}

/* ---- recording */

void model_begin(struct model *model, uint32_t command_buffer)
{
    memset(&model->command_buffers[command_buffer], 0, sizeof(struct recording));
}

static void learn(struct model *model, struct recording *recording,
                  const struct operation *operation)
{
    const struct recording *secondary = &model->command_buffers[operation->dst];
    switch (operation->action) {
    case ACTION_EXECUTE:
        for (uint32_t i = 0; i < secondary->count; i++)
            learn(model, recording, &secondary->operations[i]);
        return;
    case ACTION_BUILD:
        recording->knows[operation->dst] = true;
        recording->known[operation->dst] = operation->asked;
        return;
    case ACTION_FILL:
        recording->knows[operation->dst] = true;
        recording->known[operation->dst] = not_known;
        return;
    default: /* updates and copies */
        recording->knows[operation->dst] = recording->knows[operation->src];
        recording->known[operation->dst] = recording->known[operation->src];
        recording->known[operation->dst].compacted |= compacts(operation->action);
    }
}

void model_record(struct model *model, uint32_t command_buffer, const struct operation *operation)
{
    struct recording *recording = &model->command_buffers[command_buffer];
    struct operation *added = &recording->operations[recording->count++];
    *added = *operation;
    added->is_judged =
        (added->action == ACTION_UPDATE || is_copy(added->action)) && recording->knows[added->src];
    if (added->is_judged)
        judge_operation(model, added, &recording->known[added->src]);
    learn(model, recording, added);
}

/* ---- running */

static bool precedes(const struct model *model, uint32_t first, uint32_t second)
{
    return first == second || (model->batches[second].follows >> first & 1) != 0;
}

/* What a batch reads: certain only if all writes so far have an order, and it follows the last. */
static struct content read_structure(const struct model *model, uint32_t structure, uint32_t batch)
{
    const uint32_t count = model->write_count[structure];
    if (model->host_writers[structure] != 0)
        return not_known;
    if (count == 0)
        return (struct content){.state = NEVER_BUILT};
    for (uint32_t i = 1; i < count; i++)
        if (!precedes(model, model->writes[structure][i - 1].batch,
                      model->writes[structure][i].batch))
            return not_known;
    return precedes(model, model->writes[structure][count - 1].batch, batch)
               ? model->writes[structure][count - 1].content
               : not_known;
}

static void write_structure(struct model *model, uint32_t structure, uint32_t batch,
                            const struct content *content)
{
    const uint32_t i = model->write_count[structure]++;
    model->writes[structure][i].content = *content;
    model->writes[structure][i].batch = batch;
}

static void run_recording(struct model *model, uint32_t batch, const struct recording *recording)
{
    for (uint32_t i = 0; i < recording->count; i++) {
        const struct operation *operation = &recording->operations[i];
        struct content content = operation->asked;
        if (operation->action == ACTION_EXECUTE) {
            run_recording(model, batch, &model->command_buffers[operation->dst]);
            continue;
        }
        if (operation->action == ACTION_FILL)
            content = not_known;
        else if (operation->action != ACTION_BUILD)
            content = read_structure(model, operation->src, batch);
        if (!operation->is_judged)
            judge_operation(model, operation, &content);
        if (content.state == NEVER_BUILT)
            content = not_known;
        content.compacted |= compacts(operation->action);
        write_structure(model, operation->dst, batch, &content);
    }
}

/* The batch that signals the awaited value or more; -1: none yet. */
static int find_signal(const struct model *model, const struct model_batch *batch)
{
    for (uint32_t i = 0; i < model->batch_count; i++)
        if (model->batches[i].queue == batch->waits_for &&
            model->batches[i].signal_value >= batch->wait_value)
            return (int)i;
    return -1;
}

static bool follow(const struct model *model, struct model_batch *batch, int other)
{
    if (other < 0 || !model->batches[other].has_run)
        return false;
    batch->follows |= model->batches[other].follows | (uint64_t)1 << other;
    return true;
}

/* Whether the batch can execute; if so, `follows` is complete. */
static bool is_ready(struct model *model, struct model_batch *batch)
{
    batch->follows = batch->host;
    for (struct model_batch *other = model->batches; other < batch; other++)
        if (other->queue == batch->queue && !follow(model, batch, (int)(other - model->batches)))
            return false;
    if (batch->binary_signal >= 0 && !follow(model, batch, batch->binary_signal))
        return false;
    return batch->wait_value == 0 || follow(model, batch, find_signal(model, batch));
}

bool model_run_queue(struct model *model, uint32_t queue)
{
    bool any = false;
    for (uint32_t i = 0; i < model->batch_count; i++) {
        struct model_batch *batch = &model->batches[i];
        if (batch->queue != queue || batch->has_run || !is_ready(model, batch))
            continue;
        batch->has_run = any = true;
        for (uint32_t j = 0; j < batch->recording_count; j++)
            run_recording(model, i, &batch->recordings[j]);
    }
    return any;
}

void model_run(struct model *model)
{
    bool any = true;
    while (any) {
        any = false;
        for (uint32_t queue = 0; queue < QUEUES; queue++)
            any = model_run_queue(model, queue) || any;
    }
}

/* ---- the rest */

struct model_batch *model_add_batch(struct model *model, uint32_t queue)
{
    struct model_batch *batch = &model->batches[model->batch_count++];
    *batch = (struct model_batch){.queue = queue, .host = model->host, .binary_signal = -1};
    return batch;
}

void model_idle(struct model *model)
{
    model->host =
        model->batch_count == MODEL_BATCHES ? UINT64_MAX : ((uint64_t)1 << model->batch_count) - 1;
}

void model_create(struct model *model, uint32_t structure)
{
    model->write_count[structure] = 0;
}

/* ---- work of the host */

uint32_t model_judge_work(struct model *model, const struct operation *operation)
{
    struct model_batch *batch = model_add_batch(model, QUEUES);
    const uint32_t number = model->batch_count - 1;
    batch->has_run = true;
    batch->follows = batch->host;
    const struct content source = read_structure(model, operation->src, number);
    judge_operation(model, operation, &source);
    return number;
}

void model_begin_work(struct model *model, const struct operation *operation)
{
    model->host_writers[operation->dst]++;
}

void model_end_work(struct model *model, uint32_t batch, const struct operation *operation,
                    bool fails)
{
    model->host_writers[operation->dst]--;
    struct content content = not_known;
    if (!fails && operation->action == ACTION_HOST_BUILD)
        content = operation->asked;
    else if (!fails && operation->action != ACTION_HOST_FILL)
        content = read_structure(model, operation->src, batch);
    if (content.state == NEVER_BUILT)
        content = not_known;
    content.compacted |= compacts(operation->action);
    write_structure(model, operation->dst, batch, &content);
    model->host |= (uint64_t)1 << batch;
}
