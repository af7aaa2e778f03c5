/* SPDX-License-Identifier: Apache-2.0 */
/* Structures of VK_NV_ray_tracing, which `structures nv` asks for: builds have the flags and the
 * source of their line, inputs V0, I0 and X0, or A0, or N0, and each a part of scratch S0. `count
 * NUMBER` and `offset NUMBER`: of vertices and indices, boxes or instances; `bare`: without indices
 * and a transform; `short-indices`: of 16 bits; `translated`: by 2, 3 and 4; `opaque`; `null`:
 * without the build's info.
 * `wrong WHAT`: a member that leads nowhere or means nothing, see set_wrong().
 *
 *     query NAME > POOL          the compacted size; the pool's name begins with PN */
#include "tests/player/play.h"

enum { SCRATCH_SIZE = 16 * 1024, GEOMETRIES = 4 }; /* of a build */

/* What structures are built of. */
struct nv_input {
    VkAccelerationStructureInfoNV info;
    VkGeometryNV geometry, all[GEOMETRIES]; /* those of the build are alike */
    VkBuffer instances;
};

static void fill_input(struct play *play, struct nv_input *input)
{
    const bool is_top = play->nv_type == VK_GEOMETRY_TYPE_INSTANCES_KHR;
    const bool has_boxes = play->nv_type == VK_GEOMETRY_TYPE_AABBS_KHR;
    *input = (struct nv_input){
        .info = MAKE(VkAccelerationStructureInfoNV,
                     .type = is_top ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV
                                    : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV,
                     .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_NV |
                              VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_NV,
                     .instanceCount = is_top ? 3 : 0,
                     .geometryCount = is_top ? 0 : play->nv_geometries, .pGeometries = input->all),
        .geometry = MAKE(VkGeometryNV,
                         .geometryType =
                             has_boxes ? VK_GEOMETRY_TYPE_AABBS_NV : VK_GEOMETRY_TYPE_TRIANGLES_NV,
                         .geometry = {.triangles = MAKE(VkGeometryTrianglesNV),
                                      .aabbs = MAKE(VkGeometryAABBNV)})};
    if (is_top) {
        input->instances = play_object(play, "N0")->buffer.handle;
    } else if (has_boxes) {
        VkGeometryAABBNV *boxes = &input->geometry.geometry.aabbs;
        boxes->aabbData = play_object(play, "A0")->buffer.handle;
        boxes->numAABBs = 3;
        boxes->stride = sizeof(VkAabbPositionsKHR);
    } else {
        VkGeometryTrianglesNV *triangles = &input->geometry.geometry.triangles;
        triangles->vertexData = play_object(play, "V0")->buffer.handle;
        triangles->vertexCount = triangles->indexCount = 6;
        triangles->vertexStride = 12;
        triangles->vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
        triangles->indexType = VK_INDEX_TYPE_UINT32;
        triangles->indexData = play_object(play, "I0")->buffer.handle;
        play_init(play, (char *[]){"", "X0", "transform"});
        triangles->transformData = play_object(play, "X0")->buffer.handle;
    }
}

static void repeat_geometry(const struct play *play, struct nv_input *input)
{
    PLAY_REQUIRE(play, play->nv_geometries <= GEOMETRIES);
    for (uint32_t i = 0; i < play->nv_geometries; i++)
        input->all[i] = input->geometry;
}

/* None that is for one use, or needs a feature. */
static void check_memory_types(const struct play *play, uint32_t types)
{
    const VkMemoryPropertyFlags special =
        VK_MEMORY_PROPERTY_PROTECTED_BIT | VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT |
        VK_MEMORY_PROPERTY_DEVICE_COHERENT_BIT_AMD | VK_MEMORY_PROPERTY_RDMA_CAPABLE_BIT_NV;
    VkPhysicalDeviceMemoryProperties properties;
    play->fixture.vk.GetPhysicalDeviceMemoryProperties(play->fixture.physical, &properties);
    for (uint32_t i = 0; i < properties.memoryTypeCount; i++)
        PLAY_REQUIRE(play, !(types >> i & 1 && properties.memoryTypes[i].propertyFlags & special));
}

void play_create_nv(struct play *play, struct play_object *object, VkDeviceSize compacted)
{
    const VkuDeviceDispatchTable *vk = &play->vk;
    struct nv_input input;
    VkMemoryRequirements2 requirements = MAKE(VkMemoryRequirements2);
    fill_input(play, &input);
    repeat_geometry(play, &input);
    if (compacted)
        input.info.geometryCount = input.info.instanceCount = 0;
    const STRUCT(VkAccelerationStructureCreateInfoNV, info, .compactedSize = compacted,
                 .info = input.info);
    object->is_nv = true;
    GET(vk->CreateAccelerationStructureNV(play->device, &info, NULL, &object->nv));
    const STRUCT(VkAccelerationStructureMemoryRequirementsInfoNV, of,
                 .accelerationStructure = object->nv);
    vk->GetAccelerationStructureMemoryRequirementsNV(play->device, &of, &requirements);
    if (play->platform->is_cpu)
        check_memory_types(play, requirements.memoryRequirements.memoryTypeBits);
    object->buffer.size = requirements.memoryRequirements.size;
    const STRUCT(
        VkMemoryAllocateInfo, allocation, .allocationSize = requirements.memoryRequirements.size,
        .memoryTypeIndex = (uint32_t)__builtin_ctz(requirements.memoryRequirements.memoryTypeBits));
    GET(vk->AllocateMemory(play->device, &allocation, NULL, &object->buffer.memory));
    const STRUCT(VkBindAccelerationStructureMemoryInfoNV, bind, .accelerationStructure = object->nv,
                 .memory = object->buffer.memory);
    GET(vk->BindAccelerationStructureMemoryNV(play->device, 1, &bind));
}

