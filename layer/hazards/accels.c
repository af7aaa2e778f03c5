/* SPDX-License-Identifier: Apache-2.0 */
/* Records copies, serialization and queries of acceleration structures, and commands of
 * VK_EXT_opacity_micromap. They access what the last build needed, which may be less than the
 * structure was created with, and something else may lie behind it: only the first byte is
 * certain. Of serialized data it is the header. */
#include "layer/hazards/builds.h"
#include "layer/hazards/recording.h"
#include "observers.h"
#include "src/base/readable.h"
#include "src/model/build_parameters.h"
#include "src/model/inputs.h"

/* ---- structures and memory */

static void add_accel(struct hazard_recording *recording, enum access_kind kind,
                      enum hazard_role role, VkAccelerationStructureKHR handle)
{
    struct accel_facts facts;
    const struct hazard_use use = {.kind = kind, .role = role};
    resources_look_up_accel(recording->device->resources, handle, &facts);
    hazard_recording_add_accel(recording, &use, &facts, 1);
}

static void add_nv(struct hazard_recording *recording, enum access_kind kind, enum hazard_role role,
                   VkAccelerationStructureNV handle)
{
    struct nv_accel_facts facts;
    const struct hazard_use use = {.kind = kind, .role = role};
    resources_look_up_nv_accel(recording->device->resources, handle, &facts);
    hazard_recording_add_nv(recording, &use, &facts);
    nv_shape_release(facts.created);
}

/* The dst of a copy or deserialization. One that may be a top-level structure counts as one. */
static void add_dst(struct hazard_recording *recording, enum access_kind kind,
                    VkAccelerationStructureKHR handle)
{
    struct accel_facts facts;
    struct hazard_use use = {.kind = kind, .role = HAZARD_TOP_DST};
    resources_look_up_accel(recording->device->resources, handle, &facts);
    if (facts.memory && facts.type == VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR)
        use.role = HAZARD_DST;
    hazard_recording_add_accel(recording, &use, &facts, 1);
}

/* UUIDs of the driver and of the format, two sizes, and the number of references. */
enum { SERIALIZATION_HEADER = 2 * VK_UUID_SIZE + 3 * sizeof(uint64_t) };

static void add_header(struct hazard_recording *recording, enum access_kind kind,
                       VkDeviceAddress address)
{
    struct address_facts facts;
    const struct hazard_use use = {.kind = kind, .role = HAZARD_MEMORY};
    resources_look_up_address(recording->device->resources, address, &facts);
    hazard_recording_add_address(recording, &use, &facts, 0, SERIALIZATION_HEADER);
    if (access_is_write(kind))
        hazard_recording_add_anywhere(recording, &use);
}

static void add_host_header(struct hazard_recording *recording, enum access_kind kind,
                            const void *address)
{
    const struct hazard_use use = {.kind = kind, .role = HAZARD_MEMORY};
    hazards_add_host(recording, &use, address, SERIALIZATION_HEADER);
}

/* ---- in command buffers */

void hazards_copy_accel(struct hazard_recording *recording,
                        const VkCopyAccelerationStructureInfoKHR *info)
{
    add_accel(recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, info->src);
    add_dst(recording, ACCESS_COPY_ACCEL_WRITE, info->dst);
}

void hazards_copy_nv_accel(struct hazard_recording *recording, VkAccelerationStructureNV dst,
                           VkAccelerationStructureNV src)
{
    add_nv(recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, src);
    add_nv(recording, ACCESS_COPY_ACCEL_WRITE, HAZARD_TOP_DST, dst);
}

void hazards_write_accel(struct hazard_recording *recording,
                         const VkCopyAccelerationStructureToMemoryInfoKHR *info)
{
    add_accel(recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, info->src);
    add_header(recording, ACCESS_COPY_ACCEL_TRANSFER_WRITE, info->dst.deviceAddress);
}

void hazards_read_accel(struct hazard_recording *recording,
                        const VkCopyMemoryToAccelerationStructureInfoKHR *info)
{
    add_header(recording, ACCESS_COPY_ACCEL_TRANSFER_READ, info->src.deviceAddress);
    add_dst(recording, ACCESS_COPY_ACCEL_WRITE, info->dst);
}

