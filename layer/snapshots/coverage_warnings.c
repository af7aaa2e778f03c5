/* SPDX-License-Identifier: Apache-2.0 */
/* Words the warnings about builds that level content does not validate. */
#include "layer/snapshots/executions.h"

#include "layer/snapshots/recorder.h"
#include "src/report/words.h"

enum { LINE_SIZE = 1024 };

static bool is_reported(const struct layer_device *device)
{
    return device->level >= LEVEL_CONTENT;
}

static const char *reason_of(enum left_out reason)
{
    switch (reason) {
    case LEFT_OUT_NOTHING:
    case LEFT_OUT_MEMORY:
        break;
    case LEFT_OUT_BUDGET:
        return "beyond content_budget_mib";
    case LEFT_OUT_BUFFER:
        return "a buffer that can't be read";
    case LEFT_OUT_PLACE:
        return "no place for copies";
    }
    return "no memory for copies";
}

/* For the summary. */
static void count_left_out(const struct layer_device *device, const struct recording *recording)
{
    static const char *const what[] = {
        [LEFT_OUT_NOTHING] = "builds without memory for copies",
        [LEFT_OUT_MEMORY] = "builds without memory for copies",
        [LEFT_OUT_BUDGET] = "builds beyond content_budget_mib",
        [LEFT_OUT_BUFFER] = "builds with a buffer that can't be read",
        [LEFT_OUT_PLACE] = "builds without a place for copies",
    };
    struct reporter *reporter = device->instance->reporter;
    for (uint32_t i = 0; i < recording->left_out_count && i < LEFT_OUT_NAMED; i++)
        reporter_add_unchecked(reporter, what[recording->left_out[i].reason], 1);
    if (recording->left_out_count > LEFT_OUT_NAMED)
        reporter_add_unchecked(reporter, "builds that follow those in the same command buffers",
                               recording->left_out_count - LEFT_OUT_NAMED);
}

static void append_builds(struct text_buffer *text, const struct recording *recording)
{
    uint32_t named =
        recording->left_out_count < LEFT_OUT_NAMED ? recording->left_out_count : LEFT_OUT_NAMED;
    for (uint32_t i = 0; i < named; i++) {
        const struct left_out_build *build = &recording->left_out[i];
        text_append(text, i ? ", " : " ");
        if (build->position == POSITION_OF_OTHERS)
            text_append(text, "a build of a micromap or a deserialization");
        else
            text_say(text, "build {}", number(build->position));
        text_say(text, " ({})", phrase(reason_of(build->reason)));
    }
    if (named < recording->left_out_count)
        text_say(text, " and {} more", number(recording->left_out_count - named));
}

/* Secondaries were reported when they were executed. */
void warn_left_out(const struct layer_device *device, VkCommandBuffer handle)
{
    struct recording *recording = recording_of(device, handle);
    if (!is_reported(device) || !recording || !recording->left_out_count ||
        recording->left_out_reported)
        return;
    char line[LINE_SIZE];
    struct text_buffer text;
    recording->left_out_reported = true;
    count_left_out(device, recording);
    text_begin(&text, line, sizeof(line));
    words_say((&(const struct words){.text = &text, .names = device->names}),
              "assay_validation.level = content: {} has builds that are unchecked, or only partly "
              "checked:",
              object(VK_OBJECT_TYPE_COMMAND_BUFFER, handle_number(handle)));
    append_builds(&text, recording);
    text_append(&text, ".");
    reporter_warn(device->instance->reporter, line);
}

static void append_executions(struct text_buffer *text, uint32_t count, const char *why)
{
    if (count)
        text_say(text, text->text[text->length - 1] == ':' ? " {} {}" : "; {} {}", number(count),
                 phrase(why));
}

/* For the summary. */
static void count_missed(const struct layer_device *device, const struct missed_executions *missed)
{
    const struct {
        uint32_t count;
        const char *what;
    } counts[] = {
        {missed->no_memory, "executions without memory for copies"},
        {missed->overwritten, "executions that another one of the same submission overwrote"},
        {missed->unread, "executions that were submitted again before they were complete"},
        {missed->repeated,
         "executions after the first with VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT"},
        {missed->device_lost, "executions on a lost device"},
        {missed->held, "executions that wait for signals that were not submitted"},
    };
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); i++)
        if (counts[i].count)
            reporter_add_unchecked(device->instance->reporter, counts[i].what, counts[i].count);
}

void warn_missed(const struct layer_device *device, const struct missed_executions *missed)
{
    char line[LINE_SIZE];
    struct text_buffer text;
    if (!is_reported(device) || !(missed->no_memory || missed->overwritten || missed->unread ||
                                  missed->repeated || missed->device_lost || missed->held))
        return;
    count_missed(device, missed);
    text_begin(&text, line, sizeof(line));
    text_append(&text,
                "assay_validation.level = content: builds are unchecked in these executions "
                "of command buffers:");
    append_executions(&text, missed->no_memory, "for lack of memory");
    append_executions(&text, missed->overwritten,
                      "followed by another of the same command buffer in the submission");
    append_executions(&text, missed->unread,
                      "of command buffers that are submitted again before they are complete");
    append_executions(&text, missed->repeated,
                      "of command buffers that were begun with "
                      "VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT and are submitted again");
    append_executions(&text, missed->device_lost, "on a device that is lost");
    append_executions(&text, missed->held, "after waits for signals that were not submitted");
    text_append(&text, ".");
    reporter_warn(device->instance->reporter, line);
}

void warn_unordered(const struct layer_device *device)
{
    struct snapshots *snapshots = device->snapshots;
    uint32_t count = atomic_load(&snapshots->unordered);
    if (!is_reported(device) || !count || !unknown_is_set(&snapshots->order_unknown) ||
        atomic_exchange(&snapshots->unordered_reported, true))
        return;
    reporter_say_warning(
        device->instance->reporter,
        "assay_validation.level = content: builds are unchecked in {} of command buffers, and "
        "in all from now on, because their order is unknown ({}).",
        count_of(count, "execution"), phrase(order_unknown_words[snapshots->unknown_reason].cause));
}

void warn_lack_of_copies(const struct layer_device *device)
{
    if (atomic_exchange(&device->snapshots->lack_of_copies_reported, true))
        return;
    reporter_warn(device->instance->reporter,
                  device->snapshots->are_for_backend
                      ? "assay_validation.backend = cpu can't build: the driver completed a "
                        "submission without executing the commands that copy what builds "
                        "read. Is it a mock driver?"
                      : "assay_validation.level = content can't validate builds: the driver "
                        "completed a submission without executing the commands that copy "
                        "what builds read. Is it a mock driver?");
}
