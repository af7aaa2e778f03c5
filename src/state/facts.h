/* SPDX-License-Identifier: Apache-2.0 */
/* Facts: copies, by value, of the tracked state of one object at one time. Rules get only facts, so
 * no lock is held while they run, and a destroyed object does not affect them. */
#ifndef ASSAY_STATE_FACTS_H
#define ASSAY_STATE_FACTS_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/base/handle.h"

/* A rule stays silent on UNKNOWN. One byte, because facts are copied for every build. */
enum __attribute__((packed)) tristate { UNKNOWN, NO, YES };

static inline VkDeviceSize smaller_of(VkDeviceSize a, VkDeviceSize b)
{
    return a < b ? a : b;
}

/* Copies of micromaps are tracked and executed like those of structures. */
static inline VkCopyAccelerationStructureModeKHR copy_mode_of_micromap(VkCopyMicromapModeEXT mode)
{
    switch (mode) {
    case VK_COPY_MICROMAP_MODE_CLONE_EXT:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR;
    case VK_COPY_MICROMAP_MODE_SERIALIZE_EXT:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR;
    case VK_COPY_MICROMAP_MODE_DESERIALIZE_EXT:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR;
    case VK_COPY_MICROMAP_MODE_COMPACT_EXT:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR;
    default:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_MAX_ENUM_KHR;
    }
}

/* Bytes [begin, end) of one VkDeviceMemory; memory VK_NULL_HANDLE: none, or unknown. */
struct memory_span {
    VkDeviceMemory memory;
    VkDeviceSize begin, end;
};

static inline struct memory_span memory_span_of(VkDeviceMemory memory, VkDeviceSize begin,
                                                VkDeviceSize size)
{
    return memory ? (struct memory_span){memory, begin, begin + size} : (struct memory_span){0};
}

/* Bytes [begin, end) of a sparse buffer. Their memory changes with sparse bindings. */
struct sparse_bytes {
    VkBuffer buffer;
    uint64_t buffer_id;
    VkDeviceSize begin, end;
};

/* A binding of vkQueueBindSparse to a buffer. */
struct sparse_binding {
    VkBuffer buffer;
    VkDeviceMemory memory;
    uint64_t buffer_id, memory_id; /* 0: unknown; memory_id is also 0 if the binding unbinds */
    VkDeviceSize offset, size, memory_offset;
};

/* Returns the value of memory_span::memory in spans of host addresses. */
static inline VkDeviceMemory memory_of_host(void)
{
    return (VkDeviceMemory)(uintptr_t)UINT64_MAX;
}

/* An acceleration structure. All members but the handle are copied from its record; they take one
 * cache line. */
struct accel_facts {
    uint64_t id;       /* never reused, unlike handles; 0 unless alive */
    VkDeviceSize size; /* bytes, VkAccelerationStructureCreateInfoKHR::size */
    VkBuffer buffer;
    uint64_t buffer_id;    /* of `buffer`; never reused */
    VkDeviceMemory memory; /* the structure's memory; null if it is in several pieces */
    VkDeviceSize begin;    /* offset of its bytes in the memory, or in a sparse buffer */
    VkAccelerationStructureTypeKHR type;
    VkAccelerationStructureCreateFlagsKHR create_flags;
    enum tristate alive;    /* a structure of this device */
    bool of_another_device; /* alive == NO, but another VkDevice has this handle */
    bool details_known;     /* type, create_flags, size and buffer are meaningful */
    enum tristate backed;   /* its buffer range lies in live memory */
    bool is_sparse;         /* its buffer is sparse, see resources_find_pieces */
    /* Properties of its memory; UNKNOWN for a sparse buffer. multi_instance: the memory has several
     * instances (device groups). */
    enum tristate host_visible, multi_instance;
    bool by_address : 1;  /* created by vkCreateAccelerationStructure2KHR */
    bool fully_bound : 1; /* the same, with VK_ADDRESS_COMMAND_FULLY_BOUND_BIT_KHR */
    bool is_external : 1; /* its buffer may be bound to external memory, or is unknown */
    bool buffer_is_destroyed : 1;
    VkAccelerationStructureKHR handle;
};

