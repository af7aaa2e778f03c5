/* SPDX-License-Identifier: Apache-2.0 */
/* What VK_LAYER_ASSAY_validation adds for tests and tools: tracing of acceleration structures on
 * the CPU, and counters. vkGetDeviceProcAddr returns both functions for devices of backend cpu
 * (assay_validation.backend = cpu) that enable VK_KHR_acceleration_structure or VK_NV_ray_tracing.
 * On backend driver at level content it returns vkGetCountersASSAY for such devices. It returns
 * NULL for all other devices.
 *
 *     PFN_vkTraceRaysASSAY trace =
 *         (PFN_vkTraceRaysASSAY)vkGetDeviceProcAddr(device, "vkTraceRaysASSAY");
 *
 * Later versions only add members at the ends of these structures. The caller passes the size that
 * it was compiled with; the description of each function says how. */
#ifndef ASSAY_H
#define ASSAY_H

#include <vulkan/vulkan_core.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- vkTraceRaysASSAY */

/* Traversal follows "Ray Traversal" of the Vulkan specification.
 *
 * EXACT: exact arithmetic decides what a ray hits wherever rounding could matter. No ray passes
 * between two triangles that share an edge or a vertex, and no ray hits both.
 *
 * ROBUST: padded boxes (Ize 2013) and the watertight test of Woop 2013. A ray through a shared edge
 * may hit one triangle or both.
 *
 * FAST: plain float arithmetic. A ray may also miss a triangle. */
typedef enum AssayAccuracy {
    ASSAY_ACCURACY_FAST = 0,
    ASSAY_ACCURACY_ROBUST = 1,
    ASSAY_ACCURACY_EXACT = 2,
} AssayAccuracy;

/* The ray is origin + t * direction. Its space is world space for a top-level structure, and the
 * space of the geometries for a bottom-level one. `t` counts lengths of `direction`, which need not
 * be 1. A triangle is hit if tMin < t < tMax, an AABB if [tMin, tMax] overlaps the ray's part
 * within the box. A ray hits nothing if it has a NaN, an infinite origin or direction, a direction
 * of length 0 or a negative tMin.
 *
 * flags: SPIR-V's Ray Flags: 0x1 opaque, 0x2 no opaque, 0x4 terminate on first hit, 0x10 and 0x20
 * cull back- and front-facing triangles, 0x40 and 0x80 cull opaque and no opaque, 0x100 and 0x200
 * skip triangles and AABBs.
 *
 * cullMask: its low 8 bits are compared with the masks of instances; ignored for a bottom level.
 *
 * time: from 0 to 1, for motion (VK_NV_ray_tracing_motion_blur); clamped to that range. */
typedef struct AssayRay {
    float origin[3], tMin;
    float direction[3], tMax;
    uint32_t flags, cullMask;
    float time; /* if raySize excludes this member, the time is 0 */
} AssayRay;

/* The nearest hit, or with flag 0x4 the first hit found. Without a `candidate` function every AABB
 * and every triangle is accepted, opaque or not, as if its shader confirmed it. An AABB is hit at
 * the t where the ray enters it, or at tMin if the ray begins inside. If several hits have the same
 * t, any of them may be returned. */
typedef struct AssayHit {
    VkBool32 isHit; /* if VK_FALSE, all other members are 0 */
    float t;
    /* Barycentric weights of the triangle's second and third vertex, before displacement. */
    float u, v;
    uint32_t geometry, primitive;    /* indices within the build */
    uint32_t instance;               /* index among all instances of the build */
    uint32_t customIndex, sbtOffset; /* of the instance, 24 bits each */
    VkBool32 isAabb, isFrontFacing, isOpaque;
} AssayHit;

/* The result of a `candidate` function, which stands for the intersection and any-hit shaders. The
 * candidates of one ray come in any order. For an AABB, `candidate->t` is where the ray enters it,
 * or tMin; the function overwrites it with the t of the hit inside the box. An accepted t is
 * ignored if it lies outside [tMin, nearest t accepted before]. Called on the thread that traces.
 */
