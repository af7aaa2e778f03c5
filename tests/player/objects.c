/* SPDX-License-Identifier: Apache-2.0 */
/* Objects of programs. */
#include "tests/player/play.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BUFFER_USAGE                                                                               \
    (VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |                         \
     VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |                    \
     VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |                                                   \
     VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |                        \
     VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR)
#define HOST_BUFFER_USAGE                                                                          \
    (VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |                \
     VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR)
#define MICROMAP_USAGE                                                                             \
    (VK_BUFFER_USAGE_MICROMAP_BUILD_INPUT_READ_ONLY_BIT_EXT |                                      \
     VK_BUFFER_USAGE_MICROMAP_STORAGE_BIT_EXT)

static const VkExtent3D image_extent = {4, 4, 1};

uint64_t play_number(const struct play *play, const char *word)
{
    PLAY_REQUIRE(play, word != NULL);
    return play_is(word, "size") ? play->last_size : strtoull(word, NULL, 0);
}

uint64_t play_words_value(const struct play *play, const char *names, const struct play_word *words,
                          size_t count)
{
    uint64_t value = 0;
    for (;;) {
        const size_t length = strcspn(names, "|:");
        size_t i = 0;
        while (i < count &&
               (strlen(words[i].name) != length || strncmp(words[i].name, names, length) != 0))
            i++;
        if (i == count)
            play_fail(play, names);
        value |= words[i].value;
        if (names[length] != '|')
            return value;
        names += length + 1;
    }
}

bool play_set_member(void *structure, const struct play_member *members, size_t count,
                     const char *name, uint64_t value)
{
    size_t i = 0;
    while (i < count && strcmp(members[i].name, name) != 0)
        i++;
    if (i < count)
        memcpy((char *)structure + members[i].offset, &value, members[i].size);
    return i < count;
}

/* ---- creation */

static void name_object(const struct play *play, VkObjectType type, uint64_t handle,
                        const char *name)
{
    const STRUCT(VkDebugUtilsObjectNameInfoEXT, info, .objectType = type, .objectHandle = handle,
                 .pObjectName = name);
    play->vk.SetDebugUtilsObjectNameEXT(play->device, &info);
}

VkBufferCreateInfo play_buffer_info(const struct play *play, VkDeviceSize size)
{
    return MAKE(VkBufferCreateInfo, .size = size,
                .usage = BUFFER_USAGE |
                         (play_has(play, "VK_EXT_opacity_micromap") ? MICROMAP_USAGE : 0) |
                         (play->is_nv ? VK_BUFFER_USAGE_RAY_TRACING_BIT_NV : 0));
}

void play_create_buffer(struct play *play, struct play_object *object)
{
    VkBufferCreateInfo info =
        play_buffer_info(play, object->name[0] == 'W' ? PLAY_LARGE_SIZE : PLAY_BUFFER_SIZE);
    const STRUCT(VkBufferUsageFlags2CreateInfo, flags,
                 .usage = info.usage | VK_BUFFER_USAGE_2_COMPRESSED_DATA_DGF1_BIT_AMDX);
    if (object->name[0] == 'H')
        info.usage = HOST_BUFFER_USAGE;
    else if (play_has(play, "VK_AMDX_dense_geometry_format"))
        info.pNext = &flags;
    object->buffer = (object->name[0] == 'U' ? buffer_create_unmapped : buffer_create)(
        &play->vk, play->device, play->memory_type, &info);
    name_object(play, VK_OBJECT_TYPE_BUFFER, (uint64_t)object->buffer.handle, object->name);
}

