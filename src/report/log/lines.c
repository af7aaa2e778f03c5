/* SPDX-License-Identifier: Apache-2.0 */
/* Composes the lines of log_format = json and of record_builds = true. */
#include "src/report/log/lines.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "src/base/text_buffer.h"
#include "src/platform/clock.h"
#include "src/platform/process.h"
#include "src/report/finding_message.h"
#include "src/report/words.h"
#include "src/state/commands/call_sites.h"
#include "src/state/commands/object_names.h"
#include "src/state/order/order.h"
#include "vuid-tables/registry.h"

static void append_executable(struct text_buffer *text)
{
    char path[LOG_PATH_SIZE];
    process_executable(path, sizeof(path));
    const char *slash = strrchr(path, '/');
    text_append(text, slash ? slash + 1 : path);
}

bool log_filename_expand(const char *pattern, char path[LOG_PATH_SIZE])
{
    struct text_buffer text;
    text_begin(&text, path, LOG_PATH_SIZE);
    for (const char *rest = pattern; *rest;) {
        size_t plain = strcspn(rest, "%");
        text_append_part(&text, rest, plain);
        rest += plain;
        if (!*rest)
            break;
        if (rest[1] == 'p')
            text_append_decimal(&text, process_id());
        else if (rest[1] == 'e')
            append_executable(&text);
        else
            text_append(&text, "%");
        rest += rest[1] == 'p' || rest[1] == 'e' || rest[1] == '%' ? 2 : 1;
    }
    return !text.cut;
}

/* ---- composes the lines of log_format = json */

enum {
    TIME_SIZE = 64,
    REGION_SIZE = 2 * MESSAGE_LABELS * MESSAGE_NAME_SIZE,
    SPEC_SIZE = 4096,
    REASON_SIZE = 512,
    NAME_SHOWN = MESSAGE_NAME_SIZE - 1,
};

/* Begins a line with the members that all lines have. The other functions call it. */
static void line_begin(struct json *json, const char *type)
{
    char time[TIME_SIZE];
    struct text_buffer text;
    text_begin(&text, time, sizeof(time));
    text_append_time(&text, clock_utc());
    json_begin(json);
    json_text(json, "Type", type);
    json_number(json, "pid", process_id());
    json_text(json, "time", time);
}

/* ---- header, device */

static void write_version(struct json *json, const char *key, uint32_t version)
{
    char words[64];
    struct text_buffer text;
    text_begin(&text, words, sizeof(words));
    text_say(&text, "{}.{}.{}", number(VK_API_VERSION_MAJOR(version)),
             number(VK_API_VERSION_MINOR(version)), number(VK_API_VERSION_PATCH(version)));
    json_text(json, key, words);
}

static void write_application(struct json *json, const VkApplicationInfo *application)
{
    char executable[LOG_PATH_SIZE];
    process_executable(executable, sizeof(executable));
    json_begin_object(json, "Application");
    if (application && application->pApplicationName)
        json_text(json, "Name", application->pApplicationName);
    if (application && application->pEngineName)
        json_text(json, "Engine", application->pEngineName);
    json_text(json, "Executable", executable);
    write_version(json, "ApiVersion",
                  application && application->apiVersion ? application->apiVersion
                                                         : VK_API_VERSION_1_0);
    json_end_object(json);
}

static void write_setting(void *context, const char *key, const char *value)
{
    json_text(context, key, value);
}

bool line_of_header(struct json *json, const VkApplicationInfo *application,
                    const struct settings *settings)
{
    line_begin(json, "Header");
    json_number(json, "version", RECORD_VERSION);
    json_text(json, "Layer", "VK_LAYER_ASSAY_validation");
    json_text(json, "LayerVersion", ASSAY_VERSION);
    json_text(json, "RegistryVersion", registry_version);
    write_application(json, application);
    json_begin_object(json, "Settings");
    settings_each(settings, write_setting, json);
    json_end_object(json);
    return json_end(json);
}

bool line_of_device(struct json *json, VkDevice device, const char *name,
                    const VkPhysicalDeviceDriverProperties *driver)
{
    line_begin(json, "Device");
    json_hex(json, "device", handle_number(device));
    json_text(json, "DeviceName", name);
    json_text_of_size(json, "Driver", driver->driverName, sizeof(driver->driverName));
    json_text_of_size(json, "DriverInfo", driver->driverInfo, sizeof(driver->driverInfo));
    return json_end(json);
}

/* ---- findings */

static const char *severity_name(enum report_flag severity)
{
    switch (severity) {
    case REPORT_ERROR:
        return "Error";
    case REPORT_WARNING:
    case REPORT_PERFORMANCE:
        return "Warning";
    case REPORT_INFO:
        break;
    }
    return "Info";
}

static void write_objects(struct json *json, const char *key, const struct message *message)
{
    json_begin_array(json, key);
    for (uint32_t i = 0; i < message->named.count; i++) {
        const VkDebugUtilsObjectNameInfoEXT *object = &message->named.objects[i];
        const char *type = object_type_name(object->objectType);
        json_begin_object(json, NULL);
        json_text(json, "type", type ? type : "object");
        json_hex(json, "handle", object->objectHandle);
        if (object->pObjectName)
            json_text(json, "name", object->pObjectName);
        json_end_object(json);
    }
    json_end_array(json);
}

