/* SPDX-License-Identifier: Apache-2.0 */
/* The one engine that words messages: templates with gaps, and what stands in the gaps.
 *
 *     words_say(&words, "has {}, but {} needs {}",
 *               count_of(3, "byte"), object(type, handle), hex(8));
 *     words_fill(&words, " traces rays in {later.object}[[, {later.labels}]].",
 *                fill_gap, report);
 *
 * A part between [[ and ]] is left out if one of its gaps stays empty. Nothing here allocates or
 * prints; locks of names are the only ones that are taken, and none in a signal handler. */
#ifndef ASSAY_REPORT_WORDS_H
#define ASSAY_REPORT_WORDS_H

#include "src/base/text_buffer.h"
#include "src/view/finding.h"

struct object_names;

enum {
    MESSAGE_NAME_SIZE = 256,              /* bytes of an object's or a label's name */
    MESSAGE_OBJECTS = FINDING_VALUES + 2, /* the values', the command buffer (or device), a queue */
};

/* The objects that a message names, each once. */
struct named_objects {
    uint32_t count;
    VkDebugUtilsObjectNameInfoEXT objects[MESSAGE_OBJECTS];
    char names[MESSAGE_OBJECTS][MESSAGE_NAME_SIZE];
};
/* Adds an object with its debug name ("": none). Returns false if there is no room. */
bool named_objects_add(struct named_objects *named, VkObjectType type, uint64_t handle,
                       const char *name);

/* Where a sentence goes, and what its values need. All but `text` may be null or 0. */
struct words {
    struct text_buffer *text;
    struct named_objects *named;      /* gets the objects */
    const struct object_names *names; /* of the objects; NULL: they have none */
    enum build_command command;       /* of VALUE_FIELD */
    bool is_in_handler;               /* of a signal: names are left out while a thread uses them */
};

/* Each {} stands for the next value. */
void words_append(const struct words *words, const char *says, const struct value *values,
                  uint32_t count);
#define words_say(words, says, ...) words_append((words), (says), VALUES(__VA_ARGS__))
/* Words values that need nothing but the text. */
#define text_say(buffer, says, ...)                                                                \
    words_say((&(const struct words){.text = (buffer)}), says, __VA_ARGS__)

/* Appends what {gap} stands for, or nothing. */
typedef void words_gap(const struct words *words, const void *about, const char *gap);
void words_fill(const struct words *words, const char *says, words_gap *fill, const void *about);

/* Appends an object that has, or had, this debug name ("": none), such as VkBuffer
 * 0x12["vertices"]. Appends nothing if `named` has no room for it. */
void words_append_object(const struct words *words, VkObjectType type, uint64_t handle,
                         const char *name);

/* ---- paths of builds, such as pInfos[3].flags */

/* Appends the build's element of the call's parameters. */
void words_append_build(struct text_buffer *text, enum build_command command, uint32_t build);
/* Returns what stands between a build and its members: some commands take a pointer to a build. */
const char *words_separator(enum build_command command);
/* Appends nothing if the field is "", which stands for the structure itself. */
void words_append_field(struct text_buffer *text, const char *separator, const char *field);

#endif
