/* SPDX-License-Identifier: Apache-2.0 */
/* Facts: copies, by value, of what the state knows about something at one moment. Rules see only
 * facts, so no lock is held while they run and no object can die under them. */
#ifndef ASSAY_STATE_FACTS_H
#define ASSAY_STATE_FACTS_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

/* An answer that may not be known; a rule stays silent on UNKNOWN. A byte, so that facts that are
 * copied for every build stay small. */
enum __attribute__((packed)) tristate { UNKNOWN, NO, YES };

/* Bytes [begin, end) of one VkDeviceMemory; memory VK_NULL_HANDLE: none, or not known. */
struct memory_span {
    VkDeviceMemory memory;
    VkDeviceSize begin, end;
};

static inline struct memory_span memory_span_of(VkDeviceMemory memory, VkDeviceSize begin,
                                                VkDeviceSize size)
{
    return memory ? (struct memory_span){memory, begin, begin + size} : (struct memory_span){0};
}

/* Bytes [begin, end) of a sparse buffer: where they lie depends on when. */
struct sparse_bytes {
    VkBuffer buffer;
    uint64_t buffer_id;
    VkDeviceSize begin, end;
};

/* What vkQueueBindSparse binds to a buffer. */
struct sparse_binding {
    VkBuffer buffer;
    VkDeviceMemory memory;
    uint64_t buffer_id, memory_id; /* 0: not known; of memory also where it unbinds */
    VkDeviceSize offset, size, memory_offset;
};

/* Stands for host memory that is no VkDeviceMemory, in spans of host addresses. */
static inline VkDeviceMemory memory_of_host(void)
{
    return (VkDeviceMemory)(uintptr_t)UINT64_MAX;
}

/* An acceleration structure. All but the handle are what its record says, one cache line. */
struct accel_facts {
    uint64_t id;       /* never reused, as handles are; 0 unless alive */
    VkDeviceSize size; /* bytes, VkAccelerationStructureCreateInfoKHR::size */
    VkBuffer buffer;
    uint64_t buffer_id;    /* is_sparse: of that buffer */
    VkDeviceMemory memory; /* where the structure lies, if in one piece; else null */
    VkDeviceSize begin;    /* of its bytes there, or in a sparse buffer */
    VkAccelerationStructureTypeKHR type;
    VkAccelerationStructureCreateFlagsKHR create_flags;
    enum tristate alive;    /* a structure of this device */
    bool of_another_device; /* alive == NO, but another VkDevice has this handle */
    bool details_known;     /* type, create_flags, size and buffer are meaningful */
    enum tristate backed;   /* its buffer range lies in live memory */
    bool is_sparse;         /* it is in a sparse buffer, see resources_find_pieces */
    /* Of its memory, unless that is sparse: host-visible; of several instances. */
    enum tristate host_visible, multi_instance;
    bool by_address; /* created by vkCreateAccelerationStructure2KHR */
    VkAccelerationStructureKHR handle;
};

/* A VkDeferredOperationKHR. */
struct deferred_operation_facts {
    VkDeferredOperationKHR handle;
    enum tristate alive;    /* an operation of this device */
    bool of_another_device; /* alive == NO, but another VkDevice has this handle */
    enum tristate complete; /* what was deferred to it before */
};

enum __attribute__((packed)) address_status {
    ADDRESS_UNKNOWN,   /* not looked up, or the state cannot tell */
    ADDRESS_NULL,      /* 0 */
    ADDRESS_NOWHERE,   /* in no buffer whose address was retrieved */
    ADDRESS_UNBOUND,   /* only in buffers that are not bound to live memory */
    ADDRESS_IN_BUFFER, /* in at least one bound (or sparse) buffer */
};

/* A device address. Aliasing buffers may share it: usage is what any of them has, bytes_left what
 * the one that reaches furthest leaves from the address to its end. */
struct address_facts {
    VkDeviceAddress address;
    VkDeviceSize bytes_left;
    VkBufferUsageFlags2 usage;
    VkBuffer buffer;       /* the one that reaches furthest */
    uint64_t buffer_id;    /* of that one; never reused */
    VkDeviceMemory memory; /* of that one; null: none, not known, or in pieces */
    VkDeviceSize begin;    /* of the address in that memory, or in a sparse buffer */
    enum address_status status;
    bool is_sparse;    /* `buffer` is sparse */
    bool is_shared;    /* bytes of `buffer` are also those of others */
    bool is_protected; /* any of the buffers is: only protected commands may read it */
};

