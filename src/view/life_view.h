/* SPDX-License-Identifier: Apache-2.0 */
/* The views of the commands about acceleration structures and micromaps that are no builds of
 * structures: what they create, copy, query and destroy. The forms of a command (in a command
 * buffer or on the host, of the extensions KHR, EXT and NV) share a view, so that one rule
 * validates all of them. Facts about objects are unknown below level STATE. */
#ifndef ASSAY_VIEW_LIFE_VIEW_H
#define ASSAY_VIEW_LIFE_VIEW_H

#include "src/state/resources/resources.h"
#include "src/view/finding.h"
#include "src/view/micromap_view.h"
#include "src/view/view.h"

/* A structure or micromap that a command names by its handle. */
struct life_object {
    /* VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV or
     * VK_OBJECT_TYPE_MICROMAP_EXT */
    VkObjectType object_type;
    uint64_t handle;
    uint64_t id; /* see struct accel_facts; 0 unless alive */
    enum tristate alive;
    bool of_another_device; /* alive == NO, but another VkDevice has this handle */
    bool details_known;     /* type, create_flags, size and buffer are meaningful */
    uint32_t type;          /* VkAccelerationStructureTypeKHR or VkMicromapTypeEXT */
    VkFlags create_flags;   /* NV: VkAccelerationStructureInfoNV::flags */
    VkDeviceSize size;      /* bytes, of the create info; NV: that the next layer requires */
    VkBuffer buffer;
    uint64_t buffer_id;                         /* of `buffer`; never reused */
    bool buffer_is_destroyed;                   /* then another VkBuffer may have its handle */
    enum tristate backed;                       /* all its bytes lie in live memory */
    bool is_sparse;                             /* its buffer is sparse */
    enum tristate host_visible, multi_instance; /* see struct accel_facts */
    bool by_address;                            /* created by vkCreateAccelerationStructure2KHR */
    struct memory_span span;                    /* its bytes; memory null: unknown */
};

static inline struct value life_object_value(const struct life_object *object_)
{
    return object(object_->object_type, object_->handle);
}

/* Fills the finding for an object in a buffer without live memory. */
static inline bool violated_by_buffer_of(const struct life_object *object_, struct finding *finding,
                                         const char *field)
{
    const struct holding_buffer held_by =
        holding_buffer_of(object_->buffer, object_->buffer_id, object_->buffer_is_destroyed);
    return violated(finding, field, "{} lies in {}, {}", life_object_value(object_), held_by.value,
                    phrase(held_by.lacks));
}

/* The micromaps that serialized data refer to, as far as they are known. */
struct referenced_micromaps {
    struct micromap_shape *items;
    uint32_t count, capacity;
};

/* Serialized data that the host reads, from level CONTENT on. Zero where unknown. */
struct serialized_facts {
    enum tristate compatible; /* the physical device can read this version */
    /* The following are not of micromaps of VK_EXT_opacity_micromap. */
    bool has_sizes;
    uint64_t size, deserialized_size; /* bytes, as the header says */
    uint64_t header_size;             /* bytes, with its references or blocks; or a lower bound */
    /* What is in its blocks, if the data are compatible. */
    uint32_t invalid_type;
    bool has_micromaps;
    VkDeviceAddress invalid_address;        /* of a micromap */
    struct referenced_micromaps *micromaps; /* to which the reader adds; or NULL */
};

enum copy_direction { COPY_BETWEEN_OBJECTS, COPY_TO_MEMORY, COPY_FROM_MEMORY };

/* A copy of a structure or micromap. */
struct copy_view {
    const struct call_view *call;
    enum copy_direction direction;
    /* The mode of a copy of a micromap is the mode of structures that has the same name, and
     * MAX_ENUM for any other value. */
    VkCopyAccelerationStructureModeKHR mode;
    struct value given_mode; /* as the command spells it */
    /* COPY_TO_MEMORY has no dst, and COPY_FROM_MEMORY no src: these have the handle 0. */
    struct life_object src, dst;
    /* The memory of these two directions. */
    bool is_on_host;
    uint64_t address;
    bool memory_unreadable;      /* on the host: the header of serialized data is not there */
    struct address_facts memory; /* in command buffers, from level STATE on */
    struct serialized_facts data;
};

