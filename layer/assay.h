/* SPDX-License-Identifier: Apache-2.0 */
/* What VK_LAYER_ASSAY_validation offers to tests and tools beyond Vulkan: tracing of acceleration
 * structures on the CPU, and counters. Only for devices of backend cpu (assay_validation.backend =
 * cpu) that enable VK_KHR_acceleration_structure or VK_NV_ray_tracing, and counters for such
 * devices of backend driver at level content, too: vkGetDeviceProcAddr answers NULL for others.
 *
 *     PFN_vkTraceRaysASSAY trace =
 *         (PFN_vkTraceRaysASSAY)vkGetDeviceProcAddr(device, "vkTraceRaysASSAY");
 *
 * Structures of these functions only grow at their ends, and each function says how it is told
 * their size. */
#ifndef ASSAY_H
#define ASSAY_H

#include <vulkan/vulkan_core.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- vkTraceRaysASSAY */

/* Follows "Ray Traversal" of the Vulkan specification. Exact: what a ray meets is decided in exact
 * arithmetic wherever rounding could matter, so that no ray passes between two triangles that share
 * an edge or a vertex, or hits both. Robust: padded boxes (Ize 2013) and the watertight test of
 * Woop 2013; a ray through a shared edge may hit either or both. Fast: plain float arithmetic; may
 * also miss. */
typedef enum AssayAccuracy {
    ASSAY_ACCURACY_FAST = 0,
    ASSAY_ACCURACY_ROBUST = 1,
    ASSAY_ACCURACY_EXACT = 2,
} AssayAccuracy;

/* The ray is origin + t * direction, in the structure's space: of the world for a top-level
 * structure, the geometries' own for a bottom-level one. `t` is in lengths of `direction`, which
 * need not be 1. Triangles are hit where tMin < t < tMax, AABBs where [tMin, tMax] meets the ray's
 * part within the box. A ray with a NaN, an infinite origin or direction, no direction or a
 * negative tMin hits nothing.
 *
 * flags: values of SPIR-V's Ray Flags: 0x1 opaque, 0x2 no opaque, 0x4 terminate on first hit, 0x10
 * and 0x20 cull back- and front-facing triangles, 0x40 and 0x80 cull opaque and no opaque, 0x100
 * and 0x200 skip triangles and AABBs.
 * cullMask: its low 8 bits are compared with the instances' masks; unused for a bottom level.
 * time: from 0 to 1, for what moves (VK_NV_ray_tracing_motion_blur); beyond counts as the nearer
 * end. */
typedef struct AssayRay {
    float origin[3], tMin;
    float direction[3], tMax;
    uint32_t flags, cullMask;
    float time; /* rays of a size without it have time 0 */
} AssayRay;

/* The nearest hit, or the first found with flag 0x4. Unless there is a function that says
 * otherwise, every AABB and every triangle counts, opaque or not, as if each shader confirmed it;
 * an AABB where the ray enters, or at tMin where it begins inside. Of hits at the same t any may be
 * the one. */
typedef struct AssayHit {
    VkBool32 isHit; /* VK_FALSE: all else is 0 */
    float t;
    float u, v;                      /* weights of a triangle's second and third vertex, before
                                        it was displaced */
    uint32_t geometry, primitive;    /* indices within the build */
    uint32_t instance;               /* index among all instances of the build */
    uint32_t customIndex, sbtOffset; /* of the instance, 24 bits each */
    VkBool32 isAabb, isFrontFacing, isOpaque;
} AssayHit;

/* What becomes of something that a ray meets, as intersection and any-hit shaders would say; the
 * candidates of one ray come in any order. For an AABB, `candidate->t` is where the ray enters it,
 * or tMin; write the t at which the ray meets what the box holds. An accepted t that isn't between
 * tMin and the nearest one accepted before is ignored. Called on the thread that traces. */
typedef enum AssayAnswer {
    ASSAY_ANSWER_IGNORE = 0,
    ASSAY_ANSWER_ACCEPT = 1, /* and go on with what is nearer, unless flag 0x4 is set */
    ASSAY_ANSWER_STOP = 2,   /* ignore it, and leave it at what was accepted before */
} AssayAnswer;
typedef AssayAnswer(VKAPI_PTR *PFN_AssayCandidate)(void *userData, uint32_t rayIndex,
                                                   AssayHit *candidate);

/* Traces `rayCount` rays against what `accelerationStructure` holds now, and writes one hit each: a
 * VkAccelerationStructureKHR or -NV, or what vkGetAccelerationStructureDeviceAddressKHR or
 * vkGetAccelerationStructureHandleNV tells of one. Bottom levels are found by the references of a
 * top level's instances; instances of what isn't built (any more) are not hit. On the caller's
 * thread; several may trace at once, and what is destroyed or rebuilt meanwhile is traced as it
 * was. Setting up takes time in proportion to the instances, so one call should have many rays.
 *
 * raySize and hitSize: sizeof(AssayRay), or what it was before rays had a time, and
 * sizeof(AssayHit).
 *
 * VK_SUCCESS; VK_ERROR_OUT_OF_HOST_MEMORY; VK_ERROR_VALIDATION_FAILED where the structure is none
 * of the device's or isn't built, an argument is out of range, rays can't be read or hits written.
 * After an error no hit has been written, unless memory ran out while micromaps were looked for. */
typedef struct AssayTraceInfo {
    uint64_t accelerationStructure;
    AssayAccuracy accuracy;
    uint32_t rayCount;
    size_t raySize, hitSize;
    const AssayRay *rays;
    AssayHit *hits;
    PFN_AssayCandidate candidate; /* NULL: all are accepted */
    void *userData;
} AssayTraceInfo;
typedef VkResult(VKAPI_PTR *PFN_vkTraceRaysASSAY)(VkDevice device, const AssayTraceInfo *info);

/* ---- vkGetCountersASSAY */

/* What the layer has done for the device since its creation; on backend driver it copies snapshots
 * and nothing else. Nothing is done before it is asked
 * for, so the difference between two readings is what lies between them. */
typedef struct AssayCounters {
    uint64_t builds;          /* trees built */
    uint64_t updates;         /* trees made from another one by an update */
    uint64_t copies;          /* clones, compactions, serializations, deserializations */
    uint64_t primitives;      /* that builds and updates were given */
    uint64_t bytesBuilt;      /* of trees built, updated, copied or deserialized */
    uint64_t bytesSerialized; /* written */
    uint64_t ownScratch;      /* host builds that could not use the scratch given to them */
    uint64_t rays;            /* traced */
    uint64_t nodesVisited;
    uint64_t instancesEntered;
    uint64_t primitivesTested;
    uint64_t exactCalls;     /* signs that needed exact arithmetic */
    uint64_t bytesSnapshot;  /* that command buffers were told to copy for their builds */
    uint64_t matrixProducts; /* of positions and the transforms of their geometries */
    uint64_t micromapsRead;  /* opacities that rays looked up in micromaps */
} AssayCounters;

/* Writes the first `size` bytes of the counters, at most sizeof(AssayCounters) of this header; of
 * counters that the layer doesn't know, 0. */
typedef void(VKAPI_PTR *PFN_vkGetCountersASSAY)(VkDevice device, size_t size,
                                                AssayCounters *counters);

#ifdef __cplusplus
}
#endif

#endif