/* A buffer, by its handle. */
struct buffer_facts {
    VkBuffer handle;
    uint64_t id; /* never reused; 0 unless alive */
    enum tristate alive;
    bool of_another_device; /* alive == NO, but another VkDevice has this handle */
    VkDeviceSize size;      /* these three: where alive == YES */
    VkBufferUsageFlags2 usage;
    enum address_status status; /* of its bytes, had they addresses */
};

/* What vkGetAccelerationStructureMemoryRequirementsNV of the next layer says, bytes. */
struct nv_size_facts {
    bool known;
    VkDeviceSize object, build_scratch, update_scratch;
};

/* How vkBindAccelerationStructureMemoryNV has bound a structure. */
enum nv_binding {
    NV_BINDING_UNKNOWN,
    NV_UNBOUND,
    NV_MEMORY_FREED,
    NV_MEMORY_TOO_SMALL, /* it goes beyond the end */
    NV_BOUND,
};

/* A structure of VK_NV_ray_tracing. */
struct nv_accel_facts {
    VkAccelerationStructureNV handle;
    uint64_t id; /* never reused; 0 unless alive */
    enum tristate alive;
    bool of_another_device; /* alive == NO, but another VkDevice has this handle */
    enum nv_binding binding;
    VkDeviceMemory memory;   /* that it is bound to, or was */
    struct memory_span span; /* where it lies; memory null: not known */
    struct nv_size_facts sizes;
    struct nv_shape *created; /* a reference, for who asked to release; NULL: not known */
};

enum command_buffer_state {
    COMMAND_BUFFER_UNKNOWN,
    COMMAND_BUFFER_INITIAL,
    COMMAND_BUFFER_RECORDING,
    COMMAND_BUFFER_EXECUTABLE,
    COMMAND_BUFFER_INVALID,
};

struct command_buffer_facts {
    VkCommandBuffer handle;
    VkQueueFlags queue_flags; /* of the pool's queue family; 0: unknown */
    enum command_buffer_state state;
    uint32_t build_index; /* builds recorded before this call */
    enum tristate alive;
    enum tristate is_protected;
    enum tristate in_render_pass; /* render pass instance or dynamic rendering */
    enum tristate suspended;      /* between a suspended rendering and its resumption */
    enum tristate in_video_coding;
};

/* What vkGetAccelerationStructureBuildSizesKHR of the next layer says, bytes. */
struct size_facts {
    bool known;
    VkDeviceSize acceleration_structure, build_scratch, update_scratch;
};

/* What a device has of micromaps: features that were enabled, and limits. */
struct micromap_support {
    bool any;      /* one of the three extensions is enabled: geometries may have micromaps */
    bool ext, khr; /* the feature `micromap` of VK_EXT_ or VK_KHR_opacity_micromap */
    struct {
        uint32_t opacity_2_state_level, opacity_4_state_level;
    } ext_limits;
    struct {
        uint32_t opacity_2_state_level, opacity_4_state_level, lossy_4_state_level;
        uint64_t triangles;
    } khr_limits;
    uint32_t displacement_level; /* maxDisplacementMicromapSubdivisionLevel */
};

/* A VkMicromapEXT. */
struct micromap_facts {
    VkMicromapEXT handle;
    uint64_t id;         /* never reused, nor that of an acceleration structure; 0 unless alive */
    enum tristate alive; /* a micromap of this device */
    bool of_another_device; /* alive == NO, but another VkDevice has this handle */
    VkMicromapTypeEXT type; /* alive == YES */
};

/* A device: what was enabled, and the limits. Never changes after its creation. */
struct device_facts {
    VkDevice handle;
    uint32_t api_version;
    /* An extension that the registry of this build doesn't know is enabled: enumerants and
     * structures that look wrong may be right. */
    bool newer_than_registry;
    /* Commands that the layer doesn't see may build acceleration structures. */
    bool has_other_builders;
    bool acceleration_structure, acceleration_structure_indirect_build,
        acceleration_structure_host_commands;                  /* features */
    bool spheres, linear_swept_spheres, dense_geometry_format; /* likewise */
    struct {
        bool acceleration_structure, motion_blur_nv, opacity_micromap_ext, opacity_micromap_khr,
            displacement_micromap_nv, linear_swept_spheres_nv, dense_geometry_format_amdx,
            position_fetch_khr, cluster_acceleration_structure_nv, ray_tracing_nv;
        bool adds_to_inputs; /* any of those that chain structures to geometries */
    } extension;             /* enabled */
    VkPhysicalDeviceAccelerationStructurePropertiesKHR limits;
    struct micromap_support micromap;
    VkPhysicalDeviceRayTracingPropertiesNV nv_limits;
};

#endif
