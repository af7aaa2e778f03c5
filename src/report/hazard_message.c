/* SPDX-License-Identifier: Apache-2.0 */
/* A message has three sentences: what the two accesses are, why they are not ordered, and what
 * orders them (hazard_remedy.c). */
#include "src/report/hazard_message.h"

#include <inttypes.h>

#include "src/model/input_names.h"
#include "src/report/message.h"
#include "src/state/commands/object_names.h"

enum hazard_id hazard_id_of(const struct hazard *hazard)
{
    switch (hazard->type) {
    case READ_AFTER_WRITE:
        return hazard->is_racing ? HAZARD_ID_READ_RACING_WRITE : HAZARD_ID_READ_AFTER_WRITE;
    case WRITE_AFTER_READ:
        return hazard->is_racing ? HAZARD_ID_WRITE_RACING_READ : HAZARD_ID_WRITE_AFTER_READ;
    case EARLY_TRACE:
        return HAZARD_ID_EARLY_TRACE;
    case READ_AFTER_SHADER:
        return HAZARD_ID_LATE_SHADER;
    case READ_RACING_HOST:
        return HAZARD_ID_HOST_WRITE;
    case TRACE_OF_DESTROYED:
        return HAZARD_ID_TRACE_DESTROYED;
    case READ_OF_OVERWRITTEN:
        return HAZARD_ID_OVERWRITTEN;
    case TRACE_OF_UNBUILT:
        return HAZARD_ID_TRACE_UNBUILT;
    case WRITE_AFTER_WRITE:
        break;
    }
    return hazard->is_racing ? HAZARD_ID_WRITE_RACING_WRITE : HAZARD_ID_WRITE_AFTER_WRITE;
}

struct message_subject hazard_subject(const struct hazard_report *report)
{
    const struct hazard_access_text *later = &report->later;
    if (later->object)
        return (struct message_subject){later->type, later->object};
    return message_subject_of(&later->origin, &(struct finding){.says = ""});
}

/* ---- members */

/* The member of a geometry that has the address. */
static const char *geometry_member(enum hazard_role role)
{
    switch (role) {
    case HAZARD_VERTICES:
        return input_name(INPUT_VERTEX, INPUT_PLAIN);
    case HAZARD_INDICES:
        return input_name(INPUT_INDEX, INPUT_PLAIN);
    case HAZARD_TRANSFORM:
        return input_name(INPUT_MATRIX, INPUT_PLAIN);
    case HAZARD_BOXES:
        return input_name(INPUT_AABBS, INPUT_PLAIN);
    case HAZARD_INSTANCES:
    case HAZARD_INSTANCE_POINTERS:
        return input_name(INPUT_INSTANCES, INPUT_PLAIN);
    default:
        return NULL;
    }
}

static void append_build_member(struct text_buffer *text, const struct hazard_access_text *access)
{
    const char *member = geometry_member(access->role);
    if (access->role == HAZARD_RANGES) {
        text_append(text, "pIndirectDeviceAddresses[%" PRIu32 "]", access->info);
        return;
    }
    if (access->role == HAZARD_REFERENCE)
        text_append(text, "an instance of ");
    text_append(text, "pInfos[%" PRIu32 "]", access->info);
    if (access->role == HAZARD_DST || access->role == HAZARD_TOP_DST)
        text_append(text, ".dstAccelerationStructure");
    else if (access->role == HAZARD_SRC)
        text_append(text, ".srcAccelerationStructure");
    else if (access->role == HAZARD_SCRATCH)
        text_append(text, ".scratchData");
    else if (member)
        text_append(text, ".pGeometries[%" PRIu32 "].%s", access->geometry, member);
    else if (access->role == HAZARD_OTHER_INPUT || access->role == HAZARD_MICROMAP)
        text_append(text, ".pGeometries[%" PRIu32 "]", access->geometry);
}

static const char *plain_member(enum hazard_role role)
{
    switch (role) {
    case HAZARD_DST:
    case HAZARD_TOP_DST:
        return "dst";
    case HAZARD_SRC:
        return "src";
    case HAZARD_SCRATCH:
        return "scratchData";
    case HAZARD_MEMORY:
        return "deviceAddress";
    case HAZARD_SHADER:
    case HAZARD_TRACED:
    case HAZARD_USED:
        return "a shader";
    default:
        return "an input";
    }
}

static void append_member(struct text_buffer *text, const struct hazard_access_text *access)
{
    if (access->is_build)
        append_build_member(text, access);
    else
        text_append(text, "%s", plain_member(access->role));
}

/* ---- sentences */

