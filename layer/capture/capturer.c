/* SPDX-License-Identifier: Apache-2.0 */
/* Setting capture: writes what the device builds, in execution order, and the data of it, to a
 * folder (src/capture/lines.h).
 *
 * Lines are queued at the execution point of their batch. A build waits in the queue until its data
 * was read, which is after its completion; the lines behind it wait, too. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "layer/consumers.h"
#include "layer/execution/build_records.h"
#include "layer/physical_device.h"
#include "src/capture/lines.h"
#include "src/platform/process.h"
#include "src/platform/threads.h"
#include "src/report/words.h"
#include "src/state/resources/nv_shape.h"
#include "src/view/names.h"

enum { PATH_SHOWN = 512, WARNING_SIZE = 1024 };

/* A line that is not written yet. A build waits while `batch` is set. */
struct queued_line {
    struct queued_line *next;
    const struct order_batch *batch; /* that executes the build, in which command buffer */
    uint32_t command;
    const struct recorded_build *build;
    bool is_before;    /* the capture has not begun: what structures need is kept */
    bool is_last;      /* the capture ends with it */
    bool destroys;     /* `dst` */
    uint64_t dst, src; /* ids of structures: that is written, that is read; 0: none */
    size_t size;       /* of `text`; a build's lacks the } at the end */
    char text[];
};

struct capturer {
    struct layer_device *device;
    pthread_mutex_t lock; /* guards what follows */
    struct capture_writer writer;
    struct queued_line *first, **last;
    struct json head;
    uint64_t lines, calls;      /* their numbers */
    bool has_begun, has_ended;  /* capture_from and capture_until: no line is queued any more */
    bool was_in_label;          /* of capture_until */
    bool is_over;               /* nothing is written any more */
    char warning[WARNING_SIZE]; /* to be sent; "": none */
};

/* ---- the folder */

/* Ends the capture once the folder takes no more. The lock is held: leave() sends the warning. */
static void end_if_failed(struct capturer *capturer)
{
    struct text_buffer text;
    const struct capture_folder *folder = &capturer->writer.folder;
    const int error = folder->error;
    if (capturer->is_over || !(error || folder->is_full))
        return;
    capturer->is_over = true;
    if (!error)
        capture_write_end(&capturer->writer, "capture_limit_mib was reached");
    text_begin(&text, capturer->warning, sizeof(capturer->warning));
    text_say(&text, "assay_validation.capture: {} ends here: {}. The application goes on.",
             quoted(folder->path, PATH_SHOWN),
             phrase(error ? strerror(error) : "capture_limit_mib is reached"));
}

static void enter(struct capturer *capturer)
{
    pthread_mutex_lock(&capturer->lock);
}

/* `may_warn`: the caller holds no other lock. Then the lines are written, too. */
static void leave(struct capturer *capturer, bool may_warn)
{
    char warning[WARNING_SIZE] = "";
    if (may_warn) {
        capture_folder_flush(&capturer->writer.folder);
        end_if_failed(capturer);
    }
    if (may_warn && capturer->warning[0]) {
        memcpy(warning, capturer->warning, sizeof(warning));
        capturer->warning[0] = '\0';
    }
    pthread_mutex_unlock(&capturer->lock);
    if (warning[0])
        reporter_warn(capturer->device->instance->reporter, warning);
}

/* The devices of a process after the first one write to folders of their own. */
static bool find_path(const char *pattern, char path[LOG_PATH_SIZE])
{
    static atomic_uint devices;
    struct text_buffer text;
    if (!log_filename_expand(pattern, path))
        return false;
    const unsigned number = atomic_fetch_add(&devices, 1) + 1;
    text = (struct text_buffer){path, LOG_PATH_SIZE, strlen(path), false};
    if (number > 1) {
        text_append(&text, "-");
        text_append_decimal(&text, number);
    }
    return !text.cut;
}

