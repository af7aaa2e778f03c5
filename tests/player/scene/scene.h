/* SPDX-License-Identifier: Apache-2.0 */
/* A small valid world of objects and one build call over them, in arrays that a case edits freely
 * before the call is made.
 *
 * Everything that the functions here create belongs to the scene and is destroyed with it. Several
 * threads may each have a scene of the same world. */
#ifndef ASSAY_TESTS_PLAYER_SCENE_H
#define ASSAY_TESTS_PLAYER_SCENE_H

#include "tests/fixture/make.h"
#include "tests/player/scene/fixture.h"
#include "vuid-tables/rules.h"

/* The builds of the call. */
enum scene_build {
    INDEXED,   /* BLAS: 2 triangles, 32-bit indices, a transform */
    UNINDEXED, /* BLAS: 2 triangles without indices, then 2 with 16-bit ones */
    AABBS,     /* BLAS: twice 3 boxes */
    TLAS,      /* 3 instances, all null references */
    UPDATE,    /* INDEXED again, from another source */
    REFIT,     /* INDEXED again, in place */
    SCENE_BASE_BUILDS,
};

enum {
    SCENE_BUILDS = 40,
    SCENE_GEOMETRIES = 8,
    SCENE_CLEANUPS = 512,
    SCENE_INPUTS_MAX = 24,
    SCENE_BUFFER_SIZE = 4096, /* of each input buffer, bytes */
    SCENE_TRANSFORM_OFFSET = 48,
};

#define INPUT_USAGE                                                                                \
    (VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |                        \
     VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT)
#define SCRATCH_USAGE                                                                              \
    (VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT)
#define ACCEL_USAGE                                                                                \
    (VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |                                      \
     VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT)

struct test_memory {
    VkDeviceMemory handle;
    VkDeviceSize size;
    uint8_t *bytes; /* NULL: not mapped */
};

struct scene;

/* What command buffers copy to a buffer of inputs. */
struct scene_input_copy {
    VkBuffer source, buffer;
    VkDeviceSize size;
};

struct scene_cleanup {
    void (*destroy)(struct scene *scene, VkDevice device, uint64_t handle);
    VkDevice device;
    uint64_t handle;
};

enum { SCENE_NV_GEOMETRIES = 4, SCENE_USAGES = 4, SCENE_MICROMAP_INPUT_SIZE = 1 << 16 };

/* A call of vkCmdBuildAccelerationStructureNV, and what it uses. */
struct scene_nv {
    const VkAccelerationStructureInfoNV *info_argument;
    VkAccelerationStructureInfoNV info;
    VkGeometryNV geometries[SCENE_NV_GEOMETRIES];
    VkBuffer instance_data;
    VkDeviceSize instance_offset;
    VkBool32 update;
    VkAccelerationStructureNV dst, src;
    VkBuffer scratch;
    VkDeviceSize scratch_offset;
    struct device_buffer vertices, indices, transforms, boxes, instances, scratch_buffer;
};

union life_arguments; /* of the generated life_arguments.h */

/* A call of a command of vuid-tables/commands.def, and what it uses. Copies of micromaps and of
 * VK_NV_ray_tracing are made of the same members. */
struct scene_life {
    VkObjectType object_type; /* of the structures, or micromaps, of the command */
    uint64_t src, dst;        /* src is built before the call, and allows compaction */
    VkCopyAccelerationStructureInfoKHR copy;
    VkCopyAccelerationStructureToMemoryInfoKHR to_memory;
    VkCopyMemoryToAccelerationStructureInfoKHR from_memory;
    struct device_buffer memory; /* of these two */

    uint64_t objects[4]; /* that are queried */
    uint32_t object_count;
    const uint64_t *objects_argument;
    VkQueryType query_type;
    VkQueryPool pool;
    uint32_t first_query;
    uint64_t data[4];
    size_t data_size, stride;
    void *data_argument;

