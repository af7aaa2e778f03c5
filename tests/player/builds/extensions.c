/* SPDX-License-Identifier: Apache-2.0 */
/* Geometries of extensions in builds, of NVIDIA:
 *
 *     [motion PLACE] [spheres PLACE] [swept PLACE] [list] [displaced MICROMAP]
 *     [biases PLACE] [vectors PLACE] [primitive-flags PLACE]
 *                              what a displaced build reads, instead of V0
 *     [displaced-indices PLACE]                               likewise; they have 16 bits
 *
 * of VK_AMDX_dense_geometry_format:
 *
 *     [dense PLACE] [triangles COUNT] [dense-vertices COUNT] [max-primitive INDEX]
 *     [max-geometry INDEX] [size BYTES]
 *
 * and of VK_KHR_opacity_micromap:
 *
 *     [triangle-array PLACE]   the structure is a micromap
 *     [opacity STRUCTURE]      which the triangles of a structure have
 *
 * `mixed`, behind a micromap: with the usages of play_mixed_usages(). */
#include "tests/player/builds/builds.h"

/* Spheres and linear swept spheres share these members. */
#define SPHERES_OF(line, word)                                                                     \
    .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT, .vertexData = build_input(line, "V0"),             \
    .vertexStride = 12, .radiusFormat = VK_FORMAT_R32_SFLOAT,                                      \
    .radiusData = build_input(line, word), .radiusStride = 4, .indexType = VK_INDEX_TYPE_UINT32,   \
    .indexData = build_input(line, "I0"), .indexStride = 4

static void begin_dense(struct build_line *line, struct one_build *build, const char *word)
{
    build->chained.dense =
        MAKE(VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX,
             .compressedData = build_input(line, word), .dataSize = 512, .numTriangles = PRIMITIVES,
             .numVertices = 4, .maxPrimitiveIndex = 1, .maxGeometryIndex = 1,
             .format = VK_COMPRESSED_TRIANGLE_FORMAT_DGF1_AMDX);
    build->geometry.geometryType = VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX;
    build->geometry.pNext = &build->chained.dense;
}

/* The micromap has a triangle for each primitive, and all that it reads is in V0. */
static void displace(const struct build_line *line, struct one_build *build, const char *name)
{
    const VkDeviceOrHostAddressConstKHR data = build_input(line, "V0");
    build->usage = (VkMicromapUsageEXT){PRIMITIVES, 0,
                                        VK_DISPLACEMENT_MICROMAP_FORMAT_64_TRIANGLES_64_BYTES_NV};
    build->displaced =
        MAKE(VkAccelerationStructureTrianglesDisplacementMicromapNV,
             .displacementBiasAndScaleFormat = VK_FORMAT_R32G32_SFLOAT,
             .displacementVectorFormat = VK_FORMAT_R32G32B32_SFLOAT,
             .displacementBiasAndScaleBuffer = data, .displacementBiasAndScaleStride = 8,
             .displacementVectorBuffer = data, .displacementVectorStride = 12,
             .displacedMicromapPrimitiveFlags = data, .displacedMicromapPrimitiveFlagsStride = 1,
             .indexType = VK_INDEX_TYPE_UINT32, .indexBuffer = data, .indexStride = 4,
             .usageCountsCount = 1, .pUsageCounts = &build->usage,
             .micromap = play_object(line->play, name)->micromap);
    build->geometry.geometry.triangles.pNext = &build->displaced;
}

/* A micromap of VK_KHR_opacity_micromap, which is a structure. */
static void begin_micromap(const struct build_line *line, struct one_build *build, const char *word)
{
    build->usage_khr = (VkMicromapUsageKHR){PRIMITIVES, 0, VK_OPACITY_MICROMAP_FORMAT_2_STATE_KHR};
    build->chained.micromap_khr =
        MAKE(VkAccelerationStructureGeometryMicromapDataKHR, .usageCountsCount = 1,
             .pUsageCounts = &build->usage_khr, .data = build_input(line, "V0").deviceAddress,
             .triangleArray = build_input(line, word).deviceAddress,
             .triangleArrayStride = sizeof(VkMicromapTriangleEXT));
    build->info.type = VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
    build->geometry.geometryType = VK_GEOMETRY_TYPE_MICROMAP_KHR;
    build->geometry.pNext = &build->chained.micromap_khr;
}

