/* SPDX-License-Identifier: Apache-2.0 */
/* Replaying journals as batches execute.
 *
 * The hooks are called by one thread at a time (src/state/order/order.h), so the live states need
 * no lock, and none is held while a message goes out. Structures may be destroyed, or written by
 * the host, on any thread: news of that waits on a list of its own until the next batch. */
#include "layer/execution/submissions.h"

#include <pthread.h>
#include <stdlib.h>

#include "layer/execution/contents.h"
#include "layer/layer.h"
#include "layer/snapshots/snapshots.h"
#include "src/check/replay/replay.h"
#include "src/state/builds/built_flags.h"

struct submissions {
    struct layer_device *device;
    struct build_states live;
    struct built_flags *flags; /* NULL: nobody asks */
    bool lost;                 /* nothing is known any more, of anything */

    struct build_undo undo; /* of batches that were checked and have not run */

    pthread_mutex_t news_lock; /* guards the rest */
    struct news {
        uint64_t first_id;
        uint32_t count;
    } * news;
    size_t news_count, news_capacity;
};

VkResult submissions_create(struct layer_device *device, struct submissions **submissions)
{
    *submissions = calloc(1, sizeof(**submissions));
    if (!*submissions)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*submissions)->device = device;
    pthread_mutex_init(&(*submissions)->news_lock, NULL);
    if (device->level >= LEVEL_CONTENT &&
        (device->facts.micromap.ext || device->facts.micromap.khr))
        (*submissions)->flags = built_flags_create();
    return VK_SUCCESS;
}

void submissions_destroy(struct submissions *submissions)
{
    if (!submissions)
        return;
    build_undo_release(&submissions->undo);
    build_states_release(&submissions->live);
    built_flags_destroy(submissions->flags);
    pthread_mutex_destroy(&submissions->news_lock);
    free(submissions->news);
    free(submissions);
}

static bool reserve_news(struct submissions *submissions)
{
    if (submissions->news_count < submissions->news_capacity)
        return true;
    size_t capacity = submissions->news_capacity ? submissions->news_capacity * 2 : 64;
    struct news *news = realloc(submissions->news, capacity * sizeof(*news));
    if (!news)
        return false;
    submissions->news = news;
    submissions->news_capacity = capacity;
    return true;
}

/* Without memory nothing is lost: of what is dead nobody asks again, as ids are not used twice. */
void submissions_forget(struct submissions *submissions, uint64_t first_id, uint32_t count)
{
    if (!submissions || !first_id)
        return;
    pthread_mutex_lock(&submissions->news_lock);
    if (reserve_news(submissions))
        submissions->news[submissions->news_count++] = (struct news){first_id, count};
    pthread_mutex_unlock(&submissions->news_lock);
}

static void lose(struct submissions *submissions)
{
    submissions->lost = true;
    build_undo_release(&submissions->undo);
    build_states_release(&submissions->live);
    built_flags_forget_all(submissions->flags);
}

struct built_flags *submissions_flags(const struct submissions *submissions)
{
    return submissions ? submissions->flags : NULL;
}

static void take_news(struct submissions *submissions)
{
    pthread_mutex_lock(&submissions->news_lock);
    for (size_t i = 0; i < submissions->news_count; i++) {
        const struct news *news = &submissions->news[i];
        for (uint32_t j = 0; j < news->count; j++) {
            build_states_remove(&submissions->live, news->first_id + j);
            built_flags_forget(submissions->flags, news->first_id + j);
        }
    }
    submissions->news_count = 0;
    pthread_mutex_unlock(&submissions->news_lock);
}

/* ---- one batch */

struct batch {
    struct submissions *submissions;
    struct call_origin origin;
    bool skip; /* a callback asked to skip the call */
};

static void locate(void *user, const struct journal *journal, uint32_t position, uint32_t info)
{
    struct batch *batch = user;
    batch->origin.command_buffer = journal->command_buffer;
    batch->origin.build_index = position - info;
    batch->origin.labels = journal_labels_at(journal, position);
}

static bool found(void *user, enum rule rule, const struct location *location,
                  const struct finding *finding)
{
    struct batch *batch = user;
    struct reporter *reporter = batch->submissions->device->instance->reporter;
    if (reporter_send(reporter, rule, location, &batch->origin, finding))
        batch->skip = true;
    return reporter_wants(reporter, rule_infos[rule].vuid[location->command]);
}

