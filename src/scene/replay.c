/* SPDX-License-Identifier: Apache-2.0 */
/* Replays a capture: builds again, in the captured order and one call after the other, from the
 * same data. Buffers lie where they lay: in memory of the same layout, so that what overlapped
 * overlaps. On a driver that needs more, all offsets and sizes are multiplied by one number. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vk_enum_string_helper.h>

#include "src/platform/files.h"
#include "src/scene/driver.h"
#include "src/scene/tool.h"

enum { SPARE_SIZE = 1 << 24, SPARE_ALIGNMENT = 256, CALL_BUILDS = 4096 };

struct placed_memory {
    struct driver_memory memory;
    VkDeviceSize extent; /* the captured end of the last buffer in it */
    uint32_t last_use;   /* the last command that needs it */
};

struct placed_buffer {
    VkBuffer handle;          /* null: not yet, or no longer */
    struct driver_buffer own; /* if it could not be placed in the captured memory */
    unsigned char *bytes;
    VkDeviceAddress address;
};

struct placed_structure {
    VkAccelerationStructureKHR handle;
    struct driver_buffer own; /* if there is no room where it lay */
    VkDeviceAddress address;
    bool is_built;
    bool is_left_out; /* what was built into it is not in the capture, or was not replayed */
    bool is_kept; /* built before the capture: something else may lie there by then in a replay */
};

/* Memory for what has no place in the capture, used again by the next call. */
struct spare {
    struct spare *next;
    struct driver_buffer buffer;
    VkDeviceSize used;
};

enum { REASONS = 16 };

struct replay {
    struct capture *capture;
    const struct replay_options *options;
    struct capture_error *error;
    struct driver driver;
    uint64_t scale; /* of offsets and sizes */
    bool is_same_driver;
    struct placed_memory *memories;
    struct placed_buffer *buffers;
    struct placed_structure *structures;
    struct spare *spares;
    bool has_bad_build; /* in the call that is recorded: the layer keeps it from the driver */
    uint32_t built, copied, skipped, findings;
    /* Why commands were skipped; the first command of each reason is printed. */
    struct {
        const char *why; /* texts of a capture are equal if their pointers are */
        uint32_t more;
    } reasons[REASONS];
    uint32_t reason_count;
};

/* Says why a command is not replayed, once for each reason. */
static void skip(struct replay *replay, const struct captured_command *command, const char *why)
{
    replay->skipped++;
    /* The application, or who made the capture smaller, may have left out the source of a copy. */
    if (command->dst != CAPTURE_NONE &&
        (command->kind == CAPTURE_COMMAND_BUILD || command->src == CAPTURE_NONE ||
         replay->structures[command->src].is_left_out))
        replay->structures[command->dst].is_left_out = true;
    uint32_t i = 0;
    while (i < replay->reason_count && replay->reasons[i].why != why)
        i++;
    if (i < replay->reason_count) {
        replay->reasons[i].more++;
    } else {
        if (i < REASONS)
            replay->reasons[replay->reason_count++].why = why;
        printf("not replayed: %" PRIu64 " (%s): %s\n", command->n,
               command->command ? command->command : "build", why);
    }
}

/* The first command of each reason was printed. */
static void print_skipped(const struct replay *replay)
{
    for (uint32_t i = 0; i < replay->reason_count; i++)
        if (replay->reasons[i].more)
            printf("not replayed, %" PRIu32 " more: %s\n", replay->reasons[i].more,
                   replay->reasons[i].why);
}

/* ---- the layer's messages */

static VkBool32 VKAPI_PTR on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                     VkDebugUtilsMessageTypeFlagsEXT types,
                                     const VkDebugUtilsMessengerCallbackDataEXT *data, void *user)
{
    struct replay *replay = user;
    (void)severity;
    if (types & VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT)
        return VK_FALSE; /* of the loader */
    replay->findings++;
    printf("finding: %s", data->pMessageIdName ? data->pMessageIdName : "");
    for (uint32_t i = 0; i < data->objectCount; i++)
        if (data->pObjects[i].pObjectName)
            printf(" \"%s\"", data->pObjects[i].pObjectName);
    printf("\n");
    return replay->has_bad_build;
}

static void name_object(struct replay *replay, VkObjectType type, uint64_t handle, const char *name)
{
    const VkDebugUtilsObjectNameInfoEXT info = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
        .objectType = type,
        .objectHandle = handle,
        .pObjectName = name};
    if (name && replay->driver.messenger)
        replay->driver.vk.SetDebugUtilsObjectNameEXT(replay->driver.device, &info);
}

/* ---- spare memory */

/* Returns NULL, with an error, without memory. */
static unsigned char *take_spare(struct replay *replay, VkDeviceSize size, VkDeviceAddress *address)
{
    const VkDeviceSize room = (size + SPARE_ALIGNMENT - 1) / SPARE_ALIGNMENT * SPARE_ALIGNMENT;
    struct spare *spare = replay->spares;
    while (spare && spare->buffer.size - spare->used < room + SPARE_ALIGNMENT)
        spare = spare->next;
    if (!spare) {
        spare = capture_allocate(NULL, 1, sizeof(*spare));
        *spare = (struct spare){.next = replay->spares};
        replay->spares = spare;
        const VkDeviceSize whole = room + 2 * SPARE_ALIGNMENT;
        if (!driver_make_buffer(
                &replay->driver, whole > SPARE_SIZE ? whole : SPARE_SIZE,
                VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                    VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                &spare->buffer, replay->error))
            return NULL;
        spare->used = (SPARE_ALIGNMENT - spare->buffer.address % SPARE_ALIGNMENT) % SPARE_ALIGNMENT;
    }
    const VkDeviceSize at = spare->used;
    spare->used += room;
    *address = spare->buffer.address + at;
    return spare->buffer.memory.bytes + at;
}