static void mix_micromap_khr(struct one_build *build, const VkMicromapUsageEXT *from)
{
    for (unsigned i = 0; i < PLAY_MIXED_USAGES; i++)
        build->mixed_khr[i] = (VkMicromapUsageKHR){from[i].count, from[i].subdivisionLevel,
                                                   (VkOpacityMicromapFormatKHR)from[i].format};
    build->chained.micromap_khr.usageCountsCount = PLAY_MIXED_USAGES;
    build->chained.micromap_khr.pUsageCounts = build->mixed_khr;
}

void build_mix_usages(const struct play *play, struct one_build *build)
{
    const VkMicromapUsageEXT *usages = play_mixed_usages(play);
    build->micromap.usageCountsCount = build->displaced.usageCountsCount = PLAY_MIXED_USAGES;
    build->micromap.pUsageCounts = build->displaced.pUsageCounts = usages;
    if (build->geometry.geometryType == VK_GEOMETRY_TYPE_MICROMAP_KHR)
        mix_micromap_khr(build, usages);
}

static bool read_displacement(const struct build_line *line,
                              VkAccelerationStructureTrianglesDisplacementMicromapNV *displaced,
                              const char *option, const char *word)
{
    if (play_is(option, "biases")) {
        displaced->displacementBiasAndScaleBuffer = build_input(line, word);
    } else if (play_is(option, "vectors")) {
        displaced->displacementVectorBuffer = build_input(line, word);
    } else if (play_is(option, "primitive-flags")) {
        displaced->displacedMicromapPrimitiveFlags = build_input(line, word);
    } else if (play_is(option, "displaced-indices")) {
        displaced->indexBuffer = build_input(line, word);
        displaced->indexType = VK_INDEX_TYPE_UINT16;
        displaced->indexStride = sizeof(uint16_t);
    } else {
        return false;
    }
    return true;
}

/* An option of an extension's geometry. */
bool build_read_extension(struct build_line *line, struct one_build *build, const char *option,
                          const char *word)
{
    if (play_is(option, "motion")) {
        build->chained.motion = MAKE(VkAccelerationStructureGeometryMotionTrianglesDataNV,
                                     .vertexData = build_input(line, word));
        build->geometry.geometry.triangles.pNext = &build->chained.motion;
    } else if (play_is(option, "spheres")) {
        build->chained.spheres =
            MAKE(VkAccelerationStructureGeometrySpheresDataNV, SPHERES_OF(line, word));
        build->geometry.geometryType = VK_GEOMETRY_TYPE_SPHERES_NV;
        build->geometry.pNext = &build->chained.spheres;
    } else if (play_is(option, "swept")) {
        build->chained.swept =
            MAKE(VkAccelerationStructureGeometryLinearSweptSpheresDataNV, SPHERES_OF(line, word),
                 .indexingMode = VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV);
        build->geometry.geometryType = VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV;
        build->geometry.pNext = &build->chained.swept;
    } else if (play_is(option, "dense")) {
        begin_dense(line, build, word);
    } else if (play_is(option, "opacity")) {
        build->opacity = MAKE(VkAccelerationStructureTrianglesOpacityMicromapKHR,
                              .indexType = VK_INDEX_TYPE_NONE_KHR,
                              .micromap = play_object(line->play, word)->structure);
        build->geometry.geometry.triangles.pNext = &build->opacity;
    } else if (play_is(option, "displaced")) {
        displace(line, build, word);
    } else if (play_is(option, "triangle-array")) {
        begin_micromap(line, build, word);
    } else {
        return read_displacement(line, &build->displaced, option, word);
    }
    return true;
}