static void warn_of_folder(const struct capturer *capturer, const char *path, int error)
{
    reporter_say_warning(
        capturer->device->instance->reporter,
        "assay_validation.capture: {} cannot be written ({}). Nothing is captured.",
        quoted(path, PATH_SHOWN), phrase(error == EEXIST ? "it has a capture" : strerror(error)));
}

static void write_device(struct capturer *capturer)
{
    const struct layer_device *device = capturer->device;
    PFN_vkGetPhysicalDeviceProperties2 get_properties = physical_device_properties2(
        device->instance, &device->instance->vk, device->physical_device);
    VkPhysicalDeviceAccelerationStructurePropertiesKHR limits = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR};
    VkPhysicalDeviceDriverProperties driver = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES, .pNext = &limits};
    VkPhysicalDeviceProperties2 properties = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &driver};
    if (get_properties)
        get_properties(device->physical_device, &properties);
    capture_write_device(&capturer->writer, &(struct capture_device){
                                                .handle = device->handle,
                                                .properties = &properties.properties,
                                                .driver = &driver,
                                                .limits = &limits,
                                            });
}

/* Returns 0 or an error number. */
static int open_folder(struct capturer *capturer, const struct settings *settings,
                       struct reporter *reporter)
{
    char path[LOG_PATH_SIZE];
    if (process_is_elevated())
        return EPERM; /* as for the log */
    if (!find_path(settings->capture, path))
        return ENAMETOOLONG;
    int error =
        capture_writer_open(&capturer->writer, path, (uint64_t)settings->capture_limit_mib << 20);
    if (error)
        return error;
    write_device(capturer);
    struct text_buffer text = {path, sizeof(path), strlen(path), false};
    text_append(&text, "/findings.jsonl");
    error = text.cut ? ENAMETOOLONG : reporter_copy_messages(reporter, path);
    return error ? error : capturer->writer.folder.error;
}

/* ---- the queue: the caller holds the lock */

static void keep_line(struct capture_writer *writer, const struct queued_line *line)
{
    if (line->destroys)
        capture_kept_remove(&writer->kept, &writer->folder, line->dst);
    else if (line->dst)
        capture_kept_add(&writer->kept, &writer->folder, line->dst, line->src, line->text,
                         line->size);
}

static void write_line(struct capturer *capturer, const struct queued_line *line)
{
    struct capture_writer *writer = &capturer->writer;
    if (capturer->is_over)
        return;
    if (line->is_before) {
        keep_line(writer, line);
        return;
    }
    capture_kept_write(&writer->kept, &writer->folder, line->src, &capturer->lines);
    capture_kept_remove(&writer->kept, &writer->folder, line->dst);
    if (line->is_last) {
        capture_write_end(writer, "capture_until was reached");
        capturer->is_over = true;
    } else {
        capture_folder_add_command(&writer->folder, ++capturer->lines, false, line->text,
                                   line->size);
    }
}

static void write_queue(struct capturer *capturer)
{
    while (capturer->first && !capturer->first->batch) {
        struct queued_line *line = capturer->first;
        capturer->first = line->next;
        if (!capturer->first)
            capturer->last = &capturer->first;
        write_line(capturer, line);
        free(line);
    }
}

static struct queued_line *make_line(const char *text, size_t size)
{
    struct queued_line *line = malloc(sizeof(*line) + size);
    if (!line)
        return NULL;
    *line = (struct queued_line){.size = size};
    memcpy(line->text, text, size);
    return line;
}

static void add_line(struct capturer *capturer, struct queued_line *line)
{
    *capturer->last = line;
    capturer->last = &line->next;
}

