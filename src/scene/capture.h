/* SPDX-License-Identifier: Apache-2.0 */
/* A capture in memory: the folder that setting `capture` writes (docs/capture.md). The lines of
 * builds.jsonl become arrays of structures; arrays of input data are read when they are asked for.
 * A program of one thread uses this; without memory it ends with status 2. */
#ifndef ASSAY_SCENE_CAPTURE_H
#define ASSAY_SCENE_CAPTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/base/handle_table.h"

/* An index with this value names no element. */
#define CAPTURE_NONE UINT32_MAX

enum { CAPTURE_ERROR_SIZE = 1024, CAPTURE_HASH_SIZE = 33 };

/* What is wrong, mostly as FILE:LINE: WHAT. Text of the capture in it is not escaped. */
struct capture_error {
    char text[CAPTURE_ERROR_SIZE];
};

/* The value 0 of these stands for what this version does not know. */
enum capture_structure_type {
    CAPTURE_UNKNOWN_LEVEL,
    CAPTURE_TOP,
    CAPTURE_BOTTOM,
    CAPTURE_GENERIC,
    CAPTURE_MICROMAP,
    CAPTURE_STRUCTURE_TYPES,
};
enum capture_geometry_type {
    CAPTURE_OTHER_GEOMETRY,
    CAPTURE_TRIANGLES,
    CAPTURE_AABBS,
    CAPTURE_INSTANCES,
    CAPTURE_SPHERES,
    CAPTURE_SWEPT_SPHERES,
    CAPTURE_DENSE_TRIANGLES,
    CAPTURE_MICROMAP_GEOMETRY,
    CAPTURE_GEOMETRY_TYPES,
};
enum capture_role {
    CAPTURE_OTHER_ROLE,
    CAPTURE_VERTICES,
    CAPTURE_INDICES,
    CAPTURE_TRANSFORM,
    CAPTURE_BOXES,
    CAPTURE_INSTANCE_ROWS,
    CAPTURE_MOTION_VERTICES,
    CAPTURE_OPACITY_INDICES,
    CAPTURE_DISPLACEMENTS,
};
enum capture_mode {
    CAPTURE_OTHER_MODE,
    CAPTURE_BUILD,
    CAPTURE_UPDATE,
    CAPTURE_CLONE,
    CAPTURE_COMPACT,
    CAPTURE_DESERIALIZE,
};
enum capture_kind {
    CAPTURE_OTHER_LINE,
    CAPTURE_HEADER,
    CAPTURE_DEVICE,
    CAPTURE_MEMORY,
    CAPTURE_BUFFER,
    CAPTURE_STRUCTURE,
    CAPTURE_COMMAND_BUILD,
    CAPTURE_COMMAND_COPY,
    CAPTURE_COMMAND_QUERY,
    CAPTURE_COMPACTED_SIZE,
    CAPTURE_DESTROYED,
    CAPTURE_END,
};

/* The names of a type and of a mode in a capture; static text. */
const char *capture_structure_type_name(enum capture_structure_type type);
const char *capture_mode_name(enum capture_mode mode);

/* A line of builds.jsonl. */
struct captured_line {
    enum capture_kind kind;
    uint32_t index; /* in the array of its kind: devices, ..., commands */
    const char *text;
    size_t length;
    bool is_left_out; /* capture_write() leaves it out */
    bool is_changed;  /* capture_write() makes it of its structure, not of `text` */
};

struct captured_device {
    uint64_t device; /* handle */
    const char *name, *driver, *driver_info;
    uint32_t scratch_alignment, max_geometries, max_instances, max_primitives; /* 0: unknown */
};

struct captured_memory {
    uint64_t id, size;
};

/* `memory`, `buffer`, `structure` and `dst` here and below are indices. */
struct captured_buffer {
    uint64_t id;
    const char *name; /* debug names and other texts are NULL if there is none */
    uint32_t memory;
    uint64_t memory_offset, size, usage;
};

struct captured_structure {
    uint64_t id, handle;
    const char *name;
    enum capture_structure_type type;
    uint32_t buffer;
    uint64_t offset, size;
    const char *missing; /* why what was built into it before is not in the capture */
};

/* The elements of an array of a geometry, packed. */
enum capture_element {
    CAPTURE_F2,
    CAPTURE_F4,
    CAPTURE_F8,
    CAPTURE_I1,
    CAPTURE_I2,
    CAPTURE_I4,
    CAPTURE_U1,
    CAPTURE_U2,
    CAPTURE_U4,
    CAPTURE_INSTANCE, /* VkAccelerationStructureInstanceKHR */
};
struct captured_data {
    char hash[CAPTURE_HASH_SIZE];
    enum capture_element element;
    uint32_t columns;  /* elements of a row */
    uint32_t row_size; /* bytes */
    uint64_t rows;
    size_t header_size, size; /* bytes of the file */
    uint8_t *file;            /* its bytes, once they are read */
};