static void reuse_spares(struct replay *replay)
{
    for (struct spare *spare = replay->spares; spare; spare = spare->next)
        spare->used = (SPARE_ALIGNMENT - spare->buffer.address % SPARE_ALIGNMENT) % SPARE_ALIGNMENT;
}

/* ---- memory and buffers */

static void note_use(struct replay *replay, uint32_t buffer, uint32_t command)
{
    if (buffer != CAPTURE_NONE && replay->capture->buffers[buffer].memory != CAPTURE_NONE)
        replay->memories[replay->capture->buffers[buffer].memory].last_use = command;
}

/* Finds the last command that needs each memory. That of structures stays. */
static void find_last_uses(struct replay *replay)
{
    const struct capture *capture = replay->capture;
    for (uint32_t i = 0; i < capture->command_count; i++) {
        const struct captured_command *command = &capture->commands[i];
        if (command->kind != CAPTURE_COMMAND_BUILD)
            continue;
        note_use(replay, command->scratch_buffer, i);
        for (uint32_t g = 0; g < command->geometry_count; g++)
            for (uint32_t n = 0; n < command->geometries[g].input_count; n++)
                note_use(replay, command->geometries[g].inputs[n].buffer, i);
    }
    for (uint32_t i = 0; i < capture->structure_count; i++)
        note_use(replay, capture->structures[i].buffer, CAPTURE_NONE);
}

static void find_extents(struct replay *replay)
{
    for (uint32_t i = 0; i < replay->capture->buffer_count; i++) {
        const struct captured_buffer *buffer = &replay->capture->buffers[i];
        const VkDeviceSize end = buffer->memory_offset + buffer->size;
        if (buffer->memory != CAPTURE_NONE && end > replay->memories[buffer->memory].extent)
            replay->memories[buffer->memory].extent = end;
    }
}

/* Usage that the device has without extensions but the one for acceleration structures. */
static VkBufferUsageFlags usage_of(const struct captured_buffer *buffer)
{
    const VkBufferUsageFlags known =
        0x1ff | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR;
    return ((VkBufferUsageFlags)buffer->usage & known) | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
}

/* Binds a buffer where it lay. Returns false if the device wants it elsewhere. */
static bool bind_in_memory(struct replay *replay, const struct captured_buffer *captured,
                           struct placed_buffer *buffer)
{
    struct driver *driver = &replay->driver;
    struct placed_memory *memory = &replay->memories[captured->memory];
    const VkDeviceSize offset = captured->memory_offset * replay->scale;
    VkMemoryRequirements requirements;
    driver->vk.GetBufferMemoryRequirements(driver->device, buffer->handle, &requirements);
    /* A buffer may need more bytes than it has. */
    const VkDeviceSize extent = memory->extent * replay->scale + requirements.alignment;
    if (!memory->memory.handle && !driver_allocate(driver, extent, requirements.memoryTypeBits,
                                                   &memory->memory, replay->error))
        return false;
    if (offset % requirements.alignment || offset + requirements.size > extent ||
        driver->vk.BindBufferMemory(driver->device, buffer->handle, memory->memory.handle,
                                    offset) != VK_SUCCESS)
        return false;
    buffer->bytes = memory->memory.bytes + offset;
    buffer->address = driver_buffer_address(driver, buffer->handle);
    return true;
}

/* Returns NULL, with an error, if there is no such buffer. */
static struct placed_buffer *place_buffer(struct replay *replay, uint32_t index)
{
    const struct captured_buffer *captured = &replay->capture->buffers[index];
    struct placed_buffer *buffer = &replay->buffers[index];
    struct driver *driver = &replay->driver;
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                     .size = captured->size * replay->scale,
                                     .usage = usage_of(captured)};
    if (buffer->handle)
        return buffer;
    const VkResult result = driver->vk.CreateBuffer(driver->device, &info, NULL, &buffer->handle);
    if (result != VK_SUCCESS) {
        driver_fail(replay->error, "vkCreateBuffer", result);
        return NULL;
    }
    if (captured->memory == CAPTURE_NONE || !bind_in_memory(replay, captured, buffer)) {
        driver->vk.DestroyBuffer(driver->device, buffer->handle, NULL);
        buffer->handle = VK_NULL_HANDLE;
        if (!driver_make_buffer(driver, info.size, info.usage, &buffer->own, replay->error))
            return NULL;
        *buffer = (struct placed_buffer){buffer->own.handle, buffer->own, buffer->own.memory.bytes,
                                         buffer->own.address};
    }
    name_object(replay, VK_OBJECT_TYPE_BUFFER, (uint64_t)buffer->handle, captured->name);
    return buffer;
}

