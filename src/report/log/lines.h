/* SPDX-License-Identifier: Apache-2.0 */
/* The lines of log_format = json; json/findings.schema.json describes them.
 *
 * The functions that return bool begin and end a line. They return false if the line is not
 * complete. */
#ifndef ASSAY_REPORT_LOG_LINES_H
#define ASSAY_REPORT_LOG_LINES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/report/log/json.h"
#include "src/report/message.h"
#include "src/report/settings.h"
#include "src/report/summary.h"

/* The version of json/findings.schema.json, which says what raises it. */
enum { RECORD_VERSION = 1 };

/* `application` may be NULL. */
bool line_of_header(struct json *json, const VkApplicationInfo *application,
                    const struct settings *settings);
/* `driver` may lack names. */
bool line_of_device(struct json *json, VkDevice device, const char *name,
                    const VkPhysicalDeviceDriverProperties *driver);
bool line_of_message(struct json *json, const struct message *message,
                     enum spec_text_setting spec_text);
bool line_of_summary(struct json *json, const struct settings *settings,
                     const struct duplicates *duplicates, struct unchecked_counts *unchecked);

/* ---- the name of the log file, with the words that stand for the process */

enum { LOG_PATH_SIZE = 4096 };

/* Writes `pattern` with the process id instead of %p, the executable's name without folder instead
 * of %e, and % instead of %%. Other uses of % stay as they are. Returns false if the result does
 * not fit. */
bool log_filename_expand(const char *pattern, char path[LOG_PATH_SIZE]);

/* ---- What setting record_builds adds to the log: one record, and one line, for each submission,
 * build and copy when it executes, for each compacted size that the application reads, and for each
 * structure that it destroys; at level content also for the instances of each build. Labels that
 * announce findings are records, too. */

/* What such labels begin with. */
#define EXPECTATION_PREFIX "assay:expect"

struct object_names;
struct submitted_commands;

enum record_kind {
    RECORD_SUBMISSION, /* a batch of a submission */
    RECORD_BUILD,      /* a build or an update */
    RECORD_COPY,       /* a clone, a compacting copy, or a deserialization */
    RECORD_SIZE,       /* the application has read a compacted size */
    RECORD_DESTROYED,  /* it destroys a structure */
    RECORD_INSTANCES,  /* what the instances of a build refer to, once they have been read */
    RECORD_QUERY,      /* a command queries a property of a structure; only in captures */
    /* Whatever record_builds is: a label that announces findings was opened. */
    RECORD_EXPECTATION,
};

/* A structure, and how many instances refer to it. */
struct log_reference {
    uint64_t structure;
    uint32_t instances;
};

/* What records call a type of structures. */
const char *record_type_name(VkAccelerationStructureTypeKHR type);

/* Members that do not apply are null or 0. */
struct log_record {
    enum record_kind kind;
    VkDevice device;
    struct submission_origin submission;
    const struct object_names *names;

    /* RECORD_SUBMISSION. */
    const struct submitted_commands *commands;
    uint32_t command_count;

    /* The others. */
    VkObjectType object_type; /* of `dst` and `src` */
    uint64_t dst, src;
    VkDeviceSize compacted_size;

    /* RECORD_BUILD and RECORD_COPY. */
    const char *mode, *type; /* as in json/findings.schema.json */
    VkCommandBuffer command_buffer;
    VkDeviceSize size; /* of the structure `dst`; 0: unknown */
    VkDeviceMemory memory;
    VkDeviceSize memory_offset;

    /* RECORD_INSTANCES: some of `reference_total` structures. */
    const struct log_reference *references;
    uint32_t reference_count, reference_total;

    /* RECORD_EXPECTATION. */
    const char *label;

    /* Writes members that only a capture has; NULL: there are none. */
    void (*write_more)(struct json *json, const struct log_record *record);

    /* RECORD_BUILD. */
    bool has_position, has_geometries, has_primitives;
    uint32_t position;   /* in the command buffer, or of a host build in pInfos */
    uint32_t geometries; /* and `flags`, if has_geometries */
    VkBuildAccelerationStructureFlagsKHR flags;
    uint64_t primitives;
    VkDeviceSize scratch_size; /* that the build needs; 0: unknown, or none */
};

/* Writes the names of open labels, outermost first, joined by ::; nothing if there are none. Either
 * may be NULL. */
void line_add_region(struct json *json, const char *key, const struct label_stack *of_queue,
                     const struct label_stack *of_commands);

/* Begins and ends a line. Returns false if the line is not complete. */
bool line_of_record(struct json *json, const struct log_record *record);

#endif
