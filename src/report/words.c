/* SPDX-License-Identifier: Apache-2.0 */
/* Words values, and fills gaps. */
#include "src/report/words.h"

#include <string.h>

#include "src/state/commands/object_names.h"

enum {
    REAL_DIGITS = 9, /* tell any two floats apart */
    GAP_SIZE = 64    /* of a name */
};

/* ---- paths */

void words_append_build(struct text_buffer *text, enum build_command command, uint32_t build)
{
    if (command == COMMAND_NV)
        text_append(text, "pInfo");
    else if (command == COMMAND_GetAccelerationStructureBuildSizesKHR)
        text_append(text, "pBuildInfo");
    else if (command == COMMAND_CreateAccelerationStructureNV)
        text_append(text, "pCreateInfo->info");
    else
        text_say(text, "pInfos[{}]", number(build));
}

const char *words_separator(enum build_command command)
{
    return command == COMMAND_NV || command == COMMAND_GetAccelerationStructureBuildSizesKHR ? "->"
                                                                                             : ".";
}

void words_append_field(struct text_buffer *text, const char *separator, const char *field)
{
    if (field[0])
        text_append(text, separator);
    text_append(text, field);
}

/* ---- objects */

bool named_objects_add(struct named_objects *named, VkObjectType type, uint64_t handle,
                       const char *name)
{
    for (uint32_t i = 0; i < named->count; i++)
        if (named->objects[i].objectType == type && named->objects[i].objectHandle == handle &&
            strcmp(named->names[i], name) == 0)
            return true;
    if (named->count == MESSAGE_OBJECTS)
        return false;

    const uint32_t i = named->count++;
    struct text_buffer copy;
    text_begin(&copy, named->names[i], MESSAGE_NAME_SIZE);
    text_append(&copy, name);
    named->objects[i] = (VkDebugUtilsObjectNameInfoEXT){
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
        .objectType = type,
        .objectHandle = handle,
        .pObjectName = name[0] ? named->names[i] : NULL,
    };
    return true;
}

void words_append_object(const struct words *words, VkObjectType type, uint64_t handle,
                         const char *name)
{
    const char *type_name = object_type_name(type);
    if (words->named && !named_objects_add(words->named, type, handle, name))
        return;
    text_say(words->text, "{} {}", phrase(type_name ? type_name : "object"), hex(handle));
    if (name[0])
        text_say(words->text, "[{}]", quoted(name, MESSAGE_NAME_SIZE - 1));
}

static void append_object(const struct words *words, const struct value *value)
{
    char name[MESSAGE_NAME_SIZE] = "";
    if (!value->number) {
        text_append(words->text, "VK_NULL_HANDLE");
        return;
    }
    if (words->names && value->kind == VALUE_DESTROYED)
        object_names_get_past(words->names, value->object_type, value->number, value->id, name,
                              sizeof(name));
    else if (words->names && words->is_in_handler)
        object_names_try_get(words->names, value->object_type, value->number, name, sizeof(name));
    else if (words->names)
        object_names_get(words->names, value->object_type, value->number, name, sizeof(name));
    words_append_object(words, value->object_type, value->number, name);
}

/* Appends a recorded build such as: in VkCommandBuffer 0x12["frame"], build 3. */
static void append_built(const struct words *words, const struct value *built)
{
    char name[MESSAGE_NAME_SIZE] = "";
    if (!built->number) {
        text_say(words->text, "by {}, pInfos[{}]", phrase(build_command_name(COMMAND_HOST)),
                 number(built->build));
        return;
    }
    if (words->names)
        object_names_get_of(words->names, VK_OBJECT_TYPE_COMMAND_BUFFER, built->number, built->id,
                            name, sizeof(name));
    text_append(words->text, "in ");
    words_append_object(words, VK_OBJECT_TYPE_COMMAND_BUFFER, built->number, name);
    text_say(words->text, ", build {}", number(built->build));
}

/* ---- flags */

/* Names end in _BIT, most of them with the author's tag behind it, which says nothing here. Returns
 * the length up to there; 0: the bit has no name. */
static size_t name_length(const struct value *flags, uint64_t bit)
{
    const char *name = flags->name_of_bit(bit), *end = name ? strstr(name, "_BIT") : NULL;
    return end ? (size_t)(end - name) : 0;
}

/* Appends 0x5 (ALLOW_UPDATE | PREFER_FAST_TRACE); without the names if no bit has one. */
static void append_flags(struct text_buffer *text, const struct value *flags)
{
    const char *before = " (";
    bool has_names = false;
    text_append_hex(text, flags->number);
    for (uint64_t rest = flags->number; rest; rest &= rest - 1)
        has_names |= name_length(flags, rest & -rest) > 0;
    for (uint64_t rest = has_names ? flags->number : 0; rest; rest &= rest - 1) {
        const uint64_t bit = rest & -rest;
        const size_t length = name_length(flags, bit);
        text_append(text, before);
        if (length)
            text_append_part(text, flags->name_of_bit(bit), length);
        else
            text_append_hex(text, bit);
        before = " | ";
    }
    text_append(text, has_names ? ")" : "");
}

/* ---- values */

static void append_value(const struct words *words, const struct value *value)
{
    struct text_buffer *text = words->text;
    switch (value->kind) {
    case VALUE_ADDRESS:
    case VALUE_HEX:
        text_append_hex(text, value->number);
        return;
    case VALUE_FLAGS:
        append_flags(text, value);
        return;
    case VALUE_NUMBER:
        text_append_decimal(text, value->number);
        return;
    case VALUE_COUNT:
        text_append_count(text, value->number, value->text);
        return;
    case VALUE_REAL:
        text_append_real(text, value->real, REAL_DIGITS);
        return;
    case VALUE_TEXT:
        text_append(text, value->text ? value->text : "");
        return;
    case VALUE_QUOTED:
        text_append_quoted(text, value->text, value->number);
        return;
    case VALUE_FIELD:
        words_append_build(text, words->command, value->build);
        words_append_field(text, words_separator(words->command), value->text ? value->text : "");
        return;
    case VALUE_OBJECT:
    case VALUE_DESTROYED:
        append_object(words, value);
        return;
    case VALUE_BUILT:
        append_built(words, value);
        return;
    }
}

/* ---- gaps */

struct filling {
    const struct words *words;
    const struct value *values;
    uint32_t left; /* values that have no gap yet */
    words_gap *fill;
    const void *about;
};

static void fill_with_next(struct text_buffer *text, void *about, const char *name, size_t length)
{
    struct filling *filling = about;
    (void)name, (void)length;
    if (filling->left) {
        filling->left--;
        append_value(filling->words, filling->values++);
    } else {
        text_append(text, "{}");
    }
}

void words_append(const struct words *words, const char *says, const struct value *values,
                  uint32_t count)
{
    struct filling filling = {.words = words, .values = values, .left = count};
    text_append_template(words->text, says, fill_with_next, &filling);
}

static void fill_by_name(struct text_buffer *text, void *about, const char *name, size_t length)
{
    const struct filling *filling = about;
    char gap[GAP_SIZE] = "";
    (void)text;
    memcpy(gap, name, length < sizeof(gap) ? length : sizeof(gap) - 1);
    filling->fill(filling->words, filling->about, gap);
}

void words_fill(const struct words *words, const char *says, words_gap *fill, const void *about)
{
    struct filling filling = {.words = words, .fill = fill, .about = about};
    text_append_template(words->text, says, fill_by_name, &filling);
}