    VkMicromapUsageEXT usages[SCENE_USAGES];
    const VkMicromapUsageEXT *usage_pointers[SCENE_USAGES];
    VkMicromapBuildInfoEXT builds[2];
    uint32_t build_count;
    struct device_buffer micromap_input, micromap_scratch; /* of the first build */

    struct device_buffer storage; /* in which a structure is created */
    VkAccelerationStructureCreateInfoKHR create;
    VkAccelerationStructureCreateInfo2KHR create_at;
    VkMicromapCreateInfoEXT create_micromap;
    VkAccelerationStructureCreateInfoNV create_nv;
    VkAccelerationStructureInfoNV nv_info; /* create_nv.info before the case; see nv.info */
    const VkAllocationCallbacks *allocator;
    uint64_t created, destroyed;
    VkBindAccelerationStructureMemoryInfoNV bindings[2];
    uint32_t binding_count;

    VkAccelerationStructureBuildTypeKHR build_type; /* these three: a query of sizes */
    const VkAccelerationStructureBuildGeometryInfoKHR *build_argument;
    const uint32_t *counts_argument;
    VkAccelerationStructureBuildSizesInfoKHR sizes;
    VkMicromapBuildSizesInfoEXT micromap_sizes;
    VkAccelerationStructureDeviceAddressInfoKHR address_info;
    VkAccelerationStructureCaptureDescriptorDataInfoEXT capture_info;
    VkAccelerationStructureMemoryRequirementsInfoNV requirements_info;
    VkMemoryRequirements2 requirements;
    VkAccelerationStructureVersionInfoKHR version;
    VkMicromapVersionInfoEXT micromap_version;
    uint8_t version_data[2 * VK_UUID_SIZE];
    VkAccelerationStructureCompatibilityKHR compatibility;

    VkAccelerationStructureMotionInfoNV motion; /* chained by cases */
    VkWriteDescriptorSetAccelerationStructureKHR descriptor;
    VkWriteDescriptorSetAccelerationStructureNV descriptor_nv;
    VkWriteDescriptorSet write;
    VkWriteDescriptorSetPartitionedAccelerationStructureNV partition_descriptor;
    VkDescriptorUpdateTemplate update_template;
    const void *template_data;
    VkPushDescriptorSetInfo push;

    /* A build of clusters, at first of one cluster of triangles, and one of a partitioned
     * structure. `cluster_input`: a count of 1, and infos from byte 64 on. */
    VkClusterAccelerationStructureCommandsInfoNV cluster;
    VkClusterAccelerationStructureTriangleClusterInputNV cluster_triangles;
    VkClusterAccelerationStructureClustersBottomLevelInputNV cluster_bottom_level;
    VkClusterAccelerationStructureMoveObjectsInputNV cluster_moves;
    VkBuildPartitionedAccelerationStructureInfoNV partition;
    VkPartitionedAccelerationStructureFlagsNV partition_flags;
    struct device_buffer cluster_input, cluster_dst, cluster_arrays, cluster_scratch;

    /* Changes the arguments just before the call; or NULL. */
    void (*edit)(struct scene *scene, union life_arguments *arguments);
};

/* The micromaps of a scene: none until a case asks for one. */
struct scene_micromaps {
    /* For scene_build_micromap(). */
    VkAccelerationStructureGeometryMicromapDataKHR data;
    VkMicromapTriangleKHR *triangles; /* what it leads to, as the host writes it */
    struct device_buffer triangle_buffer;
    VkMicromapUsageKHR usages[SCENE_USAGES];
    const VkMicromapUsageKHR *usage_pointers[SCENE_USAGES];
    /* For the other functions. */
    VkAccelerationStructureTrianglesOpacityMicromapKHR opacity;
    VkAccelerationStructureTrianglesOpacityMicromapEXT opacity_ext;
    VkAccelerationStructureTrianglesDisplacementMicromapNV displacement;
    VkMicromapUsageEXT usages_ext[SCENE_USAGES];
    const VkMicromapUsageEXT *usage_pointers_ext[SCENE_USAGES];
};