void play_create_structure(struct play *play, struct play_object *object, VkBuffer buffer,
                           VkDeviceSize offset, VkDeviceSize size,
                           VkAccelerationStructureTypeKHR type)
{
    const bool moves = play_has(play, "VK_NV_ray_tracing_motion_blur");
    const STRUCT(VkAccelerationStructureMotionInfoNV, motion, .maxInstances = PLAY_ITEMS);
    const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .pNext = moves ? &motion : NULL,
                 .createFlags = moves ? VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV : 0,
                 .buffer = buffer, .offset = offset, .size = size, .type = type);
    object->is_ghost = false;
    play_note(play, play->vk.CreateAccelerationStructureKHR(play->device, &info, NULL,
                                                            &object->structure));
    if (object->structure)
        name_object(play, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, (uint64_t)object->structure,
                    object->name);
}

VkMicromapTypeEXT play_micromap_type(const struct play *play)
{
    return play_has(play, "VK_NV_displacement_micromap") ? VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV
                                                         : VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT;
}

static void create_micromap(struct play *play, struct play_object *object, VkBuffer buffer,
                            VkDeviceSize offset, VkDeviceSize size)
{
    const STRUCT(VkMicromapCreateInfoEXT, info, .buffer = buffer, .offset = offset, .size = size,
                 .type = play_micromap_type(play));
    GET(play->vk.CreateMicromapEXT(play->device, &info, NULL, &object->micromap));
    name_object(play, VK_OBJECT_TYPE_MICROMAP_EXT, (uint64_t)object->micromap, object->name);
}

static VkAccelerationStructureTypeKHR type_of(const struct play *play,
                                              const struct play_object *object)
{
    return object->name[0] == 'T' ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                                  : play->bottom_type;
}

static void create_image(struct play *play, struct play_object *object)
{
    const STRUCT(
        VkImageCreateInfo, info, .imageType = VK_IMAGE_TYPE_2D,
        .format = object->name[1] == 'C' ? VK_FORMAT_BC1_RGB_UNORM_BLOCK : VK_FORMAT_R8G8B8A8_UNORM,
        .extent = image_extent, .mipLevels = 1, .arrayLayers = 1, .samples = VK_SAMPLE_COUNT_1_BIT,
        .usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT);
    VkMemoryRequirements requirements;
    GET(play->vk.CreateImage(play->device, &info, NULL, &object->image));
    play->vk.GetImageMemoryRequirements(play->device, object->image, &requirements);
    object->buffer.memory =
        memory_create(&play->vk, play->device, play->memory_type, requirements.size);
    GET(play->vk.BindImageMemory(play->device, object->image, object->buffer.memory, 0));
}

static struct play_object *find(struct play *play, const char *name)
{
    for (unsigned i = 0; i < play->object_count; i++)
        if (strcmp(play->objects[i].name, name) == 0)
            return &play->objects[i];
    return NULL;
}

static struct play_object *add(struct play *play, const char *name)
{
    PLAY_REQUIRE(play, play->object_count < PLAY_OBJECTS);
    struct play_object *object = &play->objects[play->object_count++];
    *object = (struct play_object){.queue = 0};
    snprintf(object->name, sizeof(object->name), "%s", name);
    return object;
}

VkQueryPool play_create_queries(const struct play *play, const char *name)
{
    const VkQueryType type =
        name[1] == 'M'   ? VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT
        : name[1] == 'C' ? VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT
        : name[1] == 'N' ? VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV
        : name[1] == 'O' ? VK_QUERY_TYPE_OCCLUSION
        : name[1] == 'T' ? VK_QUERY_TYPE_TIMESTAMP
                         : VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
    const VkQueryPool pool = query_pool_create(&play->vk, play->device, type, 3);
    name_object(play, VK_OBJECT_TYPE_QUERY_POOL, (uint64_t)pool, name);
    return pool;
}

/* Programs deserialize data that they have not serialized: these are data of the null driver. */
static void write_serialized(const struct play_object *object)
{
    memcpy(object->buffer.bytes, &NULL_DRIVER_SERIALIZED, sizeof(NULL_DRIVER_SERIALIZED));
}

