/* SPDX-License-Identifier: Apache-2.0 */
/* Random programs on the null driver, valid ones save for their updates and copies, with what the
 * model expects of each line. In faulty programs some builds have wrong parameters, too. */
#include "random_test.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* ---- shapes, and one difference for each rule about updates */

enum {
    ALLOW_UPDATE = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
    ALLOW_COMPACTION = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR,
    FAST_TRACE = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR,
};

/* A build of one triangle geometry, with everything. */
static struct shape shape_plain(void)
{
    return (struct shape){
        .flags = ALLOW_UPDATE | ALLOW_COMPACTION,
        .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
        .geometry_count = 1,
        .geometry_type = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
        .vertex_format = VK_FORMAT_R32G32B32_SFLOAT,
        .max_vertex = 5,
        .index_type = VK_INDEX_TYPE_UINT32,
        .has_transform = true,
        .primitive_count = 2,
    };
}

enum { INPUT_SIZE = 128 };

static void write_triangles(const struct shape *shape, char words[INPUT_SIZE])
{
    snprintf(words, INPUT_SIZE, "plain%s%s%s",
             shape->index_type == VK_INDEX_TYPE_UINT16 ? " short-indices I1" : "",
             shape->vertex_format == VK_FORMAT_R16G16B16A16_SFLOAT ? " format rgba16" : "",
             shape->has_transform ? "" : " no-transform");
}

/* The geometry comes first, as it replaces what is said of one before; `max` behind `primitives`.
 */
static void shape_write(const struct shape *shape, char words[SHAPE_WORDS_SIZE])
{
    char input[INPUT_SIZE] = "boxes A0", max[16] = "";
    if (shape->geometry_type == VK_GEOMETRY_TYPE_TRIANGLES_KHR) {
        write_triangles(shape, input);
        snprintf(max, sizeof(max), " max %u", shape->max_vertex);
    } else if (shape->geometry_type == VK_GEOMETRY_TYPE_INSTANCES_KHR) {
        snprintf(input, sizeof(input), "instances N0");
    }
    snprintf(words, SHAPE_WORDS_SIZE, "%s%s primitives %u%s geometries %u flags none%s%s%s", input,
             shape->geometry_flags ? " opaque" : "", shape->primitive_count, max,
             shape->geometry_count, shape->flags & ALLOW_UPDATE ? "|update" : "",
             shape->flags & ALLOW_COMPACTION ? "|compaction" : "",
             shape->flags & FAST_TRACE ? "|fast_trace" : "");
}

struct difference differences[DIFFERENCES];

void differences_fill(void)
{
    for (uint32_t i = 0; i < DIFFERENCES; i++)
        differences[i].built = differences[i].asked = shape_plain();
    differences[0].built.flags = ALLOW_COMPACTION;
    differences[1].built.geometry_count = 2;
    differences[2].built.flags |= FAST_TRACE;
    differences[3].asked.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
    differences[3].asked.geometry_type = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    differences[4].built.geometry_type = VK_GEOMETRY_TYPE_AABBS_KHR;
    differences[5].built.geometry_flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    differences[6].built.vertex_format = VK_FORMAT_R16G16B16A16_SFLOAT;
    differences[7].built.max_vertex = 6;
    differences[8].built.index_type = VK_INDEX_TYPE_UINT16;
    differences[9].built.has_transform = false;
    differences[10].asked.has_transform = false;
    differences[11].built.primitive_count = 1;
}

/* ---- the model. It keeps every write of every structure, and for every batch the set of batches
 * that certainly came before. */

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

static void model_begin(struct model *model, uint32_t command_buffer)
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

static void model_record(struct model *model, uint32_t command_buffer,
                         const struct operation *operation)
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

/* The batches of one queue that nothing holds back; false if there were none. */
static bool model_run_queue(struct model *model, uint32_t queue)
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

static void model_run(struct model *model)
{
    bool any = true;
    while (any) {
        any = false;
        for (uint32_t queue = 0; queue < QUEUES; queue++)
            any = model_run_queue(model, queue) || any;
    }
}

/* ---- the rest */