/* A VkDeferredOperationKHR. */
struct deferred_operation_facts {
    VkDeferredOperationKHR handle;
    enum tristate alive;    /* an operation of this device */
    bool of_another_device; /* alive == NO, but another VkDevice has this handle */
    enum tristate complete; /* the command that was deferred to it before is complete */
};

enum __attribute__((packed)) address_status {
    ADDRESS_UNKNOWN,   /* not looked up, or not tracked */
    ADDRESS_NULL,      /* 0 */
    ADDRESS_NOWHERE,   /* outside of all buffers whose address was retrieved */
    ADDRESS_UNBOUND,   /* only in buffers that are not bound to live memory */
    ADDRESS_IN_BUFFER, /* in at least one bound (or sparse) buffer */
};

/* A device address. Several aliasing buffers may contain it; `buffer` is the one that ends last. */
struct address_facts {
    VkDeviceAddress address;
    VkDeviceSize bytes_left;   /* from the address to the end of `buffer` */
    VkBufferUsageFlags2 usage; /* of all these buffers together */
    VkBuffer buffer;
    uint64_t buffer_id;    /* of `buffer`; never reused */
    VkDeviceMemory memory; /* of `buffer`; null: none, unknown, or in several pieces */
    VkDeviceSize begin;    /* offset of the address in `memory`, or in a sparse buffer */
    enum address_status status;
    bool is_sparse;    /* `buffer` is sparse */
    bool is_shared;    /* `buffer` shares bytes with other buffers */
    bool is_protected; /* one of the buffers is protected: only protected commands may read it */
};

/* A buffer that a command names by its handle. */
struct buffer_facts {
    VkBuffer handle;
    uint64_t id; /* never reused; 0 unless alive */
    enum tristate alive;
    bool of_another_device;     /* alive == NO, but another VkDevice has this handle */
    VkDeviceSize size;          /* if alive == YES */
    VkBufferUsageFlags2 usage;  /* if alive == YES */
    VkBufferCreateFlags flags;  /* if alive == YES */
    enum address_status status; /* if alive == YES: as if its bytes had addresses */
};

/* Bytes that vkGetAccelerationStructureMemoryRequirementsNV of the next layer returns. */
struct nv_size_facts {
    bool known;
    VkDeviceSize object, build_scratch, update_scratch;
    VkDeviceSize alignment; /* of the object in memory; 0: unknown */
    uint32_t memory_types;  /* VkMemoryRequirements::memoryTypeBits of the object; 0: unknown */
};

/* The memory binding of a VkAccelerationStructureNV. */
enum nv_binding {
    NV_BINDING_UNKNOWN,
    NV_UNBOUND,
    NV_MEMORY_FREED,
    NV_MEMORY_TOO_SMALL, /* the structure extends beyond the end of the memory */
    NV_BOUND,
};

/* A VkAccelerationStructureNV. */
struct nv_accel_facts {
    VkAccelerationStructureNV handle;
    uint64_t id; /* never reused; 0 unless alive */
    enum tristate alive;
    bool of_another_device; /* alive == NO, but another VkDevice has this handle */
    enum nv_binding binding;
    VkDeviceMemory memory;   /* bound now, or until it was freed */
    struct memory_span span; /* its bytes; memory null: unknown */
    struct nv_size_facts sizes;
    struct nv_shape *created; /* its create info; a reference that the caller of the look-up
                                 releases; NULL: unknown */
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
    uint32_t id;              /* never reused; 0 unless alive */
    VkQueueFlags queue_flags; /* of the pool's queue family; 0: unknown */
    enum command_buffer_state state;
    uint32_t build_index; /* builds recorded before this call */
    enum tristate alive;
    enum tristate is_protected;
    enum tristate in_render_pass; /* render pass instance or dynamic rendering */
    enum tristate suspended;      /* between a suspended rendering and its resumption */
    enum tristate in_video_coding;
};

/* Bytes that vkGetAccelerationStructureBuildSizesKHR of the next layer returns. */
struct size_facts {
    bool known;
    VkDeviceSize acceleration_structure, build_scratch, update_scratch;
};

/* Bytes that vkGetMicromapBuildSizesEXT of the next layer returns. */
struct micromap_size_facts {
    bool known;
    VkDeviceSize micromap, build_scratch;
};

