/* SPDX-License-Identifier: Apache-2.0 */
/* Words the paths of fields, and call sites. */
#include "src/report/message_path.h"

#include <inttypes.h>

#include "src/state/commands/call_sites.h"
#include "src/state/commands/object_names.h"
#include "src/state/resources/destroyed.h"

enum { MODULE_SHOWN = 512 };

void message_append_build(struct text_buffer *text, enum build_command command, uint32_t build)
{
    if (command == COMMAND_NV)
        text_append(text, "pInfo");
    else
        text_append(text, "pInfos[%" PRIu32 "]", build);
}

void message_append_field(struct text_buffer *text, const char *separator, const char *field)
{
    if (field[0])
        text_append(text, "%s%s", separator, field);
}

/* A range of the indirect command lies in device memory; only its count is a parameter, and has no
 * fields. */
static const char *ranges_name(enum build_command command, const char *field)
{
    if (command != COMMAND_INDIRECT)
        return "ppBuildRangeInfos";
    return field[0] ? "pIndirectDeviceAddresses" : "ppMaxPrimitiveCounts";
}

void message_append_path(struct text_buffer *text, const struct location *at, const char *field)
{
    const char *separator = at->command == COMMAND_NV ? "->" : ".";
    switch (at->subject) {
    case SUBJECT_CALL:
    case SUBJECT_PARAMETER:
        text_append(text, "%s", field);
        return;
    case SUBJECT_BUILD:
        message_append_build(text, at->command, at->build);
        message_append_field(text, separator, field);
        return;
    case SUBJECT_GEOMETRY:
        message_append_build(text, at->command, at->build);
        text_append(text, "%s%s[%" PRIu32 "]", separator,
                    at->geometry_by_pointer ? "ppGeometries" : "pGeometries", at->geometry);
        message_append_field(text, at->geometry_by_pointer ? "->" : ".", field);
        return;
    case SUBJECT_RANGE:
        text_append(text, "%s[%" PRIu32 "][%" PRIu32 "]", ranges_name(at->command, field),
                    at->build, at->geometry);
        message_append_field(text, ".", field);
        return;
    case SUBJECT_ELEMENT:
        text_append(text, "%s[%" PRIu32 "]", field, at->build);
        return;
    }
}

void message_append_destroyed(struct text_buffer *text, const struct value *value,
                              const struct call_origin *origin)
{
    struct destroyed_object object;
    if (value->kind != VALUE_ADDRESS || !origin->destroyed ||
        !destroyed_objects_find(origin->destroyed, value->object_type, value->number, &object))
        return;
    uint64_t submissions = origin->submissions ? origin->submissions
                                               : destroyed_objects_submissions(origin->destroyed);
    text_append(text, " %s 0x%" PRIx64, object_type_name(object.type), object.handle);
    if (object.name[0]) {
        text_append(text, "[");
        text_append_quoted(text, object.name, sizeof(object.name) - 1);
        text_append(text, "]");
    }
    text_append(text, " had this address and was destroyed ");
    if (submissions > object.submissions) {
        text_append_count(text, submissions - object.submissions, "submission");
        text_append(text, " ago.");
    } else {
        text_append(text, "since the last submission.");
    }
}

void message_append_call_site(struct text_buffer *text, const struct call_site *site, uint32_t most)
{
    for (uint32_t i = 0; i < site->count && i < most; i++) {
        text_append_plain(text, i ? ", " : " Called from ");
        text_append_escaped(text, call_frame_module(&site->frames[i]), MODULE_SHOWN);
        text_append_plain(text, "+");
        text_append_hex(text, site->frames[i].offset);
    }
    text_append_plain(text, ".");
}
