/* SPDX-License-Identifier: Apache-2.0 */
/* Messages: the text, and the data that a debug callback gets with it.
 *
 * A message holds all of its text and allocates nothing; text that does not fit is cut. It refers
 * to its origin, whose label stack holds the names of labels. */
#ifndef ASSAY_REPORT_MESSAGE_H
#define ASSAY_REPORT_MESSAGE_H

#include <stdint.h>
#include <stdio.h>
#include <vulkan/vulkan_core.h>

#include "src/base/text_buffer.h"
#include "src/report/ids/message_id.h"
#include "src/report/settings.h"
#include "src/report/words.h"
#include "src/state/commands/label_stack.h"
#include "src/view/finding.h"
#include "src/view/location.h"

struct call_site;
struct destroyed_objects;
struct object_names;
struct resources;

/* The objects that a message names in addition to the finding's. Members may be null or 0. */
struct call_origin {
    VkDevice device;
    VkCommandBuffer command_buffer;
    uint32_t build_index; /* builds recorded in the command buffer before this call */
    const struct object_names *names;
    const struct label_stack *labels;    /* of the command buffer */
    const struct call_site *call_site;   /* of the call that recorded the build, or made it */
    VkCommandBuffer executed_by;         /* if a list of builds names the primary one, too */
    struct submission_origin submission; /* if the finding arose from one */
    /* Number of references that the layer replaced by 0 because of the mistake (setting guard). */
    uint32_t replaced;
    /* When the data was read, if that was not after completion: static text such as "read after the
     * device was lost". */
    const char *when;
    /* The objects that were destroyed, for addresses; and the number of calls that had submitted
     * work when the build was submitted, or now. NULL: unknown. */
    struct destroyed_objects *destroyed;
    uint64_t submissions;
    struct resources *resources; /* for buffers in front of addresses; or NULL */
};

enum {
    MESSAGE_SIZE = 8192, /* bytes of heading and text together */
    MESSAGE_LABELS = 16, /* at most; the innermost */
};

struct message {
    enum report_flag severity;
    const char *id; /* the VUID, current or listed as vuid_names sets, or an id of the layer */
    int32_t id_number;
    const char *heading; /* the line "Validation Error: ...", followed by the text */
    const char *text;
    struct named_objects named;
    uint32_t label_count, queue_label_count;
    VkDebugUtilsLabelEXT labels[MESSAGE_LABELS];       /* innermost first */
    VkDebugUtilsLabelEXT queue_labels[MESSAGE_LABELS]; /* innermost first */

    /* Parts of the text, for lines of JSON. */
    const char *main; /* the path of the member, the sentence about it, and the hint */
    size_t main_length, path_length;
    enum vuid vuid; /* VUID_NONE: not about a rule */
    /* NULL: of the layer about itself; then the next three members are unset. */
    const struct call_origin *origin;
    const char *function; /* the command */
    enum level level;     /* that finds such mistakes */
    struct location location;
    uint32_t also_count;
    const char *also[FINDING_ALSO]; /* ids that the same mistake violates */

    char buffer[MESSAGE_SIZE]; /* storage of the text */
};

/* Returns the number of the build in its command buffer that the message is about; -1: none. */
int64_t message_build(const struct message *message);

/* If the message is the last one that duplicate_message_limit allows, its text says so. */
enum last_message {
    LAST_OF_NOTHING,
    LAST_OF_OBJECT, /* of its id, for the object that it is about */
    LAST_OF_ID,     /* of its id, for any object */
};

struct message_style {
    enum vuid_names_setting vuid_names;
    enum spec_text_setting spec_text;
    enum last_message last;
    uint32_t sent;    /* messages of the id, for the object or for any object as `last` says */
    uint32_t left;    /* at most this many messages of the id follow */
    bool are_counted; /* findings that are held back appear in the summary */
};

/* The object that a finding is about: the first object that its sentence names, or else the command
 * buffer, or else the device. */
struct message_subject {
    VkObjectType type;
    uint64_t handle;
};
struct message_subject message_subject_of(const struct call_origin *origin,
                                          const struct finding *finding);

/* Returns whether a filter for this id (see narrow_filters_have) matches the debug name of an
 * object of the message, or a label. */
bool message_is_muted(const struct message *message, const struct narrow_filter *filters,
                      uint32_t id);

/* Appends the message as it stands in the log, and its objects. */
enum { MESSAGE_LINES_SIZE = MESSAGE_SIZE + MESSAGE_OBJECTS * (4 * MESSAGE_NAME_SIZE + 96) };
void message_append_lines(const struct message *message, struct text_buffer *text);
/* Writes that to a file. Holds the file's lock, so writes of other threads don't mix in. */
void message_write(const struct message *message, FILE *file);
void message_write_to_debugger(const struct message *message);

/* ---- for the composers of messages */

/* Writes the heading. `text` continues behind it, with room for the last notice. */
void message_begin(struct message *message, struct text_buffer *text, enum report_flag severity,
                   const char *id);
/* Says which call the message is about, and mentions its objects and labels. `function` is the
 * command's name in static storage. */
void message_set_origin(struct message *message, const struct call_origin *origin,
                        const char *function, enum level level, const struct location *location);

/* Appends `what` and the labels of a stack, outermost first, like a path; nothing if there are
 * none, or `stack` is NULL. */
void message_append_labels(struct text_buffer *text, const char *what,
                           const struct label_stack *stack);
/* Appends the properties of a place, see PLACE and `build` in properties.def. */
void message_append_place(const struct words *words, const struct call_origin *origin,
                          int64_t build, bool is_aside);
/* Appends the sentences about where the call was recorded and submitted, and its call site. */
void message_append_origin(struct text_buffer *text, struct message *message);

/* Appends that this was the last message of its id, if the style says so. Uses reserved room, so
 * the notice is complete even if the text before it was cut. */
void message_append_last_notice(struct text_buffer *text, const char *what,
                                const struct message_subject *subject,
                                const struct message_style *style);

/* ---- paths of fields, such as pInfos[3].pGeometries[5].flags, and call sites */

void message_append_path(struct text_buffer *text, const struct location *at, const char *field);

/* Appends the first frames: /usr/bin/app+0x1139, /usr/lib/libengine.so+0x52f0. */
void message_append_call_frames(struct text_buffer *text, const struct call_site *site,
                                uint32_t most);
/* Appends a sentence: Called from /usr/bin/app+0x1139, /usr/lib/libengine.so+0x52f0. It has so many
 * frames at most. Signal handlers may call this. */
void message_append_call_site(struct text_buffer *text, const struct call_site *site,
                              uint32_t most);
/* If the value is an address, appends what is known of it: which destroyed object had it, and when
 * that was destroyed, or else behind the end of which buffer it lies. */
void message_append_about_address(struct text_buffer *text, struct message *message,
                                  const struct value *value);

#endif