static void append_object_of(struct text_buffer *text, struct message *message,
                             const struct hazard_access_text *access)
{
    if (!access->object)
        text_append(text, "memory");
    else if (access->object_is_destroyed)
        message_append_destroyed_object(text, message, access->type, access->object, 0,
                                        access->origin.names);
    else
        message_append_object(text, message, access->type, access->object, access->origin.names);
}

/* Reads and writes of the later access. Scratch is read, too. */
static const char *verb_of(const struct hazard_access_text *access)
{
    return access_is_write(access->kind) ? "writes" : "reads";
}

static const char *past_of(const struct hazard_access_text *access)
{
    return access_is_write(access->kind) ? "wrote" : "read";
}

/* Appends where the command was recorded, such as: in VkCommandBuffer 0x12, build 3. */
static void append_place(struct text_buffer *text, struct message *message,
                         const struct hazard_access_text *access)
{
    const struct call_origin *origin = &access->origin;
    if (!origin->command_buffer)
        return;
    text_append(text, " in ");
    message_append_object(text, message, VK_OBJECT_TYPE_COMMAND_BUFFER,
                          handle_number(origin->command_buffer), origin->names);
    if (access->is_build)
        text_append(text, ", build %" PRIu64, (uint64_t)origin->build_index + access->info);
    message_append_labels(text, "labels", origin->labels);
    if (origin->submission.queue) {
        text_append(text, ", submitted to ");
        message_append_object(text, message, VK_OBJECT_TYPE_QUEUE,
                              handle_number(origin->submission.queue), origin->names);
        if (origin->submission.number)
            text_append(text, ", submission %" PRIu64, origin->submission.number);
    }
}

static void append_bytes(struct text_buffer *text, const struct hazard_bytes *bytes)
{
    if (bytes->end - bytes->begin == 1)
        text_append(text, " (byte %" PRIu64 " of its memory).", bytes->begin);
    else
        text_append(text, " (bytes %" PRIu64 " to %" PRIu64 " of its memory).", bytes->begin,
                    bytes->end - 1);
}

static void append_trace(struct text_buffer *text, struct message *message,
                         const struct hazard_report *report)
{
    text_append(text,
                " traces rays, and no top-level structure that it may trace is visible to it. The "
                "last one of them that was built is ");
    append_object_of(text, message, &report->earlier);
    text_append(text, ": ");
    append_member(text, &report->earlier);
    text_append(text, " of %s", report->earlier.command);
    append_place(text, message, &report->earlier);
    text_append(text, "%s wrote it.", report->earlier.origin.command_buffer ? "," : "");
}

/* Appends what a build reads. */
static void append_read(struct text_buffer *text, struct message *message,
                        const struct hazard_report *report)
{
    text_append(text, " reads ");
    append_object_of(text, message, &report->later);
    append_bytes(text, &report->hazard.bytes);
}

static void append_shader(struct text_buffer *text, struct message *message,
                          const struct hazard_report *report)
{
    append_read(text, message, report);
    text_append(text,
                " The data have changed since the last build that read them. No other command "
                "can have written them, so a shader did. The last command with shaders "
                "before this one is %s",
                report->earlier.command);
    append_place(text, message, &report->earlier);
    text_append(text, ".");
}

static void append_host_write(struct text_buffer *text, struct message *message,
                              const struct hazard_report *report)
{
    append_read(text, message, report);
    text_append(text,
                " The host has overwritten them since the build was submitted, and has not "
                "observed that the build is complete. Wait on the host until it is, for example "
                "for a fence, before the write, or give each frame in flight a buffer of its own.");
}

/* Appends an object that is destroyed, with the name that it had, or one without memory. */
static void append_lost(struct text_buffer *text, struct message *message,
                        const struct hazard_report *report)
{
    if (report->is_freed) {
        append_object_of(text, message, &report->earlier);
        return;
    }
    text_append(text, "%s 0x%" PRIx64, object_type_name(report->earlier.type),
                report->earlier.object);
    if (report->destroyed_name[0]) {
        text_append(text, "[");
        text_append_quoted(text, report->destroyed_name, MESSAGE_NAME_SIZE - 1);
        text_append(text, "]");
    }
}

/* What was lost is the top-level structure itself if `later` has no object. */
static void append_trace_of_destroyed(struct text_buffer *text, struct message *message,
                                      const struct hazard_report *report)
{
    const char *how = report->is_freed ? "Its memory was freed" : "That was destroyed";
    const char *remedy = report->later.object
                             ? "Build the top-level structure without it first, or keep it"
                             : "Update the descriptor set that still refers to it, or keep it";
    text_append(text, " traces rays in ");
    if (report->later.object) {
        append_object_of(text, message, &report->later);
        text_append(text, ", an instance of which refers to ");
    }
    append_lost(text, message, report);
    if (report->hazard.is_racing)
        text_append(text,
                    ". %s, and the application had not observed that this command is complete. "
                    "Wait on the host until it is, for example for a fence, before that.",
                    how);
    else
        text_append(text, ". %s before this command executed. %s.", how, remedy);
}