/* Returns how much of a label's name is shown. */
static size_t label_length(const char *name)
{
    const size_t length = strnlen(name, NAME_SHOWN);
    return length < NAME_SHOWN ? length : text_cut_length(name, NAME_SHOWN);
}

static void append_labels(struct text_buffer *region, const VkDebugUtilsLabelEXT *labels,
                          uint32_t count)
{
    for (uint32_t i = count; i-- > 0;) {
        text_append(region, region->length ? "::" : "");
        text_append_part(region, labels[i].pLabelName, label_length(labels[i].pLabelName));
    }
}

static void write_region(struct json *json, const char *key, const struct message *message)
{
    char text[REGION_SIZE];
    struct text_buffer region;
    text_begin(&region, text, sizeof(text));
    append_labels(&region, message->queue_labels, message->queue_label_count);
    append_labels(&region, message->labels, message->label_count);
    json_text(json, key, text);
}

void line_add_region(struct json *json, const char *key, const struct label_stack *of_queue,
                     const struct label_stack *of_commands)
{
    char text[REGION_SIZE];
    struct text_buffer region;
    text_begin(&region, text, sizeof(text));
    if (of_queue)
        append_labels(&region, of_queue->labels, of_queue->count);
    if (of_commands)
        append_labels(&region, of_commands->labels, of_commands->count);
    if (region.length)
        json_text(json, key, text);
}

static void write_location(struct json *json, const char *key, const struct message *message)
{
    json_text_of_size(json, key, message->main, message->path_length);
}

static void write_main(struct json *json, const char *key, const struct message *message)
{
    json_text_of_size(json, key, message->main, message->main_length);
}

static void write_formerly(struct json *json, const char *key, const struct message *message)
{
    const char *retired;
    json_begin_array(json, key);
    for (unsigned n = 0; (retired = vuid_retired(message->vuid, n)); n++)
        if (strcmp(retired, message->id) != 0)
            json_text(json, NULL, retired);
    json_end_array(json);
}

static void write_also(struct json *json, const char *key, const struct message *message)
{
    json_begin_array(json, key);
    for (uint32_t i = 0; i < message->also_count; i++)
        json_text(json, NULL, message->also[i]);
    json_end_array(json);
}

static void write_call_site(struct json *json, const char *key, const struct message *message)
{
    const struct call_site *site = message->origin->call_site;
    json_begin_array(json, key);
    for (uint32_t i = 0; i < site->count; i++) {
        json_begin_object(json, NULL);
        json_text(json, "module", call_frame_module(&site->frames[i]));
        json_hex(json, "offset", site->frames[i].offset);
        json_end_object(json);
    }
    json_end_array(json);
}

static void write_value(struct json *json, const char *key, struct value value)
{
    if (!key)
        return;
    if (value.kind == VALUE_TEXT)
        json_text(json, key, value.text);
    else if (value.kind == VALUE_NUMBER)
        json_number(json, key, value.number);
    else
        json_hex(json, key, value.number);
}

/* Records of builds, too, have these properties. `build`: see properties.def. */
static void write_place(struct json *json, const struct call_origin *origin, int64_t build)
{
#define PLACE(key, type, is_known, value, says, aside, range, about)                               \
    if (is_known)                                                                                  \
        write_value(json, key, value);
#include "src/report/properties.def"
}

bool line_of_message(struct json *json, const struct message *message,
                     enum spec_text_setting spec_text)
{
    const struct call_origin *origin = message->origin;
    const struct vuid_text *vuid = &vuid_texts[message->vuid];
    char sentence[SPEC_SIZE], url[SPEC_SIZE];
    struct text_buffer words;
    text_begin(&words, sentence, sizeof(sentence));
    specification_append_sentence(&words, vuid, spec_text);
    text_begin(&words, url, sizeof(url));
    specification_append_url(&words, vuid);
    line_begin(json, "Finding");
#define PROPERTY(key, type, is_known, value, about)                                                \
    if (is_known)                                                                                  \
        write_value(json, key, value);
#define WRITTEN(key, type, is_known, write, about)                                                 \
    if (is_known)                                                                                  \
        write_##write(json, key, message);
#include "src/report/properties.def"
    if (origin)
        write_place(json, origin, message_build(message));
    return json_end(json);
}

/* ---- summary */

bool line_of_summary(struct json *json, const struct settings *settings,
                     const struct duplicates *duplicates, struct unchecked_counts *unchecked)
{
    line_begin(json, "Summary");
    json_begin_object(json, "Findings");
    for (uint32_t id = 0; id < REPORTED_IDS; id++) {
        uint64_t found = atomic_load(&duplicates->ids[id].found);
        if (found)
            json_number(json, reported_id_name(id), found);
    }
    json_end_object(json);
    json_begin_object(json, "HeldBack");
    for (uint32_t id = 0; id < REPORTED_IDS; id++) {
        uint64_t held = atomic_load(&duplicates->ids[id].held);
        if (held)
            json_number(json, reported_id_name(id), held);
    }
    json_end_object(json);
    json_begin_array(json, "Unchecked");
    for (unsigned n = 0; n < SUMMARY_REASONS; n++) {
        char reason[REASON_SIZE];
        struct text_buffer text;
        text_begin(&text, reason, sizeof(reason));
        summary_append_reason(&text, n, settings, unchecked);
        if (text.length)
            json_text(json, NULL, reason);
    }
    json_end_array(json);
    return json_end(json);
}