struct scene {
    struct fixture *fixture;
    const VkuDeviceDispatchTable *vk;
    enum build_command command;
    const char *skip; /* set by scene_skip */

    /* The call. The pointers lead to the arrays below until a case edits them. */
    VkCommandBuffer command_buffer;
    bool is_edited;  /* a case has edited it: queries of sizes may have findings */
    VkDevice device; /* these two: COMMAND_HOST */
    VkDeferredOperationKHR deferred_operation;
    uint32_t info_count;
    const VkAccelerationStructureBuildGeometryInfoKHR *infos_argument;
    const VkAccelerationStructureBuildRangeInfoKHR *const *ranges_argument;
    const uint32_t *const *counts_argument; /* these three: COMMAND_INDIRECT */
    const VkDeviceAddress *indirect_addresses_argument;
    const uint32_t *indirect_strides_argument;

    VkAccelerationStructureBuildGeometryInfoKHR infos[SCENE_BUILDS];
    VkAccelerationStructureGeometryKHR geometries[SCENE_BUILDS][SCENE_GEOMETRIES];
    const VkAccelerationStructureGeometryKHR *geometry_pointers[SCENE_BUILDS][SCENE_GEOMETRIES];
    VkAccelerationStructureBuildRangeInfoKHR ranges[SCENE_BUILDS][SCENE_GEOMETRIES];
    const VkAccelerationStructureBuildRangeInfoKHR *range_pointers[SCENE_BUILDS];

    /* For COMMAND_INDIRECT. Counts and the buffer are filled from `ranges` when the call is made.
     */
    uint32_t counts[SCENE_BUILDS][SCENE_GEOMETRIES];
    const uint32_t *count_pointers[SCENE_BUILDS];
    VkDeviceAddress indirect_addresses[SCENE_BUILDS];
    uint32_t indirect_strides[SCENE_BUILDS];
    struct device_buffer indirect;

    struct scene_nv nv;     /* COMMAND_NV */
    struct scene_life life; /* commands that build no structures */

    /* What the builds use. */
    struct device_buffer vertices, indices, transforms, boxes, instances;
    struct scene_input_copy inputs[SCENE_INPUTS_MAX];
    uint32_t input_count;
    struct scene_micromaps micromaps;
    struct device_buffer dst_buffers[SCENE_BUILDS], scratch_buffers[SCENE_BUILDS];
    VkDevice other_device; /* made by scene_enter_other_device */
    VkuDeviceDispatchTable other_vk;
    VkDevice own_device; /* while the scene is in the other one */

    /* Structures of extensions, for cases that chain them. */
    VkAccelerationStructureGeometryMotionTrianglesDataNV motion;
    VkAccelerationStructureGeometrySpheresDataNV spheres;
    VkAccelerationStructureGeometryLinearSweptSpheresDataNV swept_spheres;
    VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX dense;

    uint32_t cleanup_count;
    struct scene_cleanup cleanups[SCENE_CLEANUPS];
};

/* ---- the whole (scene.c) ---- */

struct scene *scene_open(struct fixture *fixture, enum build_command command);
void scene_close(struct scene *scene);

/* Makes the call. VK_SUCCESS for the commands that return nothing. */
VkResult scene_call(struct scene *scene);

/* Makes the call lead to misaligned copies of all of its arrays, structures and chains that are the
 * scene's own, as they are now. The copies last until the thread calls it again (scene.c). */
void scene_misalign(struct scene *scene);

/* Says that the case cannot be played here, and why. */
void scene_skip(struct scene *scene, const char *reason);

/* Turns every pGeometries of the call that leads to the scene's own array into ppGeometries. */
void scene_use_geometry_pointers(struct scene *scene);

/* Appends a build like `model`, with a dst and scratch of its own; returns its index. */
uint32_t scene_add_build(struct scene *scene, uint32_t model);