/* Ends the line of a build, which has waited at `place`, with an object of more members. */
static void complete_line(struct capturer *capturer, struct queued_line **place, const char *more,
                          size_t size)
{
    struct queued_line *line = *place;
    const bool is_last = capturer->last == &line->next;
    struct queued_line *whole = realloc(line, sizeof(*line) + line->size + size);
    if (!whole) { /* as if its data could not be read */
        more = "}\n";
        size = 2; /* for which there is room */
        whole = line;
    }
    memcpy(whole->text + whole->size, more, size);
    if (*more == '{')
        whole->text[whole->size] = ','; /* the line has members */
    whole->size += size;
    whole->batch = NULL;
    *place = whole;
    if (is_last)
        capturer->last = &whole->next;
}

static void complete_without_data(struct capturer *capturer, struct queued_line **place,
                                  const char *why)
{
    struct json *json = &capturer->writer.build;
    json_begin(json);
    json_text(json, "missing", why);
    json_end(json);
    complete_line(capturer, place, json->text.text, json->text.length);
}

/* Completes the builds of a command buffer that still wait; of all, if `batch` is NULL. */
static void complete_all(struct capturer *capturer, const struct order_batch *batch,
                         uint32_t command)
{
    for (struct queued_line **at = &capturer->first; *at; at = &(*at)->next)
        if ((*at)->batch && (!batch || ((*at)->batch == batch && (*at)->command == command)))
            complete_without_data(capturer, at, "the layer did not copy its data");
    write_queue(capturer);
}

/* ---- batches */

/* A record that is about to become a line. */
struct captured_record {
    struct log_record record; /* first */
    struct capturer *capturer;
    const struct journal *journal;
    const struct journal_entry *entry; /* NULL: a structure was destroyed */
    const struct recorded_build *build;
    const struct order_batch *waits_for; /* as struct queued_line has it */
    uint32_t command;
    uint64_t dst_id, src_id; /* of structures; 0: none */
};

static void write_origin(struct json *json, const struct captured_record *captured)
{
    const struct journal_entry *entry = captured->entry;
    line_add_region(json, "region", shared_labels_stack(captured->record.submission.labels),
                    journal_labels(captured->journal, entry->origin));
    json_text(json, "command", build_command_name((enum build_command)entry->command));
    if (captured->record.kind == RECORD_BUILD && !journal_is_fill(entry)) {
        json_number(json, "call", captured->capturer->calls);
        json_number(json, "info", entry->info);
    }
    if (captured->record.kind == RECORD_QUERY) {
        const struct value query = query_type(entry->read.query);
        json_text(json, "query", query.kind == VALUE_TEXT ? query.text : "");
    }
    if (captured->src_id)
        json_number(json, "src_id", captured->src_id);
}

static void write_more(struct json *json, const struct log_record *record)
{
    const struct captured_record *captured = (const struct captured_record *)(const void *)record;
    if (captured->entry)
        write_origin(json, captured);
    if (captured->dst_id)
        json_number(json, "dst_id", captured->dst_id);
}

/* As far as a structure of VK_NV_ray_tracing has such facts. */
static void look_up_nv(struct capturer *capturer, uint64_t handle, struct accel_facts *facts)
{
    struct nv_accel_facts nv;
    resources_look_up_nv_accel(capturer->device->resources,
                               (VkAccelerationStructureNV)(uintptr_t)handle, &nv);
    *facts = (struct accel_facts){
        .id = nv.id,
        .handle = (VkAccelerationStructureKHR)(uintptr_t)handle,
        .details_known = nv.created && nv.sizes.known,
        .size = nv.sizes.object,
        .type = nv.created ? nv.created->type : VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR,
    };
    nv_shape_release(nv.created);
}

static void describe_structure(struct capturer *capturer, VkObjectType type, uint64_t handle,
                               uint64_t id, const char *missing)
{
    struct accel_facts facts = {0};
    if (type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV)
        look_up_nv(capturer, handle, &facts);
    else if (type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR)
        resources_look_up_accel(capturer->device->resources,
                                (VkAccelerationStructureKHR)(uintptr_t)handle, &facts);
    if (id && facts.id == id)
        capture_write_structure(&capturer->writer, &facts, missing);
}

