/* SPDX-License-Identifier: Apache-2.0 */
/* Objects that are created otherwise, or die before the program ends:
 *
 *     structures generic | nv [boxes | instances | GEOMETRIES] | khr
 *                              what new structures are: `generic` is about those whose names
 *                              begin with B, and the others about all
 *     create NAME [generic | sparse [long] | fitting SHAPE | last-size [less BYTES]]
 *                              a structure, in its old buffer or a sparse one; SHAPE is the
 *                              words of a build, and `last-size`: the size that the host read
 *                              last
 *     create NAME at PLACE [micromap | bound]
 *                              a structure, by vkCreateAccelerationStructure2KHR, which says
 *                              that it is `bound`; or an opacity micromap
 *     create NAME of BYTES [less BYTES]      a buffer
 *     create NAME scratch build | update STRUCTURE SHAPE
 *                              a buffer, for the scratch of a build
 *     have NAME...             creates what is not there yet
 *     destroy NAME             destroy buffer NAME: of a structure
 *     free NAME                its memory
 *     renew NAME               destroys and creates a buffer with its memory, an operation, or
 *                              a pool of queries, which nothing has reset
 *     event NAME               only the device can set it
 *     create nameless PLACE COUNT      structures without names, one behind the other
 *     destroy nameless
 *     label NAME               insert NAME       unlabel           in the command buffer */
#include "tests/player/play.h"

#include <stdlib.h>

static void choose_structures(struct play *play, char **words)
{
    if (play_is(words[1], "generic")) {
        play->bottom_type = VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR;
        return;
    }
    PLAY_REQUIRE(play, play_is(words[1], "nv") || play_is(words[1], "khr"));
    play->is_nv = play_is(words[1], "nv");
    play->nv_type = play_is(words[2], "boxes")       ? VK_GEOMETRY_TYPE_AABBS_KHR
                    : play_is(words[2], "instances") ? VK_GEOMETRY_TYPE_INSTANCES_KHR
                                                     : VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    const bool is_counted = words[2] && play->nv_type == VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    play->nv_geometries = is_counted ? (uint32_t)atoi(words[2]) : 1;
}

/* ---- creation */

static void create_sparse_buffer(struct play *play, struct play_object *object, VkDeviceSize size)
{
    VkBufferCreateInfo info = play_buffer_info(play, size);
    VkMemoryRequirements requirements;
    info.flags = VK_BUFFER_CREATE_SPARSE_BINDING_BIT | VK_BUFFER_CREATE_SPARSE_ALIASED_BIT;
    buffer_destroy(&play->vk, play->device, &object->buffer);
    object->buffer = (struct device_buffer){.size = info.size};
    GET(play->vk.CreateBuffer(play->device, &info, NULL, &object->buffer.handle));
    play->vk.GetBufferMemoryRequirements(play->device, object->buffer.handle, &requirements);
    PLAY_REQUIRE(play, PLAY_PAGE_SIZE % requirements.alignment == 0);
    if (!play->pages)
        play->pages = memory_create(&play->vk, play->device, play->memory_type,
                                    (VkDeviceSize)PLAY_PAGES * PLAY_PAGE_SIZE);
}

static void enlarge(struct play *play, struct play_object *object, VkDeviceSize size)
{
    const VkBufferCreateInfo info = play_buffer_info(play, size);
    buffer_destroy(&play->vk, play->device, &object->buffer);
    object->buffer = (struct device_buffer){.size = 0}; /* if the creation fails */
    object->buffer = buffer_create(&play->vk, play->device, play->memory_type, &info);
}

static void create_scratch(struct play *play, char **words)
{
    struct play_object *object = play_object(play, words[1]);
    const VkAccelerationStructureBuildSizesInfoKHR sizes =
        play_build_sizes(play, words + 4, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR);
    enlarge(play, object,
            play_is(words[3], "update") ? sizes.updateScratchSize : sizes.buildScratchSize);
}