static struct replay replay_of(struct batch *batch, const struct batch_run *run)
{
    struct submissions *submissions = batch->submissions;
    return (struct replay){
        .active = submissions->device->active_rules,
        .resources = submissions->device->resources,
        .states = &submissions->live,
        .flags = submissions->flags,
        .now = run->moment,
        .follows = run->clock,
        .predecessors_known = run->predecessors_known,
        .never_is_certain = !submissions->device->facts.has_other_builders,
        .unordered = run->work != WORK_OF_QUEUE,
        .locate = locate,
        .found = found,
        .user = batch,
    };
}

/* Work of the host is judged before its call goes down, if its turn has come by then. */
static void replay_work(struct replay *replay, const struct journal *journal,
                        const struct batch_run *run)
{
    if (run->work != WORK_BEGINS) {
        replay_end_work(replay, journal, run->work == WORK_FAILS);
        return;
    }
    if (!run->checked)
        replay_judge_work(replay, journal);
    replay_begin_work(replay, journal);
}

/* Judges a batch and, save for a check of the host's work, applies it. A command buffer without a
 * whole journal may have written anything. */
static bool replay_batch(struct submissions *submissions, const struct batch_run *run,
                         struct build_undo *undo)
{
    struct batch batch = {
        .submissions = submissions,
        .origin = {.device = submissions->device->handle,
                   .names = submissions->device->names,
                   .queue = run->queue},
    };
    struct replay replay = replay_of(&batch, run);
    struct content_notes *notes =
        run->work == WORK_OF_QUEUE ? contents_note_batch(submissions->device->contents, run) : NULL;
    replay.undo = undo;
    take_news(submissions);
    for (uint32_t i = 0; i < run->command_count && !submissions->lost; i++) {
        const struct journal *journal = run->commands[i].captured;
        if (!journal || journal->incomplete) {
            lose(submissions);
            break;
        }
        replay.notes = notes ? &notes[i] : NULL;
        if (run->work == WORK_OF_QUEUE) {
            replay_deaths(&replay, journal);
            replay_submitted(&replay, journal);
        } else if (undo) {
            replay_judge_work(&replay, journal);
        } else {
            replay_work(&replay, journal, run);
        }
        if (replay.out_of_memory)
            lose(submissions);
    }
    return batch.skip;
}

/* ---- hooks */

static void *capture(void *user, VkCommandBuffer handle)
{
    struct submissions *submissions = user;
    struct command_buffer *command_buffer =
        command_buffers_find(submissions->device->command_buffers, handle);
    return command_buffer && command_buffer->journal ? journal_share(command_buffer->journal)
                                                     : NULL;
}

static bool is_open(void *user, VkQueue queue, const void *captured)
{
    const struct submissions *submissions = user;
    return events_submit(submissions->device->events, queue, captured);
}

static void settle_bindings(struct resources *resources, const struct journal *journal)
{
    struct journal_cursor cursor = journal_start(journal);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));) {
        const struct sparse_binding binding = journal_binding(entry);
        resources_settle_sparse(resources, &binding);
    }
}

static void release(void *user, void *captured)
{
    const struct submissions *submissions = user;
    const struct journal *journal = captured;
    if (journal->binds)
        settle_bindings(submissions->device->resources, journal);
    journal_release(captured);
}

/* A batch is judged before its call goes down, so that a callback can have the call skipped, and
 * applied at once: what comes before it has run. */
static bool check(void *user, const struct batch_run *run)
{
    struct submissions *submissions = user;
    return !submissions->lost && replay_batch(submissions, run, &submissions->undo);
}

static void drop(void *user)
{
    struct submissions *submissions = user;
    for (size_t i = 0; i < submissions->undo.count; i++)
        built_flags_forget(submissions->flags, submissions->undo.before[i].id);
    build_undo_carry_out(&submissions->undo, &submissions->live);
    contents_drop(submissions->device->contents);
}

static void run_batch(void *user, const struct batch_run *run)
{
    struct submissions *submissions = user;
    bool is_done = run->checked && run->work == WORK_OF_QUEUE;
    build_undo_forget(&submissions->undo);
    if (!is_done && !submissions->lost)
        replay_batch(submissions, run, NULL);
    if (submissions->device->snapshots)
        snapshots_run(submissions->device, run);
    contents_end_batch(submissions->device->contents, run);
}

static void lost(void *user, enum order_loss why)
{
    struct submissions *submissions = user;
    lose(submissions);
    if (submissions->device->snapshots)
        snapshots_lose_order(submissions->device, why);
}

struct execution_hooks submissions_hooks(struct submissions *submissions)
{
    return (struct execution_hooks){
        .user = submissions,
        .capture = capture,
        .release = release,
        .is_open = is_open,
        .check = check,
        .drop = drop,
        .run = run_batch,
        .lost = lost,
    };
}