static const char *const before =
    "it was built before the capture began, or by a command that is not captured";

static void queue_record(struct captured_record *captured)
{
    struct capturer *capturer = captured->capturer;
    struct json *json = &capturer->head;
    captured->record.write_more = write_more;
    if (!line_of_record(json, &captured->record))
        return;
    struct queued_line *line = make_line(json->text.text, json->text.length);
    if (!line)
        return;
    line->size -= captured->waits_for ? 2 : 0; /* } and the newline */
    line->batch = captured->waits_for;
    line->command = captured->command;
    line->is_before = !capturer->has_begun;
    line->dst = captured->dst_id;
    /* A build may name a source that it does not read. */
    line->src = captured->entry && journal_is_build(captured->entry) ? 0 : captured->src_id;
    line->destroys = captured->record.kind == RECORD_DESTROYED;
    line->build = captured->build;
    add_line(capturer, line);
}

/* What builds have of their parameters, whatever was built before. */
static void add_parameters(struct log_record *record, const struct recorded_build *build)
{
    const struct build_parameters *given = recorded_build_given(build);
    if (build->addressed || build->deserialization)
        return;
    record->has_geometries = true;
    record->geometries = given->info.geometryCount;
    record->flags = given->info.flags;
}

/* ---- where the capture begins and ends */

static bool has_label(const struct label_stack *stack, const char *text)
{
    for (uint32_t i = 0; stack && i < stack->count; i++)
        if (strstr(stack->labels[i].pLabelName, text))
            return true;
    return false;
}

static bool is_in_label(const struct capture_point *point, const struct captured_record *captured)
{
    return has_label(shared_labels_stack(captured->record.submission.labels), point->label) ||
           has_label(journal_labels(captured->journal, captured->entry->origin), point->label);
}

static bool begins(const struct capture_point *from, const struct captured_record *captured)
{
    switch (from->kind) {
    case AT_FRAME:
        return captured->record.submission.frame >= from->number;
    case AT_SUBMISSION:
        return captured->record.submission.number >= from->number;
    case AT_LABEL:
        return is_in_label(from, captured);
    case AT_ANY_POINT:
        break;
    }
    return true;
}

static bool ends(struct capturer *capturer, const struct capture_point *until,
                 const struct captured_record *captured)
{
    const bool was_in_label = capturer->was_in_label;
    switch (until->kind) {
    case AT_FRAME:
        return captured->record.submission.frame > until->number;
    case AT_SUBMISSION:
        return captured->record.submission.number > until->number;
    case AT_LABEL:
        capturer->was_in_label = is_in_label(until, captured);
        return was_in_label && !capturer->was_in_label;
    case AT_ANY_POINT:
        break;
    }
    return false;
}

static void queue_end(struct capturer *capturer)
{
    struct queued_line *line = make_line("", 0);
    capturer->has_ended = true;
    if (!line)
        return;
    line->is_last = true;
    add_line(capturer, line);
}

/* Whether a record is queued. */
static bool is_wanted(struct capturer *capturer, const struct captured_record *captured)
{
    const struct settings *settings = reporter_settings(capturer->device->instance->reporter);
    if (capturer->has_ended)
        return false;
    if (!capturer->has_begun)
        capturer->has_begun = begins(&settings->capture_from, captured);
    if (capturer->has_begun && ends(capturer, &settings->capture_until, captured))
        queue_end(capturer);
    return !capturer->has_ended && (capturer->has_begun || settings->capture_keep);
}

/* What a walk over a batch hands on. */
struct batch_walk {
    struct capturer *capturer;
    const struct order_batch *batch; /* NULL: no data of the command buffer was copied */
    uint32_t command;
};

