/* SPDX-License-Identifier: Apache-2.0 */
#include "src/capture/arrays.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/text_buffer.h"
#include "src/bvh/input/source.h"
#include "src/model/formats.h"
#include "src/snapshots/build_input.h"

const char *capture_role_name(enum input_role role)
{
    static const char *const names[INPUT_ROLES] = {
        [INPUT_VERTEX] = "vertices",
        [INPUT_INDEX] = "indices",
        [INPUT_MATRIX] = "transform",
        [INPUT_AABBS] = "aabbs",
        [INPUT_INSTANCES] = "instances",
        [INPUT_MOTION_VERTEX] = "motion vertices",
        [INPUT_SPHERE_VERTEX] = "centers",
        [INPUT_SPHERE_RADIUS] = "radii",
        [INPUT_SPHERE_INDEX] = "indices",
        [INPUT_SWEPT_VERTEX] = "centers",
        [INPUT_SWEPT_RADIUS] = "radii",
        [INPUT_SWEPT_INDEX] = "indices",
        [INPUT_MICROMAP_DATA] = "micromap data",
        [INPUT_MICROMAP_TRIANGLES] = "micromap triangles",
        [INPUT_OPACITY_INDEX] = "opacity indices",
        [INPUT_OPACITY_EXT_INDEX] = "opacity indices",
        [INPUT_DENSE_DATA] = "dense data",
        [INPUT_DISPLACEMENT_INDEX] = "displacement indices",
        [INPUT_DISPLACEMENT_VECTOR] = "displacement vectors",
        [INPUT_DISPLACEMENT_BIAS] = "displacement biases",
        [INPUT_DISPLACEMENT_FLAGS] = "displacement flags",
    };
    return names[role] ? names[role] : "data";
}

/* ---- types */

static void set_type(struct capture_array *array, const char *type, uint64_t columns)
{
    struct text_buffer text;
    array->type = type;
    text_begin(&text, array->columns, sizeof(array->columns));
    if (columns == 1)
        return;
    text_append(&text, ", ");
    text_append_decimal(&text, columns);
}

/* Sets the type of rows of numbers of `component` bytes, and of a kind that NumPy has. */
static void set_numbers(struct capture_array *array, char kind, uint32_t component)
{
    static const struct {
        char kind;
        uint32_t component;
        const char *type;
    } types[] = {
        {'f', 2, "'<f2'"}, {'f', 4, "'<f4'"}, {'f', 8, "'<f8'"}, {'i', 1, "'|i1'"},
        {'i', 2, "'<i2'"}, {'i', 4, "'<i4'"}, {'u', 2, "'<u2'"}, {'u', 4, "'<u4'"},
    };
    for (size_t i = 0; i < sizeof(types) / sizeof(types[0]); i++)
        if (types[i].kind == kind && types[i].component == component && component &&
            array->size % component == 0)
            set_type(array, types[i].type, array->size / component);
}

static VkFormat format_of(const VkAccelerationStructureGeometryKHR *geometry,
                          const struct chained_input *chained, enum input_role role)
{
    switch (role) {
    case INPUT_VERTEX:
    case INPUT_MOTION_VERTEX:
        return geometry->geometry.triangles.vertexFormat;
    case INPUT_SPHERE_VERTEX:
    case INPUT_SWEPT_VERTEX:
        return chained->spheres.vertexFormat;
    case INPUT_SPHERE_RADIUS:
    case INPUT_SWEPT_RADIUS:
        return chained->spheres.radiusFormat;
    case INPUT_DISPLACEMENT_VECTOR:
        return chained->displacement.displacementVectorFormat;
    case INPUT_DISPLACEMENT_BIAS:
        return chained->displacement.displacementBiasAndScaleFormat;
    default:
        return VK_FORMAT_UNDEFINED;
    }
}

/* Bytes, unless the role says more. */
static void find_type(struct capture_array *array, const struct geometry_input *input,
                      VkFormat format, bool has_motion)
{
    set_type(array, "'|u1'", array->size);
    if (format) {
        set_numbers(array, format_number_kind(format), format_smallest_component(format));
    } else if (input->role == INPUT_AABBS) {
        set_numbers(array, 'f', sizeof(float));
    } else if (input->role == INPUT_MATRIX) {
        set_type(array, "'<f4'", 1);
        memcpy(array->columns, ", 3, 4", sizeof(", 3, 4"));
    } else if (input->role == INPUT_INSTANCES && !has_motion) {
        set_type(array,
                 "[('transform', '<f4', (3, 4)), ('customIndexAndMask', '<u4'), "
                 "('offsetAndFlags', '<u4'), ('reference', '<u8')]",
                 1);
    } else {
        set_numbers(array, 'u', array->size == 2 || array->size == 4 ? (uint32_t)array->size : 1);
    }
}

/* ---- rows */

static bool make_room(struct capture_room *room, uint64_t count, uint64_t size)
{
    uint64_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX)
        return false;
    if (bytes > room->size) {
        free(room->bytes);
        room->bytes = malloc((size_t)bytes);
        room->size = room->bytes ? bytes : 0;
    }
    return room->size >= bytes;
}

/* Returns how many whole rows there are in so many bytes, up to the count of the input. */
static uint64_t rows_within(const struct geometry_input *input, uint64_t bytes)
{
    if (bytes < input->most || !input->most)
        return 0;
    if (!input->stride)
        return 1; /* all are the same */
    const uint64_t rows = (bytes - input->most) / input->stride + 1;
    return rows < input->count ? rows : input->count;
}