static void remove_buffer(struct replay *replay, uint32_t index)
{
    struct placed_buffer *buffer = &replay->buffers[index];
    if (buffer->own.handle)
        driver_destroy_buffer(&replay->driver, &buffer->own);
    else
        replay->driver.vk.DestroyBuffer(replay->driver.device, buffer->handle, NULL);
    *buffer = (struct placed_buffer){0};
}

/* Frees memory that no later command needs, with its buffers. */
static void remove_memory_after(struct replay *replay, uint32_t command)
{
    for (uint32_t m = 0; m < replay->capture->memory_count; m++) {
        struct placed_memory *memory = &replay->memories[m];
        if (!memory->memory.handle || memory->last_use > command)
            continue;
        for (uint32_t i = 0; i < replay->capture->buffer_count; i++)
            if (replay->capture->buffers[i].memory == m)
                remove_buffer(replay, i);
        driver_free(&replay->driver, &memory->memory);
    }
}

/* ---- structures */

static VkAccelerationStructureTypeKHR type_of(enum capture_structure_type type)
{
    return type == CAPTURE_TOP      ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
           : type == CAPTURE_BOTTOM ? VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR
                                    : VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR;
}

/* Creates a structure of so many bytes where it lay, or elsewhere if there is no room. */
static bool create_structure(struct replay *replay, uint32_t index, VkDeviceSize least)
{
    const struct captured_structure *captured = &replay->capture->structures[index];
    struct placed_structure *structure = &replay->structures[index];
    struct driver *driver = &replay->driver;
    const VkDeviceSize size = captured->size * replay->scale;
    VkAccelerationStructureCreateInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR,
        .offset = captured->offset * replay->scale,
        .size = size > least ? size : least,
        .type = type_of(captured->type)};
    if (captured->buffer != CAPTURE_NONE && size >= least && !structure->is_kept) {
        const struct placed_buffer *buffer = place_buffer(replay, captured->buffer);
        if (!buffer)
            return false;
        info.buffer = buffer->handle;
    } else {
        info.offset = 0;
        if (!driver_make_buffer(driver, info.size,
                                VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR,
                                &structure->own, replay->error))
            return false;
        info.buffer = structure->own.handle;
    }
    const VkResult result =
        driver->vk.CreateAccelerationStructureKHR(driver->device, &info, NULL, &structure->handle);
    if (result != VK_SUCCESS)
        return driver_fail(replay->error, "vkCreateAccelerationStructureKHR", result);
    structure->address = driver->vk.GetAccelerationStructureDeviceAddressKHR(
        driver->device,
        &(VkAccelerationStructureDeviceAddressInfoKHR){
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR,
            .accelerationStructure = structure->handle});
    name_object(replay, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, (uint64_t)structure->handle,
                captured->name);
    return true;
}

static bool need_structure(struct replay *replay, uint32_t index, VkDeviceSize least)
{
    return replay->structures[index].handle || create_structure(replay, index, least);
}

static void destroy_structure(struct replay *replay, uint32_t index)
{
    struct placed_structure *structure = &replay->structures[index];
    replay->driver.vk.DestroyAccelerationStructureKHR(replay->driver.device, structure->handle,
                                                      NULL);
    structure->handle = VK_NULL_HANDLE; /* its address stays for instances that refer to it */
    if (structure->own.handle)
        driver_destroy_buffer(&replay->driver, &structure->own);
}

/* ---- the parameters of a build */

static VkFormat format_named(const char *name)
{
    for (int format = 0; name && format <= VK_FORMAT_ASTC_12x12_SRGB_BLOCK; format++)
        if (strcmp(string_VkFormat((VkFormat)format), name) == 0)
            return (VkFormat)format;
    return VK_FORMAT_UNDEFINED;
}

static VkIndexType index_type_named(const char *name)
{
    static const VkIndexType types[] = {VK_INDEX_TYPE_UINT16, VK_INDEX_TYPE_UINT32,
                                        VK_INDEX_TYPE_UINT8_KHR, VK_INDEX_TYPE_NONE_KHR};
    for (size_t i = 0; name && i < sizeof(types) / sizeof(types[0]); i++)
        if (strcmp(string_VkIndexType(types[i]), name) == 0)
            return types[i];
    return VK_INDEX_TYPE_NONE_KHR;
}

/* Where the bytes from an address on lie, so far as the capture says it; otherwise in spare memory.
 * Returns NULL, with an error, without memory. */
static unsigned char *place_input(struct replay *replay, const struct captured_command *build,
                                  const struct captured_input *input, uint64_t size,
                                  VkDeviceAddress *address)
{
    if (input->buffer != CAPTURE_NONE && !build->kept) {
        const struct placed_buffer *buffer = place_buffer(replay, input->buffer);
        const uint64_t offset = input->offset * replay->scale,
                       room = replay->capture->buffers[input->buffer].size * replay->scale;
        if (!buffer)
            return NULL;
        *address = buffer->address + offset;
        if (offset <= room && input->first <= room - offset && size <= room - offset - input->first)
            return buffer->bytes + offset + input->first;
    }
    /* The address itself must be in a buffer, too. */
    unsigned char *bytes = take_spare(replay, input->first + size, address);
    return bytes ? bytes + input->first : NULL;
}

