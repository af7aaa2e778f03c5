/* SPDX-License-Identifier: Apache-2.0 */
/* What an application does on backend cpu in each life of tests/scarce: host builds, deferred ones,
 * copies and queries, each asked for again where memory was lacking; then rays tell whether all is
 * as it should be. */
#include <string.h>

#include "application_parts.h"
#include "tests/fixture/copies.h"
#include "tests/fixture/make.h"
#include "tests/fixture/trace.h"

enum {
    /* So many that tables grow beyond their first size, and arrays beyond what is kept in place. */
    STRUCTURES = 48,
    GEOMETRIES = 20, /* of the largest build */
    BLASES = STRUCTURES - 1,
    MOVING = 2,
    WITH_MICROMAP = 4,
    DISPLACED = 6 /* of them */,
    STRUCTURE_SIZE = 16384
};

static VkAccelerationStructureKHR structures[STRUCTURES]; /* the last is the TLAS */
static PFN_vkTraceRaysASSAY trace_rays;                   /* NULL if the backend is the driver's */

/* Beside the structures. */
static struct {
    VkBuffer buffer;
    VkDeferredOperationKHR operation;
    VkPrivateDataSlot slot;
    float vertices[9];
    char scratch[65536] __attribute__((aligned(16)));
    VkAccelerationStructureGeometryMotionTrianglesDataNV motion;
    VkMicromapEXT micromap, displacing;
    VkAccelerationStructureTrianglesOpacityMicromapEXT opacity;
    VkAccelerationStructureTrianglesDisplacementMicromapNV displacement;
    VkAccelerationStructureGeometryKHR triangles[GEOMETRIES], instances;
    VkAccelerationStructureInstanceKHR instance[BLASES];
} host;

/* With memory short, the library that reads settings may lose one without telling; then the backend
 * is the driver's. */
static void find_tracing(void)
{
    trace_rays = (PFN_vkTraceRaysASSAY)vk.GetDeviceProcAddr(device, "vkTraceRaysASSAY");
    outcome.expected++;
    outcome.found += trace_rays != NULL;
}

/* The micromap has so many triangles of level 0 in the first format of its type: opaque, or not
 * displaced. */
static void build_micromap(VkMicromapEXT micromap, VkMicromapTypeEXT type,
                           const VkMicromapUsageEXT *usage)
{
    static const uint8_t opaque[1] = {1}, still[64];
    static const VkMicromapTriangleEXT triangles[] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    const STRUCT(VkMicromapBuildInfoEXT, info, .type = type, .dstMicromap = micromap,
                 .usageCountsCount = 1, .pUsageCounts = usage,
                 .data.hostAddress = type == VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT ? opaque : still,
                 .triangleArray.hostAddress = triangles,
                 .triangleArrayStride = sizeof(triangles[0]));
    CALL(BuildMicromapsEXT, device, VK_NULL_HANDLE, 1, &info);
}

static VkAccelerationStructureTrianglesDisplacementMicromapNV
displacement_of(VkMicromapEXT micromap, const VkMicromapUsageEXT *usage, VkDeviceAddress vectors)
{
    return MAKE(VkAccelerationStructureTrianglesDisplacementMicromapNV,
                .displacementBiasAndScaleFormat = VK_FORMAT_R32G32_SFLOAT,
                .displacementVectorFormat = VK_FORMAT_R32G32B32_SFLOAT,
                .displacementVectorBuffer.deviceAddress = vectors, .displacementVectorStride = 12,
                .indexType = VK_INDEX_TYPE_NONE_KHR, .usageCountsCount = 1, .pUsageCounts = usage,
                .micromap = micromap);
}

/* ---- objects */

static VkAccelerationStructureKHR create_structure(unsigned n, VkAccelerationStructureTypeKHR type)
{
    VkAccelerationStructureKHR structure = VK_NULL_HANDLE;
    const STRUCT(VkAccelerationStructureMotionInfoNV, motion);
    const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .pNext = n == MOVING ? &motion : NULL,
                 .createFlags = n == MOVING ? VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV : 0,
                 .buffer = host.buffer, .offset = n * STRUCTURE_SIZE, .size = STRUCTURE_SIZE,
                 .type = type);
    CREATE(AccelerationStructureKHR, &info, &structure);
    return structure;
}