/* The creation of a structure or micromap. */
struct create_view {
    const struct call_view *call;
    bool is_micromap, is_nv;
    uint32_t type; /* VkAccelerationStructureTypeKHR, or VkMicromapTypeEXT */
    VkFlags create_flags;
    VkDeviceSize offset, size;
    VkDeviceAddress device_address;          /* to be replayed; 0: none */
    bool has_motion_info, has_captured_data; /* the pNext chain has such a structure */
    bool chain_known;                        /* the whole chain is readable */
    /* From level STATE on: the buffer. vkCreateAccelerationStructure2KHR: the one at `address`,
     * unknown if several buffers are there. */
    struct buffer_facts buffer;
    /* vkCreateAccelerationStructure2KHR only. */
    bool by_address;
    VkFlags address_flags;
    VkDeviceAddress address;
    struct address_facts storage; /* from level STATE on */
    /* vkCreateAccelerationStructureNV only. */
    VkDeviceSize compacted_size;
    const VkAccelerationStructureInfoNV *nv_info;
};

/* A command that writes a property of several structures to a query pool or to host memory. */
struct query_view {
    const struct call_view *call;
    uint32_t count; /* of structures */
    VkQueryType type;
    /* In command buffers. */
    struct query_pool_facts pool; /* from level STATE on */
    uint32_t first_query;
    /* On the host. */
    size_t data_size, stride; /* bytes */
    void *data;
};

/* One structure of such a command. */
struct queried_view {
    const struct query_view *query;
    uint32_t index;
    struct life_object object;
};

/* A read of results of a pool whose queries are of a property of structures or micromaps. */
struct read_queries_view {
    VkQueryPool pool;
    uint32_t number;       /* of the first query that no command has reset or written */
    bool is_uninitialized; /* there is one */
};

/* A query of the sizes that a build needs. */
struct size_query_view {
    const struct call_view *call;
    VkAccelerationStructureBuildTypeKHR build_type;
    const VkAccelerationStructureBuildGeometryInfoKHR *info; /* NULL: unreadable */
    /* info->geometryCount elements, or NULL if neither array is readable. */
    const VkAccelerationStructureGeometryKHR *geometries;
    const VkAccelerationStructureGeometryKHR *const *geometry_pointers;
    const void *counts_argument;
    const uint32_t *counts; /* NULL: unreadable */
};

/* A VkMicromapBuildInfoEXT, of a build or of a query of the sizes of a build. */
struct micromap_info_view {
    const struct call_view *call;
    const VkMicromapBuildInfoEXT *info;
    struct micromap_usages usages;
};

/* A build of a micromap: one element of pInfos. */
struct built_micromap_view {
    const struct call_view *call;
    const VkMicromapBuildInfoEXT *info;
    bool count_known;
    uint64_t triangle_count; /* the sum of the usage counts */
    /* From level STATE on. */
    struct life_object dst;
    struct micromap_size_facts sizes;
    struct address_facts data, triangles, scratch; /* in command buffers */
    /* On the host: the triangles and the scratch; and the data of the first triangle whose data is
     * not there. */
    struct host_bytes host_triangles, host_scratch, host_data;
    uint64_t triangle; /* whose data `host_data` is */
};

/* The micromap triangles that a build reads. */
struct micromap_triangles_view {
    const struct call_view *call;
    VkMicromapTypeEXT type;
    const uint8_t *first; /* `count` VkMicromapTriangleEXT, which may be misaligned */
    uint64_t count, stride;
};

/* A query of the address or the handle of a structure. */
struct lookup_view {
    const struct call_view *call;
    struct life_object object;
    size_t data_size;
    struct buffer_facts buffer; /* of the object, from level STATE on */
};

