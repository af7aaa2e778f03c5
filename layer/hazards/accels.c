/* SPDX-License-Identifier: Apache-2.0 */
/* Accesses of structures and of serialized data, for rows of commands, and builds of
 * VK_EXT_opacity_micromap. Commands access what the last build needed, which may be less than the
 * structure was created with, and something else may lie behind it: only the first byte is
 * certain. Of serialized data it is the header. */
#include "layer/hazards/builds.h"
#include "layer/hazards/recording.h"
#include "observers.h"
#include "src/base/readable.h"
#include "src/model/build_parameters.h"
#include "src/model/inputs.h"

/* ---- structures and memory */

/* One that is written, and that may be a top-level structure, counts as one. */
void hazards_access_accel(struct hazard_recording *recording, enum access_kind kind,
                          enum hazard_role role, VkAccelerationStructureKHR handle)
{
    struct accel_facts facts;
    struct hazard_use use = {.kind = kind, .role = role};
    resources_look_up_accel(recording->device->resources, handle, &facts);
    if (role == HAZARD_TOP_DST && facts.memory &&
        facts.type == VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR)
        use.role = HAZARD_DST;
    hazard_recording_add_accel(recording, &use, &facts, 1);
}

void hazards_access_nv_accel(struct hazard_recording *recording, enum access_kind kind,
                             enum hazard_role role, VkAccelerationStructureNV handle)
{
    struct nv_accel_facts facts;
    const struct hazard_use use = {.kind = kind, .role = role};
    resources_look_up_nv_accel(recording->device->resources, handle, &facts);
    hazard_recording_add_nv(recording, &use, &facts);
    nv_shape_release(facts.created);
}

void hazards_access_serialized(struct hazard_recording *recording, enum access_kind kind,
                               enum hazard_role role, VkDeviceAddress address, VkDeviceSize size)
{
    hazards_access_address(recording, kind, role, address, size);
    if (access_is_write(kind))
        hazard_recording_add_anywhere(recording, &(struct hazard_use){.kind = kind, .role = role});
}

void hazards_access_host(struct hazard_recording *recording, enum access_kind kind,
                         enum hazard_role role, const void *pointer, uint64_t size)
{
    hazards_add_host(recording, &(struct hazard_use){.kind = kind, .role = role}, pointer, size);
}

/* A query cannot be deferred, so its accesses end with the call. */
void hazards_query_accels_on_host(struct hazard_recording *recording, uint32_t count,
                                  const VkAccelerationStructureKHR *accels)
{
    for (uint32_t i = 0; i < count; i++)
        hazards_access_accel(recording, ACCESS_HOST_READ, HAZARD_SRC, accels[i]);
    struct host_work work = host_work_begin(recording->device);
    host_work_prepare(&work, false);
    host_work_finish(&work, VK_NULL_HANDLE, VK_SUCCESS);
}

/* ---- micromaps */

/* Adds the first `size` bytes of a micromap. */
static void add_micromap(struct hazard_recording *recording, const struct hazard_use *use,
                         VkMicromapEXT handle, VkDeviceSize size)
{
    struct memory_bytes all;
    if (!resources_find_micromap_bytes(recording->device->resources, handle, &all))
        return;
    const struct hazard_bytes bytes = {all.memory_id, all.begin,
                                       all.begin + (size < all.size ? size : all.size)};
    hazard_recording_add(recording, use, VK_OBJECT_TYPE_MICROMAP_EXT, handle_number(handle),
                         &bytes);
}

void hazards_access_micromap(struct hazard_recording *recording, enum access_kind kind,
                             enum hazard_role role, VkMicromapEXT handle)
{
    add_micromap(recording, &(struct hazard_use){.kind = kind, .role = role}, handle, 1);
}

/* ---- builds */

/* Adds bytes behind an address of the device or, for a build on the host, of the host. */
static void add_bytes(struct hazard_recording *recording, const struct hazard_use *use,
                      VkDeviceOrHostAddressConstKHR address, bool is_host, uint64_t size)
{
    struct address_facts facts;
    if (is_host) {
        hazards_add_host(recording, use, address.hostAddress, size);
        return;
    }
    resources_look_up_address(recording->device->resources, address.deviceAddress, &facts);
    hazard_recording_add_address(recording, use, &facts, 0, size);
}

/* The layer's own call needs the feature and a valid structure, as the application's. */
static bool can_query_sizes(const struct layer_device *device, const VkMicromapBuildInfoEXT *info)
{
    return device->facts.micromap.ext && info->sType == VK_STRUCTURE_TYPE_MICROMAP_BUILD_INFO_EXT &&
           !check_has_found() && device->vk.GetMicromapBuildSizesEXT;
}

/* Which part of the data the triangles use is in device memory: it is not recorded. */
static void add_triangles(struct hazard_recording *recording, uint32_t index,
                          const struct geometry_input *triangles, bool is_host)
{
    struct address_facts facts = {.status = ADDRESS_UNKNOWN};
    const struct hazard_use use = {.kind = is_host ? ACCESS_HOST_READ : ACCESS_MICROMAP_SHADER_READ,
                                   .role = HAZARD_OTHER_INPUT,
                                   .info = index};
    if (!is_host)
        resources_look_up_address(recording->device->resources, triangles->address.deviceAddress,
                                  &facts);
    hazards_add_elements(
        recording, &use,
        &(struct hazard_elements){.facts = &facts,
                                  .host = is_host ? triangles->address.hostAddress : NULL,
                                  .count = triangles->count,
                                  .stride = triangles->stride,
                                  .size = triangles->size});
}

static void add_build(struct hazard_recording *recording, uint32_t index,
                      const VkMicromapBuildInfoEXT *info, bool is_host)
{
    const struct layer_device *device = recording->device;
    const VkAccelerationStructureBuildTypeKHR type =
        is_host ? VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR
                : VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR;
    VkMicromapBuildSizesInfoEXT sizes = {.sType = VK_STRUCTURE_TYPE_MICROMAP_BUILD_SIZES_INFO_EXT};
    struct hazard_use use = {.kind = is_host ? ACCESS_HOST_WRITE : ACCESS_MICROMAP_WRITE,
                             .role = HAZARD_DST,
                             .info = index};
    struct build_parameters build;
    struct geometry_input inputs[GEOMETRY_INPUTS];
    uint32_t count = 0;
    if (micromap_info_copy(readable_cache_of_thread(), info, &build) == VK_SUCCESS)
        count = inputs_of_geometry(0, &build.geometries[0], &build.chained[0], NULL, inputs);
    const struct geometry_input *triangles = input_of_role(inputs, count, INPUT_MICROMAP_TRIANGLES);
    if (triangles && can_query_sizes(device, info))
        device->vk.GetMicromapBuildSizesEXT(device->handle, type, info, &sizes);
    add_micromap(recording, &use, info->dstMicromap, sizes.micromapSize);
    use.role = HAZARD_SCRATCH;
    add_bytes(recording, &use,
              (VkDeviceOrHostAddressConstKHR){.deviceAddress = info->scratchData.deviceAddress},
              is_host, sizes.buildScratchSize);
    if (triangles)
        add_triangles(recording, index, triangles, is_host);
    build_parameters_release(&build);
}

void hazards_build_micromaps(struct hazard_recording *recording, uint32_t count,
                             const VkMicromapBuildInfoEXT *infos)
{
    for (uint32_t i = 0; i < count; i++)
        add_build(recording, i, &infos[i], !recording->command_buffer);
}