void create_objects(void)
{
    host.buffer = create_bound_buffer(STRUCTURES * STRUCTURE_SIZE,
                                      VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
                                          VK_BUFFER_USAGE_MICROMAP_STORAGE_BIT_EXT);
    for (unsigned i = 0; i < BLASES; i++)
        structures[i] =
            create_structure(i, i % 2 ? VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR
                                      : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    structures[BLASES] = create_structure(BLASES, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    host.micromap =
        create_micromap(host.buffer, 0, STRUCTURE_SIZE, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT);
    host.displacing =
        create_micromap(host.buffer, 0, STRUCTURE_SIZE, VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV);
    CREATE(PrivateDataSlot, &MAKE(VkPrivateDataSlotCreateInfo), &host.slot);
    CALL(CreateDeferredOperationKHR, device, NULL, &host.operation);
    OWN(DestroyDeferredOperationKHR, host.operation);
    find_tracing();
}

/* ---- builds */

static VkAccelerationStructureBuildGeometryInfoKHR blas_info(unsigned n, uint32_t geometries)
{
    static const float vertices[9] = {0, 0, 0, 0, 1, 0, 0, 0, 1};
    memcpy(host.vertices, vertices, sizeof(vertices));
    for (uint32_t i = 0; i < geometries; i++)
        host.triangles[i] =
            describe_triangles((VkDeviceOrHostAddressConstKHR){.hostAddress = host.vertices}, NULL);
    return MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
                .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR |
                         VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR,
                .dstAccelerationStructure = structures[n], .geometryCount = geometries,
                .pGeometries = host.triangles, .scratchData.hostAddress = host.scratch);
}

static VkResult build(VkDeferredOperationKHR operation,
                      const VkAccelerationStructureBuildGeometryInfoKHR *info, uint32_t count)
{
    VkAccelerationStructureBuildRangeInfoKHR ranges[GEOMETRIES] = {{0}};
    const VkAccelerationStructureBuildRangeInfoKHR *pointer = ranges;
    for (uint32_t i = 0; i < info->geometryCount; i++)
        ranges[i].primitiveCount = count;
    return vk.BuildAccelerationStructuresKHR(device, operation, 1, info, &pointer);
}

/* Large enough, or zeros where memory was lacking; the second time there is some. */
static void check_sizes(const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    uint32_t counts[GEOMETRIES];
    STRUCT(VkAccelerationStructureBuildSizesInfoKHR, sizes);
    for (int i = 0; i < GEOMETRIES; i++)
        counts[i] = 1;
    for (int i = 0; i < 2 && sizes.accelerationStructureSize == 0; i++)
        vk.GetAccelerationStructureBuildSizesKHR(
            device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR, info, counts, &sizes);
    if (!sizes.accelerationStructureSize || sizes.accelerationStructureSize > STRUCTURE_SIZE)
        complain("accelerationStructureSize", (int)sizes.accelerationStructureSize);
}

/* In time, though not in space. */
static void move(VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    host.motion = MAKE(VkAccelerationStructureGeometryMotionTrianglesDataNV,
                       .vertexData.hostAddress = host.vertices);
    host.triangles[0].geometry.triangles.pNext = &host.motion;
    info->flags |= VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
}

/* The first format of either type: one triangle, opaque, or not displaced. */
static const VkMicromapUsageEXT usage = {.count = 1, .format = 1};

static void use_micromap(void)
{
    host.opacity = MAKE(VkAccelerationStructureTrianglesOpacityMicromapEXT,
                        .indexType = VK_INDEX_TYPE_NONE_KHR, .usageCountsCount = 1,
                        .pUsageCounts = &usage, .micromap = host.micromap);
    host.triangles[0].geometry.triangles.pNext = &host.opacity;
}

static void displace(void)
{
    host.displacement =
        displacement_of(host.displacing, &usage, (uint64_t)(uintptr_t)host.vertices);
    host.triangles[0].geometry.triangles.pNext = &host.displacement;
}

static void build_blases(void)
{
    build_micromap(host.micromap, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT, &usage);
    build_micromap(host.displacing, VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV, &usage);
    for (unsigned i = 0; i < BLASES; i++) {
        VkAccelerationStructureBuildGeometryInfoKHR info = blas_info(i, i == 0 ? GEOMETRIES : 1);
        if (i == MOVING)
            move(&info);
        if (i == WITH_MICROMAP)
            use_micromap();
        if (i == DISPLACED)
            displace();
        if (i == 0 || i == MOVING || i == WITH_MICROMAP || i == DISPLACED)
            check_sizes(&info);
        GET("vkBuildAccelerationStructuresKHR", build(VK_NULL_HANDLE, &info, 1));
    }
    VkAccelerationStructureBuildGeometryInfoKHR info = blas_info(0, GEOMETRIES);
    info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    info.srcAccelerationStructure = info.dstAccelerationStructure;
    GET("an update", build(VK_NULL_HANDLE, &info, 1));
}

static VkResult complete(void)
{
    VkResult joined = vk.DeferredOperationJoinKHR(device, host.operation);
    return joined == VK_SUCCESS ? vk.GetDeferredOperationResultKHR(device, host.operation) : joined;
}

/* A deferred command may lack memory when it is called, or when it is carried out. */
#define GET_DEFERRED(what, call)                                                                   \
    GET(what, (call) == VK_OPERATION_DEFERRED_KHR ? complete() : VK_ERROR_OUT_OF_HOST_MEMORY)

static void build_tlas(void)
{
    for (unsigned i = 0; i < BLASES; i++)
        host.instance[i] = (VkAccelerationStructureInstanceKHR){
            .transform.matrix = {{1, 0, 0, (float)i}, {0, 1, 0, 2.0f * (float)i}, {0, 0, 1, 0}},
            .mask = 0xff,
            .accelerationStructureReference = (uint64_t)structures[i]};
    host.instances =
        MAKE(VkAccelerationStructureGeometryKHR, .geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR,
             .geometry.instances = MAKE(VkAccelerationStructureGeometryInstancesDataKHR,
                                        .data.hostAddress = host.instance));
    VkAccelerationStructureBuildGeometryInfoKHR info = blas_info(BLASES, 0);
    info.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
    info.geometryCount = 1;
    info.pGeometries = &host.instances;
    GET_DEFERRED("a deferred build", build(host.operation, &info, BLASES));
}

/* ---- copies */

static void copy_through_memory(VkAccelerationStructureKHR structure)
{
    static char bytes[2 * STRUCTURE_SIZE] __attribute__((aligned(16)));
    const VkCopyAccelerationStructureToMemoryInfoKHR out =
        serialize_info(structure, (uintptr_t)bytes);
    const VkCopyMemoryToAccelerationStructureInfoKHR in =
        deserialize_info((uintptr_t)bytes, structure);
    CALL(CopyAccelerationStructureToMemoryKHR, device, VK_NULL_HANDLE, &out);
    GET_DEFERRED("vkCopyMemoryToAccelerationStructureKHR",
                 vk.CopyMemoryToAccelerationStructureKHR(device, host.operation, &in));
}

static void copy_all(void)
{
    const VkCopyAccelerationStructureInfoKHR copy =
        copy_info(structures[1], structures[3], VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR);
    CALL(CopyAccelerationStructureKHR, device, VK_NULL_HANDLE, &copy);
    copy_through_memory(structures[5]);
    copy_through_memory(structures[BLASES]);
    uint64_t size = 0;
    CALL(WriteAccelerationStructuresPropertiesKHR, device, 1, &structures[3],
         VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR, sizeof(size), &size,
         sizeof(size));
    if (!size)
        complain("no serialization size", 0);
}

/* ---- what became of it */

static void set_private_data(void)
{
    uint64_t value = 0;
    for (unsigned i = 0; i < STRUCTURES; i++)
        CALL(SetPrivateData, device, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
             (uint64_t)structures[i], host.slot, i);
    vk.GetPrivateData(device, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, (uint64_t)structures[7],
                      host.slot, &value);
    if (value != 7)
        complain("vkGetPrivateData", (int)value);
}

/* Every instance is hit where it is. */
static void trace_all(void)
{
    AssayRay rays[BLASES];
    AssayHit hits[BLASES];
    for (unsigned i = 0; i < BLASES; i++)
        rays[i] = (AssayRay){.origin = {-1, 2.0f * (float)i + 0.25f, 0.25f},
                             .direction = {1, 0, 0},
                             .tMax = 1000,
                             .cullMask = 0xff};
    const AssayTraceInfo info =
        trace_info((uint64_t)structures[BLASES], ASSAY_ACCURACY_EXACT, BLASES, rays, hits);
    memset(hits, 0, sizeof(hits));
    GET("vkTraceRaysASSAY", trace_rays(device, &info));
    for (unsigned i = 0; i < BLASES; i++)
        if (!hits[i].isHit || hits[i].instance != i || hits[i].t != (float)i + 1)
            complain("not the hit that was expected: ray", (int)i);
}

void record_all(void)
{
    if (!trace_rays)
        return;
    build_blases();
    build_tlas();
    copy_all();
    set_private_data();
    trace_all();
}
