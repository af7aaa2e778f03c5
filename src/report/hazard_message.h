/* SPDX-License-Identifier: Apache-2.0 */
/* Words hazards: accesses that no dependency orders. */
#ifndef ASSAY_REPORT_HAZARD_MESSAGE_H
#define ASSAY_REPORT_HAZARD_MESSAGE_H

#include "src/hazards/hazards.h"
#include "src/report/ids/message_id.h"
#include "src/report/message.h"
#include "src/state/commands/hazard_entries.h"

/* An access of a command, as messages name it. */
struct hazard_access_text {
    const char *command; /* such as vkCmdCopyBuffer */
    bool is_build;       /* a command that makes builds: `info` and `geometry` have a meaning */
    enum hazard_role role;
    enum access_kind kind;
    uint32_t info, geometry;
    VkObjectType type;
    uint64_t object;          /* the structure or buffer; 0: unknown */
    bool object_is_destroyed; /* then another one may have its handle */
    struct call_origin origin;
};

/* A barrier between the two commands that lacks a stage, or an access, on one side. */
struct hazard_barrier_text {
    bool is_there;
    bool lacks_src;   /* else its dst side lacks it */
    bool lacks_stage; /* and perhaps the access; else the access alone */
    VkCommandBuffer command_buffer;
    const struct call_site *call_site; /* NULL: unknown */
    /* The command before the barrier; NULL: the barrier is the command buffer's first command. If
     * it builds: the number of its builds, and the position of the first one. */
    const char *follows;
    uint32_t builds, first_build;
};

struct hazard_report {
    struct hazard hazard;
    struct hazard_access_text earlier, later;
    struct barrier_features features; /* of the device */
    /* TRACE_OF_DESTROYED: `earlier` has only the destroyed object, and this is the name it had; ""
     * if it had none. The trace is `later`; its object is the top-level structure, or 0 if that is
     * the destroyed one. */
    const char *destroyed_name;
    struct hazard_barrier_text barrier;
    /* A wait of the host between the two submissions returned VK_TIMEOUT, after so many ns; 0: none
     * is known. */
    uint64_t timeout;
    bool is_freed;     /* it is alive, and its memory was freed */
    bool is_used;      /* a descriptor is used statically; whether rays are traced is unknown */
    uint32_t more;     /* accesses of the same kind in this command that have such a hazard, too */
    bool is_own_write; /* READ_OF_OVERWRITTEN: both accesses are of one build */
    /* READ_AFTER_WRITE: the command also writes the bytes with this kind of access, and needs the
     * same barrier for that; ACCESS_KINDS: it does not. */
    enum access_kind write;
};

enum hazard_id hazard_id_of(const struct hazard *hazard);
/* The object that the message is about. */
struct message_subject hazard_subject(const struct hazard_report *report);

void message_of_hazard(struct message *message, const struct hazard_report *report,
                       const struct message_style *style);

#endif