static void add_record(void *user, const struct journal *journal, const struct journal_entry *entry,
                       const struct log_record *record)
{
    const struct batch_walk *walk = user;
    struct capturer *capturer = walk->capturer;
    const bool builds = record->kind == RECORD_BUILD && !journal_is_fill(entry);
    struct captured_record captured = {
        .record = *record,
        .capturer = capturer,
        .journal = journal,
        .entry = entry,
        .build = builds ? journal_copies(entry) : NULL,
        .dst_id = record->kind == RECORD_QUERY ? 0 : entry->dst_id,
        .src_id = record->src ? entry->src_id : 0, /* a deserialization reads a buffer */
    };
    if (record->object_type == VK_OBJECT_TYPE_MICROMAP_EXT)
        captured.dst_id = captured.src_id = 0;
    if (!is_wanted(capturer, &captured))
        return;
    describe_structure(capturer, record->object_type, record->src, captured.src_id, before);
    describe_structure(capturer, record->object_type, record->dst, captured.dst_id, NULL);
    if (captured.build) {
        capturer->calls += captured.build->begins_call;
        captured.waits_for = walk->batch;
        captured.command = walk->command;
        add_parameters(&captured.record, captured.build);
    } else {
        capturer->calls += builds;
    }
    queue_record(&captured);
}

static void run_batch(void *self, struct order_batch *batch)
{
    struct capturer *capturer = self;
    enter(capturer);
    for (uint32_t i = 0; i < batch->command_count && !capturer->is_over; i++) {
        const bool is_copied = atomic_load(&batch->commands[i].execution);
        struct batch_walk walk = {capturer, is_copied ? batch : NULL, i};
        build_records_walk(capturer->device, batch, i, &(struct record_sink){add_record, &walk});
    }
    write_queue(capturer);
    leave(capturer, true);
}

static struct batch_consumer batches(void *self)
{
    return (struct batch_consumer){.user = self, .run = run_batch};
}

static void on_destroy(void *self, VkAccelerationStructureKHR accel)
{
    struct capturer *capturer = self;
    struct accel_facts facts;
    resources_look_up_accel(capturer->device->resources, accel, &facts);
    enter(capturer);
    if (facts.id && handle_table_find(&capturer->writer.structures, facts.id) && !capturer->is_over)
        queue_record(&(struct captured_record){
            .record = {.kind = RECORD_DESTROYED,
                       .device = capturer->device->handle,
                       .names = capturer->device->names,
                       .object_type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                       .dst = handle_number(accel)},
            .capturer = capturer,
            .dst_id = facts.id,
        });
    write_queue(capturer);
    leave(capturer, false);
}

/* ---- data */

/* Collects what the instances of a build refer to. */
struct capture_reader {
    struct build_reader reader; /* first */
    struct capturer *capturer;
    struct executed_input executed;
    struct capture_reference *references;
    uint32_t count, capacity;
    bool lacks_memory;
};

/* The structures that all instances up to this geometry refer to. */
static void collect_references(struct build_reader *reader, struct content *content)
{
    struct capture_reader *own = (struct capture_reader *)reader;
    const struct instance_uses *uses = content->walk->instances;
    own->count = 0;
    for (size_t i = 0; uses && uses->indices.slots && i <= uses->indices.mask; i++) {
        const struct handle_slot *slot = &uses->indices.slots[i];
        if (!slot->handle)
            continue;
        const struct instance_use *use = &uses->items[(uintptr_t)slot->record - 1];
        if (!ARRAY_HAS_ROOM(own->references, own->count, own->capacity)) {
            own->lacks_memory = true;
            return;
        }
        own->references[own->count++] =
            (struct capture_reference){slot->handle, use->referenced.id, use->referenced.handle};
    }
}

static struct queued_line **find_waiting(struct capturer *capturer,
                                         const struct executed_input *executed)
{
    struct queued_line **at = &capturer->first;
    while (*at && ((*at)->batch != executed->batch || (*at)->command != executed->command ||
                   (*at)->build != executed->build))
        at = &(*at)->next;
    return at;
}