/* Gives a build a dst of the right size, and scratch that serves building and updating. */
void scene_give_objects(struct scene *scene, uint32_t build);
/* The same where its dst is too small for what it has become. */
void scene_fit(struct scene *scene, uint32_t build);

/* Carries out builds of the scene by a call of their own that comes before the scene's, with the
 * inputs as they are now. */
void scene_build_before(struct scene *scene, uint32_t first, uint32_t count);

/* What updates start from: on the host, where they are judged when they are called, their sources
 * have to be built before. */
void scene_build_source(struct scene *scene, uint32_t update);

/* A bound buffer of inputs, which cases write by its `bytes`. If the fixture copies inputs, builds
 * on the device read it in device-local memory, and the `bytes` are copied there just before. Then
 * builds that come before the call are submitted at once, by command buffers of their own. */
struct device_buffer scene_input(struct scene *scene, VkDeviceSize size, VkBufferUsageFlags usage);
/* Records these copies, for the build that is recorded next. */
void scene_inputs_copy(struct scene *scene, VkCommandBuffer command_buffer);
/* Where builds that come before the call are recorded; and their end. */
VkCommandBuffer scene_begin_before(struct scene *scene);
void scene_end_before(struct scene *scene, VkCommandBuffer command_buffer);

/* Copies a structure before the call, by the command of the same kind: on the host, or recorded.
 * VK_SUCCESS if it is recorded: backend cpu may refuse copies on the host. */
VkResult scene_copy(struct scene *scene, VkAccelerationStructureKHR src,
                    VkAccelerationStructureKHR dst, VkCopyAccelerationStructureModeKHR mode);

/* A build like `model` that is not part of the call; returns its index. */
uint32_t scene_reserve_build(struct scene *scene, uint32_t model);

/* A structure of the size and type that the build needs. */
VkAccelerationStructureKHR scene_accel_for(struct scene *scene, uint32_t build);

/* What vkGetAccelerationStructureBuildSizesKHR says of a build as it stands. */
VkAccelerationStructureBuildSizesInfoKHR scene_sizes(const struct scene *scene, uint32_t build);
/* Makes the call, a query of sizes, be about a build. */
void scene_ask_sizes_of(struct scene *scene, uint32_t build);

/* The size of scratch that a build needs in its mode, as it stands. */
VkDeviceSize scene_scratch_size(const struct scene *scene, uint32_t build);

/* What an instance has that refers to a structure, likewise. */
uint64_t scene_reference(const struct scene *scene, VkAccelerationStructureKHR accel);

/* An address in a buffer, as the command of the scene wants it: of the device or the host. */
uint64_t scene_address(const struct scene *scene, const struct device_buffer *buffer,
                       VkDeviceSize offset);

/* ---- builds at addresses (scene_extensions.c) ---- */

bool command_builds_at_addresses(
    enum build_command command); /* or queries the sizes of such builds */
void scene_open_clusters(struct scene *scene);
void scene_use_cluster_op(struct scene *scene, VkClusterAccelerationStructureOpTypeNV type);
void scene_use_cluster_mode(struct scene *scene, VkClusterAccelerationStructureOpModeNV mode);
void scene_use_partition_descriptor(struct scene *scene);
/* Makes the queries that a build's counts are compared with. */
void scene_query_input_sizes(struct scene *scene);

/* ---- memory, buffers, structures (scene_objects.c) ---- */

void scene_defer(struct scene *scene, VkDevice device, uint64_t handle,
                 void (*destroy)(struct scene *scene, VkDevice device, uint64_t handle));
/* Defines what scene_defer wants for objects that a command of the device destroys; and a function
 * that creates such an object of the scene's device by vkCreate`what`. */
#define SCENE_DESTROYS(name, command, type)                                                        \
    static void name(struct scene *scene, VkDevice device, uint64_t handle)                        \
    {                                                                                              \
        scene_table_of(scene, device)->command(device, (type)handle, NULL);                        \
    }