struct captured_input {
    enum capture_role role;
    uint64_t address;
    uint32_t buffer;
    uint64_t offset;                     /* of `address` in the buffer */
    uint64_t first, count, stride, size; /* `first`: bytes from `address` to the first element */
    uint32_t data;
    const char *missing; /* why data is missing */
};

struct captured_geometry {
    enum capture_geometry_type type;
    uint32_t flags;
    uint32_t primitive_count, primitive_offset, first_vertex, transform_offset; /* build range */
    const char *vertex_format;
    uint64_t vertex_stride, stride;
    uint32_t max_vertex;
    const char *index_type;
    bool array_of_pointers;
    bool is_left_out; /* a changed line lacks it */
    struct captured_input *inputs;
    uint32_t input_count;
};

struct captured_reference {
    uint64_t reference;
    uint32_t structure;
    bool is_dead;
    bool is_left_out; /* a changed line lacks it */
};

/* A build, copy, query or destruction, or a compacted size that the application has read. */
struct captured_command {
    enum capture_kind kind;
    uint32_t line; /* in `lines` */
    uint64_t n;
    uint64_t device, queue, command_buffer; /* handles; 0: the host has executed it */
    uint64_t submission, frame, build, call, info;
    uint64_t
        kept; /* 1: it ran before the capture began, and before commands that precede it here */
    const char *region, *command_buffer_name, *command, *query, *missing;
    enum capture_mode mode;
    enum capture_structure_type type;
    uint32_t flags;
    uint32_t dst, src;
    uint64_t compacted_size;
    uint64_t scratch_address, scratch_offset;
    uint64_t scratch_size; /* that the driver of the capture needed; 0: unknown, or none */
    uint32_t scratch_buffer;
    struct captured_geometry *geometries;
    struct captured_reference *references; /* sorted by `reference` */
    uint32_t geometry_count, reference_count;
};

struct captured_finding {
    const char *id, *message, *severity;
    uint32_t command;             /* the build that it is about; CAPTURE_NONE: unknown */
    uint32_t geometry, primitive; /* CAPTURE_NONE: it names none */
};

struct capture {
    const char *folder;
    const char *application, *executable, *layer_version, *time, *end;
    const char *note; /* a last line that was cut, and dropped; NULL: there is none */
    struct captured_line *lines;
    struct captured_device *devices;
    struct captured_memory *memories;
    struct captured_buffer *buffers;
    struct captured_structure *structures;
    struct captured_command *commands;
    struct captured_data *data;
    struct captured_finding *findings;
    uint32_t line_count, line_capacity, device_count, device_capacity, memory_count,
        memory_capacity, buffer_count, buffer_capacity, structure_count, structure_capacity,
        command_count, command_capacity, data_count, data_capacity, finding_count, finding_capacity;
    /* Private: indices + 1 by id or by the hash of a text, and texts by their hash. */
    struct handle_table memory_ids, buffer_ids, structure_ids, data_ids, texts;
    char *text, *finding_text;
};

/* Reads the folder. Returns false, with an error, if it cannot be read or is damaged; only a last
 * line that was cut is no error. The caller closes the capture in both cases. */
bool capture_open(struct capture *capture, const char *folder, struct capture_error *error);
void capture_close(struct capture *capture);

/* Returns the first row of an array, which is read from its file if it has not been, or NULL with
 * an error. capture_release_data() frees it again. */
const void *capture_load_data(struct capture *capture, uint32_t data, struct capture_error *error);
void capture_release_data(struct capture *capture, uint32_t data);
/* Adds an array, or finds it. `rows` has row_count * columns elements. */
uint32_t capture_add_data(struct capture *capture, enum capture_element element, uint32_t columns,
                          uint64_t row_count, const void *rows);

/* Returns the input of a role, or NULL. */
const struct captured_input *capture_input_of(const struct captured_geometry *geometry,
                                              enum capture_role role);
/* Returns what a reference of an instance of a build means, or NULL. */
const struct captured_reference *capture_reference_of(const struct captured_command *build,
                                                      uint64_t reference);

/* Sets `count` to the number of commands up to a point: "frame:N", "submission:N", "build:N" (the
 * number n of a command), or "label:TEXT". The last command there is counted. */
bool capture_find_point(const struct capture *capture, const char *point, uint32_t *count,
                        struct capture_error *error);

/* Writes a new folder with the lines that are not left out, and the arrays and findings.
 * Returns false, with an error, if the folder exists or cannot be written. */
bool capture_write(struct capture *capture, const char *folder, struct capture_error *error);

/* Like realloc(), but ends the program if memory runs out. */
void *capture_allocate(void *old, size_t count, size_t size);

#endif
