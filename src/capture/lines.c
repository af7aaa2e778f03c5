/* SPDX-License-Identifier: Apache-2.0 */
#include "src/capture/lines.h"

#include <stdlib.h>
#include <string.h>

#include "src/platform/clock.h"
#include "src/platform/process.h"
#include "src/report/message.h"
#include "src/view/names.h"

enum { FORMAT_VERSION = 1, LINE_MOST = 1 << 28 };

int capture_writer_open(struct capture_writer *writer, const char *path, uint64_t limit)
{
    writer->line_size = JSON_LINE_MAX;
    return capture_folder_open(&writer->folder, path, limit);
}

void capture_writer_close(struct capture_writer *writer)
{
    capture_kept_release(&writer->kept);
    capture_folder_close(&writer->folder);
    handle_table_release(&writer->buffers);
    handle_table_release(&writer->memories);
    handle_table_release(&writer->structures);
    free(writer->room.bytes);
    free(writer->line);
}

/* ---- lines */

static struct json *begin_line(struct capture_writer *writer, const char *type)
{
    json_begin(&writer->json);
    json_text(&writer->json, "Type", type);
    return &writer->json;
}

static void end_line(struct capture_writer *writer)
{
    struct json *json = &writer->json;
    if (json_end(json))
        capture_folder_add_line(&writer->folder, json->text.text, json->text.length);
}

/* Returns whether an object has no line yet; it has one from then on. */
static bool is_new(struct handle_table *table, uint64_t id)
{
    static char has_line;
    return id && !handle_table_find(table, id) && handle_table_set(table, id, &has_line);
}

static void write_name(const struct capture_writer *writer, struct json *json, VkObjectType type,
                       uint64_t handle)
{
    char name[MESSAGE_NAME_SIZE];
    if (object_names_get(writer->names, type, handle, name, sizeof(name)))
        json_text(json, "name", name);
}

static void write_value(struct json *json, const char *key, struct value value)
{
    if (value.kind == VALUE_TEXT)
        json_text(json, key, value.text);
    else
        json_number(json, key, value.number);
}

/* ---- the device */

static void write_process(struct capture_writer *writer)
{
    char text[LOG_PATH_SIZE];
    struct text_buffer time;
    struct json *json = begin_line(writer, "Capture");
    json_number(json, "version", FORMAT_VERSION);
    json_number(json, "pid", process_id());
    text_begin(&time, text, sizeof(text));
    text_append_time(&time, clock_utc());
    json_text(json, "time", text);
    json_text(json, "Layer", "VK_LAYER_ASSAY_validation");
    json_text(json, "LayerVersion", ASSAY_VERSION);
    json_begin_object(json, "Application");
    process_executable(text, sizeof(text));
    json_text(json, "Executable", text);
    json_end_object(json);
    end_line(writer);
}

void capture_write_device(struct capture_writer *writer, const struct capture_device *device)
{
    write_process(writer);
    struct json *json = begin_line(writer, "Device");
    json_hex(json, "device", handle_number(device->handle));
    json_text(json, "DeviceName", device->properties->deviceName);
    json_text_of_size(json, "Driver", device->driver->driverName,
                      sizeof(device->driver->driverName));
    json_text_of_size(json, "DriverInfo", device->driver->driverInfo,
                      sizeof(device->driver->driverInfo));
    json_begin_object(json, "limits");
    json_number(json, "scratch_alignment",
                device->limits->minAccelerationStructureScratchOffsetAlignment);
    json_number(json, "max_geometries", device->limits->maxGeometryCount);
    json_number(json, "max_instances", device->limits->maxInstanceCount);
    json_number(json, "max_primitives", device->limits->maxPrimitiveCount);
    json_end_object(json);
    end_line(writer);
}

void capture_write_end(struct capture_writer *writer, const char *why)
{
    writer->folder.limit = UINT64_MAX;
    writer->folder.is_full = false;
    json_text(begin_line(writer, "End"), "why", why);
    end_line(writer);
}

/* ---- buffers and structures */

static void write_memory(struct capture_writer *writer, uint64_t id, VkDeviceMemory handle)
{
    if (!is_new(&writer->memories, id))
        return;
    const struct memory_facts facts = resources_find_memory(writer->resources, handle);
    struct json *json = begin_line(writer, "Memory");
    json_number(json, "memory", id);
    write_name(writer, json, VK_OBJECT_TYPE_DEVICE_MEMORY, handle_number(handle));
    if (facts.size)
        json_number(json, "size", facts.size);
    end_line(writer);
}