#define SCENE_CREATES(name, what, type, info_type)                                                 \
    SCENE_CREATES_BY(name, Create##what, what, type, info_type)
#define SCENE_CREATES_BY(name, command, what, type, info_type)                                     \
    SCENE_DESTROYS(name##_destroy, Destroy##what, type)                                            \
    static type name(struct scene *scene, const info_type *create_info)                            \
    {                                                                                              \
        const VkDevice device = scene->fixture->device;                                            \
        type object;                                                                               \
        GET(scene->vk->command(device, create_info, NULL, &object));                               \
        scene_defer(scene, device, (uint64_t)object, name##_destroy);                              \
        return object;                                                                             \
    }
/* Destroys one thing before its time. */
void scene_destroy(struct scene *scene, uint64_t handle);
/* A call has destroyed it. */
void scene_forget(struct scene *scene, uint64_t handle);

struct test_memory scene_allocate(struct scene *scene, VkDeviceSize size);
struct test_memory scene_allocate_with(struct scene *scene, VkDeviceSize size,
                                       VkMemoryPropertyFlags properties, const void *chain);
struct device_buffer scene_create_buffer(struct scene *scene, VkDeviceSize size,
                                         VkBufferUsageFlags usage);
struct device_buffer scene_create_buffer_with(struct scene *scene,
                                              const VkBufferCreateInfo *create_info);
void scene_bind(struct scene *scene, struct device_buffer *buffer, const struct test_memory *memory,
                VkDeviceSize offset);
/* Fills in address and bytes after a binding made by other means. */
void scene_note_binding(struct scene *scene, struct device_buffer *buffer,
                        const struct test_memory *memory, VkDeviceSize offset);
VkDeviceAddress scene_buffer_address(struct scene *scene, VkBuffer buffer);
VkDeviceSize scene_buffer_memory_size(struct scene *scene, const struct device_buffer *buffer);

/* Allocates memory of the first type that the bits allow. */
struct test_memory scene_allocate_of_type(struct scene *scene, VkDeviceSize size,
                                          uint32_t memory_type_bits);

/* Addresses of buffers that builds can't read: of freed memory, of a destroyed buffer, and without
 * the usage for it. */
VkDeviceAddress scene_freed_address(struct scene *scene);
VkDeviceAddress scene_destroyed_address(struct scene *scene);
VkDeviceAddress scene_address_without_usage(struct scene *scene);

/* A bound buffer with memory of its own. */
struct device_buffer scene_buffer(struct scene *scene, VkDeviceSize size, VkBufferUsageFlags usage);

/* The same, with VkBufferUsageFlags2CreateInfo, which replaces VkBufferCreateInfo::usage. */
struct device_buffer scene_buffer_of_flags2(struct scene *scene, VkDeviceSize size,
                                            VkBufferUsageFlags usage, VkBufferUsageFlags2 usage2);
/* One of SCENE_BUFFER_SIZE bytes, with usage that wants VK_KHR_maintenance5. */
struct device_buffer scene_dense_buffer(struct scene *scene, VkBufferUsageFlags2 usage);
#define DENSE_USAGE VK_BUFFER_USAGE_2_COMPRESSED_DATA_DGF1_BIT_AMDX

VkAccelerationStructureKHR
scene_create_accel(struct scene *scene, const VkAccelerationStructureCreateInfoKHR *create_info);
VkAccelerationStructureKHR scene_accel_at(struct scene *scene,
                                          const VkAccelerationStructureCreateInfo2KHR *create_info);
/* An opacity micromap is created by its address. */
VkAccelerationStructureKHR scene_accel_in(struct scene *scene, const struct device_buffer *buffer,
                                          VkDeviceSize offset, VkDeviceSize size,
                                          VkAccelerationStructureTypeKHR type);

/* A sparse buffer, no page bound. */
struct device_buffer scene_sparse_buffer(struct scene *scene, VkDeviceSize size,
                                         VkBufferUsageFlags usage, VkBufferCreateFlags flags);

/* Between these what the scene creates is of another VkDevice. */
void scene_enter_other_device(struct scene *scene);
void scene_leave_other_device(struct scene *scene);
const VkuDeviceDispatchTable *scene_table_of(const struct scene *scene, VkDevice device);

/* An acceleration structure of another VkDevice, like the dst of `build`. */
VkAccelerationStructureKHR scene_accel_of_other_device(struct scene *scene, uint32_t build);

/* ---- micromaps (scene_micromap.c) ---- */

/* Makes AABBS the build of an opacity micromap of VK_KHR_opacity_micromap, of one triangle. */
void scene_build_micromap(struct scene *scene);

/* A structure that such a build may have as its dst. */
VkAccelerationStructureKHR scene_micromap_structure(struct scene *scene,
                                                    VkAccelerationStructureTypeKHR type);

/* Each gives a micromap of its extension to the triangles of INDEXED, with 32-bit indices. Builds
 * on the host take no micromaps of VK_KHR_opacity_micromap: there it is null. */
void scene_use_micromap(struct scene *scene);
void scene_use_micromap_ext(struct scene *scene);
void scene_use_displacement(struct scene *scene);

VkMicromapEXT scene_micromap_ext(struct scene *scene, VkMicromapTypeEXT type);

/* A build of a micromap by one usage, which it leads to. The second half of the input is full of
 * triangles of its format; the first half is their data. */
struct scene_micromap_build {
    struct device_buffer input, scratch;
    VkMicromapBuildInfoEXT info;
};
struct scene_micromap_build scene_build_of_micromap(struct scene *scene, VkMicromapTypeEXT type,
                                                    VkMicromapEXT dst,
                                                    const VkMicromapUsageEXT *usage,
                                                    bool is_on_host);

/* A structure that the command buffer of the scene has made an opacity micromap of so many
 * triangles. */
VkAccelerationStructureKHR scene_record_micromap(struct scene *scene, uint32_t triangle_count);

/* The address of serialized data of the null driver; and records a deserialization of them. */
VkDeviceAddress scene_serialized(struct scene *scene);
void scene_deserialize(struct scene *scene, VkAccelerationStructureKHR structure);

/* ---- extensions (scene_extensions.c) ---- */

/* The build that these add: one geometry of 4 primitives, its data in the scene's structures. */
enum { SPHERES = SCENE_BASE_BUILDS };
void scene_add_spheres(struct scene *scene);
void scene_add_swept_spheres(struct scene *scene);

/* An instance of TLAS; and making it refer to a structure. */
VkAccelerationStructureInstanceKHR *scene_instance(struct scene *scene, uint32_t index);
void scene_refer(struct scene *scene, uint32_t index, VkAccelerationStructureKHR accel);
/* A structure like `model` that is built before the call. */
VkAccelerationStructureKHR scene_built(struct scene *scene, uint32_t model);
/* Has TLAS read its instances, at their places, by pointers in the second half of the buffer; the
 * other pointers there are null. */
void scene_use_instance_pointers(struct scene *scene);

/* Gives a build a dst that was created for motion, and scratch. */
void scene_give_motion_dst(struct scene *scene, uint32_t build);

/* ---- VK_NV_ray_tracing (scene_nv.c) ---- */

/* Prepares the build of a BLAS: 2 triangles with 32-bit indices and a transform, then 2 without
 * either. */
void scene_nv_open(struct scene *scene);
void scene_nv_call(struct scene *scene);

/* Makes it another valid call: of 3 boxes, twice; of 3 null instances; an update from another
 * structure, built before in the command buffer. */
void scene_nv_use_boxes(struct scene *scene);
void scene_nv_use_instances(struct scene *scene);
void scene_nv_use_update(struct scene *scene);

/* Gives the call a dst, and scratch for building and updating, that fit the info as it stands; and
 * scratch that fits any. */
void scene_nv_give_objects(struct scene *scene);
void scene_nv_give_large_scratch(struct scene *scene);

/* A structure for the info as it stands, not bound; its memory requirements; and binding it, to
 * memory of its own or of the caller's. */
VkAccelerationStructureNV scene_nv_create(struct scene *scene);
VkMemoryRequirements scene_nv_requirements(const struct scene *scene,
                                           VkAccelerationStructureNV accel,
                                           VkAccelerationStructureMemoryRequirementsTypeNV type);
struct test_memory scene_nv_allocate(struct scene *scene, VkAccelerationStructureNV accel,
                                     VkDeviceSize size);
void scene_nv_bind(struct scene *scene, VkAccelerationStructureNV accel, VkDeviceMemory memory,
                   VkDeviceSize offset);
VkAccelerationStructureNV scene_nv_accel(struct scene *scene);

/* A buffer of another VkDevice, for what a build reads; its handle. */
uint64_t scene_nv_foreign_buffer(struct scene *scene);

/* Records a build of `dst`, from nothing, with the info as it stands. */
void scene_nv_build(struct scene *scene, VkAccelerationStructureNV dst);

/* ---- other commands (scene_life.c) ---- */

bool command_is_of_micromaps(enum build_command command);
bool command_is_of_nv(enum build_command command);
bool command_writes_descriptors(enum build_command command);
/* Has the call write descriptors of VK_NV_ray_tracing. */
void scene_use_nv_descriptor(struct scene *scene);
bool command_is_on_host(enum build_command command); /* its work is done by the host */
bool command_returns_result(enum build_command command);
const char *command_needs(enum build_command command); /* of the setup, or NULL */

void scene_life_open(struct scene *scene);
VkResult scene_life_call(struct scene *scene);
VkQueryPool scene_query_pool(struct scene *scene, VkQueryType type, uint32_t count);

/* ---- command buffers (scene_commands.c) ---- */

VkCommandPool scene_pool(struct scene *scene, uint32_t family, VkCommandPoolCreateFlags flags);
VkCommandBuffer scene_allocate_command_buffer(struct scene *scene, VkCommandPool pool,
                                              VkCommandBufferLevel level);
/* Returns a command buffer of a new resettable pool of `family`, in the initial state. */
VkCommandBuffer scene_command_buffer(struct scene *scene, uint32_t family);
void scene_begin(struct scene *scene, VkCommandBuffer command_buffer,
                 VkCommandBufferUsageFlags flags);
void scene_end(struct scene *scene, VkCommandBuffer command_buffer);
uint32_t scene_family(const struct scene *scene); /* the first queue family that can build */
VkQueue scene_queue(const struct scene *scene, uint32_t family); /* the first one */
/* Makes all earlier writes visible to all later commands. */
void scene_barrier(struct scene *scene, VkCommandBuffer command_buffer);
/* Returns a command buffer of the scene's family that records; and ends, submits and waits for one.
 */
VkCommandBuffer scene_begin_own(struct scene *scene);
void scene_run(struct scene *scene, VkCommandBuffer command_buffer);
/* Submits to the family's first queue and waits. */
void scene_submit(struct scene *scene, uint32_t family, VkCommandBuffer command_buffer);

/* Ends the command buffer of the call and submits it; waits for what has been submitted. */
VkResult scene_submit_call(struct scene *scene);

/* A framebuffer without attachments and its render pass, and beginning an instance of it. */
void scene_begin_render_pass(struct scene *scene, VkCommandBuffer command_buffer);
void scene_begin_render_pass2(struct scene *scene, VkCommandBuffer command_buffer);
VkRenderPass scene_render_pass(struct scene *scene);
void scene_begin_rendering(struct scene *scene, VkCommandBuffer command_buffer,
                           VkRenderingFlags flags);
void scene_end_rendering(struct scene *scene, VkCommandBuffer command_buffer);

/* Ends the call's command buffer's life and starts another of a family; recording. */
void scene_record_in_family(struct scene *scene, uint32_t family, VkCommandPoolCreateFlags flags);

#endif
