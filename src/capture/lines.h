/* SPDX-License-Identifier: Apache-2.0 */
/* The lines of a capture. docs/capture.md describes them, and json/capture.schema.json.
 *
 * A line that names a buffer, its memory or a structure follows the line that describes it. The
 * caller serializes access. */
#ifndef ASSAY_CAPTURE_LINES_H
#define ASSAY_CAPTURE_LINES_H

#include "src/capture/arrays.h"
#include "src/capture/folder.h"
#include "src/capture/kept.h"
#include "src/snapshots/recorded_build.h"
#include "src/state/commands/object_names.h"
#include "src/state/resources/resources.h"

struct capture_writer {
    struct capture_folder folder;
    struct capture_kept kept;    /* of before the capture */
    struct resources *resources; /* of the device */
    const struct object_names *names;
    struct handle_table buffers, memories, structures; /* that have lines, by id */
    struct capture_room room;
    struct json json, build; /* `build`: what capture_compose_build() composes */
    char *line;              /* memory for a build that json.line does not hold; owned, or NULL */
    size_t line_size;
};

/* `writer` is zero-initialized but for `resources` and `names`. Returns 0 or an error number, as
 * capture_folder_open() does. */
int capture_writer_open(struct capture_writer *writer, const char *path, uint64_t limit);
void capture_writer_close(struct capture_writer *writer);

/* ---- Each writes a line. Whether it was written, the folder says. */

struct capture_device {
    VkDevice handle;
    const VkPhysicalDeviceProperties *properties;
    const VkPhysicalDeviceDriverProperties *driver;
    const VkPhysicalDeviceAccelerationStructurePropertiesKHR *limits;
};
void capture_write_device(struct capture_writer *writer, const struct capture_device *device);
/* Describes a structure once. `missing`: why what was built into it is not in the capture; NULL: it
 * is, or nothing was. */
void capture_write_structure(struct capture_writer *writer, const struct accel_facts *structure,
                             const char *missing);
/* The last line, whatever the limit is. */
void capture_write_end(struct capture_writer *writer, const char *why);

/* ---- builds */

/* What a reference of instances refers to: a structure by its id and handle. */
struct capture_reference {
    uint64_t reference, structure;
    VkAccelerationStructureKHR handle;
};

struct capture_build {
    const struct recorded_build *build;
    const struct input_memory *memory;
    const struct capture_reference *references;
    uint32_t reference_count;
};

/* Writes the data of a build, and composes the members of its line that describe them: an object in
 * writer->build.text, and a newline. Returns false without memory. */
bool capture_compose_build(struct capture_writer *writer, const struct capture_build *build);

#endif