/* A batch that is being filled; then its submission, which may let others run, too. */
static struct model_batch *model_add_batch(struct model *model, uint32_t queue)
{
    struct model_batch *batch = &model->batches[model->batch_count++];
    *batch = (struct model_batch){.queue = queue, .host = model->host, .binary_signal = -1};
    return batch;
}

/* The host has waited for all there is; nothing is held back. */
static void model_idle(struct model *model)
{
    model->host =
        model->batch_count == MODEL_BATCHES ? UINT64_MAX : ((uint64_t)1 << model->batch_count) - 1;
}

static void model_create(struct model *model, uint32_t structure)
{
    model->write_count[structure] = 0;
}

/* ---- work of the host */

/* Work of the host, one operation: judged when it begins; then carried out, or called off; then, if
 * it was carried out, it ends. Returns its batch. */
static uint32_t model_judge_work(struct model *model, const struct operation *operation)
{
    struct model_batch *batch = model_add_batch(model, QUEUES);
    const uint32_t number = model->batch_count - 1;
    batch->has_run = true;
    batch->follows = batch->host;
    const struct content source = read_structure(model, operation->src, number);
    judge_operation(model, operation, &source);
    return number;
}

static void model_begin_work(struct model *model, const struct operation *operation)
{
    model->host_writers[operation->dst]++;
}