typedef enum AssayAnswer {
    ASSAY_ANSWER_IGNORE = 0,
    ASSAY_ANSWER_ACCEPT = 1, /* and continue with nearer candidates, unless flag 0x4 is set */
    ASSAY_ANSWER_STOP = 2,   /* ignore the candidate and end the ray with what was accepted */
} AssayAnswer;
typedef AssayAnswer(VKAPI_PTR *PFN_AssayCandidate)(void *userData, uint32_t rayIndex,
                                                   AssayHit *candidate);

/* Traces `rayCount` rays against the current contents of `accelerationStructure`, and writes one
 * hit each.
 *
 * accelerationStructure: a VkAccelerationStructureKHR or -NV, or the value that
 * vkGetAccelerationStructureDeviceAddressKHR or vkGetAccelerationStructureHandleNV returned. Bottom
 * levels are found by the references of a top level's instances. An instance is not hit if its
 * bottom level is not built or was destroyed.
 *
 * Traces on the caller's thread; several threads may trace at once. A structure that is destroyed
 * or rebuilt meanwhile is traced with its former contents. Setting up takes time in proportion to
 * the instances, so one call should have many rays.
 *
 * raySize: sizeof(AssayRay), or its value before rays had a time. hitSize: sizeof(AssayHit).
 *
 * Returns VK_SUCCESS; VK_ERROR_OUT_OF_HOST_MEMORY; or VK_ERROR_VALIDATION_FAILED if the structure
 * does not belong to the device or is not built, an argument is out of range, rays can't be read or
 * hits can't be written. After an error no hit has been written, unless memory ran out while
 * micromaps were looked up. */
typedef struct AssayTraceInfo {
    uint64_t accelerationStructure;
    AssayAccuracy accuracy;
    uint32_t rayCount;
    size_t raySize, hitSize;
    const AssayRay *rays;
    AssayHit *hits;
    PFN_AssayCandidate candidate; /* NULL: every candidate is accepted */
    void *userData;
} AssayTraceInfo;
typedef VkResult(VKAPI_PTR *PFN_vkTraceRaysASSAY)(VkDevice device, const AssayTraceInfo *info);

/* ---- vkGetCountersASSAY */

/* What the layer has done for the device since its creation. On backend driver only bytesSnapshot
 * counts. Backend cpu builds a BVH on first use, so the difference between two readings is the work
 * done between them. */
typedef struct AssayCounters {
    uint64_t builds;          /* BVHs built */
    uint64_t updates;         /* BVHs updated */
    uint64_t copies;          /* clones, compactions, serializations, deserializations */
    uint64_t primitives;      /* primitives given to builds and updates */
    uint64_t bytesBuilt;      /* size of the BVHs built, updated, copied or deserialized */
    uint64_t bytesSerialized; /* bytes of serialized structures written */
    uint64_t ownScratch;      /* host builds that could not use the scratch given to them */
    uint64_t rays;            /* traced */
    uint64_t nodesVisited;
    uint64_t instancesEntered;
    uint64_t primitivesTested;
    uint64_t exactCalls;     /* orientation signs that needed exact arithmetic */
    uint64_t bytesSnapshot;  /* bytes that command buffers copy as inputs of their builds */
    uint64_t matrixProducts; /* products of positions and the transforms of their geometries */
    uint64_t micromapsRead;  /* opacity values that rays looked up in micromaps */
} AssayCounters;

/* Writes the first `size` bytes of the counters, at most sizeof(AssayCounters) of this header.
 * Counters that the layer does not have are written as 0. */
typedef void(VKAPI_PTR *PFN_vkGetCountersASSAY)(VkDevice device, size_t size,
                                                AssayCounters *counters);

#ifdef __cplusplus
}
#endif

#endif