static void create(struct play *play, struct play_object *object)
{
    switch (object->name[0]) {
    case 'B':
    case 'T':
        if (play->is_nv) {
            play_create_nv(play, object, 0);
            break;
        }
        play_create_buffer(play, object);
        play_create_structure(play, object, object->buffer.handle, 0, PLAY_STRUCTURE_SIZE,
                              type_of(play, object));
        break;
    case 'M':
        play_create_buffer(play, object);
        create_micromap(play, object, object->buffer.handle, 0, PLAY_STRUCTURE_SIZE);
        break;
    case 'E':
        GET(play->vk.CreateEvent(play->device, &MAKE(VkEventCreateInfo), NULL, &object->event));
        break;
    case 'F':
        create_image(play, object);
        break;
    case 'P':
        object->queries = play_create_queries(play, object->name);
        play->vk.ResetQueryPool(play->device, object->queries, 0, 1);
        break;
    case 'c':
        break; /* `begin` says more of it */
    case 'd':
        GET(play->vk.CreateDeferredOperationKHR(play->device, NULL, &object->operation));
        break;
    case 's':
        GET(play->vk.CreateSemaphore(play->device, &MAKE(VkSemaphoreCreateInfo), NULL,
                                     &object->semaphore));
        break;
    case 't':
        object->semaphore = timeline_create(&play->vk, play->device);
        break;
    default:
        PLAY_REQUIRE(play, object->name[0] >= 'A' && object->name[0] <= 'Z');
        play_create_buffer(play, object);
        if (object->name[0] == 'D' && play->platform->null_driver.configure &&
            !play->platform->is_cpu)
            write_serialized(object);
    }
}

struct play_object *play_object(struct play *play, const char *name)
{
    PLAY_REQUIRE(play, name && strlen(name) < sizeof(play->objects[0].name));
    struct play_object *object = find(play, name);
    if (!object)
        create(play, object = add(play, name));
    return object;
}

struct play_object *play_place(struct play *play, const char *word, VkDeviceSize *offset)
{
    char name[sizeof(play->objects[0].name) + 1];
    PLAY_REQUIRE(play, word != NULL);
    size_t length = strcspn(word, "+");
    snprintf(name, sizeof(name), "%.*s", (int)length, word);
    *offset = word[length] ? strtoull(word + length + 1, NULL, 0) : 0;
    return play_object(play, name);
}

VkDeviceOrHostAddressKHR play_address_in(const struct device_buffer *buffer, VkDeviceSize offset,
                                         bool is_host)
{
    if (is_host)
        return (VkDeviceOrHostAddressKHR){.deviceAddress = (uintptr_t)buffer->bytes + offset};
    return (VkDeviceOrHostAddressKHR){.deviceAddress = buffer->address + offset};
}

VkDeviceOrHostAddressKHR play_address_for(struct play *play, const char *word, bool is_host)
{
    VkDeviceSize offset;
    if (word && word[0] == '@')
        return (VkDeviceOrHostAddressKHR){.deviceAddress = play_number(play, word + 1)};
    const struct play_object *object = play_place(play, word, &offset);
    return play_address_in(&object->buffer, offset, is_host);
}

VkDeviceAddress play_address(struct play *play, const char *word)
{
    return play_address_for(play, word, false).deviceAddress;
}

/* ---- other places */

/* What `alias` says of a buffer. */
struct alias {
    VkBufferCreateInfo info;
    VkDeviceSize bound; /* bytes of a sparse buffer */
    bool is_sparse, is_unbound;
};