/* Writes the line of a structure that an instance refers to, and what was kept of it. */
static void describe_reference(struct capturer *capturer, const struct capture_reference *reference,
                               bool is_before)
{
    struct capture_writer *writer = &capturer->writer;
    describe_structure(capturer, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                       handle_number(reference->handle), reference->structure, before);
    if (!is_before && !capturer->is_over)
        capture_kept_write(&writer->kept, &writer->folder, reference->structure, &capturer->lines);
}

/* The data of a build was read: writes it, and ends the build's line. */
static void end_build(struct build_reader *reader)
{
    struct capture_reader *own = (struct capture_reader *)reader;
    struct capturer *capturer = own->capturer;
    const struct capture_build build = {own->executed.build, own->executed.memory, own->references,
                                        own->lacks_memory ? 0 : own->count};
    enter(capturer);
    struct queued_line **place = find_waiting(capturer, &own->executed);
    for (uint32_t i = 0; *place && i < build.reference_count; i++)
        describe_reference(capturer, &build.references[i], (*place)->is_before);
    capturer->writer.folder.holds = *place && (*place)->is_before;
    if (*place && capture_compose_build(&capturer->writer, &build))
        complete_line(capturer, place, capturer->writer.build.text.text,
                      capturer->writer.build.text.length);
    else if (*place)
        complete_without_data(capturer, place, "the layer had no memory");
    write_queue(capturer);
    leave(capturer, false); /* the snapshots are locked */
    free(own->references);
    free(own);
}

static struct build_reader *on_build(void *self, const struct executed_input *executed)
{
    struct capturer *capturer = self;
    if (executed->build->addressed || executed->build->deserialization)
        return NULL;
    struct capture_reader *reader = calloc(1, sizeof(*reader));
    if (!reader)
        return NULL;
    reader->reader = (struct build_reader){.on_geometry = collect_references, .end = end_build};
    reader->capturer = capturer;
    reader->executed = *executed;
    return &reader->reader;
}

static void report(void *self, const struct order_batch *batch, uint32_t command)
{
    struct capturer *capturer = self;
    enter(capturer);
    if (batch)
        complete_all(capturer, batch, command);
    leave(capturer, true);
}

/* ---- the device */

static void destroy(void *self)
{
    struct capturer *capturer = self;
    while (capturer->first) {
        struct queued_line *line = capturer->first;
        capturer->first = line->next;
        free(line);
    }
    capture_writer_close(&capturer->writer);
    pthread_mutex_destroy(&capturer->lock);
    free(capturer);
}

static VkResult start(struct layer_device *device, void **self)
{
    struct reporter *reporter = device->instance->reporter;
    const struct settings *settings = reporter_settings(reporter);
    if (!settings->capture || !device->snapshots)
        return VK_SUCCESS;
    struct capturer *capturer = calloc(1, sizeof(*capturer));
    if (!capturer)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    capturer->device = device;
    capturer->last = &capturer->first;
    capturer->writer.resources = device->resources;
    capturer->writer.names = device->names;
    pthread_mutex_init(&capturer->lock, NULL);
    const int error = open_folder(capturer, settings, reporter);
    if (error) {
        warn_of_folder(capturer, settings->capture, error);
        destroy(capturer);
        return VK_SUCCESS;
    }
    device->notes_figures = true;
    *self = capturer;
    return VK_SUCCESS;
}

static void conclude(void *self, bool destroys_device)
{
    struct capturer *capturer = self;
    enter(capturer);
    complete_all(capturer, NULL, 0);
    if (!capturer->is_over)
        capture_write_end(&capturer->writer, destroys_device ? "the device was destroyed"
                                                             : "the instance was destroyed");
    capturer->is_over = true;
    leave(capturer, true);
}

const struct consumer capturing = {
    .start = start,
    .conclude = conclude,
    .destroy = destroy,
    .batches = batches,
    .on_destroy = on_destroy,
    .on_build = on_build,
    .report = report,
};