/* The elements behind an array of pointers. With motion the low 4 bits of a pointer are the type,
 * which precedes a motion instance, as flags of 4 bytes do. */
enum { TYPE_BITS = 4, MOTION_HEADER = 8 };
static uint64_t motion_size(uint32_t type)
{
    return type == VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV
               ? sizeof(VkAccelerationStructureMatrixMotionInstanceNV)
           : type == VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV
               ? sizeof(VkAccelerationStructureSRTMotionInstanceNV)
               : sizeof(VkAccelerationStructureInstanceKHR);
}

static bool read_pointed(const struct input_memory *memory, uint64_t pointer, bool has_motion,
                         unsigned char *row)
{
    const uint32_t type = has_motion ? pointer & ((1 << TYPE_BITS) - 1) : 0;
    const uint64_t size = motion_size(type);
    const void *bytes;
    if (memory->find(memory->context, pointer - type, size, &bytes) < size)
        return false;
    if (has_motion)
        memcpy(row, &type, sizeof(type));
    memcpy(row + (has_motion ? MOTION_HEADER : 0), bytes, size);
    return true;
}

static bool read_pointers(const struct input_memory *memory, bool has_motion,
                          const unsigned char *pointers, struct capture_room *room,
                          struct capture_array *array)
{
    array->size = has_motion ? sizeof(VkAccelerationStructureMotionInstanceNV)
                             : sizeof(VkAccelerationStructureInstanceKHR);
    if (!make_room(room, array->count, array->size))
        return false;
    memset(room->bytes, 0, array->count * array->size);
    for (uint64_t i = 0; i < array->count; i++) {
        uint64_t pointer;
        memcpy(&pointer, pointers + i * sizeof(pointer), sizeof(pointer));
        if (!read_pointed(memory, pointer, has_motion, room->bytes + i * array->size))
            return false;
    }
    array->rows = room->bytes;
    return true;
}

static bool pack(const struct geometry_input *input, const unsigned char *bytes,
                 struct capture_room *room, struct capture_array *array)
{
    if (!make_room(room, array->count, array->size))
        return false;
    for (uint64_t i = 0; i < array->count; i++)
        memcpy(room->bytes + i * array->size, bytes + i * input->stride, array->size);
    array->rows = room->bytes;
    return true;
}

/* Returns how many bytes of the input can be read, from its first element on. */
static uint64_t find_bytes(const struct input_memory *memory, const struct geometry_input *input,
                           const void **bytes)
{
    const uint64_t address = input_extent(input->address.deviceAddress, 1, input->offset, 0),
                   end = input_end(input), size = end > input->offset ? end - input->offset : 0;
    return address == UINT64_MAX ? 0 : memory->find(memory->context, address, size, bytes);
}

static bool read_rows(const struct input_memory *memory, bool has_motion, bool has_pointers,
                      const struct geometry_input *input, struct capture_room *room,
                      struct capture_array *array)
{
    const void *bytes = NULL;
    array->count = rows_within(input, find_bytes(memory, input, &bytes));
    array->size = input->most;
    array->rows = bytes;
    if (!array->count)
        return false;
    if (has_pointers)
        return read_pointers(memory, has_motion, bytes, room, array);
    return input->stride == array->size || array->count == 1 || pack(input, bytes, room, array);
}

static uint64_t count_spheres(const struct input_memory *memory,
                              const VkAccelerationStructureGeometryKHR *geometry,
                              const struct chained_input *chained, uint32_t primitives,
                              const struct geometry_input *indices)
{
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = primitives};
    struct builder_geometry described;
    build_input_describe(geometry, chained, &described);
    described.spheres.indices_size = find_bytes(memory, indices, &described.spheres.indices);
    return sphere_vertex_count(&described.spheres, type_is_swept_spheres(geometry->geometryType),
                               &range);
}

void capture_count_chosen(const struct input_memory *memory, const struct build_parameters *build,
                          uint32_t geometry, uint32_t primitives, struct geometry_input *inputs,
                          uint32_t count)
{
    struct micromap_input micromap;
    uint64_t spheres = 0;
    for (uint32_t i = 0; i < count; i++) {
        switch (inputs[i].role) {
        case INPUT_SPHERE_INDEX:
        case INPUT_SWEPT_INDEX: /* before what they choose */
            spheres = count_spheres(memory, &build->geometries[geometry], &build->chained[geometry],
                                    primitives, &inputs[i]);
            break;
        case INPUT_SPHERE_VERTEX:
        case INPUT_SPHERE_RADIUS:
        case INPUT_SWEPT_VERTEX:
        case INPUT_SWEPT_RADIUS:
            inputs[i].count = inputs[i].count ? inputs[i].count : spheres;
            break;
        case INPUT_MICROMAP_DATA:
            build_input_find_micromap(build, memory, &micromap);
            inputs[i].count = micromap_data_extent(&micromap);
            inputs[i].stride = inputs[i].size = inputs[i].most = 1;
            break;
        default:
            break;
        }
    }
}

bool capture_array_read(const struct input_memory *memory, bool has_motion,
                        const VkAccelerationStructureGeometryKHR *geometry,
                        const struct chained_input *chained, const struct geometry_input *input,
                        struct capture_room *room, struct capture_array *array)
{
    const bool has_pointers = input->role == INPUT_INSTANCES && has_instance_pointers(geometry);
    *array = (struct capture_array){0};
    if (!read_rows(memory, has_motion, has_pointers, input, room, array))
        return false;
    find_type(array, input, format_of(geometry, chained, input->role), has_motion);
    return true;
}