static struct alias read_alias(struct play *play, char **words, VkDeviceSize size)
{
    static const VkExternalMemoryBufferCreateInfo imported = {
        .sType = VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO,
        .handleTypes = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT};
    struct alias alias = {.info = play_buffer_info(play, size)};
    for (; *words; words++) {
        if (play_is(*words, "protected")) {
            alias.info.flags = VK_BUFFER_CREATE_PROTECTED_BIT;
        } else if (play_is(*words, "replayed")) {
            alias.info.flags = VK_BUFFER_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT;
        } else if (play_is(*words, "described")) {
            alias.info.flags = VK_BUFFER_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT;
        } else if (play_is(*words, "for-nv")) {
            alias.info.usage = VK_BUFFER_USAGE_RAY_TRACING_BIT_NV;
        } else if (play_is(*words, "imported")) {
            alias.info.pNext = &imported;
        } else if (play_is(*words, "plain")) {
            alias.info.usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR;
        } else if (play_is(*words, "unbound")) {
            alias.is_unbound = true;
        } else if (play_is(*words, "sparse") || play_is(*words, "aliased")) {
            alias.info.flags = VK_BUFFER_CREATE_SPARSE_BINDING_BIT |
                               (play_is(*words, "sparse") ? VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT
                                                          : VK_BUFFER_CREATE_SPARSE_ALIASED_BIT);
            alias.is_sparse = true;
            alias.bound = play_number(play, *++words);
        } else {
            alias.info.size = play_number(play, *words);
        }
    }
    return alias;
}

static void bind_pages(struct play *play, VkBuffer buffer, VkDeviceMemory memory, VkDeviceSize size)
{
    const VkSparseMemoryBind bind = {.size = size, .memory = memory};
    const VkSparseBufferMemoryBindInfo binds = {buffer, 1, &bind};
    const STRUCT(VkBindSparseInfo, info, .bufferBindCount = 1, .pBufferBinds = &binds);
    GET(play->vk.QueueBindSparse(play->queues[0], 1, &info, VK_NULL_HANDLE));
    GET(play->vk.QueueWaitIdle(play->queues[0]));
}

void play_alias(struct play *play, char **words)
{
    VkDeviceSize offset;
    const struct play_object *other = play_place(play, words[2], &offset);
    const struct alias alias = read_alias(play, words + 3, PLAY_BUFFER_SIZE - offset);
    PLAY_REQUIRE(play, !find(play, words[1]));
    struct device_buffer buffer = {.size = alias.info.size, .bytes = other->buffer.bytes + offset};
    GET(play->vk.CreateBuffer(play->device, &alias.info, NULL, &buffer.handle));
    if (alias.is_sparse)
        bind_pages(play, buffer.handle, other->buffer.memory, alias.bound);
    else if (!alias.is_unbound)
        GET(play->vk.BindBufferMemory(play->device, buffer.handle, other->buffer.memory, offset));
    if (!alias.is_unbound && alias.info.usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT)
        buffer.address = buffer_address(&play->vk, play->device, buffer.handle);
    struct play_object *object = add(play, words[1]);
    object->buffer = buffer;
    object->is_freed = other->is_freed;
    name_object(play, VK_OBJECT_TYPE_BUFFER, (uint64_t)buffer.handle, object->name);
}

/* back NAME PLACE */
void play_back(struct play *play, char **words)
{
    VkDeviceSize offset;
    const struct play_object *memory = play_place(play, words[2], &offset);
    struct device_buffer *buffer = &play_object(play, words[1])->buffer;
    GET(play->vk.BindBufferMemory(play->device, buffer->handle, memory->buffer.memory, offset));
    buffer->address = buffer_address(&play->vk, play->device, buffer->handle);
}

void play_put(struct play *play, char **words)
{
    VkDeviceSize offset;
    const struct play_object *buffer = play_place(play, words[2], &offset);
    PLAY_REQUIRE(play, !find(play, words[1]));
    struct play_object *object = add(play, words[1]);
    if (object->name[0] == 'M')
        create_micromap(play, object, buffer->buffer.handle, offset, PLAY_BUFFER_SIZE / 4);
    else
        play_create_structure(play, object, buffer->buffer.handle, offset, PLAY_BUFFER_SIZE / 4,
                              type_of(play, object));
}

/* ---- what the host writes */