/* create NAME at PLACE [micromap | bound] */
static void create_at(struct play *play, char **words)
{
    struct play_object *object = play_object(play, words[1]);
    const STRUCT(
        VkAccelerationStructureCreateInfo2KHR, info,
        .addressRange = {play_address(play, words[3]), PLAY_STRUCTURE_SIZE},
        .addressFlags = VK_ADDRESS_COMMAND_STORAGE_BUFFER_USAGE_BIT_KHR |
                        (play_is(words[4], "bound") ? VK_ADDRESS_COMMAND_FULLY_BOUND_BIT_KHR : 0),
        .type = play_is(words[4], "micromap") ? VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR
                                              : play->bottom_type);
    play_destroy_object(play, object);
    GET(play->vk.CreateAccelerationStructure2KHR(play->device, &info, NULL, &object->structure));
}

/* create NAME last-size [less BYTES] */
static VkDeviceSize last_size(const struct play *play, char **words)
{
    return play->last_size - (words[3] ? (VkDeviceSize)atoi(words[4]) : 0);
}

static void create(struct play *play, char **words)
{
    VkDeviceSize size = PLAY_STRUCTURE_SIZE;
    struct play_object *object = play_object(play, words[1]);
    VkAccelerationStructureTypeKHR type =
        object->name[0] == 'T' ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR : play->bottom_type;
    play_destroy_object(play, object);
    if (play->is_nv) {
        play->vk.FreeMemory(play->device, object->buffer.memory, NULL);
        play_create_nv(play, object, play_is(words[2], "last-size") ? last_size(play, words) : 0);
        return;
    }
    if (play_is(words[2], "generic")) {
        type = VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR;
    } else if (play_is(words[2], "sparse")) {
        size = PLAY_PAGE_SIZE * (play_is(words[3], "long") ? 2 : 1);
        create_sparse_buffer(play, object, size);
    } else if (play_is(words[2], "fitting")) {
        words[2] = words[1];
        size = play_build_sizes(play, words + 2, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR)
                   .accelerationStructureSize;
        if (size > object->buffer.size)
            enlarge(play, object, size);
    } else if (play_is(words[2], "last-size")) {
        if (play->last_size) /* else memory has run out */
            size = last_size(play, words);
    } else {
        PLAY_REQUIRE(play, !words[2]);
    }
    play_create_structure(play, object, object->buffer.handle, 0, size, type);
}

static void create_nameless(struct play *play, char **words)
{
    enum { SMALL = 256 };
    VkDeviceSize offset;
    const struct play_object *object = play_place(play, words[0], &offset);
    const uint64_t count = play_number(play, words[1]);
    PLAY_REQUIRE(play, play->nameless_count + count <= PLAY_NAMELESS);
    for (uint64_t i = 0; i < count; i++) {
        const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .buffer = object->buffer.handle,
                     .offset = offset + i * SMALL, .size = SMALL,
                     .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
        GET(play->vk.CreateAccelerationStructureKHR(play->device, &info, NULL,
                                                    &play->nameless[play->nameless_count]));
        play->nameless_count++;
    }
}

void play_destroy_nameless(struct play *play)
{
    while (play->nameless_count > 0)
        play->vk.DestroyAccelerationStructureKHR(play->device,
                                                 play->nameless[--play->nameless_count], NULL);
}

/* As far as calls succeed. */
static void renew_buffer(struct play *play, struct play_object *object)
{
    const VkBufferCreateInfo info = play_buffer_info(play, PLAY_BUFFER_SIZE);
    const STRUCT(VkMemoryAllocateFlagsInfo, flags, .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT);
    STRUCT(VkMemoryAllocateInfo, allocation, .pNext = &flags, .memoryTypeIndex = play->memory_type);
    struct device_buffer *buffer = &object->buffer;
    VkMemoryRequirements requirements;
    buffer_destroy(&play->vk, play->device, buffer);
    *buffer = (struct device_buffer){.size = info.size};
    play_note(play, play->vk.CreateBuffer(play->device, &info, NULL, &buffer->handle));
    if (!buffer->handle)
        return;
    play->vk.GetBufferMemoryRequirements(play->device, buffer->handle, &requirements);
    allocation.allocationSize = requirements.size;
    play_note(play, play->vk.AllocateMemory(play->device, &allocation, NULL, &buffer->memory));
    if (play->result == VK_SUCCESS)
        play_note(play, play->vk.BindBufferMemory(play->device, buffer->handle, buffer->memory, 0));
    if (play->result != VK_SUCCESS)
        return;
    buffer->address = buffer_address(&play->vk, play->device, buffer->handle);
    play_note(play, play->vk.MapMemory(play->device, buffer->memory, 0, VK_WHOLE_SIZE, 0,
                                       (void **)&buffer->bytes));
    if (buffer->bytes)
        memset(buffer->bytes, 0, buffer->size);
}