/* ---- composes the lines of record_builds = true */

const char *record_type_name(VkAccelerationStructureTypeKHR type)
{
    switch ((int)type) {
    case VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR:
        return "top level";
    case VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR:
        return "bottom level";
    case VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR:
        return "generic";
    case VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR:
        return "micromap";
    }
    return "unknown";
}

/* More do not fit into a line for certain. */
enum { COMMAND_BUFFERS_SHOWN = 4096 };

static void write_name(struct json *json, const char *key, const struct log_record *record,
                       VkObjectType type, uint64_t handle)
{
    char name[MESSAGE_NAME_SIZE];
    if (record->names && object_names_get(record->names, type, handle, name, sizeof(name)))
        json_text(json, key, name);
}

static void write_object(struct json *json, const char *key, const char *name_key,
                         const struct log_record *record, VkObjectType type, uint64_t handle)
{
    if (!handle)
        return;
    json_hex(json, key, handle);
    write_name(json, name_key, record, type, handle);
}

static void write_command_buffers(struct json *json, const struct log_record *record)
{
    json_begin_array(json, "command_buffers");
    for (uint32_t i = 0; i < record->command_count && i < COMMAND_BUFFERS_SHOWN; i++)
        json_hex(json, NULL, handle_number(record->commands[i].handle));
    json_end_array(json);
}

static void write_structure(struct json *json, const struct log_record *record)
{
    write_object(json, "dst", "dst_name", record, record->object_type, record->dst);
    write_object(json, "src", "src_name", record, record->object_type, record->src);
}

static void write_command(struct json *json, const struct log_record *record)
{
    write_object(json, "command_buffer", "command_buffer_name", record,
                 VK_OBJECT_TYPE_COMMAND_BUFFER, handle_number(record->command_buffer));
    if (record->has_position)
        json_number(json, "build", record->position);
    json_text(json, "mode", record->mode);
    json_text(json, "type", record->type);
    write_structure(json, record);
    if (record->has_geometries) {
        json_number(json, "geometries", record->geometries);
        json_hex(json, "flags", record->flags);
    }
    if (record->has_primitives)
        json_number(json, "primitives", record->primitives);
    if (record->size)
        json_number(json, "size", record->size);
    if (record->scratch_size)
        json_number(json, "scratch_size", record->scratch_size);
    if (record->memory) {
        json_hex(json, "memory", handle_number(record->memory));
        json_number(json, "memory_offset", record->memory_offset);
    }
}

static void write_instances(struct json *json, const struct log_record *record)
{
    write_object(json, "command_buffer", "command_buffer_name", record,
                 VK_OBJECT_TYPE_COMMAND_BUFFER, handle_number(record->command_buffer));
    json_number(json, "build", record->position);
    write_structure(json, record);
    json_number(json, "structure_count", record->reference_total);
    json_begin_array(json, "structures");
    for (uint32_t i = 0; i < record->reference_count; i++) {
        json_begin_object(json, NULL);
        write_object(json, "handle", "name", record, record->object_type,
                     record->references[i].structure);
        json_number(json, "instances", record->references[i].instances);
        json_end_object(json);
    }
    json_end_array(json);
}

bool line_of_record(struct json *json, const struct log_record *record)
{
    static const char *const types[] = {
        [RECORD_SUBMISSION] = "Submission",
        [RECORD_BUILD] = "Build",
        [RECORD_COPY] = "Copy",
        [RECORD_SIZE] = "CompactedSize",
        [RECORD_DESTROYED] = "Destroyed",
        [RECORD_INSTANCES] = "Instances",
        [RECORD_QUERY] = "Query",
        [RECORD_EXPECTATION] = "Expectation",
    };
    line_begin(json, types[record->kind]);
    write_place(json,
                &(struct call_origin){.device = record->device, .submission = record->submission},
                -1);
    switch (record->kind) {
    case RECORD_SUBMISSION:
        write_command_buffers(json, record);
        break;
    case RECORD_BUILD:
    case RECORD_COPY:
        write_command(json, record);
        break;
    case RECORD_SIZE:
        write_structure(json, record);
        json_number(json, "compacted_size", record->compacted_size);
        break;
    case RECORD_DESTROYED:
    case RECORD_QUERY:
        write_structure(json, record);
        break;
    case RECORD_INSTANCES:
        write_instances(json, record);
        break;
    case RECORD_EXPECTATION:
        json_text_of_size(json, "label", record->label, label_length(record->label));
        break;
    }
    if (record->write_more)
        record->write_more(json, record);
    return json_end(json);
}
