/* SPDX-License-Identifier: Apache-2.0 */
/* Reads and writes captures. Tables say which members of which structure the keys of a line are,
 * for both directions. */
#include "src/scene/capture.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>
#include <vulkan/vulkan_core.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "src/base/array.h"
#include "src/platform/files.h"

enum { PATH_SIZE = 4096 };

void *capture_allocate(void *old, size_t count, size_t size)
{
    size_t bytes;
    void *memory =
        __builtin_mul_overflow(count, size, &bytes) ? NULL : realloc(old, bytes + !bytes);
    if (!memory) {
        fputs("assay-scene: out of memory\n", stderr);
        exit(2);
    }
    return memory;
}

static void *allocate_zeroed(size_t count, size_t size)
{
    return memset(capture_allocate(NULL, count, size), 0, count * size);
}

static void require_memory(bool has_memory)
{
    if (!has_memory)
        capture_allocate(NULL, SIZE_MAX, 2);
}

/* Appends a zeroed element to an array of the capture, and gives its address. */
#define APPEND(capture, items, item)                                                               \
    (require_memory(                                                                               \
         ARRAY_HAS_ROOM((capture)->items, (capture)->item##_count, (capture)->item##_capacity)),   \
     memset(&(capture)->items[(capture)->item##_count++], 0, sizeof(*(capture)->items)),           \
     &(capture)->items[(capture)->item##_count - 1])

/* Where the reading is. Once it has failed, all that follows is without effect. */
struct reader {
    struct capture *capture;
    struct capture_error *error;
    const char *file; /* in the folder */
    uint32_t line;    /* 0: the file is not one of lines */
    bool has_failed;
};

__attribute__((format(printf, 2, 3))) static bool fail(struct reader *reader, const char *says, ...)
{
    if (reader->has_failed)
        return false;
    reader->has_failed = true;
    char line[16] = "";
    if (reader->line)
        snprintf(line, sizeof(line), ":%" PRIu32, reader->line);
    int length = snprintf(reader->error->text, CAPTURE_ERROR_SIZE,
                          "%s/%s%s: ", reader->capture->folder, reader->file, line);
    va_list arguments;
    va_start(arguments, says);
    if (length > 0 && length < CAPTURE_ERROR_SIZE)
        vsnprintf(reader->error->text + length, (size_t)(CAPTURE_ERROR_SIZE - length), says,
                  arguments);
    va_end(arguments);
    return false;
}

static void path_in(const struct capture *capture, const char *file, char path[PATH_SIZE])
{
    snprintf(path, PATH_SIZE, "%s/%s", capture->folder, file);
}

/* Reads a file, and adds a 0 behind it. Returns NULL if it cannot be read. */
static char *read_file(struct reader *reader, size_t most, size_t *size, size_t *whole)
{
    char path[PATH_SIZE];
    path_in(reader->capture, reader->file, path);
    FILE *file = file_find_kind(path) == FILE_FOLDER ? NULL : file_open_to_read(path);
    long end = -1;
    if (file && fseek(file, 0, SEEK_END) == 0)
        end = ftell(file);
    if (end < 0 || fseek(file, 0, SEEK_SET) != 0) {
        fail(reader, "cannot be read: %s", strerror(errno ? errno : EISDIR));
        if (file)
            fclose(file);
        return NULL;
    }
    *whole = (size_t)end;
    *size = *whole < most ? *whole : most;
    char *bytes = capture_allocate(NULL, *size + 1, 1);
    *size = fread(bytes, 1, *size, file);
    bytes[*size] = '\0';
    fclose(file);
    return bytes;
}

/* Returns the capture's own copy of a text: one for all that are equal. */
static const char *keep_text(struct capture *capture, const char *text)
{
    const size_t length = strlen(text);
    uint64_t hash = XXH3_64bits(text, length);
    for (char *kept;; hash++) {
        hash += !hash; /* key 0 is in no table */
        if (!(kept = handle_table_find(&capture->texts, hash))) {
            kept = memcpy(capture_allocate(NULL, length + 1, 1), text, length + 1);
            require_memory(handle_table_set(&capture->texts, hash, kept));
            return kept;
        }
        if (strcmp(kept, text) == 0)
            return kept;
    }
}

static void set_index(struct handle_table *table, uint64_t key, uint32_t index)
{
    require_memory(handle_table_set(table, key, (void *)((uintptr_t)index + 1)));
}

static uint32_t index_of(const struct handle_table *table, uint64_t key)
{
    return (uint32_t)((uintptr_t)handle_table_find(table, key) - 1);
}

/* ---- arrays of input data */

static const struct {
    const char *name;
    uint32_t size;
} elements[] = {
    [CAPTURE_F2] = {"'<f2'", 2},
    [CAPTURE_F4] = {"'<f4'", 4},
    [CAPTURE_F8] = {"'<f8'", 8},
    [CAPTURE_I1] = {"'|i1'", 1},
    [CAPTURE_I2] = {"'<i2'", 2},
    [CAPTURE_I4] = {"'<i4'", 4},
    [CAPTURE_U1] = {"'|u1'", 1},
    [CAPTURE_U2] = {"'<u2'", 2},
    [CAPTURE_U4] = {"'<u4'", 4},
    [CAPTURE_INSTANCE] = {"[('transform','<f4',(3,4)),('customIndexAndMask','<u4'),"
                          "('offsetAndFlags','<u4'),('reference','<u8')]",
                          64},
};

enum { NPY_PREFIX = 10, NPY_HEADER_MOST = NPY_PREFIX + UINT16_MAX };

/* Finds the value of a key in a header without blanks. */
static const char *npy_value(const char *header, const char *key)
{
    const char *found = strstr(header, key);
    return found ? found + strlen(key) : "";
}

static bool read_shape(const char *shape, struct captured_data *data, uint64_t *values)
{
    uint64_t numbers[3] = {0, 1, 1};
    if (*shape++ != '(')
        return false;
    for (uint32_t i = 0; i < 3 && isdigit((unsigned char)*shape); i++) {
        char *end;
        errno = 0;
        numbers[i] = strtoull(shape, &end, 10);
        if (errno || (i > 0 && (numbers[i] == 0 || numbers[i] > UINT16_MAX)))
            return false;
        shape = end + (*end == ',');
    }
    data->rows = numbers[0];
    data->columns = (uint32_t)(numbers[1] * numbers[2]);
    return *shape == ')' && data->columns <= UINT16_MAX &&
           !__builtin_mul_overflow(data->rows, data->columns, values);
}

static bool read_npy_header(struct reader *reader, char *bytes, size_t size, size_t whole,
                            struct captured_data *data)
{
    if (size < NPY_PREFIX || memcmp(bytes, "\x93NUMPY\x01\x00", 8) != 0)
        return fail(reader, "is no array of NumPy's format 1.0");
    const size_t length = (uint8_t)bytes[8] | (size_t)(uint8_t)bytes[9] << 8;
    if (NPY_PREFIX + length > size)
        return fail(reader, "ends in its header");
    data->header_size = NPY_PREFIX + length;
    char *to = bytes, *const header = bytes;
    for (const char *from = bytes + NPY_PREFIX; from < bytes + data->header_size; from++)
        if (*from && !isspace((unsigned char)*from))
            *to++ = *from;
    *to = '\0';
    const char *type = npy_value(header, "'descr':");
    uint32_t element = 0, count = sizeof(elements) / sizeof(*elements);
    while (element < count &&
           strncmp(type, elements[element].name, strlen(elements[element].name)) != 0)
        element++;
    if (element == count)
        return fail(reader, "has a type that no capture has: %.60s", type);
    data->element = (enum capture_element)element;
    if (strncmp(npy_value(header, "'fortran_order':"), "False", 5) != 0)
        return fail(reader, "is not in C order");
    uint64_t values, bytes_needed;
    if (!read_shape(npy_value(header, "'shape':"), data, &values) ||
        __builtin_mul_overflow(values, elements[element].size, &bytes_needed))
        return fail(reader, "has no shape of a capture: %.60s", npy_value(header, "'shape':"));
    data->row_size = data->columns * elements[element].size;
    if (whole - data->header_size != bytes_needed)
        return fail(reader, "has %zu bytes of data, but its shape needs %" PRIu64,
                    whole - data->header_size, bytes_needed);
    data->size = whole;
    return true;
}

static void path_of_data(const struct captured_data *data, char path[64])
{
    snprintf(path, 64, "data/%s.npy", data->hash);
}

/* Returns the array of a hash, whose header is read at its first use; CAPTURE_NONE after a failure.
 */
static uint32_t find_data(struct reader *reader, const char *hash)
{
    struct capture *capture = reader->capture;
    if (strlen(hash) != CAPTURE_HASH_SIZE - 1 ||
        strspn(hash, "0123456789abcdef") != CAPTURE_HASH_SIZE - 1) {
        fail(reader, "data is not 32 hexadecimal digits: %.60s", hash);
        return CAPTURE_NONE;
    }
    uint64_t key = XXH3_64bits(hash, CAPTURE_HASH_SIZE);
    key += !key;
    const uint32_t known = index_of(&capture->data_ids, key);
    if (known != CAPTURE_NONE)
        return known;
    struct captured_data data = {.row_size = 0};
    memcpy(data.hash, hash, CAPTURE_HASH_SIZE);
    char path[64];
    path_of_data(&data, path);
    struct reader inner = {.capture = capture, .error = reader->error, .file = path};
    size_t size, whole;
    char *bytes = read_file(&inner, NPY_HEADER_MOST, &size, &whole);
    reader->has_failed |= !bytes || !read_npy_header(&inner, bytes, size, whole, &data);
    free(bytes);
    if (reader->has_failed)
        return CAPTURE_NONE;
    *APPEND(capture, data, data) = data;
    set_index(&capture->data_ids, key, capture->data_count - 1);
    return capture->data_count - 1;
}

const void *capture_load_data(struct capture *capture, uint32_t index, struct capture_error *error)
{
    struct captured_data *data = &capture->data[index];
    if (!data->file) {
        char path[64];
        path_of_data(data, path);
        struct reader reader = {.capture = capture, .error = error, .file = path};
        size_t size, whole;
        char *bytes = read_file(&reader, SIZE_MAX - 1, &size, &whole);
        if (bytes && size != data->size)
            fail(&reader, "has changed while it was read");
        if (reader.has_failed) {
            free(bytes);
            return NULL;
        }
        data->file = (uint8_t *)bytes;
    }
    return data->file + data->header_size;
}

void capture_release_data(struct capture *capture, uint32_t data)
{
    free(capture->data[data].file);
    capture->data[data].file = NULL;
}

uint32_t capture_add_data(struct capture *capture, enum capture_element element, uint32_t columns,
                          uint64_t rows, const void *from)
{
    struct captured_data data = {
        .element = element,
        .columns = columns,
        .row_size = columns * elements[element].size,
        .rows = rows,
    };
    char shape[64], header[512];
    if (element == CAPTURE_F4 && columns == 12)
        snprintf(shape, sizeof(shape), "(%" PRIu64 ", 3, 4)", rows);
    else
        snprintf(shape, sizeof(shape), columns > 1 ? "(%" PRIu64 ", %u)" : "(%" PRIu64 ",)", rows,
                 columns);
    int length =
        snprintf(header, sizeof(header), "%*s{'descr': %s, 'fortran_order': False, 'shape': %s, }",
                 NPY_PREFIX, "", elements[element].name, shape);
    data.header_size = ((size_t)length + 64) / 64 * 64;
    data.size = data.header_size + rows * data.row_size;
    data.file = capture_allocate(NULL, data.size, 1);
    memset(data.file, ' ', data.header_size);
    memcpy(data.file, header, (size_t)length);
    memcpy(data.file, "\x93NUMPY\x01\x00", 8);
    data.file[8] = (uint8_t)(data.header_size - NPY_PREFIX);
    data.file[9] = (uint8_t)((data.header_size - NPY_PREFIX) >> 8);
    data.file[data.header_size - 1] = '\n';
    memcpy(data.file + data.header_size, from, rows * data.row_size);
    const XXH128_hash_t hash = XXH3_128bits(data.file, data.size);
    snprintf(data.hash, sizeof(data.hash), "%016" PRIx64 "%016" PRIx64, hash.high64, hash.low64);
    uint64_t key = XXH3_64bits(data.hash, CAPTURE_HASH_SIZE);
    key += !key;
    const uint32_t known = index_of(&capture->data_ids, key);
    if (known != CAPTURE_NONE) {
        free(data.file);
        return known;
    }
    *APPEND(capture, data, data) = data;
    set_index(&capture->data_ids, key, capture->data_count - 1);
    return capture->data_count - 1;
}

/* ---- the members of lines */

enum field_kind {
    NUMBER,
    NUMBER32,
    HEX,
    HEX32,
    TEXT,
    FLAG,
    /* a name, as a number from 1; 0: another */
    LEVEL,
    GEOMETRY,
    ROLE,
    MODE,
    /* the index of what an id, or a hash, stands for */
    MEMORY,
    BUFFER,
    STRUCTURE,
    DATA,
    KINDS,
};

struct field {
    const char *key; /* "a.b" is b of the object a; NULL: behind the last */
    enum field_kind kind;
    bool is_required;
    size_t offset; /* of the member */
};

/* What the values of keys are: texts, if nothing else is said. */
static const char *const value_names[KINDS] = {
    [NUMBER] = "a number from 0 to 2^63 - 1",
    [NUMBER32] = "a number from 0 to 4294967295",
    [HEX] = "a text such as 0x1f",
    [HEX32] = "a text such as 0x1f of up to 32 bits",
    [FLAG] = "true or false",
    [MEMORY] = "the id of a memory that an earlier line introduces",
    [BUFFER] = "the id of a buffer that an earlier line introduces",
    [STRUCTURE] = "the id of a structure that an earlier line introduces",
};

enum { NAMES_MOST = 12 };
static const char *const names[KINDS][NAMES_MOST] = {
    [LEVEL] = {[CAPTURE_TOP] = "top level",
               [CAPTURE_BOTTOM] = "bottom level",
               [CAPTURE_GENERIC] = "generic",
               [CAPTURE_MICROMAP] = "micromap"},
    [GEOMETRY] = {[CAPTURE_TRIANGLES] = "triangles",
                  [CAPTURE_AABBS] = "aabbs",
                  [CAPTURE_INSTANCES] = "instances",
                  [CAPTURE_SPHERES] = "spheres",
                  [CAPTURE_SWEPT_SPHERES] = "linear swept spheres",
                  [CAPTURE_DENSE_TRIANGLES] = "dense triangles",
                  [CAPTURE_MICROMAP_GEOMETRY] = "micromap"},
    [ROLE] = {[CAPTURE_VERTICES] = "vertices",
              [CAPTURE_INDICES] = "indices",
              [CAPTURE_TRANSFORM] = "transform",
              [CAPTURE_BOXES] = "aabbs",
              [CAPTURE_INSTANCE_ROWS] = "instances",
              [CAPTURE_MOTION_VERTICES] = "motion vertices",
              [CAPTURE_OPACITY_INDICES] = "opacity indices",
              [CAPTURE_DISPLACEMENTS] = "displacement indices"},
    [MODE] = {[CAPTURE_BUILD] = "build",
              [CAPTURE_UPDATE] = "update",
              [CAPTURE_CLONE] = "clone",
              [CAPTURE_COMPACT] = "compact",
              [CAPTURE_DESERIALIZE] = "deserialize"},
};
static const char *const line_kinds[NAMES_MOST] = {
    [CAPTURE_HEADER] = "Capture",
    [CAPTURE_DEVICE] = "Device",
    [CAPTURE_MEMORY] = "Memory",
    [CAPTURE_BUFFER] = "Buffer",
    [CAPTURE_STRUCTURE] = "Structure",
    [CAPTURE_COMMAND_BUILD] = "Build",
    [CAPTURE_COMMAND_COPY] = "Copy",
    [CAPTURE_COMMAND_QUERY] = "Query",
    [CAPTURE_COMPACTED_SIZE] = "CompactedSize",
    [CAPTURE_DESTROYED] = "Destroyed",
    [CAPTURE_END] = "End",
};

/* Returns the number of a name; 0: it is another, or NULL. */
static uint32_t find_name(const char *const list[NAMES_MOST], const char *name)
{
    uint32_t found = NAMES_MOST;
    while (found-- > 1 && !(name && list[found] && strcmp(name, list[found]) == 0))
        ;
    return found;
}

const char *capture_structure_type_name(enum capture_structure_type type)
{
    return type ? names[LEVEL][type] : "unknown";
}

const char *capture_mode_name(enum capture_mode mode)
{
    return mode ? names[MODE][mode] : "unknown";
}

#define FIELD(record, key, kind, member)                                                           \
    {                                                                                              \
        key, kind, false, offsetof(struct captured_##record, member)                               \
    }
#define NEEDED(record, key, kind, member)                                                          \
    {                                                                                              \
        key, kind, true, offsetof(struct captured_##record, member)                                \
    }

static const struct field device_fields[] = {
    NEEDED(device, "device", HEX, device),
    FIELD(device, "DeviceName", TEXT, name),
    FIELD(device, "Driver", TEXT, driver),
    FIELD(device, "DriverInfo", TEXT, driver_info),
    FIELD(device, "limits.scratch_alignment", NUMBER32, scratch_alignment),
    FIELD(device, "limits.max_geometries", NUMBER32, max_geometries),
    FIELD(device, "limits.max_instances", NUMBER32, max_instances),
    FIELD(device, "limits.max_primitives", NUMBER32, max_primitives),
    {.key = NULL},
};
static const struct field memory_fields[] = {
    NEEDED(memory, "memory", NUMBER, id),
    FIELD(memory, "size", NUMBER, size),
    {.key = NULL},
};
static const struct field buffer_fields[] = {
    NEEDED(buffer, "buffer", NUMBER, id),
    FIELD(buffer, "name", TEXT, name),
    FIELD(buffer, "memory", MEMORY, memory),
    FIELD(buffer, "memory_offset", NUMBER, memory_offset),
    FIELD(buffer, "size", NUMBER, size),
    FIELD(buffer, "usage", HEX, usage),
    {.key = NULL},
};
static const struct field structure_fields[] = {
    NEEDED(structure, "structure", NUMBER, id),
    FIELD(structure, "handle", HEX, handle),
    FIELD(structure, "name", TEXT, name),
    FIELD(structure, "type", LEVEL, type),
    FIELD(structure, "buffer", BUFFER, buffer),
    FIELD(structure, "offset", NUMBER, offset),
    FIELD(structure, "size", NUMBER, size),
    FIELD(structure, "missing", TEXT, missing),
    {.key = NULL},
};
static const struct field command_fields[] = {
    NEEDED(command, "n", NUMBER, n),
    FIELD(command, "device", HEX, device),
    FIELD(command, "queue", HEX, queue),
    FIELD(command, "submission", NUMBER, submission),
    FIELD(command, "frame", NUMBER, frame),
    FIELD(command, "region", TEXT, region),
    FIELD(command, "command_buffer", HEX, command_buffer),
    FIELD(command, "command_buffer_name", TEXT, command_buffer_name),
    FIELD(command, "build", NUMBER, build),
    FIELD(command, "call", NUMBER, call),
    FIELD(command, "info", NUMBER, info),
    FIELD(command, "kept", NUMBER, kept),
    FIELD(command, "command", TEXT, command),
    FIELD(command, "mode", MODE, mode),
    FIELD(command, "type", LEVEL, type),
    FIELD(command, "dst_id", STRUCTURE, dst),
    FIELD(command, "src_id", STRUCTURE, src),
    FIELD(command, "query", TEXT, query),
    FIELD(command, "compacted_size", NUMBER, compacted_size),
    FIELD(command, "flags", HEX32, flags),
    FIELD(command, "missing", TEXT, missing),
    FIELD(command, "scratch.address", HEX, scratch_address),
    FIELD(command, "scratch.buffer", BUFFER, scratch_buffer),
    FIELD(command, "scratch.offset", NUMBER, scratch_offset),
    FIELD(command, "scratch_size", NUMBER, scratch_size),
    {.key = NULL},
};
static const struct field geometry_fields[] = {
    NEEDED(geometry, "type", GEOMETRY, type),
    FIELD(geometry, "flags", HEX32, flags),
    FIELD(geometry, "primitiveCount", NUMBER32, primitive_count),
    FIELD(geometry, "primitiveOffset", NUMBER32, primitive_offset),
    FIELD(geometry, "firstVertex", NUMBER32, first_vertex),
    FIELD(geometry, "transformOffset", NUMBER32, transform_offset),
    FIELD(geometry, "vertexFormat", TEXT, vertex_format),
    FIELD(geometry, "vertexStride", NUMBER, vertex_stride),
    FIELD(geometry, "maxVertex", NUMBER32, max_vertex),
    FIELD(geometry, "indexType", TEXT, index_type),
    FIELD(geometry, "stride", NUMBER, stride),
    FIELD(geometry, "arrayOfPointers", FLAG, array_of_pointers),
    {.key = NULL},
};
static const struct field input_fields[] = {
    NEEDED(input, "role", ROLE, role),
    FIELD(input, "address", HEX, address),
    FIELD(input, "buffer", BUFFER, buffer),
    FIELD(input, "offset", NUMBER, offset),
    FIELD(input, "first", NUMBER, first),
    FIELD(input, "count", NUMBER, count),
    FIELD(input, "stride", NUMBER, stride),
    FIELD(input, "size", NUMBER, size),
    FIELD(input, "data", DATA, data),
    FIELD(input, "missing", TEXT, missing),
    {.key = NULL},
};
static const struct field reference_fields[] = {
    NEEDED(reference, "reference", HEX, reference),
    FIELD(reference, "structure", STRUCTURE, structure),
    FIELD(reference, "is_dead", FLAG, is_dead),
    {.key = NULL},
};

/* The lines that become elements of arrays of the capture. */
#define RECORD(record_fields, array, item)                                                         \
    {                                                                                              \
        record_fields, sizeof(*((struct capture *)NULL)->array), offsetof(struct capture, array),  \
            offsetof(struct capture, item##_count), offsetof(struct capture, item##_capacity)      \
    }
static const struct record {
    const struct field *fields; /* NULL: it becomes none */
    size_t size, array, count, capacity;
} records[NAMES_MOST] = {
    [CAPTURE_DEVICE] = RECORD(device_fields, devices, device),
    [CAPTURE_MEMORY] = RECORD(memory_fields, memories, memory),
    [CAPTURE_BUFFER] = RECORD(buffer_fields, buffers, buffer),
    [CAPTURE_STRUCTURE] = RECORD(structure_fields, structures, structure),
    [CAPTURE_COMMAND_BUILD] = RECORD(command_fields, commands, command),
    [CAPTURE_COMMAND_COPY] = RECORD(command_fields, commands, command),
    [CAPTURE_COMMAND_QUERY] = RECORD(command_fields, commands, command),
    [CAPTURE_COMPACTED_SIZE] = RECORD(command_fields, commands, command),
    [CAPTURE_DESTROYED] = RECORD(command_fields, commands, command),
};

/* Returns the element of a line. */
static void *record_of(const struct capture *capture, const struct captured_line *line)
{
    const struct record *record = &records[line->kind];
    return *(char *const *)((const char *)capture + record->array) + line->index * record->size;
}

/* Returns the object that has the last part of a key, or NULL, and that part. */
static json_t *holder_of(json_t *object, const char **key)
{
    char outer[16];
    const char *dot = strchr(*key, '.');
    if (!dot)
        return object;
    snprintf(outer, sizeof(outer), "%.*s", (int)(dot - *key), *key);
    *key = dot + 1;
    return json_object_get(object, outer);
}

static struct handle_table *ids_of(struct capture *capture, enum field_kind kind)
{
    return kind == MEMORY   ? &capture->memory_ids
           : kind == BUFFER ? &capture->buffer_ids
                            : &capture->structure_ids;
}

static bool read_hex(const char *text, uint64_t *number)
{
    if (!text || strncmp(text, "0x", 2) != 0 || !text[2] || strlen(text) > 18 ||
        text[2 + strspn(text + 2, "0123456789abcdefABCDEF")])
        return false;
    *number = strtoull(text, NULL, 16);
    return true;
}

static bool read_value(struct reader *reader, const json_t *value, const struct field *field,
                       void *to)
{
    uint64_t number = json_is_integer(value) ? (uint64_t)json_integer_value(value) : 0;
    const char *text = json_string_value(value);
    char decimal[24];
    const bool is_number = json_is_integer(value) && json_integer_value(value) >= 0;
    switch (field->kind) {
    case NUMBER:
        *(uint64_t *)to = number;
        return is_number;
    case NUMBER32:
        *(uint32_t *)to = (uint32_t)number;
        return is_number && number <= UINT32_MAX;
    case HEX:
        return read_hex(text, (uint64_t *)to);
    case HEX32:
        *(uint32_t *)to = read_hex(text, &number) ? (uint32_t)number : 0;
        return read_hex(text, &number) && number <= UINT32_MAX;
    case TEXT:
        if (is_number) { /* a value of an enumeration that has no name */
            snprintf(decimal, sizeof(decimal), "%" PRIu64, number);
            text = decimal;
        }
        if (text)
            *(const char **)to = keep_text(reader->capture, text);
        return text;
    case FLAG:
        *(bool *)to = json_is_true(value) || number == 1;
        return json_is_boolean(value) || (is_number && number <= 1);
    case LEVEL:
    case GEOMETRY:
    case ROLE:
    case MODE:
        *(uint32_t *)to = find_name(names[field->kind], text);
        return text;
    case MEMORY:
    case BUFFER:
    case STRUCTURE:
        *(uint32_t *)to = index_of(ids_of(reader->capture, field->kind), number);
        return is_number && *(uint32_t *)to != CAPTURE_NONE;
    case DATA:
        if (text)
            *(uint32_t *)to = find_data(reader, text);
        return text;
    case KINDS:
        break;
    }
    return false;
}

/* Reads the members of an object that are in the table; those that are absent stay 0, or
 * CAPTURE_NONE. */
static void read_fields(struct reader *reader, json_t *object, const struct field *fields,
                        void *structure)
{
    if (!json_is_object(object))
        fail(reader, "has something else where an object with %s is expected", fields->key);
    for (const struct field *field = fields; field->key && !reader->has_failed; field++) {
        void *to = (char *)structure + field->offset;
        if (field->kind >= MEMORY)
            *(uint32_t *)to = CAPTURE_NONE;
        const char *key = field->key;
        json_t *holder = holder_of(object, &key);
        const json_t *value = json_object_get(holder, key);
        if (holder && !json_is_object(holder))
            fail(reader, "%s is of no object", field->key);
        else if (!value && field->is_required)
            fail(reader, "lacks %s", field->key);
        else if (value && !read_value(reader, value, field, to))
            fail(reader, "%s is not %s", field->key,
                 value_names[field->kind] ? value_names[field->kind] : "a text");
    }
}

/* Returns the array of that key and its length, which are NULL and 0 if it is absent. */
static const json_t *read_array(struct reader *reader, const json_t *object, const char *key,
                                uint32_t *count)
{
    const json_t *array = json_object_get(object, key);
    if (array && !json_is_array(array))
        fail(reader, "%s is not an array", key);
    *count = reader->has_failed ? 0 : (uint32_t)json_array_size(array);
    return array;
}

/* What the rows of an array of that role can be. */
static const struct {
    uint32_t elements; /* bits */
    uint32_t columns;
} rows_of_roles[NAMES_MOST] = {
    [CAPTURE_VERTICES] = {~(1u << CAPTURE_INSTANCE), 0},
    [CAPTURE_INDICES] = {1 << CAPTURE_U1 | 1 << CAPTURE_U2 | 1 << CAPTURE_U4, 1},
    [CAPTURE_TRANSFORM] = {1 << CAPTURE_F4, 12},
    [CAPTURE_BOXES] = {1 << CAPTURE_F4, 6},
    [CAPTURE_INSTANCE_ROWS] = {1 << CAPTURE_INSTANCE, 1},
};

static bool is_of_role(const struct captured_data *data, enum capture_role role)
{
    const uint32_t wanted = rows_of_roles[role].columns;
    if (role == CAPTURE_INSTANCE_ROWS && data->element == CAPTURE_U1)
        return data->columns == sizeof(VkAccelerationStructureMotionInstanceNV);
    return !rows_of_roles[role].elements || ((rows_of_roles[role].elements >> data->element & 1) &&
                                             (!wanted || data->columns == wanted));
}

static void read_input(struct reader *reader, json_t *object, struct captured_input *input)
{
    read_fields(reader, object, input_fields, input);
    if (reader->has_failed || input->data == CAPTURE_NONE)
        return;
    const struct captured_data *data = &reader->capture->data[input->data];
    if (!is_of_role(data, input->role))
        fail(reader, "data/%s.npy has no rows of %s", data->hash, names[ROLE][input->role]);
    else if (data->rows > input->count)
        fail(reader, "data/%s.npy has %" PRIu64 " rows, but count is %" PRIu64, data->hash,
             data->rows, input->count);
}

static int compare_references(const void *first, const void *second)
{
    const struct captured_reference *a = first, *b = second;
    return (a->reference > b->reference) - (a->reference < b->reference);
}

static void read_build(struct reader *reader, const json_t *object, struct captured_command *build)
{
    const json_t *array = read_array(reader, object, "geometry", &build->geometry_count);
    build->geometries = allocate_zeroed(build->geometry_count, sizeof(*build->geometries));
    for (uint32_t i = 0; i < build->geometry_count; i++) {
        struct captured_geometry *geometry = &build->geometries[i];
        json_t *value = json_array_get(array, i);
        read_fields(reader, value, geometry_fields, geometry);
        const json_t *inputs = read_array(reader, value, "inputs", &geometry->input_count);
        geometry->inputs = allocate_zeroed(geometry->input_count, sizeof(*geometry->inputs));
        for (uint32_t j = 0; j < geometry->input_count; j++)
            read_input(reader, json_array_get(inputs, j), &geometry->inputs[j]);
    }
    array = read_array(reader, object, "references", &build->reference_count);
    build->references = allocate_zeroed(build->reference_count, sizeof(*build->references));
    for (uint32_t i = 0; i < build->reference_count; i++)
        read_fields(reader, json_array_get(array, i), reference_fields, &build->references[i]);
    qsort(build->references, build->reference_count, sizeof(*build->references),
          compare_references);
}

static void read_command(struct reader *reader, const json_t *object, struct captured_line *line,
                         struct captured_command *command)
{
    command->kind = line->kind;
    command->line = reader->capture->line_count - 1;
    if (line->index > 0 && command->n <= command[-1].n)
        fail(reader, "n is %" PRIu64 " behind %" PRIu64, command->n, command[-1].n);
    if (line->kind == CAPTURE_COMMAND_BUILD)
        read_build(reader, object, command);
}

/* Numbers an object that a line introduces. */
static void introduce(struct reader *reader, enum field_kind kind, uint64_t id, uint32_t index)
{
    struct handle_table *ids = ids_of(reader->capture, kind);
    if (id == 0)
        fail(reader, "introduces id 0");
    else if (index_of(ids, id) != CAPTURE_NONE)
        fail(reader, "introduces id %" PRIu64 " again", id);
    else
        set_index(ids, id, index);
}

static const char *text_at(struct reader *reader, const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text && text[0] ? keep_text(reader->capture, text) : NULL;
}

static void read_header(struct reader *reader, const json_t *object)
{
    struct capture *capture = reader->capture;
    const json_t *version = json_object_get(object, "version"),
                 *application = json_object_get(object, "Application");
    if (json_integer_value(version) != 1)
        fail(reader, "is of a version that this assay-scene does not read: version is not 1");
    capture->time = text_at(reader, object, "time");
    capture->layer_version = text_at(reader, object, "LayerVersion");
    capture->application = text_at(reader, application, "Name");
    capture->executable = text_at(reader, application, "Executable");
}

/* Makes the element of a line. */
static void read_record(struct reader *reader, json_t *object, struct captured_line *line)
{
    struct capture *capture = reader->capture;
    const struct record *record = &records[line->kind];
    uint32_t *count = (uint32_t *)((char *)capture + record->count);
    require_memory(array_has_room((char *)capture + record->array, *count,
                                  (uint32_t *)((char *)capture + record->capacity), record->size));
    line->index = (*count)++;
    void *element = memset(record_of(capture, line), 0, record->size);
    read_fields(reader, object, record->fields, element);
    if (line->kind >= CAPTURE_COMMAND_BUILD)
        read_command(reader, object, line, element);
    else if (line->kind > CAPTURE_DEVICE && !reader->has_failed) /* ids are their first members */
        introduce(reader, (enum field_kind)(MEMORY + line->kind - CAPTURE_MEMORY),
                  *(const uint64_t *)element, line->index);
}

static void read_line(struct reader *reader, json_t *object, const char *text, size_t length)
{
    struct capture *capture = reader->capture;
    struct captured_line *line = APPEND(capture, lines, line);
    line->text = text;
    line->length = length;
    const char *type = json_string_value(json_object_get(object, "Type"));
    if (!type)
        fail(reader, "is no object with a Type");
    line->kind = (enum capture_kind)find_name(line_kinds, type);
    if (!reader->has_failed && capture->line_count == 1 && line->kind != CAPTURE_HEADER)
        fail(reader, "the first line has another Type than Capture");
    if (line->kind == CAPTURE_HEADER)
        read_header(reader, object);
    else if (line->kind == CAPTURE_END)
        capture->end = text_at(reader, object, "why") ? text_at(reader, object, "why") : "unknown";
    else if (records[line->kind].fields && !reader->has_failed)
        read_record(reader, object, line);
}

/* ---- findings */

/* What a build and the findings about it have in common. */
static uint64_t key_of_place(uint64_t device, uint64_t queue, uint64_t command_buffer,
                             uint64_t submission, uint64_t build)
{
    const uint64_t place[] = {device, queue, command_buffer, submission, build};
    const uint64_t key = XXH3_64bits(place, sizeof(place));
    return key + !key;
}

static uint32_t number_after(const char *text, const char *before)
{
    const char *found = text ? strstr(text, before) : NULL;
    if (!found || !isdigit((unsigned char)found[strlen(before)]))
        return CAPTURE_NONE;
    const unsigned long long number = strtoull(found + strlen(before), NULL, 10);
    return number < CAPTURE_NONE ? (uint32_t)number : CAPTURE_NONE;
}

static void read_finding(struct reader *reader, json_t *object, const struct handle_table *builds)
{
    struct capture *capture = reader->capture;
    const char *type = json_string_value(json_object_get(object, "Type"));
    if (!type)
        fail(reader, "is no object with a Type");
    if (!type || strcmp(type, "Finding") != 0)
        return;
    /* Their places have the keys of those of builds. */
    struct captured_command place = {.n = 0};
    read_fields(reader, object, command_fields + 1, &place);
    struct captured_finding *finding = APPEND(capture, findings, finding);
    finding->id = text_at(reader, object, "VUID");
    finding->message = text_at(reader, object, "MainMessage");
    finding->severity = text_at(reader, object, "Severity");
    if (!finding->id || !finding->message)
        fail(reader, "has no texts VUID and MainMessage");
    const char *location = text_at(reader, object, "Location");
    finding->geometry = number_after(location, "eometries[");
    finding->primitive = number_after(finding->message, " primitive ");
    if (finding->primitive == CAPTURE_NONE)
        finding->primitive = number_after(finding->message, " instance ");
    finding->command = CAPTURE_NONE;
    const json_t *objects = json_object_get(object, "Objects");
    for (size_t i = 0; i < json_array_size(objects) && finding->command == CAPTURE_NONE; i++) {
        const json_t *value = json_array_get(objects, i);
        type = json_string_value(json_object_get(value, "type"));
        if (type && strstr(type, "CommandBuffer") &&
            read_hex(json_string_value(json_object_get(value, "handle")), &place.command_buffer))
            finding->command =
                index_of(builds, key_of_place(place.device, place.queue, place.command_buffer,
                                              place.submission, place.build));
    }
}

/* ---- files of lines */

/* Hands each line to `read_line` or read_finding(). Returns the text, which the lines refer to. */
static char *read_lines(struct reader *reader, const struct handle_table *builds)
{
    size_t size, whole;
    char *text = read_file(reader, SIZE_MAX - 1, &size, &whole);
    for (char *at = text; text && at < text + size && !reader->has_failed;) {
        reader->line++;
        char *end = memchr(at, '\n', size - (size_t)(at - text));
        if (!end) {
            char note[PATH_SIZE];
            snprintf(note, sizeof(note),
                     "%s/%s:%" PRIu32 ": the last line was cut, and is left out",
                     reader->capture->folder, reader->file, reader->line);
            reader->capture->note = keep_text(reader->capture, note);
            break;
        }
        json_error_t error;
        json_t *object = json_loadb(at, (size_t)(end - at), JSON_REJECT_DUPLICATES, &error);
        if (!object)
            fail(reader, "is not JSON: %s (column %d)", error.text, error.column);
        else if (builds)
            read_finding(reader, object, builds);
        else
            read_line(reader, object, at, (size_t)(end - at));
        json_decref(object);
        at = end + 1;
    }
    return text;
}

static void read_findings(struct reader *reader)
{
    struct capture *capture = reader->capture;
    char path[PATH_SIZE];
    path_in(capture, "findings.jsonl", path);
    if (file_find_kind(path) == FILE_NONE)
        return;
    struct handle_table builds = {.slots = NULL};
    for (uint32_t i = 0; i < capture->command_count; i++) {
        const struct captured_command *command = &capture->commands[i];
        if (command->kind == CAPTURE_COMMAND_BUILD && command->command_buffer)
            set_index(&builds,
                      key_of_place(command->device, command->queue, command->command_buffer,
                                   command->submission, command->build),
                      i);
    }
    reader->file = "findings.jsonl";
    reader->line = 0;
    capture->finding_text = read_lines(reader, &builds);
    handle_table_release(&builds);
}

bool capture_open(struct capture *capture, const char *folder, struct capture_error *error)
{
    *capture = (struct capture){.folder = NULL};
    capture->folder = keep_text(capture, folder);
    struct reader reader = {.capture = capture, .error = error, .file = "builds.jsonl"};
    capture->text = read_lines(&reader, NULL);
    if (!reader.has_failed && capture->line_count == 0)
        fail(&reader, "has no whole line");
    if (!reader.has_failed)
        read_findings(&reader);
    return !reader.has_failed;
}

void capture_close(struct capture *capture)
{
    for (uint32_t i = 0; i < capture->command_count; i++) {
        struct captured_command *command = &capture->commands[i];
        for (uint32_t j = 0; j < command->geometry_count; j++)
            free(command->geometries[j].inputs);
        free(command->geometries);
        free(command->references);
    }
    for (uint32_t i = 0; i < capture->data_count; i++)
        capture_release_data(capture, i);
    void *const arrays[] = {capture->lines,       capture->devices,    capture->memories,
                            capture->buffers,     capture->structures, capture->commands,
                            capture->data,        capture->findings,   capture->text,
                            capture->finding_text};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(*arrays); i++)
        free(arrays[i]);
    handle_table_release(&capture->memory_ids);
    handle_table_release(&capture->buffer_ids);
    handle_table_release(&capture->structure_ids);
    handle_table_release(&capture->data_ids);
    handle_table_drop(&capture->texts, free);
}

const struct captured_input *capture_input_of(const struct captured_geometry *geometry,
                                              enum capture_role role)
{
    for (uint32_t i = 0; i < geometry->input_count; i++)
        if (geometry->inputs[i].role == role)
            return &geometry->inputs[i];
    return NULL;
}

const struct captured_reference *capture_reference_of(const struct captured_command *build,
                                                      uint64_t reference)
{
    const struct captured_reference key = {.reference = reference};
    return bsearch(&key, build->references, build->reference_count, sizeof(key),
                   compare_references);
}

bool capture_find_point(const struct capture *capture, const char *point, uint32_t *count,
                        struct capture_error *error)
{
    const char *value = strchr(point, ':');
    const size_t length = value ? (size_t)(value - point) : 0;
    const char *const words[] = {"frame", "submission", "build", "label"};
    uint32_t word = 0;
    while (word < 4 && (strlen(words[word]) != length || memcmp(words[word], point, length) != 0))
        word++;
    value += length > 0;
    char *end = NULL;
    const uint64_t number = word < 3 ? strtoull(value, &end, 10) : 0;
    if (word == 4 || !value[0] || (word < 3 && (*end || !isdigit((unsigned char)value[0])))) {
        snprintf(error->text, sizeof(error->text),
                 "not frame:N, submission:N, build:N or label:TEXT: %s", point);
        return false;
    }
    *count = 0;
    for (uint32_t i = 0; i < capture->command_count; i++) {
        const struct captured_command *command = &capture->commands[i];
        const bool is_executed =
            command->kind == CAPTURE_COMMAND_BUILD || command->kind == CAPTURE_COMMAND_COPY;
        if (word == 2      ? command->n <= number
            : !is_executed ? false
            : word == 0    ? command->frame <= number
            : word == 1    ? command->submission == number && number
                           : command->region && strstr(command->region, value))
            *count = i + 1;
    }
    if (*count == 0)
        snprintf(error->text, sizeof(error->text), "%s: nothing was executed there", point);
    return *count > 0;
}

/* ---- writing */

/* Returns a member as JSON, or NULL if it is not to be written. */
static json_t *value_of(const struct capture *capture, const struct field *field, const void *from)
{
    const uint32_t index = *(const uint32_t *)from;
    const char *name = NULL;
    char text[20];
    switch (field->kind) {
    case NUMBER:
        return json_integer((json_int_t) * (const uint64_t *)from);
    case NUMBER32:
        return json_integer(index);
    case HEX:
    case HEX32:
        snprintf(text, sizeof(text), "0x%" PRIx64,
                 field->kind == HEX ? *(const uint64_t *)from : index);
        name = text;
        break;
    case TEXT:
        name = *(const char *const *)from;
        break;
    case FLAG:
        return json_integer(*(const bool *)from);
    case LEVEL:
    case GEOMETRY:
    case ROLE:
    case MODE:
        name = names[field->kind][index];
        break;
    default:
        if (index == CAPTURE_NONE)
            return NULL;
        if (field->kind == DATA)
            return json_string(capture->data[index].hash);
        return json_integer((json_int_t)(field->kind == MEMORY   ? capture->memories[index].id
                                         : field->kind == BUFFER ? capture->buffers[index].id
                                                                 : capture->structures[index].id));
    }
    return name ? json_string(name) : NULL;
}

/* Changes those members of an object that the structure has other values of. Keys stay where they
 * are, and a value that is 0 is not added. */
static void write_fields(const struct capture *capture, json_t *object, const struct field *fields,
                         const void *structure)
{
    for (const struct field *field = fields; field->key; field++) {
        const void *from = (const char *)structure + field->offset;
        json_t *value = value_of(capture, field, from);
        const char *key = field->key;
        json_t *holder = holder_of(object, &key);
        const json_t *old = json_object_get(holder, key);
        const bool is_zero =
            json_is_false(value) || (json_is_integer(value) && json_integer_value(value) == 0) ||
            (json_is_string(value) && strcmp(json_string_value(value), "0x0") == 0);
        if (value && (old || !is_zero))
            json_object_set(holder, key, value);
        else if (!value && old && (field->kind < LEVEL || field->kind > MODE))
            json_object_del(holder, key);
        json_decref(value);
    }
}

static void write_build(const struct capture *capture, json_t *object,
                        const struct captured_command *build)
{
    json_t *array = json_object_get(object, "geometry");
    for (uint32_t i = build->geometry_count; i-- > 0;) {
        const struct captured_geometry *geometry = &build->geometries[i];
        json_t *value = json_array_get(array, i);
        if (geometry->is_left_out) {
            json_array_remove(array, i);
            continue;
        }
        write_fields(capture, value, geometry_fields, geometry);
        for (uint32_t j = 0; j < geometry->input_count; j++)
            write_fields(capture, json_array_get(json_object_get(value, "inputs"), j), input_fields,
                         &geometry->inputs[j]);
    }
    array = json_object_get(object, "references");
    for (size_t i = json_array_size(array); i-- > 0;) {
        const char *text =
            json_string_value(json_object_get(json_array_get(array, i), "reference"));
        const struct captured_reference *reference =
            capture_reference_of(build, text ? strtoull(text, NULL, 16) : 0);
        if (reference && reference->is_left_out)
            json_array_remove(array, i);
    }
}

/* Returns a changed line as text, which the caller frees. */
static char *write_line(const struct capture *capture, const struct captured_line *line)
{
    json_t *object = json_loadb(line->text, line->length, 0, NULL);
    if (records[line->kind].fields)
        write_fields(capture, object, records[line->kind].fields, record_of(capture, line));
    if (line->kind == CAPTURE_COMMAND_BUILD)
        write_build(capture, object, &capture->commands[line->index]);
    char *text = json_dumps(object, JSON_COMPACT);
    require_memory(text);
    json_decref(object);
    return text;
}

/* Writes a file of the new capture, whose folder `writer` names. */
static bool write_file(struct reader *writer, const void *bytes, size_t size)
{
    char path[PATH_SIZE];
    path_in(writer->capture, writer->file, path);
    FILE *file = fopen(path, "wb");
    const bool is_written = file && fwrite(bytes, 1, size, file) == size;
    if (!file || (fclose(file) != 0) | !is_written)
        return fail(writer, "cannot be written: %s", strerror(errno));
    return true;
}

static void write_lines(struct reader *writer, const struct capture *capture)
{
    char path[PATH_SIZE];
    path_in(writer->capture, writer->file, path);
    FILE *file = fopen(path, "wb");
    for (uint32_t i = 0; file && i < capture->line_count; i++) {
        const struct captured_line *line = &capture->lines[i];
        char *text = line->is_changed && !line->is_left_out ? write_line(capture, line) : NULL;
        if (!line->is_left_out)
            fprintf(file, "%.*s\n", text ? INT32_MAX : (int)line->length, text ? text : line->text);
        free(text);
    }
    if (!file || ferror(file) | (fclose(file) != 0))
        fail(writer, "cannot be written: %s", strerror(errno));
}

/* Writes the arrays that lines which are not left out refer to. */
static void write_data(struct reader *writer, struct capture *capture, struct capture_error *error)
{
    bool *is_written = allocate_zeroed(capture->data_count, sizeof(*is_written));
    for (uint32_t i = 0; i < capture->command_count; i++) {
        const struct captured_command *command = &capture->commands[i];
        const struct captured_line *line = &capture->lines[command->line];
        for (uint32_t j = 0; j < command->geometry_count && !line->is_left_out; j++) {
            const struct captured_geometry *geometry = &command->geometries[j];
            for (uint32_t k = 0; k < geometry->input_count && !writer->has_failed; k++) {
                const uint32_t data = geometry->inputs[k].data;
                if (data == CAPTURE_NONE || is_written[data] ||
                    (geometry->is_left_out && line->is_changed))
                    continue;
                is_written[data] = true;
                const bool is_loaded = capture->data[data].file;
                char path[64];
                path_of_data(&capture->data[data], path);
                writer->file = path;
                writer->has_failed =
                    !capture_load_data(capture, data, error) ||
                    !write_file(writer, capture->data[data].file, capture->data[data].size);
                if (!is_loaded)
                    capture_release_data(capture, data);
            }
        }
    }
    free(is_written);
}

bool capture_write(struct capture *capture, const char *folder, struct capture_error *error)
{
    struct capture to = {.folder = folder}; /* all that paths and messages need */
    struct reader writer = {.capture = &to, .error = error, .file = "data"};
    char path[PATH_SIZE];
    path_in(&to, writer.file, path);
    const int number = file_find_kind(folder) ? EEXIST : file_make_folder(folder);
    if (number || file_make_folder(path)) {
        snprintf(error->text, sizeof(error->text), "%s: %s", folder, strerror(number));
        return false;
    }
    write_data(&writer, capture, error);
    writer.file = "builds.jsonl";
    if (!writer.has_failed)
        write_lines(&writer, capture);
    writer.file = "findings.jsonl";
    if (!writer.has_failed && capture->finding_text)
        write_file(&writer, capture->finding_text, strlen(capture->finding_text));
    return !writer.has_failed;
}