/* Replaces references by those of the replayed structures. */
static void refer(const struct replay *replay, const struct captured_command *build,
                  VkAccelerationStructureInstanceKHR *instance)
{
    const struct captured_reference *reference =
        capture_reference_of(build, instance->accelerationStructureReference);
    if (reference && reference->structure != CAPTURE_NONE)
        instance->accelerationStructureReference = replay->structures[reference->structure].address;
}

/* Instances, or the pointers to them, which lie in spare memory then. */
static bool write_instances(struct replay *replay, const struct captured_command *build,
                            bool has_pointers, const unsigned char *rows, uint64_t count,
                            unsigned char *to)
{
    const uint64_t size = sizeof(VkAccelerationStructureInstanceKHR);
    VkDeviceAddress address = 0;
    unsigned char *elements = has_pointers ? take_spare(replay, count * size, &address) : to;
    if (!elements)
        return false;
    for (uint64_t i = 0; i < count; i++) {
        VkAccelerationStructureInstanceKHR instance;
        memcpy(&instance, rows + i * size, size);
        refer(replay, build, &instance);
        memcpy(elements + i * size, &instance, size);
        const VkDeviceAddress pointer = address + i * size;
        if (has_pointers)
            memcpy(to + i * sizeof(pointer), &pointer, sizeof(pointer));
    }
    return true;
}

/* Writes the data of an input where the build reads it, and finds the address. Returns false, with
 * an error, if that fails. */
static bool write_input(struct replay *replay, const struct captured_command *build,
                        const struct captured_geometry *geometry,
                        const struct captured_input *input, VkDeviceAddress *address)
{
    const struct captured_data *data = &replay->capture->data[input->data];
    const unsigned char *rows = capture_load_data(replay->capture, input->data, replay->error);
    const uint64_t count = data->rows,
                   size = (count - 1) * input->stride +
                          (geometry->array_of_pointers ? sizeof(uint64_t) : data->row_size);
    if (!rows)
        return false;
    unsigned char *to = place_input(replay, build, input, size, address);
    if (!to)
        return false;
    if (input->role == CAPTURE_INSTANCE_ROWS)
        return write_instances(replay, build, geometry->array_of_pointers, rows, count, to);
    for (uint64_t i = 0; i < count; i++)
        memcpy(to + i * input->stride, rows + i * data->row_size, data->row_size);
    return true;
}

static VkDeviceOrHostAddressConstKHR *address_of(VkAccelerationStructureGeometryKHR *geometry,
                                                 enum capture_role role)
{
    switch (role) {
    case CAPTURE_VERTICES:
        return &geometry->geometry.triangles.vertexData;
    case CAPTURE_INDICES:
        return &geometry->geometry.triangles.indexData;
    case CAPTURE_TRANSFORM:
        return &geometry->geometry.triangles.transformData;
    case CAPTURE_BOXES:
        return &geometry->geometry.aabbs.data;
    case CAPTURE_INSTANCE_ROWS:
        return &geometry->geometry.instances.data;
    default:
        return NULL;
    }
}

static VkAccelerationStructureGeometryKHR shape_of(const struct captured_geometry *captured)
{
    VkAccelerationStructureGeometryKHR geometry = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR, .flags = captured->flags};
    if (captured->type == CAPTURE_TRIANGLES) {
        geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
        geometry.geometry.triangles = (VkAccelerationStructureGeometryTrianglesDataKHR){
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR,
            .vertexFormat = format_named(captured->vertex_format),
            .vertexStride = captured->vertex_stride,
            .maxVertex = captured->max_vertex,
            .indexType = index_type_named(captured->index_type)};
    } else if (captured->type == CAPTURE_AABBS) {
        geometry.geometryType = VK_GEOMETRY_TYPE_AABBS_KHR;
        geometry.geometry.aabbs = (VkAccelerationStructureGeometryAabbsDataKHR){
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR,
            .stride = captured->stride};
    } else {
        geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
        geometry.geometry.instances = (VkAccelerationStructureGeometryInstancesDataKHR){
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR,
            .arrayOfPointers = captured->array_of_pointers};
    }
    return geometry;
}

static bool uses_layer(const struct replay *replay)
{
    return replay->options->uses_layer || replay->options->compares;
}

/* The application has made a mistake, or the capture has begun later. */
static bool lacks_source(const struct captured_command *build)
{
    return build->mode == CAPTURE_UPDATE && build->src == CAPTURE_NONE;
}

/* Under the layer, builds that need what the application never built are replayed: it finds
 * mistakes in them. */
static bool is_unusable(const struct replay *replay, uint32_t structure)
{
    return structure != CAPTURE_NONE && !replay->structures[structure].is_built &&
           (replay->structures[structure].is_left_out || !uses_layer(replay));
}

static bool needs_unbuilt(const struct replay *replay, const struct captured_command *build)
{
    if (build->mode == CAPTURE_UPDATE && is_unusable(replay, build->src))
        return true;
    for (uint32_t i = 0; i < build->reference_count; i++)
        if (is_unusable(replay, build->references[i].structure))
            return true;
    return false;
}

