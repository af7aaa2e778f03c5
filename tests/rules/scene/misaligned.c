/* SPDX-License-Identifier: Apache-2.0 */
/* Copying into a thread's memory, one byte behind what is aligned. */
#include "tests/rules/scene/scene.h"

#include <stdlib.h>
#include <string.h>

#include "vuid-tables/registry.h"

enum { ROOM = 1 << 18, ALIGNMENT = 16 };

struct room {
    _Alignas(ALIGNMENT) char bytes[ROOM];
    size_t used;
};

static struct room *room_of_thread(void)
{
    static _Thread_local struct room room;
    return &room;
}

/* What lies elsewhere may be anything, and stays. */
static bool is_own(const struct scene *scene, const void *pointer, size_t size)
{
    const uintptr_t begin = (uintptr_t)scene, at = (uintptr_t)pointer;
    return at >= begin && at < begin + sizeof(*scene) && size <= begin + sizeof(*scene) - at;
}

/* NULL if it isn't the scene's own. */
static void *copy(const struct scene *scene, const void *from, size_t size)
{
    struct room *room = room_of_thread();
    if (!size || !is_own(scene, from, size))
        return NULL;
    char *to = room->bytes + room->used + 1;
    room->used += (size + 1 + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    if (room->used > ROOM)
        abort();
    memcpy(to, from, size);
    return to;
}

/* Copies what a pointer leads to, and makes the pointer, which may be misaligned, lead there. */
static void *redirect(const struct scene *scene, void *pointer, size_t size)
{
    const void *from;
    memcpy(&from, pointer, sizeof(from));
    void *to = copy(scene, from, size);
    if (to != NULL)
        memcpy(pointer, &to, sizeof(to));
    return to;
}

static size_t size_of(VkStructureType type)
{
    const struct registry_structure *structure = registry_find_structure(type);
    return structure != NULL ? structure->size : sizeof(VkBaseInStructure);
}

static void redirect_usages(const struct scene *scene, char *structure, uint32_t count,
                            size_t array, size_t pointers)
{
    if (count > SCENE_GEOMETRIES)
        return;
    redirect(scene, structure + array, count * sizeof(VkMicromapUsageEXT));
    char *copies = redirect(scene, structure + pointers, count * sizeof(void *));
    for (uint32_t i = 0; copies != NULL && i < count; i++)
        redirect(scene, copies + i * sizeof(void *), sizeof(VkMicromapUsageEXT));
}

#define REDIRECT_USAGES(type)                                                                      \
    do {                                                                                           \
        type own;                                                                                  \
        memcpy(&own, structure, sizeof(own));                                                      \
        redirect_usages(scene, structure, own.usageCountsCount, offsetof(type, pUsageCounts),      \
                        offsetof(type, ppUsageCounts));                                            \
    } while (0)

static void redirect_chain(const struct scene *scene, char *pointer)
{
    for (int i = 0; i < 4; i++) {
        VkBaseInStructure base;
        const void *from;
        memcpy(&from, pointer, sizeof(from));
        if (!is_own(scene, from, sizeof(base)))
            return;
        memcpy(&base, from, sizeof(base));
        char *structure = redirect(scene, pointer, size_of(base.sType));
        if (structure == NULL)
            return;
        if ((int)base.sType == VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR)
            REDIRECT_USAGES(VkAccelerationStructureGeometryMicromapDataKHR);
        else if ((int)base.sType ==
                 VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_EXT)
            REDIRECT_USAGES(VkAccelerationStructureTrianglesOpacityMicromapEXT);
        else if ((int)base.sType ==
                 VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_DISPLACEMENT_MICROMAP_NV)
            REDIRECT_USAGES(VkAccelerationStructureTrianglesDisplacementMicromapNV);
        pointer = structure + offsetof(VkBaseInStructure, pNext);
    }
}

static void redirect_geometry_chains(const struct scene *scene, char *geometry)
{
    if (geometry == NULL)
        return;
    redirect_chain(scene, geometry + offsetof(VkAccelerationStructureGeometryKHR, pNext));
    redirect_chain(
        scene, geometry + offsetof(VkAccelerationStructureGeometryKHR, geometry.triangles.pNext));
}

static void redirect_geometries(const struct scene *scene, char *info, uint32_t count)
{
    const size_t size = sizeof(VkAccelerationStructureGeometryKHR);
    char *array =
        redirect(scene, info + offsetof(VkAccelerationStructureBuildGeometryInfoKHR, pGeometries),
                 count * size);
    for (uint32_t i = 0; array != NULL && i < count; i++)
        redirect_geometry_chains(scene, array + i * size);
    char *pointers =
        redirect(scene, info + offsetof(VkAccelerationStructureBuildGeometryInfoKHR, ppGeometries),
                 count * sizeof(void *));
    for (uint32_t i = 0; pointers != NULL && i < count; i++)
        redirect_geometry_chains(scene, redirect(scene, pointers + i * sizeof(void *), size));
}

static uint32_t geometry_count(const struct scene *scene, uint32_t build)
{
    const uint32_t count = scene->infos[build].geometryCount;
    return count < SCENE_GEOMETRIES ? count : SCENE_GEOMETRIES;
}

/* An array of pointers to arrays of an element for each geometry. */
static void redirect_arrays(const struct scene *scene, void *argument, uint32_t count, size_t size)
{
    char *pointers = redirect(scene, argument, count * sizeof(void *));
    for (uint32_t i = 0; pointers != NULL && i < count; i++)
        redirect(scene, pointers + i * sizeof(void *), geometry_count(scene, i) * size);
}

static void misalign_nv(struct scene *scene)
{
    char *info = redirect(scene, &scene->nv.info_argument, sizeof(*scene->nv.info_argument));
    const uint32_t count = scene->nv.info.geometryCount;
    if (info != NULL && count <= SCENE_NV_GEOMETRIES)
        redirect(scene, info + offsetof(VkAccelerationStructureInfoNV, pGeometries),
                 count * sizeof(VkGeometryNV));
}

void scene_misalign(struct scene *scene)
{
    const uint32_t count = scene->info_count;
    room_of_thread()->used = 0;
    if (scene->command == COMMAND_NV)
        misalign_nv(scene);
    if (scene->command == COMMAND_NV || count > SCENE_BUILDS)
        return;
    const size_t size = sizeof(*scene->infos_argument);
    char *infos = redirect(scene, &scene->infos_argument, count * size);
    for (uint32_t i = 0; infos != NULL && i < count; i++)
        redirect_geometries(scene, infos + i * size, geometry_count(scene, i));
    redirect_arrays(scene, &scene->ranges_argument, count, sizeof(scene->ranges[0][0]));
    redirect_arrays(scene, &scene->counts_argument, count, sizeof(scene->counts[0][0]));
    redirect(scene, &scene->indirect_addresses_argument, count * sizeof(VkDeviceAddress));
    redirect(scene, &scene->indirect_strides_argument, count * sizeof(uint32_t));
}