void hazards_query_accels(struct hazard_recording *recording, uint32_t count,
                          const VkAccelerationStructureKHR *accels)
{
    for (uint32_t i = 0; i < count; i++)
        add_accel(recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, accels[i]);
}

void hazards_query_nv_accels(struct hazard_recording *recording, uint32_t count,
                             const VkAccelerationStructureNV *accels)
{
    for (uint32_t i = 0; i < count; i++)
        add_nv(recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, accels[i]);
}

/* ---- on the host */

void hazards_copy_accel_on_host(struct hazard_recording *recording,
                                const VkCopyAccelerationStructureInfoKHR *info)
{
    add_accel(recording, ACCESS_HOST_READ, HAZARD_SRC, info->src);
    add_dst(recording, ACCESS_HOST_WRITE, info->dst);
}

void hazards_read_accel_on_host(struct hazard_recording *recording,
                                const VkCopyMemoryToAccelerationStructureInfoKHR *info)
{
    add_host_header(recording, ACCESS_HOST_READ, info->src.hostAddress);
    add_dst(recording, ACCESS_HOST_WRITE, info->dst);
}

void hazards_write_accel_on_host(struct hazard_recording *recording,
                                 const VkCopyAccelerationStructureToMemoryInfoKHR *info)
{
    add_accel(recording, ACCESS_HOST_READ, HAZARD_SRC, info->src);
    add_host_header(recording, ACCESS_HOST_WRITE, info->dst.hostAddress);
}

/* A query cannot be deferred, so its accesses end with the call. */
void hazards_query_accels_on_host(struct hazard_recording *recording, uint32_t count,
                                  const VkAccelerationStructureKHR *accels)
{
    for (uint32_t i = 0; i < count; i++)
        add_accel(recording, ACCESS_HOST_READ, HAZARD_SRC, accels[i]);
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

static void add_first(struct hazard_recording *recording, enum access_kind kind,
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

/* ---- copies and queries */

void hazards_copy_micromap(struct hazard_recording *recording, const VkCopyMicromapInfoEXT *info)
{
    bool is_host = !recording->command_buffer;
    add_first(recording, is_host ? ACCESS_HOST_READ : ACCESS_MICROMAP_READ, HAZARD_SRC, info->src);
    add_first(recording, is_host ? ACCESS_HOST_WRITE : ACCESS_MICROMAP_WRITE, HAZARD_DST,
              info->dst);
}

/* The size of serialized data is unknown. They begin with their version, which is two UUIDs. */
enum { HEADER_SIZE = 2 * VK_UUID_SIZE };

static const struct hazard_use memory_read = {.kind = ACCESS_MICROMAP_TRANSFER_READ,
                                              .role = HAZARD_MEMORY};
static const struct hazard_use memory_write = {.kind = ACCESS_MICROMAP_TRANSFER_WRITE,
                                               .role = HAZARD_MEMORY};

void hazards_read_micromap(struct hazard_recording *recording,
                           const VkCopyMemoryToMicromapInfoEXT *info)
{
    add_bytes(recording, &memory_read, info->src, false, HEADER_SIZE);
    add_first(recording, ACCESS_MICROMAP_WRITE, HAZARD_DST, info->dst);
}

void hazards_write_micromap(struct hazard_recording *recording,
                            const VkCopyMicromapToMemoryInfoEXT *info)
{
    add_first(recording, ACCESS_MICROMAP_READ, HAZARD_SRC, info->src);
    add_bytes(recording, &memory_write,
              (VkDeviceOrHostAddressConstKHR){.deviceAddress = info->dst.deviceAddress}, false,
              HEADER_SIZE);
    hazard_recording_add_anywhere(recording, &memory_write);
}

void hazards_query_micromaps(struct hazard_recording *recording, uint32_t count,
                             const VkMicromapEXT *micromaps)
{
    for (uint32_t i = 0; i < count; i++)
        add_first(recording, ACCESS_MICROMAP_READ, HAZARD_SRC, micromaps[i]);
}