/* Returns why a build cannot be replayed, or NULL. */
static const char *find_obstacle(const struct replay *replay, const struct captured_command *build)
{
    if (build->dst == CAPTURE_NONE)
        return "its structure is not in the capture";
    if (lacks_source(build) && !uses_layer(replay))
        return "the structure that it updates is not in the capture";
    if (build->missing && !build->geometry_count)
        return build->missing;
    if (build->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV)
        return "motion is not replayed";
    for (uint32_t i = 0; i < build->geometry_count; i++) {
        const struct captured_geometry *geometry = &build->geometries[i];
        if (geometry->type != CAPTURE_TRIANGLES && geometry->type != CAPTURE_AABBS &&
            geometry->type != CAPTURE_INSTANCES)
            return "geometries of this type are not replayed";
        for (uint32_t n = 0; n < geometry->input_count; n++) {
            VkAccelerationStructureGeometryKHR unused = {0};
            if (!address_of(&unused, geometry->inputs[n].role))
                return "micromaps are not replayed";
            if (geometry->inputs[n].data == CAPTURE_NONE)
                return "a part of its data is not in the capture";
        }
    }
    return NULL;
}

/* One build of a call. */
struct replayed_build {
    const struct captured_command *command;
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureGeometryKHR *geometries; /* owned, as `ranges` is */
    VkAccelerationStructureBuildRangeInfoKHR *ranges;
};

static void describe_build(struct replayed_build *build, const struct captured_command *command)
{
    const uint32_t count = command->geometry_count;
    *build = (struct replayed_build){.command = command};
    build->geometries = capture_allocate(NULL, count + 1ull, sizeof(*build->geometries));
    build->ranges = capture_allocate(NULL, count + 1ull, sizeof(*build->ranges));
    build->info = (VkAccelerationStructureBuildGeometryInfoKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
        .type = type_of(command->type),
        .flags = command->flags,
        .mode = command->mode == CAPTURE_UPDATE ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                                                : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
        .geometryCount = count,
        .pGeometries = build->geometries};
    for (uint32_t i = 0; i < count; i++) {
        const struct captured_geometry *geometry = &command->geometries[i];
        build->geometries[i] = shape_of(geometry);
        build->ranges[i] = (VkAccelerationStructureBuildRangeInfoKHR){
            geometry->primitive_count, geometry->primitive_offset, geometry->first_vertex,
            geometry->transform_offset};
    }
}

static void free_build(const struct replayed_build *build)
{
    free(build->geometries);
    free(build->ranges);
}

static VkAccelerationStructureBuildSizesInfoKHR sizes_of(const struct replay *replay,
                                                         const struct replayed_build *build)
{
    VkAccelerationStructureBuildSizesInfoKHR sizes = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    const uint32_t count = build->info.geometryCount;
    uint32_t *counts = capture_allocate(NULL, count + 1ull, sizeof(*counts));
    for (uint32_t i = 0; i < count; i++)
        counts[i] = build->ranges[i].primitiveCount;
    replay->driver.vk.GetAccelerationStructureBuildSizesKHR(
        replay->driver.device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &build->info,
        counts, &sizes);
    free(counts);
    return sizes;
}

/* On the driver of the capture scratch memory stays where it was, right or wrong. Where another
 * driver needs more, that of the next build may begin too early. */
static bool place_scratch(struct replay *replay, struct replayed_build *build)
{
    const struct captured_command *command = build->command;
    VkDeviceAddress *address = &build->info.scratchData.deviceAddress;
    const bool has_place = command->scratch_buffer != CAPTURE_NONE && !command->kept;
    if (has_place) {
        const struct placed_buffer *buffer = place_buffer(replay, command->scratch_buffer);
        if (!buffer)
            return false;
        *address = buffer->address + command->scratch_offset * replay->scale;
        if (replay->is_same_driver)
            return true;
    }
    const VkAccelerationStructureBuildSizesInfoKHR sizes = sizes_of(replay, build);
    const VkDeviceSize size =
        command->mode == CAPTURE_UPDATE ? sizes.updateScratchSize : sizes.buildScratchSize;
    if (has_place && *address % replay->driver.scratch_alignment == 0 &&
        size <= command->scratch_size * replay->scale)
        return true;
    return take_spare(replay, size + 1, address);
}

/* Makes all that a build needs. */
static bool prepare_build(struct replay *replay, struct replayed_build *build)
{
    const struct captured_command *command = build->command;
    if (!need_structure(replay, command->dst, 0) ||
        (command->src != CAPTURE_NONE && !need_structure(replay, command->src, 0)))
        return false;
    replay->has_bad_build |= lacks_source(command);
    for (uint32_t i = 0; i < command->reference_count; i++) {
        const uint32_t structure = command->references[i].structure;
        if (structure != CAPTURE_NONE && !replay->structures[structure].address &&
            !need_structure(replay, structure, 0))
            return false;
    }
    build->info.dstAccelerationStructure = replay->structures[command->dst].handle;
    if (command->src != CAPTURE_NONE)
        build->info.srcAccelerationStructure = replay->structures[command->src].handle;
    for (uint32_t i = 0; i < command->geometry_count; i++)
        for (uint32_t n = 0; n < command->geometries[i].input_count; n++) {
            const struct captured_input *input = &command->geometries[i].inputs[n];
            VkDeviceAddress address;
            if (!write_input(replay, command, &command->geometries[i], input, &address))
                return false;
            address_of(&build->geometries[i], input->role)->deviceAddress = address;
        }
    return place_scratch(replay, build);
}

