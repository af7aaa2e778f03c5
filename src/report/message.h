/* SPDX-License-Identifier: Apache-2.0 */
/* Composes messages: the text, and the data that a debug callback gets with it.
 *
 * A message holds all of its text and allocates nothing; text that does not fit is cut. It refers
 * to its origin, whose label stack holds the names of labels. */
#ifndef ASSAY_REPORT_MESSAGE_H
#define ASSAY_REPORT_MESSAGE_H

#include <stdio.h>
#include <vulkan/vulkan_core.h>

#include "src/report/origin.h"
#include "src/report/settings.h"
#include "src/view/finding.h"
#include "src/view/location.h"

enum {
    MESSAGE_SIZE = 8192,                  /* bytes of heading and text together */
    MESSAGE_NAME_SIZE = 256,              /* bytes of an object's or a label's name */
    MESSAGE_OBJECTS = FINDING_VALUES + 2, /* the values', the command buffer (or device), a queue */
    MESSAGE_LABELS = 16,                  /* at most; the innermost */
};

struct message {
    enum report_flag severity;
    const char *id; /* the VUID, current or listed as vuid_names sets, or an id of the layer */
    int32_t id_number;
    const char *heading; /* the line "Validation Error: ...", followed by the text */
    const char *text;
    uint32_t object_count, label_count, queue_label_count;
    VkDebugUtilsObjectNameInfoEXT objects[MESSAGE_OBJECTS]; /* no duplicates */
    VkDebugUtilsLabelEXT labels[MESSAGE_LABELS];            /* innermost first */
    VkDebugUtilsLabelEXT queue_labels[MESSAGE_LABELS];      /* innermost first */

    /* Parts of the text, for lines of JSON. */
    const char *main; /* the path of the member, the sentence about it, and the hint */
    size_t main_length, path_length;
    enum vuid vuid;                   /* VUID_NONE: not about a rule */
    const struct call_origin *origin; /* NULL: of the layer about itself; then no location either */
    struct location location;
    uint32_t also_count;
    const char *also[FINDING_ALSO]; /* ids that the same mistake violates */

    /* Storage of the text and the names above. */
    char buffer[MESSAGE_SIZE];
    char names[MESSAGE_OBJECTS][MESSAGE_NAME_SIZE];
};

/* If the message is the last one that duplicate_message_limit allows, its text says so. */
enum last_message {
    LAST_OF_NOTHING,
    LAST_OF_OBJECT, /* of its id, for the object that it is about */
    LAST_OF_ID,     /* of its id, for any object */
};

struct message_style {
    enum vuid_names vuid_names;
    enum spec_text spec_text;
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

void message_of_finding(struct message *message, enum vuid vuid, const struct location *location,
                        const struct call_origin *origin, const struct finding *finding,
                        const struct message_style *style);

/* A warning about a difference of compared rays. It quotes no sentence of the specification. */
void message_of_difference(struct message *message, enum difference difference,
                           const struct location *location, const struct call_origin *origin,
                           const struct finding *finding, const struct message_style *style);

/* A message of the layer about itself, not about a rule. */
void message_of_layer(struct message *message, enum report_flag severity, const char *line);

/* The same with an id of its own, such as ASSAY-device-lost. */
void message_of_event(struct message *message, enum report_flag severity, const char *id,
                      const char *line);

/* Returns whether a filter for this id (see narrow_filters_have) matches the debug name of an
 * object of the message, or a label. */
bool message_is_muted(const struct message *message, const struct narrow_filter *filters,
                      uint32_t id);

/* Writes the message to the log. Holds the file's lock, so writes of other threads don't mix in. */
void message_write(const struct message *message, FILE *file);

#endif