static void append_use_of_destroyed(struct text_buffer *text, struct message *message,
                                    const struct hazard_report *report)
{
    text_append(text, " statically uses a descriptor that holds ");
    append_lost(text, message, report);
    text_append(text,
                ". %s before this command executed. Write another structure to the "
                "descriptor set, or keep this one.",
                report->is_freed ? "Its memory was freed" : "That was destroyed");
}

static void append_trace_of_unbuilt(struct text_buffer *text, struct message *message,
                                    const struct hazard_report *report)
{
    text_append(text, " traces rays in ");
    append_object_of(text, message, &report->later);
    text_append(text,
                ". No command has built it, or copied to it, before this command executed. "
                "Build the structure first, or bind the one that is built.");
}

static void append_accesses(struct text_buffer *text, struct message *message,
                            const struct hazard_report *report)
{
    if (report->hazard.type == EARLY_TRACE) {
        append_trace(text, message, report);
        return;
    }
    if (report->hazard.type == READ_AFTER_SHADER) {
        append_shader(text, message, report);
        return;
    }
    text_append(text, " %s ", verb_of(&report->later));
    append_object_of(text, message, &report->later);
    append_bytes(text, &report->hazard.bytes);
    text_append(text, " Earlier, ");
    append_member(text, &report->earlier);
    text_append(text, " of %s", report->earlier.command);
    append_place(text, message, &report->earlier);
    text_append(text, "%s %s them", report->earlier.origin.command_buffer ? "," : "",
                past_of(&report->earlier));
    if (report->earlier.object && report->earlier.object != report->later.object) {
        text_append(text, " as part of ");
        append_object_of(text, message, &report->earlier);
    }
    text_append(text, ".");
}

/* A structure is read of which something has overwritten bytes. */
static void append_overwritten(struct text_buffer *text, struct message *message,
                               const struct hazard_report *report)
{
    if (report->is_own_write) {
        append_read(text, message, report);
        text_append(text, " The same build writes them as ");
        append_member(text, &report->earlier);
        text_append(text, ", which is ");
        append_object_of(text, message, &report->earlier);
        text_append(text, ". Give each structure memory of its own.");
        return;
    }
    append_accesses(text, message, report);
    text_append(text,
                " Nothing has built or copied the structure since. Give each structure "
                "memory of its own, or build it again before its use.");
}

static void append_more(struct text_buffer *text, uint32_t more)
{
    if (!more)
        return;
    text_append(text, " The same command has ");
    text_append_count(text, more, "more hazard");
    text_append(text, " of this kind.");
}

void message_of_hazard(struct message *message, const struct hazard_report *report,
                       const struct message_style *style)
{
    const struct hazard_access_text *later = &report->later;
    const struct message_subject subject = hazard_subject(report);
    const struct location at = {.subject = later->is_build ? SUBJECT_BUILD : SUBJECT_CALL,
                                .build = later->info};
    struct text_buffer text;
    const unsigned id = other_id_of_hazard(hazard_id_of(&report->hazard));
    message_begin(message, &text, other_id_is_error(id) ? REPORT_ERROR : REPORT_WARNING,
                  other_id_name(id));
    message_set_origin(message, &later->origin, later->command, LEVEL_EXECUTION, &at);
    text_append(&text, "%s(): ", later->command);
    size_t before = text.length;
    message->main = text.text + before;
    append_member(&text, later);
    message->path_length = text.length - before;
    if (report->hazard.type == READ_RACING_HOST) {
        append_host_write(&text, message, report);
        hazard_append_timeout(&text, report->timeout);
    } else if (report->hazard.type == TRACE_OF_UNBUILT) {
        append_trace_of_unbuilt(&text, message, report);
    } else if (report->hazard.type == TRACE_OF_DESTROYED && report->is_used) {
        append_use_of_destroyed(&text, message, report);
    } else if (report->hazard.type == TRACE_OF_DESTROYED) {
        append_trace_of_destroyed(&text, message, report);
    } else if (report->hazard.type == READ_OF_OVERWRITTEN) {
        append_overwritten(&text, message, report);
    } else {
        append_accesses(&text, message, report);
        hazard_append_remedy(&text, message, report);
    }
    append_more(&text, report->more);
    message->main_length = text.length - before;
    message_append_origin(&text, message);
    message_append_last_notice(&text, "hazard", &subject, style);
}