/* ---- commands */

static int compare_times(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Records, executes and measures one call. Returns its time in microseconds. */
static bool run_call(struct replay *replay, uint32_t count,
                     const VkAccelerationStructureBuildGeometryInfoKHR *infos,
                     const VkAccelerationStructureBuildRangeInfoKHR *const *ranges, double *time)
{
    struct driver *driver = &replay->driver;
    const bool is_timed = replay->options->shows_times && driver->times;
    if (!driver_begin(driver, replay->error))
        return false;
    if (is_timed)
        driver_begin_time(driver);
    driver_order_all(driver);
    driver->vk.CmdBuildAccelerationStructuresKHR(driver->commands, count, infos, ranges);
    driver_order_all(driver);
    if (is_timed)
        driver_end_time(driver);
    if (!driver_run(driver, replay->error))
        return false;
    *time = is_timed ? driver_read_time(driver) / 1000 : 0;
    return true;
}

static void print_time(const struct replay *replay, const struct replayed_build *builds,
                       uint32_t count, double *times, uint32_t time_count)
{
    uint64_t primitives = 0;
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t g = 0; g < builds[i].info.geometryCount; g++)
            primitives += builds[i].ranges[g].primitiveCount;
    const char *name = replay->capture->structures[builds[0].command->dst].name;
    qsort(times, time_count, sizeof(*times), compare_times);
    printf("%8" PRIu64 "  %6" PRIu32 "  %10" PRIu64 "  %12.1f  %12.1f  %s\n", builds[0].command->n,
           count, primitives, times[0], times[time_count / 2], name ? name : "");
}

static bool run_builds(struct replay *replay, const struct replayed_build *builds, uint32_t count)
{
    const uint32_t repeat = replay->options->repeat ? replay->options->repeat : 1;
    VkAccelerationStructureBuildGeometryInfoKHR *infos =
        capture_allocate(NULL, count, sizeof(*infos));
    const VkAccelerationStructureBuildRangeInfoKHR **ranges =
        capture_allocate(NULL, count, sizeof(*ranges));
    double *times = capture_allocate(NULL, repeat, sizeof(*times));
    bool is_done = true;
    for (uint32_t i = 0; i < count; i++) {
        infos[i] = builds[i].info;
        ranges[i] = builds[i].ranges;
    }
    for (uint32_t i = 0; i < repeat && is_done; i++)
        is_done = run_call(replay, count, infos, ranges, &times[i]);
    if (is_done && replay->options->shows_times)
        print_time(replay, builds, count, times, repeat);
    for (uint32_t i = 0; i < count && is_done; i++, replay->built++)
        replay->structures[builds[i].command->dst].is_built = true;
    free(infos);
    free((void *)ranges);
    free(times);
    return is_done;
}

/* Replays the builds of one call, which follow each other. Returns false, with an error, if one
 * fails. */
static bool replay_call(struct replay *replay, uint32_t begin, uint32_t end)
{
    struct replayed_build *builds = capture_allocate(NULL, end - begin, sizeof(*builds));
    uint32_t count = 0;
    bool is_ready = true;
    for (uint32_t i = begin; i < end && is_ready; i++) {
        const struct captured_command *command = &replay->capture->commands[i];
        const char *obstacle = find_obstacle(replay, command);
        if (!obstacle && needs_unbuilt(replay, command))
            obstacle = "it needs structures that were not built in the capture";
        if (obstacle) {
            skip(replay, command, obstacle);
            continue;
        }
        describe_build(&builds[count], command);
        is_ready = prepare_build(replay, &builds[count++]);
    }
    const bool is_done = is_ready && (!count || run_builds(replay, builds, count));
    for (uint32_t i = 0; i < count; i++)
        free_build(&builds[i]);
    free(builds);
    replay->has_bad_build = false;
    reuse_spares(replay);
    remove_memory_after(replay, end - 1);
    return is_done;
}

/* Queries a size of a structure. */
static bool query_size(struct replay *replay, VkAccelerationStructureKHR structure,
                       VkQueryType type, VkDeviceSize *size)
{
    struct driver *driver = &replay->driver;
    const VkQueryPoolCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, .queryType = type, .queryCount = 1};
    VkQueryPool pool;
    VkResult result = driver->vk.CreateQueryPool(driver->device, &info, NULL, &pool);
    if (result != VK_SUCCESS)
        return driver_fail(replay->error, "vkCreateQueryPool", result);
    bool is_done = driver_begin(driver, replay->error);
    if (is_done) {
        driver->vk.CmdResetQueryPool(driver->commands, pool, 0, 1);
        driver->vk.CmdWriteAccelerationStructuresPropertiesKHR(driver->commands, 1, &structure,
                                                               type, pool, 0);
        is_done = driver_run(driver, replay->error);
    }
    if (is_done) {
        result = driver->vk.GetQueryPoolResults(driver->device, pool, 0, 1, sizeof(*size), size,
                                                sizeof(*size),
                                                VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
        is_done =
            result == VK_SUCCESS || driver_fail(replay->error, "vkGetQueryPoolResults", result);
    }
    driver->vk.DestroyQueryPool(driver->device, pool, NULL);
    return is_done;
}

