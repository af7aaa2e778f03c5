/* SPDX-License-Identifier: Apache-2.0 */
/* The wording of messages, and all that a debug callback gets with them.
 *
 * A message is composed in place, without memory from elsewhere; text that does not fit is cut. */
#ifndef ASSAY_REPORT_MESSAGE_H
#define ASSAY_REPORT_MESSAGE_H

#include <stdio.h>
#include <vulkan/vulkan_core.h>

#include "src/report/origin.h"
#include "src/report/settings.h"
#include "src/view/finding.h"
#include "src/view/location.h"

enum {
    MESSAGE_SIZE = 8192,                  /* bytes of text, and of its heading */
    MESSAGE_NAME_SIZE = 256,              /* of an object's name, and of a label's */
    MESSAGE_OBJECTS = FINDING_VALUES + 2, /* and the command buffer (or device), and queue */
    MESSAGE_LABELS = 16,                  /* innermost ones */
};

struct message {
    enum report_flag severity;
    const char *id; /* the VUID, as vuid_names wants it */
    int32_t id_number;
    const char *heading; /* "Validation Error: ...", a line, then the text */
    const char *text;
    uint32_t object_count, label_count;
    VkDebugUtilsObjectNameInfoEXT objects[MESSAGE_OBJECTS]; /* each once */
    VkDebugUtilsLabelEXT labels[MESSAGE_LABELS];            /* innermost first */

    /* What the members above point to. */
    char buffer[MESSAGE_SIZE];
    char names[MESSAGE_OBJECTS][MESSAGE_NAME_SIZE];
};

/* `last_of`: if not 0, tells that so many messages of this id have gone out and no more will. */
void message_of_finding(struct message *message, enum vuid vuid, const struct location *location,
                        const struct call_origin *origin, const struct finding *finding,
                        enum vuid_names names, uint32_t last_of);

/* Of what compared rays found: a warning, which no sentence of the specification goes with. */
void message_of_difference(struct message *message, enum difference difference,
                           const struct location *location, const struct call_origin *origin,
                           const struct finding *finding, uint32_t last_of);

/* A message of the layer about itself, as no rule's finding. */
void message_of_layer(struct message *message, enum report_flag severity, const char *line);

/* Writes the message as the log shows it, in one piece among other threads' writes. */
void message_write(const struct message *message, FILE *file);

#endif