static void model_end_work(struct model *model, uint32_t batch, const struct operation *operation,
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

/* ---- dice and lines */

uint32_t below(struct random_test *test, uint32_t bound)
{
    return (uint32_t)(random_next(&test->random) >> 32) % bound;
}

static const char *queue_name(const struct random_test *test, uint32_t queue)
{
    return test->queue ? test->queue : queue ? "q2" : "q0";
}

static bool chance(struct random_test *test, uint32_t percent)
{
    return below(test, 100) < percent;
}

static struct shape random_shape(struct random_test *test)
{
    struct shape shape = shape_plain();
    if (chance(test, 55))
        return shape;
    const struct difference *difference = &differences[below(test, DIFFERENCES)];
    shape = chance(test, 50) ? difference->built : difference->asked;
    if (chance(test, 20))
        shape.max_vertex++;
    if (chance(test, 20) && shape.type == VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR)
        shape.geometry_count = 1 + below(test, SHAPE_GEOMETRIES);
    if (chance(test, 20))
        shape.flags &= ~(VkFlags)VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR;
    return shape;
}

void add_line(struct random_test *test, const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    program_add(&test->program, text, test->program.line_count + 1);
}

bool play_lines(struct random_test *test)
{
    struct play *play = &test->play;
    struct program *program = &test->program;
    for (; test->played < program->line_count && play->report.outcome == OUTCOME_PASSED;
         test->played++) {
        play_line(play, test->played);
        if (play->result != VK_SUCCESS && !program->lines[test->played].result)
            program_note_result(program, test->played, play_name_of(play->result));
    }
    return play->result == VK_SUCCESS;
}

/* The last line has to report what the model has found; with `skips`, the messenger asks to skip
 * the call if there is something. */
static void expect_findings(struct random_test *test, bool skips)
{
    struct model *model = &test->now.model;
    struct program *program = &test->program;
    for (uint32_t i = 0; i < model->finding_count; i++) {
        PLAY_REQUIRE(&test->play, program->expected_count < PROGRAM_EXPECTATIONS);
        program->expected[program->expected_count++] =
            (struct expectation){.id = rule_infos[model->findings[i].rule].name,
                                 .text = model->findings[i].command,
                                 .line = (int)program->line_count - 1,
                                 .is_plain = !skips};
    }
    test->findings += model->finding_count;
    model->finding_count = 0;
}

/* The last line breaks this rule, and its command buffer must not be submitted. */
static void expect_mistake(struct random_test *test, enum rule rule)
{
    struct model *model = &test->now.model;
    model->findings[0].rule = rule;
    model->findings[0].command = "vkCmdBuildAccelerationStructuresKHR()";
    model->finding_count = 1;
    expect_findings(test, false);
}

/* Recording a secondary anew invalidates the primaries that execute it. */
static void forget_recording(struct random_test *test, uint32_t cb)
{
    test->executable[cb] = false;
    memset(test->uses[cb], 0, sizeof(test->uses[cb]));
    memset(test->executes[cb], 0, sizeof(test->executes[cb]));
    for (uint32_t i = 0; i < COMMAND_BUFFERS; i++)
        if (test->executes[i][cb])
            forget_recording(test, i);
}

/* ---- objects, which are created again: in faulty programs that may fail */

void create_all(struct random_test *test)
{
    add_line(test, "have V0 I0 I1 X0 A0 N0 R1 R2 D0 G0 S0 d1 d2 s0 s1 s2 s3");
    if (test->play.platform->is_cpu)
        add_line(test, "host build B0; host serialize B0 > D0");
    for (uint32_t i = 0; i <= COMMAND_BUFFERS; i++)
        add_line(test, "begin c%u%s for %s; end", i,
                 i >= SECONDARIES && i < COMMAND_BUFFERS ? " secondary" : "",
                 queue_name(test, i >= OTHER_QUEUE && i < SECONDARIES));
}

/* A build of a structure whose buffer has no memory. */
static void build_unbacked(struct random_test *test, uint32_t structure)
{
    add_line(test, "begin c%u for %s", COMMAND_BUFFERS, queue_name(test, 0));
    if (!play_lines(test))
        return;
    add_line(test, "build B%u", structure);
    expect_mistake(test, RULE_dst_is_backed_by_memory);
    add_line(test, "end");
    play_lines(test);
}

/* Creates an object again; the old one is destroyed even if that fails. */
static void create_again(struct random_test *test, const char *command, const char *name)
{
    add_line(test, "%s %s", command, name);
    if (play_lines(test))
        return;
    add_line(test, "%s %s", command, name);
    test->is_over = !play_lines(test);
}

/* The buffer of a structure and its memory. If only the binding failed, the structure can be
 * created all the same. */
static void renew_backing(struct random_test *test, uint32_t structure, const char *name)
{
    if (chance(test, 50)) {
        add_line(test, "%s %s", chance(test, 50) ? "free" : "destroy buffer", name);
        build_unbacked(test, structure);
    }
    add_line(test, "renew %s", name);
    if (play_lines(test))
        return;
    if (play_object(&test->play, name)->buffer.handle) {
        add_line(test, "create %s", name);
        if (play_lines(test))
            build_unbacked(test, structure);
    }
    create_again(test, "renew", name);
}

/* When nothing is pending. */
static void recreate(struct random_test *test, uint32_t structure)
{
    char name[8];
    snprintf(name, sizeof(name), "B%u", structure);
    if (test->is_faulty && chance(test, 50))
        renew_backing(test, structure, name);
    if (!test->is_over)
        create_again(test, "create", name);
    model_create(&test->now.model, structure);
    for (uint32_t cb = 0; cb < COMMAND_BUFFERS; cb++)
        if (test->uses[cb][structure])
            forget_recording(test, cb);
}

/* Any command buffer may use it. */
static void renew_scratch(struct random_test *test)
{
    if (chance(test, 50))
        add_line(test, "free S0");
    create_again(test, "renew", "S0");
    for (uint32_t cb = 0; cb < COMMAND_BUFFERS; cb++)
        forget_recording(test, cb);
}

/* ---- commands of the host, at once or deferred */

static void join(struct random_test *test, uint32_t operation)
{
    if (!test->works[operation].is_deferred)
        return;
    if (test->works[operation].fails)
        add_line(test, "fail vkGetDeferredOperationResultKHR OUT_OF_HOST_MEMORY");
    add_line(test, "host join d%u", operation);
    play_lines(test);
    test->works[operation].is_deferred = false;
    model_end_work(&test->now.model, test->works[operation].batch,
                   &test->works[operation].operation, test->works[operation].fails);
}

static struct operation random_work(struct random_test *test, uint32_t *deferred, bool *fails)
{
    static const enum action actions[] = {
        ACTION_HOST_BUILD, ACTION_HOST_BUILD,   ACTION_HOST_UPDATE, ACTION_HOST_UPDATE,
        ACTION_HOST_CLONE, ACTION_HOST_COMPACT, ACTION_HOST_FILL};
    struct operation work = {.action = actions[below(test, ARRAY_COUNT(actions))],
                             .dst = below(test, STRUCTURES),
                             .src = below(test, STRUCTURES),
                             .asked = {.state = BUILT, .counted = true}};
    if (test->play.platform->is_cpu) /* it refuses what the model finds mistakes in */
        work.action = ACTION_HOST_BUILD;
    *deferred = chance(test, 40) ? 1 + below(test, OPERATIONS) : 0;
    *fails =
        !test->is_faulty && !*deferred && work.action <= ACTION_HOST_UPDATE && chance(test, 10);
    if (work.action > ACTION_HOST_UPDATE && work.src == work.dst)
        work.src = (work.dst + 1) % STRUCTURES;
    work.asked.shape = random_shape(test);
    return work;
}

/* `end`: what follows the command. */
static void add_work(struct random_test *test, const struct operation *work, const char *end)
{
    char words[SHAPE_WORDS_SIZE];
    shape_write(&work->asked.shape, words);
    switch (work->action) {
    case ACTION_HOST_BUILD:
        add_line(test, "host build B%u %s%s", work->dst, words, end);
        break;
    case ACTION_HOST_UPDATE:
        add_line(test, "host build B%u update src B%u %s%s", work->dst, work->src, words, end);
        break;
    case ACTION_HOST_FILL:
        add_line(test, "host deserialize D0 > B%u%s", work->dst, end);
        break;
    default:
        add_line(test, "host %s B%u > B%u%s",
                 work->action == ACTION_HOST_CLONE ? "clone" : "compact", work->src, work->dst,
                 end);
    }
}

/* Some work is to be skipped if there is a finding. */
static void work_on_host(struct random_test *test)
{
    uint32_t deferred;
    bool fails;
    char end[64] = "";
    const struct operation work = random_work(test, &deferred, &fails);
    const bool may_skip = !test->is_faulty && chance(test, 20);
    join(test, deferred);
    const uint32_t batch = model_judge_work(&test->now.model, &work);
    const bool is_skipped = may_skip && test->now.model.finding_count;
    if (deferred)
        snprintf(end, sizeof(end), " deferred d%u", deferred);
    else if (fails && !is_skipped)
        snprintf(end, sizeof(end), " returns OUT_OF_HOST_MEMORY");
    if (fails && !is_skipped)
        add_line(test, "fail vkBuildAccelerationStructuresKHR OUT_OF_HOST_MEMORY");
    add_work(test, &work, end);
    expect_findings(test, is_skipped);
    const bool is_done = play_lines(test);
    if (is_skipped)
        return;
    model_begin_work(&test->now.model, &work);
    deferred = is_done ? deferred : 0;
    test->works[deferred].operation = work;
    test->works[deferred].batch = batch;
    test->works[deferred].fails = deferred ? !test->is_faulty && chance(test, 10) : !is_done;
    test->works[deferred].is_deferred = deferred != 0;
    if (!deferred)
        model_end_work(&test->now.model, batch, &work, !is_done);
}

/* ---- programs */

static uint32_t random_queue(struct random_test *test)
{
    return test->queue ? 0 : below(test, QUEUES);
}

/* ---- recording */

static enum action random_action(struct random_test *test, bool is_primary)
{
    const uint32_t dice = below(test, 100);
    if (dice < 30)
        return ACTION_BUILD;
    if (dice < 70)
        return ACTION_UPDATE;
    if (dice < 80)
        return ACTION_CLONE;
    if (dice < 87)
        return ACTION_COMPACT;
    if (dice < 90 || !is_primary)
        return ACTION_FILL;
    return ACTION_EXECUTE;
}

static void add_operation(struct random_test *test, const struct operation *operation)
{
    char words[SHAPE_WORDS_SIZE];
    char ranges[16] = "";
    const char *scratch = test->is_faulty && chance(test, 50) ? " scratch S0" : "";
    shape_write(&operation->asked.shape, words);
    if (!operation->asked.counted) /* no range changes until it is read */
        snprintf(ranges, sizeof(ranges), " ranges R%u", operation->asked.shape.primitive_count);
    switch (operation->action) {
    case ACTION_BUILD:
        add_line(test, "build B%u %s%s%s", operation->dst, words, ranges, scratch);
        break;
    case ACTION_UPDATE:
        add_line(test, "build B%u update src B%u %s%s%s", operation->dst, operation->src, words,
                 ranges, scratch);
        break;
    case ACTION_FILL:
        add_line(test, "deserialize D0 > B%u", operation->dst);
        break;
    case ACTION_EXECUTE:
        add_line(test, "execute c%u", operation->dst);
        break;
    default:
        add_line(test, "%s B%u > B%u", operation->action == ACTION_CLONE ? "clone" : "compact",
                 operation->src, operation->dst);
    }
}

/* An updated or copied structure may be its own source only in updates. */
static void record_operation(struct random_test *test, uint32_t cb)
{
    struct operation operation = {.action = random_action(test, cb < SECONDARIES),
                                  .dst = below(test, STRUCTURES),
                                  .src = below(test, STRUCTURES)};
    const enum action action = operation.action;
    if (action == ACTION_EXECUTE)
        operation.dst = SECONDARIES + below(test, 2);
    if (action == ACTION_EXECUTE && (!test->executable[operation.dst] || cb >= OTHER_QUEUE))
        return;
    if ((action == ACTION_CLONE || action == ACTION_COMPACT) && operation.src == operation.dst)
        operation.src = (operation.dst + 1) % STRUCTURES;
    operation.asked = (struct content){.state = BUILT, .shape = random_shape(test)};
    /* Level content reads ranges, and the model does not. */
    operation.asked.counted = test->is_faulty || !chance(test, 20);
    if (action == ACTION_EXECUTE) {
        test->executes[cb][operation.dst] = true;
        for (uint32_t i = 0; i < STRUCTURES; i++)
            test->uses[cb][i] |= test->uses[operation.dst][i];
    } else {
        test->uses[cb][operation.dst] = true;
        test->uses[cb][operation.src] |= action != ACTION_BUILD && action != ACTION_FILL;
    }
    add_operation(test, &operation);
    model_record(&test->now.model, cb, &operation);
    expect_findings(test, false);
}

/* The commands of one command buffer. Returns whether it may be submitted. */
static bool record_operations(struct random_test *test, uint32_t cb)
{
    for (uint32_t i = below(test, 4) + 1; i > 0; i--) {
        if (test->is_faulty && chance(test, 10))
            add_line(test, "label here; fill G0; barrier all > all; unlabel");
        if (test->is_faulty && chance(test, 5)) {
            add_line(test, "build B%u stride 6", below(test, STRUCTURES));
            expect_mistake(test, RULE_vertex_stride_is_aligned);
            return false;
        }
        record_operation(test, cb);
    }
    return true;
}

static void record(struct random_test *test)
{
    const uint32_t cb = below(test, COMMAND_BUFFERS);
    const bool is_other = cb >= OTHER_QUEUE && cb < SECONDARIES;
    if (test->pending[cb] || (is_other && test->queue))
        return;
    forget_recording(test, cb);
    add_line(test, "begin c%u simultaneous%s for %s", cb, cb >= SECONDARIES ? " secondary" : "",
             queue_name(test, is_other));
    if (!play_lines(test))
        return;
    model_begin(&test->now.model, cb);
    const bool is_valid = record_operations(test, cb);
    add_line(test, "end");
    test->executable[cb] = play_lines(test) && is_valid;
}

/* ---- submitting */

__attribute__((format(printf, 2, 3))) static void add_words(struct random_test *test,
                                                            const char *format, ...)
{
    const size_t length = strlen(test->batch);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(test->batch + length, sizeof(test->batch) - length, format, arguments);
    va_end(arguments);
}

static void add_commands(struct random_test *test, struct model_batch *batch)
{
    for (uint32_t i = below(test, 3); i > 0; i--) {
        const uint32_t cb =
            batch->queue == 0 ? below(test, OTHER_QUEUE) : OTHER_QUEUE + below(test, 2);
        if (!test->executable[cb])
            continue;
        add_words(test, " c%u", cb);
        batch->recordings[batch->recording_count++] = test->now.model.command_buffers[cb];
        test->pending[cb] = true;
        for (uint32_t j = 0; j < COMMAND_BUFFERS; j++)
            test->pending[j] |= test->executes[cb][j];
    }
}

/* The leader waits only for what has run, so that it is never held back itself. */
static bool may_wait_for(const struct random_test *test, uint32_t queue, int signal)
{
    return queue != test->leader || test->now.model.batches[signal].has_run;
}

static void add_timeline_wait(struct random_test *test, struct model_batch *batch)
{
    const uint32_t other = 1 - batch->queue;
    uint32_t last = test->now.values[other];
    if (batch->queue == test->leader)
        for (last = 0; last < test->now.values[other]; last++) {
            uint32_t i = 0;
            while (test->now.model.batches[i].queue != other ||
                   test->now.model.batches[i].signal_value != last + 1)
                i++;
            if (!test->now.model.batches[i].has_run)
                break;
        }
    else
        last += 2;
    if (last == 0)
        return;
    const uint32_t value = 1 + below(test, last);
    add_words(test, " wait t%u=%u", other, value);
    batch->waits_for = other;
    batch->wait_value = value;
    if (batch->queue != test->leader && test->now.awaited < value)
        test->now.awaited = value;
}

static void signal_timeline(struct random_test *test, struct model_batch *batch, uint32_t value)
{
    batch->signal_value = test->now.values[batch->queue] = value;
    add_words(test, " signal t%u=%u", batch->queue, value);
}

static void add_batch(struct random_test *test, uint32_t queue)
{
    struct model_batch *batch = model_add_batch(&test->now.model, queue);
    const uint32_t number = test->now.model.batch_count - 1, binary = below(test, SEMAPHORES);
    test->batch[0] = '\0';
    if (test->now.binary_signal[binary] != -1 && chance(test, 50) &&
        may_wait_for(test, queue, test->now.binary_signal[binary])) {
        add_words(test, " wait s%u", binary);
        batch->binary_signal = test->now.binary_signal[binary];
        test->now.binary_signal[binary] = -1;
    }
    if (!test->queue && chance(test, 30))
        add_timeline_wait(test, batch);
    add_commands(test, batch);
    if (test->now.binary_signal[binary] == -1 && batch->binary_signal < 0 && chance(test, 40)) {
        add_words(test, " signal s%u", binary);
        test->now.binary_signal[binary] = (int)number;
    }
    if (chance(test, 40))
        signal_timeline(test, batch, test->now.values[queue] + 1);
}

/* One batch or two; the line of the submission has the last. */
static void add_submission(struct random_test *test, uint32_t queue, bool is_second_form,
                           bool fails)
{
    for (uint32_t i = below(test, 2) + 1; i > 0; i--) {
        add_batch(test, queue);
        if (i > 1)
            add_line(test, "batch%s", test->batch);
    }
    if (fails)
        add_line(test, "fail vkQueueSubmit%s OUT_OF_HOST_MEMORY", is_second_form ? "2" : "");
    add_line(test, "submit%s %s%s%s", is_second_form ? "" : "1", queue_name(test, queue),
             test->batch, fails ? " returns OUT_OF_HOST_MEMORY" : "");
}

/* Most programs need no copy. */
static void begin_submission(struct random_test *test)
{
    if (test->is_faulty)
        test->before = test->now;
}

static void submit(struct random_test *test)
{
    const uint32_t queue = random_queue(test);
    begin_submission(test);
    add_submission(test, queue, chance(test, 50), false);
    model_run(&test->now.model);
    expect_findings(test, false);
    if (!play_lines(test) && test->is_faulty)
        test->now = test->before;
}

/* Adds a submission that fails, or that the callback skips because of a finding. The layer judges
 * it like others, and it changes nothing. */
static void submit_in_vain(struct random_test *test)
{
    const uint32_t queue = random_queue(test);
    const bool fails = chance(test, 40);
    test->before = test->now;
    add_submission(test, queue, chance(test, 50), fails);
    model_run_queue(&test->now.model, queue);
    const bool is_in_vain = fails || test->now.model.finding_count;
    if (!is_in_vain)
        model_run(&test->now.model);
    expect_findings(test, is_in_vain && !fails);
    play_lines(test);
    if (is_in_vain)
        test->now = test->before;
}

/* A lost device executes nothing any more, so nothing is pending. */
static bool succeeds_or_is_lost(struct random_test *test)
{
    return play_lines(test) || test->play.result == VK_ERROR_DEVICE_LOST;
}

/* Lets all batches go that are still held back. Returns false if the submission failed. */
static bool release(struct random_test *test)
{
    if (test->now.values[test->leader] >= test->now.awaited)
        return true;
    begin_submission(test);
    test->batch[0] = '\0';
    signal_timeline(test, model_add_batch(&test->now.model, test->leader), test->now.awaited);
    add_line(test, "submit1 %s%s", queue_name(test, test->leader), test->batch);
    model_run(&test->now.model);
    expect_findings(test, false);
    if (play_lines(test) || !test->is_faulty)
        return true;
    test->now = test->before;
    return test->play.result == VK_ERROR_DEVICE_LOST;
}

/* Waits for all batches. Returns false if that failed. */
static bool idle(struct random_test *test)
{
    for (uint32_t i = 1; i <= OPERATIONS; i++)
        join(test, i);
    if (!release(test))
        return false;
    add_line(test, "host wait %s", test->queue ? test->queue : "idle");
    if (!succeeds_or_is_lost(test))
        return false;
    model_idle(&test->now.model);
    memset(test->pending, 0, sizeof(test->pending));
    return true;
}

/* ---- programs */

void random_start(struct random_test *test)
{
    add_line(test, "structures generic");
    if (test->is_faulty)
        create_all(test);
    add_line(test, "timeline t0 0; timeline t1 0");
    for (uint32_t i = 0; i < STRUCTURES; i++)
        add_line(test, "create B%u", i);
    test->now.model.batch_count = test->now.model.finding_count = 0;
    test->now.model.host = 0;
    memset(test->now.model.write_count, 0, sizeof(test->now.model.write_count));
    memset(test->now.model.host_writers, 0, sizeof(test->now.model.host_writers));
    memset(test->works, 0, sizeof(test->works));
    memset(test->pending, 0, sizeof(test->pending));
    test->leader = random_queue(test);
    test->now.awaited = 0;
    memset(test->now.values, 0, sizeof(test->now.values));
    for (uint32_t i = 0; i < SEMAPHORES; i++)
        test->now.binary_signal[i] = -1;
    for (uint32_t i = 0; i < COMMAND_BUFFERS; i++)
        forget_recording(test, i);
    play_lines(test);
}

void random_finish(struct random_test *test)
{
    if (!idle(test))
        idle(test);
    test->batch[0] = '\0';
    for (uint32_t i = 0; i < SEMAPHORES; i++)
        if (test->now.binary_signal[i] >= 0)
            add_words(test, " wait s%u", i);
    add_line(test, "submit1 %s%s; host wait %s", queue_name(test, 0), test->batch,
             test->queue ? test->queue : "idle");
    play_lines(test);
}

void random_step(struct random_test *test)
{
    const uint32_t dice = below(test, 100);
    if (test->is_over || test->play.report.outcome != OUTCOME_PASSED)
        return;
    if (dice < 35) {
        record(test);
    } else if (dice < 55 && !test->queue) { /* threads leave its order to batches open */
        work_on_host(test);
    } else if (dice < 90 || (dice < 93 && test->is_faulty)) {
        submit(test);
    } else if (dice < 93) {
        submit_in_vain(test);
    } else if (idle(test)) {
        if (chance(test, 30))
            recreate(test, below(test, STRUCTURES));
        else if (test->is_faulty && chance(test, 40))
            renew_scratch(test);
    }
}