static void renew(struct play *play, struct play_object *object)
{
    if (object->name[0] == 'd') {
        play_destroy_object(play, object);
        GET(play->vk.CreateDeferredOperationKHR(play->device, NULL, &object->operation));
        object->is_ghost = false;
        return;
    }
    if (object->name[0] == 'P') {
        play_destroy_object(play, object);
        object->queries = play_create_queries(play, object->name);
        object->is_ghost = false;
        return;
    }
    renew_buffer(play, object);
    object->is_ghost = object->is_freed = false;
}

static void create_event(struct play *play, const char *name)
{
    struct play_object *object = play_object(play, name);
    play_destroy_object(play, object);
    GET(play->vk.CreateEvent(play->device,
                             &MAKE(VkEventCreateInfo, .flags = VK_EVENT_CREATE_DEVICE_ONLY_BIT),
                             NULL, &object->event));
}

/* ---- destruction */

static void destroy_buffer(const struct play *play, struct play_object *object)
{
    play->vk.DestroyBuffer(play->device, object->buffer.handle, NULL);
    object->buffer.handle = VK_NULL_HANDLE;
}

/* Also of the buffers that alias its bytes. */
static void free_memory(struct play *play, struct play_object *object)
{
    const unsigned char *begin = object->buffer.bytes, *end = begin + object->buffer.size;
    play->vk.FreeMemory(play->device, object->buffer.memory, NULL);
    object->buffer.memory = VK_NULL_HANDLE;
    object->is_freed = true;
    for (unsigned i = 0; begin && i < play->object_count; i++) {
        struct play_object *other = &play->objects[i];
        other->is_freed |= other->buffer.bytes >= begin && other->buffer.bytes < end;
    }
}

/* An object whose destruction the layer skips is destroyed after the program. */
static void destroy(struct play *play, char **words)
{
    const bool is_buffer = play_is(words[1], "buffer");
    struct play_object *object = play_object(play, words[is_buffer ? 2 : 1]);
    const struct play_object before = *object;
    const uint32_t messages = play->fixture.messages.count;
    if (is_buffer || play_is_buffer(object))
        destroy_buffer(play, object);
    else
        play_destroy_object(play, object);
    if (play->fixture.messages.count > messages && play_expects_mistake(play, (int)play->at))
        *object = before;
}

bool play_life(struct play *play, char **words)
{
    if (play_is(words[0], "structures"))
        choose_structures(play, words);
    else if (play_is(words[0], "create") && play_is(words[1], "nameless"))
        create_nameless(play, words + 2);
    else if (play_is(words[0], "destroy") && play_is(words[1], "nameless"))
        play_destroy_nameless(play);
    else if (play_is(words[0], "create") && play_is(words[2], "scratch"))
        create_scratch(play, words);
    else if (play_is(words[0], "create") && play_is(words[2], "of"))
        enlarge(play, play_object(play, words[1]),
                play_number(play, words[3]) - (words[4] ? play_number(play, words[5]) : 0));
    else if (play_is(words[0], "create") && play_is(words[2], "at"))
        create_at(play, words);
    else if (play_is(words[0], "create"))
        create(play, words);
    else if (play_is(words[0], "have"))
        for (words++; *words; words++)
            play_object(play, *words);
    else if (play_is(words[0], "destroy"))
        destroy(play, words);
    else if (play_is(words[0], "free"))
        free_memory(play, play_object(play, words[1]));
    else if (play_is(words[0], "renew"))
        renew(play, play_object(play, words[1]));
    else if (play_is(words[0], "event"))
        create_event(play, words[1]);
    else if (play_is(words[0], "label"))
        play->vk.CmdBeginDebugUtilsLabelEXT(play_commands(play),
                                            &MAKE(VkDebugUtilsLabelEXT, .pLabelName = words[1]));
    else if (play_is(words[0], "insert"))
        play->vk.CmdInsertDebugUtilsLabelEXT(play_commands(play),
                                             &MAKE(VkDebugUtilsLabelEXT, .pLabelName = words[1]));
    else if (play_is(words[0], "unlabel"))
        play->vk.CmdEndDebugUtilsLabelEXT(play_commands(play));
    else
        return false;
    return true;
}