/* Describes a live buffer once. */
static void write_buffer(struct capture_writer *writer, const struct buffer_facts *buffer)
{
    struct buffer_memory memory;
    uint64_t memory_id = 0;
    if (!is_new(&writer->buffers, buffer->id))
        return;
    if (resources_find_buffer_memory(writer->resources, buffer->handle, &memory))
        memory_id = resources_find_memory_id(writer->resources, memory.handle);
    if (memory_id)
        write_memory(writer, memory_id, memory.handle);
    struct json *json = begin_line(writer, "Buffer");
    json_number(json, "buffer", buffer->id);
    write_name(writer, json, VK_OBJECT_TYPE_BUFFER, handle_number(buffer->handle));
    if (memory_id) {
        json_number(json, "memory", memory_id);
        json_number(json, "memory_offset", memory.begin);
    }
    json_number(json, "size", buffer->size);
    json_hex(json, "usage", buffer->usage);
    end_line(writer);
}

/* Finds a buffer that is still the one of this id, and describes it. */
static bool find_buffer(struct capture_writer *writer, VkBuffer handle, uint64_t id,
                        struct buffer_facts *buffer)
{
    resources_look_up_buffer(writer->resources, handle, buffer);
    if (!id || buffer->alive != YES || buffer->id != id)
        return false;
    write_buffer(writer, buffer);
    return true;
}

/* Where an address lies: of so many bytes up to the end of its buffer. */
static void write_place(struct json *json, const struct buffer_facts *buffer, uint64_t bytes_left)
{
    json_number(json, "buffer", buffer->id);
    json_number(json, "offset", buffer->size - bytes_left);
}

static void write_structure_place(struct capture_writer *writer, const struct accel_facts *accel,
                                  const struct buffer_facts *buffer)
{
    struct buffer_memory memory;
    if (!resources_find_buffer_memory(writer->resources, accel->buffer, &memory) ||
        memory.handle != accel->memory)
        return;
    json_number(&writer->json, "buffer", buffer->id);
    json_number(&writer->json, "offset", accel->begin - memory.begin);
}

void capture_write_structure(struct capture_writer *writer, const struct accel_facts *accel,
                             const char *missing)
{
    struct buffer_facts buffer;
    if (!is_new(&writer->structures, accel->id))
        return;
    /* The line of the buffer comes first. */
    const bool has_buffer = find_buffer(writer, accel->buffer, accel->buffer_id, &buffer);
    struct json *json = begin_line(writer, "Structure");
    json_number(json, "structure", accel->id);
    json_hex(json, "handle", handle_number(accel->handle));
    write_name(writer, json, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
               handle_number(accel->handle));
    if (accel->details_known) {
        json_text(json, "type", record_type_name(accel->type));
        json_number(json, "size", accel->size);
        if (has_buffer)
            write_structure_place(writer, accel, &buffer);
    }
    if (missing)
        json_text(json, "missing", missing);
    end_line(writer);
}

/* ---- builds */

/* A build whose line is being composed. Lines of buffers that it names are written meanwhile. */
struct composed {
    struct capture_writer *writer;
    struct json *json;
    const struct capture_build *build;
    bool has_motion;
    bool is_incomplete; /* some data could not be read */
};

static void compose_address(const struct composed *composed, uint64_t address)
{
    struct address_facts facts;
    struct buffer_facts buffer;
    resources_look_up_address(composed->writer->resources, address, &facts);
    const bool is_found = facts.status == ADDRESS_IN_BUFFER &&
                          find_buffer(composed->writer, facts.buffer, facts.buffer_id, &buffer);
    json_hex(composed->json, "address", address);
    if (is_found)
        write_place(composed->json, &buffer, facts.bytes_left);
}

static void compose_input(struct composed *composed,
                          const VkAccelerationStructureGeometryKHR *geometry,
                          const struct chained_input *chained, const struct geometry_input *input)
{
    struct capture_array array;
    char hash[CAPTURE_HASH_SIZE];
    struct json *json = composed->json;
    json_begin_object(json, NULL);
    json_text(json, "role", capture_role_name(input->role));
    compose_address(composed, input->address.deviceAddress);
    if (input->offset)
        json_number(json, "first", input->offset);
    json_number(json, "count", input->count);
    json_number(json, "stride", input->stride);
    json_number(json, "size", input->most);
    const bool is_read = capture_array_read(composed->build->memory, composed->has_motion, geometry,
                                            chained, input, &composed->writer->room, &array) &&
                         capture_folder_add_array(&composed->writer->folder, &array, hash);
    if (is_read)
        json_text(json, "data", hash);
    else
        json_text(json, "missing", "it could not be read");
    composed->is_incomplete |= !is_read || array.count < input->count;
    json_end_object(json);
}

static const char *geometry_name(VkGeometryTypeKHR type)
{
    return type_is_triangles(type)       ? "triangles"
           : type_is_aabbs(type)         ? "aabbs"
           : type_is_instances(type)     ? "instances"
           : type_is_spheres(type)       ? "spheres"
           : type_is_swept_spheres(type) ? "linear swept spheres"
           : type_is_dense(type)         ? "dense triangles"
           : type_is_micromap(type)      ? "micromap"
                                         : "other";
}