static bool replay_copy(struct replay *replay, const struct captured_command *command)
{
    struct driver *driver = &replay->driver;
    const bool compacts = command->mode == CAPTURE_COMPACT;
    VkDeviceSize least = 0;
    if (command->dst == CAPTURE_NONE || command->src == CAPTURE_NONE ||
        (!compacts && command->mode != CAPTURE_CLONE) ||
        !replay->structures[command->src].is_built) {
        skip(replay, command, "its source was not built in the capture");
        return true;
    }
    const VkAccelerationStructureKHR src = replay->structures[command->src].handle;
    if (compacts && !replay->is_same_driver &&
        !query_size(replay, src, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, &least))
        return false;
    if (!need_structure(replay, command->dst, least) || !driver_begin(driver, replay->error))
        return false;
    const VkCopyAccelerationStructureInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR,
        .src = src,
        .dst = replay->structures[command->dst].handle,
        .mode = compacts ? VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR
                         : VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR};
    driver->vk.CmdCopyAccelerationStructureKHR(driver->commands, &info);
    replay->copied++;
    replay->structures[command->dst].is_built = true;
    return driver_run(driver, replay->error);
}

static bool replay_query(struct replay *replay, const struct captured_command *command)
{
    VkDeviceSize size;
    if (command->src == CAPTURE_NONE || !replay->structures[command->src].handle || !command->query)
        return true;
    const bool compacts = strstr(command->query, "COMPACTED_SIZE");
    if (!compacts && !strstr(command->query, "SERIALIZATION_SIZE"))
        return true;
    return query_size(replay, replay->structures[command->src].handle,
                      compacts ? VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR
                               : VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR,
                      &size);
}

/* ---- what was built, as bytes */

static bool dump_structure(struct replay *replay, uint32_t index)
{
    struct driver *driver = &replay->driver;
    const VkAccelerationStructureKHR structure = replay->structures[index].handle;
    VkDeviceSize size;
    VkDeviceAddress address;
    char path[4096];
    if (!query_size(replay, structure, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR,
                    &size))
        return false;
    const unsigned char *bytes = take_spare(replay, size, &address);
    if (!bytes || !driver_begin(driver, replay->error))
        return false;
    driver->vk.CmdCopyAccelerationStructureToMemoryKHR(
        driver->commands,
        &(VkCopyAccelerationStructureToMemoryInfoKHR){
            .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_TO_MEMORY_INFO_KHR,
            .src = structure,
            .dst.deviceAddress = address,
            .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR});
    if (!driver_run(driver, replay->error))
        return false;
    snprintf(path, sizeof(path), "%s/%" PRIu64 ".bin", replay->options->dump,
             replay->capture->structures[index].id);
    FILE *file = fopen(path, "wb");
    const bool is_written = file && fwrite(bytes, 1, size, file) == size;
    const bool is_closed = file && fclose(file) == 0;
    if (!is_written || !is_closed)
        snprintf(replay->error->text, sizeof(replay->error->text), "%.512s: %s", path,
                 strerror(errno));
    reuse_spares(replay);
    return is_written && is_closed;
}

static bool replay_destruction(struct replay *replay, uint32_t structure)
{
    if (structure == CAPTURE_NONE || !replay->structures[structure].handle)
        return true;
    if (replay->options->dump && !dump_structure(replay, structure))
        return false;
    destroy_structure(replay, structure);
    return true;
}

static bool replay_commands(struct replay *replay)
{
    const struct capture *capture = replay->capture;
    bool is_done = true;
    for (uint32_t i = 0, end; i < capture->command_count && is_done; i = end) {
        const struct captured_command *command = &capture->commands[i];
        end = i + 1;
        if (command->kind == CAPTURE_COMMAND_BUILD) {
            while (end < capture->command_count && end - i < CALL_BUILDS && command->call &&
                   capture->commands[end].kind == CAPTURE_COMMAND_BUILD &&
                   capture->commands[end].call == command->call)
                end++;
            is_done = replay_call(replay, i, end);
        } else if (command->kind == CAPTURE_COMMAND_COPY) {
            is_done = replay_copy(replay, command);
        } else if (command->kind == CAPTURE_COMMAND_QUERY) {
            is_done = replay_query(replay, command);
        } else if (command->kind == CAPTURE_DESTROYED) {
            is_done = replay_destruction(replay, command->dst);
        }
        if (!is_done) {
            char text[CAPTURE_ERROR_SIZE];
            snprintf(text, sizeof(text), "line with n = %" PRIu64 ": %.*s", command->n,
                     CAPTURE_ERROR_SIZE - 64, replay->error->text);
            memcpy(replay->error->text, text, sizeof(text));
        }
    }
    return is_done;
}

/* ---- sizes */

static uint64_t times_needed(VkDeviceSize needed, VkDeviceSize given)
{
    return given ? (needed + given - 1) / given : 1;
}

/* Another driver may need more memory: finds by how much all of it grows. */
static void find_scale(struct replay *replay)
{
    const struct capture *capture = replay->capture;
    for (uint32_t i = 0; i < capture->command_count && !replay->is_same_driver; i++) {
        const struct captured_command *command = &capture->commands[i];
        if (command->kind != CAPTURE_COMMAND_BUILD || find_obstacle(replay, command))
            continue;
        struct replayed_build build;
        describe_build(&build, command);
        const VkAccelerationStructureBuildSizesInfoKHR sizes = sizes_of(replay, &build);
        const uint64_t scale =
            times_needed(sizes.accelerationStructureSize, capture->structures[command->dst].size);
        if (scale > replay->scale)
            replay->scale = scale;
        free_build(&build);
    }
}