static void set_count(struct nv_input *input, uint32_t count)
{
    input->geometry.geometry.triangles.vertexCount = count;
    input->geometry.geometry.triangles.indexCount = count;
    input->geometry.geometry.aabbs.numAABBs = count;
    if (input->info.instanceCount)
        input->info.instanceCount = count;
}

static void set_wrong(const struct play *play, struct nv_input *input, const char *what)
{
    VkGeometryTrianglesNV *triangles = &input->geometry.geometry.triangles;
    if (play_is(what, "no-vertices")) {
        triangles->vertexData = VK_NULL_HANDLE;
    } else if (play_is(what, "wild-vertices")) {
        triangles->vertexData = (VkBuffer)(uintptr_t)0x1234567890;
    } else if (play_is(what, "vertex-offset")) {
        triangles->vertexOffset = UINT64_MAX - 8;
    } else if (play_is(what, "stride")) {
        triangles->vertexStride = UINT64_MAX;
    } else if (play_is(what, "index-offset")) {
        triangles->indexOffset = PLAY_BUFFER_SIZE - 20;
    } else if (play_is(what, "transform-offset")) {
        triangles->transformOffset = PLAY_BUFFER_SIZE - 32;
    } else if (play_is(what, "format")) {
        triangles->vertexFormat = VK_FORMAT_D32_SFLOAT;
    } else if (play_is(what, "geometry")) {
        input->geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    } else if (play_is(what, "wild-geometry")) {
        input->geometry.geometryType = (VkGeometryTypeKHR)77;
    } else if (play_is(what, "level")) {
        input->info.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV;
        input->info.geometryCount = 0;
        input->info.instanceCount = 3;
    } else {
        PLAY_REQUIRE(play, play_is(what, "geometries"));
        input->info.pGeometries = (const void *)(uintptr_t)0x1000;
    }
}

/* Reads one build. Returns the words behind it. */
static char **build(struct play *play, char **words)
{
    struct nv_input input;
    VkAccelerationStructureNV dst = play_object(play, *words++)->nv, src = VK_NULL_HANDLE;
    VkGeometryTrianglesNV *triangles = &input.geometry.geometry.triangles;
    VkGeometryAABBNV *boxes = &input.geometry.geometry.aabbs;
    VkDeviceSize instances = 0;
    bool is_update = false, is_there = true;
    const struct device_buffer *scratch = &play_object(play, "S0")->buffer;
    const VkDeviceSize offset = play->scratch_used;
    PLAY_REQUIRE(play, scratch->size > 0);
    play->scratch_used = (offset + SCRATCH_SIZE) % scratch->size;
    fill_input(play, &input);
    for (; *words && !play_is(*words, "and"); words++) {
        is_update |= play_is(*words, "update");
        if (play_is(*words, "src"))
            src = play_object(play, words[1])->nv;
        if (play_is(*words, "flags"))
            input.info.flags = play_flags(play, words[1]);
        if (play_is(*words, "count"))
            set_count(&input, (uint32_t)play_number(play, words[1]));
        if (play_is(*words, "offset"))
            triangles->vertexOffset = boxes->offset = instances = play_number(play, words[1]);
        if (play_is(*words, "opaque"))
            input.geometry.flags = VK_GEOMETRY_OPAQUE_BIT_NV;
        if (play_is(*words, "bare")) {
            triangles->indexType = VK_INDEX_TYPE_NONE_NV;
            triangles->indexData = triangles->transformData = VK_NULL_HANDLE;
            triangles->indexCount = 0;
        }
        if (play_is(*words, "short-indices"))
            triangles->indexType = VK_INDEX_TYPE_UINT16;
        if (play_is(*words, "translated"))
            play_init(play, (char *[]){"", "X0", "floats", "1", "0", "0", "2", "0", "1", "0", "3",
                                       "0", "0", "1", "4", NULL});
        if (play_is(*words, "wrong"))
            set_wrong(play, &input, words[1]);
        is_there &= !play_is(*words, "null");
    }
    repeat_geometry(play, &input);
    play->vk.CmdBuildAccelerationStructureNV(play_commands(play), is_there ? &input.info : NULL,
                                             input.instances, instances, is_update, dst, src,
                                             scratch->handle, offset);
    return *words ? words + 1 : words;
}

void play_build_nv(struct play *play, char **words)
{
    for (words++; *words;)
        words = build(play, words);
}

void play_copy_nv(struct play *play, char **words)
{
    play->vk.CmdCopyAccelerationStructureNV(
        play_commands(play), play_object(play, words[3])->nv, play_object(play, words[1])->nv,
        play_is(words[0], "compact") ? VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR
                                     : VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
}

void play_query_nv(struct play *play, char **words)
{
    PLAY_REQUIRE(play, play_is(words[2], ">"));
    play->vk.CmdWriteAccelerationStructuresPropertiesNV(
        play_commands(play), 1, &play_object(play, words[1])->nv,
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV,
        play_object(play, words[3])->queries, 0);
}