static void compose_range(struct json *json, const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    json_number(json, "primitiveCount", range->primitiveCount);
    if (range->primitiveOffset)
        json_number(json, "primitiveOffset", range->primitiveOffset);
    if (range->firstVertex)
        json_number(json, "firstVertex", range->firstVertex);
    if (range->transformOffset)
        json_number(json, "transformOffset", range->transformOffset);
}

static void compose_shape(struct json *json, const VkAccelerationStructureGeometryKHR *geometry)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &geometry->geometry.triangles;
    json_text(json, "type", geometry_name(geometry->geometryType));
    json_hex(json, "flags", geometry->flags);
    if (type_is_triangles(geometry->geometryType)) {
        write_value(json, "vertexFormat", format(triangles->vertexFormat));
        json_number(json, "vertexStride", triangles->vertexStride);
        json_number(json, "maxVertex", triangles->maxVertex);
        write_value(json, "indexType", index_type(triangles->indexType));
    }
    if (type_is_aabbs(geometry->geometryType))
        json_number(json, "stride", geometry->geometry.aabbs.stride);
    if (has_instance_pointers(geometry))
        json_number(json, "arrayOfPointers", 1);
}

static void compose_geometry(struct composed *composed, const struct build_parameters *given,
                             uint32_t index, const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    const VkAccelerationStructureGeometryKHR *geometry = &given->geometries[index];
    const struct chained_input *chained = given->chained ? &given->chained[index] : NULL;
    struct geometry_input inputs[GEOMETRY_INPUTS];
    const uint32_t count = inputs_of_geometry(given->info.flags, geometry, chained, range, inputs);
    capture_count_chosen(composed->build->memory, given, index, range->primitiveCount, inputs,
                         count);
    json_begin_object(composed->json, NULL);
    compose_shape(composed->json, geometry);
    compose_range(composed->json, range);
    json_begin_array(composed->json, "inputs");
    for (uint32_t i = 0; i < count; i++)
        compose_input(composed, geometry, chained, &inputs[i]);
    json_end_array(composed->json);
    json_end_object(composed->json);
}

static void compose_references(struct json *json, const struct capture_build *build)
{
    if (!build->reference_count)
        return;
    json_begin_array(json, "references");
    for (uint32_t i = 0; i < build->reference_count; i++) {
        json_begin_object(json, NULL);
        json_hex(json, "reference", build->references[i].reference);
        json_number(json, "structure", build->references[i].structure);
        json_end_object(json);
    }
    json_end_array(json);
}

static void compose_geometries(struct composed *composed, const struct build_parameters *given,
                               const VkAccelerationStructureBuildRangeInfoKHR *ranges)
{
    struct json *json = composed->json;
    composed->is_incomplete = false;
    json_begin_object(json, "scratch");
    compose_address(composed, given->info.scratchData.deviceAddress);
    json_end_object(json);
    json_begin_array(json, "geometry");
    for (uint32_t i = 0; i < given->info.geometryCount; i++)
        compose_geometry(composed, given, i, &ranges[i]);
    json_end_array(json);
    compose_references(json, composed->build);
    if (composed->is_incomplete)
        json_text(json, "missing", "a part of the data could not be read");
}

/* Makes the line's memory larger. */
static bool grow(struct capture_writer *writer)
{
    const size_t size = 2 * writer->line_size;
    char *line = size <= LINE_MOST ? realloc(writer->line, size) : NULL;
    if (!line)
        return false;
    writer->line = line;
    writer->line_size = size;
    return true;
}

/* The line is composed again if it did not fit: what it names is known by then. */
static bool compose(struct composed *composed, const struct build_parameters *given,
                    const VkAccelerationStructureBuildRangeInfoKHR *ranges)
{
    struct capture_writer *writer = composed->writer;
    composed->json = &writer->build;
    json_begin(&writer->build);
    for (;;) {
        compose_geometries(composed, given, ranges);
        if (json_end(&writer->build))
            return true;
        if (!grow(writer))
            return false;
        json_begin_in(&writer->build, writer->line, writer->line_size);
    }
}

/* Returns the parameters that the application gave. Recording does not change those of a micromap,
 * and recorded_build_given() lacks its usages and addresses. */
static const struct build_parameters *find_given(const struct recorded_build *build)
{
    const VkAccelerationStructureTypeKHR type = build->parameters.info.type;
    return (int)type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR
               ? &build->parameters
               : recorded_build_given(build);
}

bool capture_compose_build(struct capture_writer *writer, const struct capture_build *build)
{
    const struct build_parameters *given = find_given(build->build);
    struct composed composed = {
        .writer = writer,
        .build = build,
        .has_motion = given->info.flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV,
    };
    VkAccelerationStructureBuildRangeInfoKHR *ranges = NULL;
    if (build->build->is_indirect) {
        ranges = calloc(given->info.geometryCount + 1ull, sizeof(*ranges));
        if (!ranges)
            return false;
        recorded_build_read_ranges(build->build, build->memory, ranges);
    }
    const bool has_room = compose(&composed, given, ranges ? ranges : given->ranges);
    free(ranges);
    return has_room;
}