static bool is_driver_of(const struct capture *capture, const struct driver *driver)
{
    const struct captured_device *device = capture->device_count ? &capture->devices[0] : NULL;
    return device && device->name && device->driver_info &&
           strcmp(device->name, driver->properties.deviceName) == 0 &&
           strcmp(device->driver_info, driver->driver.driverInfo) == 0;
}

static bool make_dump_folder(const struct replay_options *options, struct capture_error *error)
{
    const int number = options->dump ? file_make_folder(options->dump) : 0;
    if (number)
        snprintf(error->text, sizeof(error->text), "%.512s: %s", options->dump, strerror(number));
    return !number;
}

static bool dump_all(struct replay *replay)
{
    bool is_done = true;
    for (uint32_t i = 0; i < replay->capture->structure_count && is_done; i++)
        if (replay->structures[i].handle)
            is_done = dump_structure(replay, i);
    return is_done;
}

/* ---- all of it */

static void close_replay(struct replay *replay)
{
    for (uint32_t i = 0; replay->driver.device && i < replay->capture->structure_count; i++)
        destroy_structure(replay, i);
    for (uint32_t i = 0; replay->driver.device && i < replay->capture->buffer_count; i++)
        remove_buffer(replay, i);
    for (uint32_t i = 0; replay->driver.device && i < replay->capture->memory_count; i++)
        driver_free(&replay->driver, &replay->memories[i].memory);
    while (replay->spares) {
        struct spare *spare = replay->spares;
        replay->spares = spare->next;
        driver_destroy_buffer(&replay->driver, &spare->buffer);
        free(spare);
    }
    driver_close(&replay->driver);
    free(replay->memories);
    free(replay->buffers);
    free(replay->structures);
}

static void *zeros(size_t count, size_t size)
{
    void *memory = capture_allocate(NULL, count + 1, size);
    memset(memory, 0, (count + 1) * size);
    return memory;
}

/* The layer checks data, and compares hits with the reference builder. */
static void set_layer(const struct replay_options *options)
{
    setenv("VK_ASSAY_VALIDATION_LEVEL", "content", 0);
    setenv("VK_ASSAY_VALIDATION_GUARD", "references", 0); /* a wild one may crash the driver */
    setenv("VK_ASSAY_VALIDATION_HAZARDS", "false", 0);    /* the replay has barriers of its own */
    setenv("VK_ASSAY_VALIDATION_DEBUG_ACTION", "callback", 0);
    setenv("VK_ASSAY_VALIDATION_ENABLE_MESSAGE_LIMIT", "false", 0);
    if (options->compares)
        setenv("VK_ASSAY_VALIDATION_COMPARE_RAYS", "1000", 0);
}

bool replay_capture(struct capture *capture, const struct replay_options *options,
                    struct capture_error *error)
{
    struct replay replay = {
        .capture = capture,
        .options = options,
        .error = error,
        .scale = 1,
        .memories = zeros(capture->memory_count, sizeof(*replay.memories)),
        .buffers = zeros(capture->buffer_count, sizeof(*replay.buffers)),
        .structures = zeros(capture->structure_count, sizeof(*replay.structures)),
    };
    const bool has_layer = uses_layer(&replay);
    if (has_layer)
        set_layer(options);
    find_last_uses(&replay);
    find_extents(&replay);
    for (uint32_t i = 0; i < capture->command_count; i++)
        if (capture->commands[i].kept && capture->commands[i].dst != CAPTURE_NONE)
            replay.structures[capture->commands[i].dst].is_kept = true;
    for (uint32_t i = 0; i < capture->structure_count; i++)
        replay.structures[i].is_left_out = capture->structures[i].missing;
    bool is_done = make_dump_folder(options, error) &&
                   driver_open(&replay.driver, has_layer, on_message, &replay, error);
    if (is_done) {
        replay.is_same_driver = is_driver_of(capture, &replay.driver);
        find_scale(&replay);
        printf("device: %s, %s\n", replay.driver.properties.deviceName,
               replay.driver.driver.driverInfo);
        if (replay.scale > 1)
            printf("memory: %" PRIu64 " times as large as captured\n", replay.scale);
        if (options->shows_times)
            printf("%8s  %6s  %10s  %12s  %12s  %s\n", "n", "builds", "primitives", "least us",
                   "median us", "name");
        is_done = replay_commands(&replay) && (!options->dump || dump_all(&replay));
    }
    close_replay(&replay);
    print_skipped(&replay);
    if (is_done)
        printf("built: %" PRIu32 "; copied: %" PRIu32 "; not replayed: %" PRIu32 "%s", replay.built,
               replay.copied, replay.skipped, has_layer ? "" : "\n");
    if (is_done && has_layer)
        printf("; findings: %" PRIu32 "\n", replay.findings);
    if (is_done && replay.skipped)
        snprintf(error->text, sizeof(error->text), "%" PRIu32 " commands were not replayed",
                 replay.skipped);
    return is_done && !replay.skipped;
}
