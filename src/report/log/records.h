/* SPDX-License-Identifier: Apache-2.0 */
/* What setting record_builds adds to the log: one record, and one line, for each submission, build
 * and copy when it executes, and for each compacted size that the application reads. */
#ifndef ASSAY_REPORT_LOG_RECORDS_H
#define ASSAY_REPORT_LOG_RECORDS_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/report/log/json.h"

struct object_names;
struct submitted_commands;

enum record_kind {
    RECORD_SUBMISSION, /* a batch of a submission */
    RECORD_BUILD,      /* a build or an update */
    RECORD_COPY,       /* a clone, a compacting copy, or a deserialization */
    RECORD_SIZE,       /* the application has read a compacted size */
};

/* Members that do not apply are null or 0. */
struct log_record {
    enum record_kind kind;
    VkDevice device;
    VkQueue queue; /* VK_NULL_HANDLE: the host */
    uint64_t submission;
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

    /* RECORD_BUILD. */
    bool has_position, has_geometries, has_primitives;
    uint32_t position; /* in the command buffer, or of a host build in pInfos */
    uint32_t geometries;
    uint64_t primitives;
};

/* Begins and ends a line. Returns false if the line is not complete. */
bool line_of_record(struct json *json, const struct log_record *record);

#endif