/* Enabled features and limits of micromaps. */
struct micromap_support {
    bool any;      /* one of the three micromap extensions is enabled */
    bool ext, khr; /* feature `micromap` of VK_EXT_ or VK_KHR_opacity_micromap */
    bool host_commands, capture_replay; /* features of VK_EXT_opacity_micromap */
    struct {
        uint32_t opacity_2_state_level, opacity_4_state_level;
    } ext_limits;
    struct {
        uint32_t opacity_2_state_level, opacity_4_state_level, lossy_4_state_level;
        uint64_t triangles;
    } khr_limits;
    uint32_t displacement_level; /* maxDisplacementMicromapSubdivisionLevel */
};

/* Features and limits of builds of structures at addresses. An alignment of 0 is unknown. */
struct cluster_support {
    bool feature; /* clusterAccelerationStructure */
    VkPhysicalDeviceClusterAccelerationStructurePropertiesNV limits;
};
struct partition_support {
    bool feature;     /* partitionedAccelerationStructure */
    uint32_t maximum; /* maxPartitionCount */
};

/* A VkMicromapEXT. */
struct micromap_facts {
    VkMicromapEXT handle;
    uint64_t id;            /* never reused, nor equal to that of a structure; 0 unless alive */
    enum tristate alive;    /* a micromap of this device */
    bool of_another_device; /* alive == NO, but another VkDevice has this handle */
    /* The following if alive == YES; see struct accel_facts. */
    VkMicromapTypeEXT type;
    VkMicromapCreateFlagsEXT create_flags;
    VkDeviceSize size; /* bytes, VkMicromapCreateInfoEXT::size */
    VkBuffer buffer;
    uint64_t buffer_id; /* of `buffer`; never reused; 0: unknown */
    enum tristate backed, host_visible, multi_instance;
    bool is_sparse, buffer_is_destroyed;
    struct memory_span span; /* its bytes; memory null: unknown */
};

/* A VkQueryPool. */
struct query_pool_facts {
    VkQueryPool handle;
    enum tristate alive;    /* a pool of this device */
    bool of_another_device; /* alive == NO, but another VkDevice has this handle */
    VkQueryType type;       /* type and count: if alive == YES */
    uint32_t count;
};

/* Enabled extensions and features, and limits of a device. Constant after its creation. */
struct device_facts {
    VkDevice handle;
    uint32_t api_version;
    /* An enabled extension is missing in the registry of this build. So enumerants and structures
     * that are unknown to the layer may be valid. */
    bool newer_than_registry;
    /* Acceleration structures without a handle may be built, or by commands that the layer does not
     * intercept. */
    bool has_other_builders;
    bool has_queues; /* it was created with a queue */
    /* Extensions that add enumerants and structures: bits by registry_owners[]. */
    uint64_t owners;
    /* Features. */
    bool acceleration_structure, acceleration_structure_indirect_build,
        acceleration_structure_host_commands, accel_capture_replay;
    bool device_fault, ray_tracing_maintenance1, synchronization2, multiview;
    bool spheres, linear_swept_spheres, dense_geometry_format;
    bool device_address_commands, buffer_device_address_multi_device,
        descriptor_buffer_capture_replay;
    bool null_descriptor; /* nullDescriptor is enabled, or may be */
    bool is_group;        /* it was created with multiple physical devices */
    /* Extensions. */
    struct {
        bool acceleration_structure, motion_blur_nv, opacity_micromap_ext, opacity_micromap_khr,
            displacement_micromap_nv, linear_swept_spheres_nv, dense_geometry_format_amdx,
            position_fetch_khr, cluster_acceleration_structure_nv, ray_tracing_nv;
        bool adds_to_inputs; /* one whose structures extend geometries is enabled */
    } extension;
    VkPhysicalDeviceAccelerationStructurePropertiesKHR limits;
    struct micromap_support micromap;
    VkPhysicalDeviceRayTracingPropertiesNV nv_limits;
    struct cluster_support clusters;
    struct partition_support partitions;
    size_t
        accel_capture_size; /* accelerationStructureCaptureReplayDescriptorDataSize; 0: unknown */
    enum tristate protected_no_fault; /* asked for with VK_KHR_device_address_commands only */
};

#endif