static uint64_t reference_to(const struct play *play, const struct play_object *object,
                             bool is_host)
{
    uint64_t reference = (uint64_t)object->structure;
    if (object->is_nv)
        GET(play->vk.GetAccelerationStructureHandleNV(play->device, object->nv, sizeof(reference),
                                                      &reference));
    else if (!is_host)
        reference = structure_address(&play->vk, play->device, object->structure);
    return reference;
}

void play_write_instances(struct play *play, void *to, char **names, bool is_host)
{
    VkAccelerationStructureInstanceKHR *instances = to;
    for (unsigned i = 0; names[i]; i++) {
        const struct play_object *object = play_object(play, names[i]);
        instances[i] = (VkAccelerationStructureInstanceKHR){
            .transform.matrix = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}},
            .mask = 0xff,
            .accelerationStructureReference = reference_to(play, object, is_host),
        };
    }
}

/* Programs that are not judged may name places behind a buffer. */
unsigned char *play_bytes(struct play *play, const char *word)
{
    enum { ROOM = 4096 };
    VkDeviceSize offset;
    const struct play_object *object = play_place(play, word, &offset);
    PLAY_REQUIRE(play, object->buffer.bytes && !object->is_freed);
    PLAY_REQUIRE(play, !play->is_unjudged ||
                           (object->buffer.size >= ROOM && offset <= object->buffer.size - ROOM));
    return object->buffer.bytes + offset;
}

void play_write(struct play *play, const char *place, const void *bytes, size_t size)
{
    memcpy(play_bytes(play, place), bytes, size);
}

uint64_t play_reference_to(const struct play *play, const struct play_object *object)
{
    uint64_t handle;
    if (!play->is_nv)
        return structure_address(&play->vk, play->device, object->structure);
    GET(play->vk.GetAccelerationStructureHandleNV(play->device, object->nv, sizeof(handle),
                                                  &handle));
    return handle;
}

void play_init(struct play *play, char **words)
{
    static const VkTransformMatrixKHR identity = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    static const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = 2};
    static const VkMicromapTriangleEXT triangles[] = {
        {0, 0, VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT},
        {0, 0, VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT}};
    static const VkAabbPositionsKHR box = {.minX = 1, .maxX = -1};
    unsigned char *bytes = play_bytes(play, words[1]);
    if (play_is(words[2], "instances"))
        play_write_instances(play, bytes, words + 3, false);
    else if (play_is(words[2], "transform"))
        play_write(play, words[1], &identity, sizeof(identity));
    else if (play_is(words[2], "triangles"))
        play_write(play, words[1], triangles, sizeof(triangles));
    else if (play_is(words[2], "triangle"))
        play_write(play, words[1],
                   &(VkMicromapTriangleEXT){.subdivisionLevel = (uint16_t)atoi(words[4]),
                                            .format = (uint16_t)atoi(words[3])},
                   sizeof(triangles[0]));
    else if (play_is(words[2], "box"))
        play_write(play, words[1], &box, sizeof(box));
    else if (play_is(words[2], "reference"))
        ((VkAccelerationStructureInstanceKHR *)(void *)bytes)->accelerationStructureReference =
            strtoull(words[3], NULL, 0);
    else if (play_is(words[2], "ranges"))
        play_write(play, words[1], &range, sizeof(range));
    else if (play_is(words[2], "pointer"))
        play_write(play, words[1],
                   &(uint64_t){play_address_for(play, words[3], true).deviceAddress},
                   sizeof(uint64_t));
    else if (play_is(words[2], "address"))
        play_write(play, words[1], &(uint64_t){play_address(play, words[3])}, sizeof(uint64_t));
    else if (play_is(words[2], "structure"))
        play_write(play, words[1],
                   &(uint64_t){play_reference_to(play, play_object(play, words[3]))},
                   sizeof(uint64_t));
    else if (play_is(words[2], "stranger"))
        play_write(play, words[1], &(uint64_t){play_stranger(play)}, sizeof(uint64_t));
    else if (play_is(words[2], "handle"))
        play_write(play, words[1], &(uint64_t){(uint64_t)play_object(play, words[3])->structure},
                   sizeof(uint64_t));
    else if (play_is(words[2], "word"))
        play_write(play, words[1], &(uint64_t){strtoull(words[3], NULL, 0)}, sizeof(uint64_t));
    else if (!play_init_input(play, words))
        play_fail(play, "init of what?");
}