/* A submitted command that uses a structure or micromap and is not complete, as far as the
 * application has observed. */
struct pending_use {
    enum build_command command;
    VkCommandBuffer command_buffer; /* may be a secondary one */
    VkQueue queue;
    uint64_t submission; /* see struct order_batch */
    uint64_t timeout; /* of a wait of the host since then that returned VK_TIMEOUT, in ns; or 0 */
};

/* An instance of a build that refers to a structure which was destroyed before the build was
 * complete, as far as the application had observed. */
struct pending_instance {
    enum build_command command;
    uint32_t index;
    VkDeviceAddress reference;
};

/* What a command may use: one of these. */
struct used_object {
    uint64_t id;              /* of a structure or micromap */
    uint64_t buffer_id;       /* of a buffer that holds a structure or an input of a build */
    VkDeviceMemory memory;    /* the same */
    bool may_hold_structures; /* a buffer or memory */
};

/* A structure, micromap, buffer or memory that is about to be destroyed. */
struct destroyed_view {
    const struct call_view *call;
    struct life_object object;     /* of a buffer or memory: only its type and handle */
    const struct pending_use *use; /* NULL: none is certain */
    /* Instead, if the structure was destroyed before: such an instance; or NULL. */
    const struct pending_instance *instance;
    enum tristate has_callbacks; /* it was created with VkAllocationCallbacks */
    bool gets_callbacks;         /* pAllocator is not NULL */
};

/* A structure or micromap that a copy, query or serialization reads, and its last build when the
 * command executes. */
struct used_source_view {
    VkObjectType object_type; /* as in struct life_object */
    uint64_t handle;
    const struct journal_read *read;
    const struct built *built; /* never BUILT_UNKNOWN */
    uint64_t micromap; /* to which the data refer that the source was deserialized from, and which
                        * was certainly not deserialized; or 0 */
};

/* A query that is not unavailable when a command that writes it executes. */
struct written_query_view {
    VkQueryPool pool;
    uint32_t number;   /* of the query in the pool */
    bool is_available; /* false: nothing has reset or written it */
};

/* A copy or serialization when it executes, and what the host has read of its size. */
struct sized_copy_view {
    VkObjectType object_type; /* as in struct life_object */
    uint64_t src, dst;        /* handles; dst of a serialization: the address */
    bool serializes, compacts;
    VkDeviceSize dst_size; /* bytes: of the create info, or from the address to the buffer's end */
    VkDeviceSize queried_size; /* bytes: the serialization size of src; or its size, of a clone; or
                                * its compacted size: the smallest query result for the build of
                                * src. 0: the host has not read it */
    bool is_full;              /* queried_size is the size of src */
    VkDeviceSize needed_size;  /* bytes: of a clone, what the build of src needs; 0: unknown */
};

/* One element of pBindInfos of vkBindAccelerationStructureMemoryNV. */
struct binding_view {
    const struct call_view *call;
    const VkBindAccelerationStructureMemoryInfoNV *info;
    enum nv_binding before; /* of the structure */
    struct nv_size_facts required;
    struct memory_facts memory;
};

/* A structure that a descriptor is written for. */
struct descriptor_view {
    const struct call_view *call;
    struct life_object structure; /* handle 0: VK_NULL_HANDLE */
};

/* A structure in the data of an update with a template. */
struct templated_view {
    const struct call_view *call;
    struct life_object structure; /* handle 0: VK_NULL_HANDLE */
    uint64_t offset;              /* in the data, in bytes */
    bool unreadable;              /* the data at the offset cannot be read */
};

/* The data of a structure for capture and replay. */
struct capture_view {
    const struct call_view *call;
    const VkAccelerationStructureCaptureDescriptorDataInfoEXT *info;
    struct life_object structure; /* of VK_KHR_acceleration_structure */
    struct life_object nv_structure;
    const void *data; /* where the data is written */
    bool data_is_cut; /* not all bytes of it are readable */
};

#endif