/* ---- destruction */

bool play_is_buffer(const struct play_object *object)
{
    return !strchr("BTMEFPcdst", object->name[0]);
}

void play_destroy_object(struct play *play, struct play_object *object)
{
    const VkuDeviceDispatchTable *vk = &play->vk;
    if (object->is_ghost && object->name[0] != 'c')
        return;
    switch (object->name[0]) {
    case 'B':
    case 'T':
        if (object->is_nv)
            vk->DestroyAccelerationStructureNV(play->device, object->nv, NULL);
        else
            vk->DestroyAccelerationStructureKHR(play->device, object->structure, NULL);
        break;
    case 'M':
        vk->DestroyMicromapEXT(play->device, object->micromap, NULL);
        break;
    case 'E':
        vk->DestroyEvent(play->device, object->event, NULL);
        break;
    case 'F':
        vk->DestroyImage(play->device, object->image, NULL);
        break;
    case 'P':
        vk->DestroyQueryPool(play->device, object->queries, NULL);
        break;
    case 'c':
        vk->DestroyCommandPool(play->device, object->pool, NULL);
        break;
    case 'd':
        vk->DestroyDeferredOperationKHR(play->device, object->operation, NULL);
        break;
    case 's':
    case 't':
        vk->DestroySemaphore(play->device, object->semaphore, NULL);
        break;
    default:
        return;
    }
    object->structure = VK_NULL_HANDLE; /* and what shares its place */
}

void play_create_objects(struct play *play)
{
    for (uint32_t i = 0; i < ARRAY_COUNT(play->pools); i++) {
        const STRUCT(VkCommandPoolCreateInfo, pool, .queueFamilyIndex = i);
        play->pools[i] = VK_NULL_HANDLE;
        if (play->queues[2 * i])
            GET(play->vk.CreateCommandPool(play->device, &pool, NULL, &play->pools[i]));
    }
    play->fence = fence_create(&play->vk, play->device);
    play->object_count = play->nameless_count = 0;
    play->scratch_used = play->instances_used = 0;
    play->ended_count = play->batch_count = 0;
    play->primary = play->secondary = play->executed = VK_NULL_HANDLE;
    play->recording = NULL;
    play->bottom_type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
    play->is_nv = false;
    play->nv_geometries = 1;
    play->nv_type = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    play->pages = VK_NULL_HANDLE;
    play->render_pass = VK_NULL_HANDLE;
    play->framebuffer = VK_NULL_HANDLE;
}

void play_destroy_objects(struct play *play)
{
    const VkuDeviceDispatchTable *vk = &play->vk;
    for (size_t i = 0; i < ARRAY_COUNT(play->pools); i++)
        vk->DestroyCommandPool(play->device, play->pools[i], NULL);
    play_destroy_shaders(play);
    vk->DestroyFramebuffer(play->device, play->framebuffer, NULL);
    vk->DestroyRenderPass(play->device, play->render_pass, NULL);
    vk->DestroyFence(play->device, play->fence, NULL);
    play_destroy_nameless(play);
    for (unsigned i = play->object_count; i-- > 0;)
        play_destroy_object(play, &play->objects[i]);
    for (unsigned i = play->object_count; i-- > 0;) {
        struct play_object *object = &play->objects[i];
        if (object->is_ghost && play_is_buffer(object))
            object->buffer.handle = VK_NULL_HANDLE;
        buffer_destroy(vk, play->device, &object->buffer);
    }
    vk->FreeMemory(play->device, play->pages, NULL);
}
