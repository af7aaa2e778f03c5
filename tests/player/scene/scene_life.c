/* SPDX-License-Identifier: Apache-2.0 */
/* Calls of the other commands about structures: copies, queries, creation, destruction and so on.
 */
#include <stdlib.h>
#include <string.h>

#include "life_calls.h"
#include "tests/player/scene/scene.h"

enum { SERIALIZED_SIZE = 1 << 16 };

/* ---- which command */

static const char *name_of(enum build_command command)
{
    return build_command_name(command);
}

bool command_is_of_micromaps(enum build_command command)
{
    return strstr(name_of(command), "Micromap") != NULL;
}

bool command_is_of_nv(enum build_command command)
{
    const char *name = name_of(command);
    return strcmp(name + strlen(name) - 2, "NV") == 0 && !command_builds_at_addresses(command);
}

bool command_is_on_host(enum build_command command)
{
    static const char *const verbs[] = {"vkBuild", "vkCopy", "vkWrite"};
    for (size_t i = 0; i < sizeof(verbs) / sizeof(verbs[0]); i++)
        if (strncmp(name_of(command), verbs[i], strlen(verbs[i])) == 0)
            return true;
    return false;
}

bool command_returns_result(enum build_command command)
{
    return command == COMMAND_HOST || life_command_returns_result(command);
}

const char *command_needs(enum build_command command)
{
    if (command == COMMAND_CreateAccelerationStructure2KHR)
        return WITH_MICROMAP_KHR;
    if (command == COMMAND_GetAccelerationStructureOpaqueCaptureDescriptorDataEXT)
        return WITH_DESCRIPTOR_CAPTURE;
    if (command == COMMAND_CmdPushDescriptorSet || command == COMMAND_CmdPushDescriptorSet2)
        return "VK_KHR_push_descriptor VK_KHR_maintenance6";
    if (command_builds_at_addresses(command))
        return WITH_CLUSTERS;
    if (command_is_of_nv(command))
        return "VK_NV_ray_tracing";
    return command_is_of_micromaps(command) ? "VK_EXT_opacity_micromap" : NULL;
}

/* ---- what calls use */

static void open_structures(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    scene->infos[INDEXED].flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR;
    scene_fit(scene, INDEXED);
    life->object_type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    life->src = (uint64_t)scene->infos[INDEXED].dstAccelerationStructure;
    life->dst = (uint64_t)scene_accel_for(scene, INDEXED);
    scene_build_before(scene, INDEXED, 1);
}

static void open_micromaps(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    const bool is_on_host = command_is_on_host(scene->command);
    life->object_type = VK_OBJECT_TYPE_MICROMAP_EXT;
    life->src = (uint64_t)scene_micromap_ext(scene, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT);
    life->dst = (uint64_t)scene_micromap_ext(scene, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT);
    for (uint32_t i = 0; i < SCENE_USAGES; i++) {
        life->usages[i] =
            (VkMicromapUsageEXT){.count = 1, .format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT};
        life->usage_pointers[i] = &life->usages[i];
    }
    const struct scene_micromap_build build =
        scene_build_of_micromap(scene, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT,
                                (VkMicromapEXT)life->src, life->usages, is_on_host);
    life->micromap_input = build.input;
    life->micromap_scratch = build.scratch;
    life->builds[0] = build.info;
    life->builds[0].flags = VK_BUILD_MICROMAP_ALLOW_COMPACTION_BIT_EXT;
    life->build_count = 1;
    if (is_on_host)
        GET(scene->vk->BuildMicromapsEXT(scene->fixture->device, VK_NULL_HANDLE, 1, life->builds));
    else
        scene->vk->CmdBuildMicromapsEXT(scene->command_buffer, 1, life->builds);
    life->builds[0].dstMicromap = (VkMicromapEXT)life->dst;
}

static void open_nv_structures(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    scene_nv_open(scene);
    scene->nv.info.flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR;
    scene_nv_give_objects(scene);
    life->object_type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV;
    life->src = (uint64_t)scene->nv.dst;
    life->dst = (uint64_t)scene_nv_accel(scene);
    scene_nv_build(scene, scene->nv.dst);
}

static VkQueryType default_query_type(enum build_command command)
{
    return command_is_of_micromaps(command) ? VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT
           : command_is_of_nv(command)      ? VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV
                                       : VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
}

SCENE_CREATES(create_pool, QueryPool, VkQueryPool, VkQueryPoolCreateInfo)

VkQueryPool scene_query_pool(struct scene *scene, VkQueryType type, uint32_t count)
{
    const STRUCT(VkQueryPoolCreateInfo, info, .queryType = type, .queryCount = count);
    return create_pool(scene, &info);
}

static void open_query(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    life->query_type = default_query_type(scene->command);
    life->objects[0] = life->objects[1] = life->src;
    life->object_count = 2;
    life->objects_argument = life->objects;
    life->data_size = sizeof(life->data);
    life->data_argument = life->data;
    life->stride = sizeof(life->data[0]);
    if (!command_is_recorded(scene->command) && scene->command != COMMAND_GetQueryPoolResults)
        return;
    life->pool = scene_query_pool(scene, life->query_type, 4);
    scene->vk->CmdResetQueryPool(scene->command_buffer, life->pool, 0, 4);
}

/* Fills the memory with what src is serialized to. */
static void serialize(struct scene *scene)
{
    const struct scene_life *life = &scene->life;
    const VkCopyAccelerationStructureToMemoryInfoKHR info =
        MAKE(VkCopyAccelerationStructureToMemoryInfoKHR, .src = life->to_memory.src,
             .dst = life->to_memory.dst, .mode = life->to_memory.mode);
    const VkCopyMicromapToMemoryInfoEXT micromap_info =
        MAKE(VkCopyMicromapToMemoryInfoEXT, .src = (VkMicromapEXT)life->src,
             .dst = life->to_memory.dst, .mode = VK_COPY_MICROMAP_MODE_SERIALIZE_EXT);
    const VkDevice device = scene->fixture->device;
    const bool is_micromap = command_is_of_micromaps(scene->command);
    if (!command_is_on_host(scene->command)) {
        if (is_micromap)
            scene->vk->CmdCopyMicromapToMemoryEXT(scene->command_buffer, &micromap_info);
        else
            scene->vk->CmdCopyAccelerationStructureToMemoryKHR(scene->command_buffer, &info);
    } else if (is_micromap) {
        GET(scene->vk->CopyMicromapToMemoryEXT(device, VK_NULL_HANDLE, &micromap_info));
    } else {
        GET(scene->vk->CopyAccelerationStructureToMemoryKHR(device, VK_NULL_HANDLE, &info));
    }
}

/* What a structure is serialized to, and deserialized from. */
static void open_memory(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    life->memory = scene_buffer(scene, SERIALIZED_SIZE, SCRATCH_USAGE);
    life->to_memory.src = (VkAccelerationStructureKHR)life->src;
    life->to_memory.dst.deviceAddress = scene_address(scene, &life->memory, 0);
    life->to_memory.mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR;
    life->from_memory.src.deviceAddress = scene_address(scene, &life->memory, 0);
    life->from_memory.dst = (VkAccelerationStructureKHR)life->dst;
    life->from_memory.mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR;
    if (strstr(name_of(scene->command), "CopyMemoryTo") != NULL)
        serialize(scene);
}

static void set_creation(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    const bool is_micromap = command_is_of_micromaps(scene->command);
    life->storage =
        scene_buffer(scene, 4096,
                     VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                         (is_micromap ? VK_BUFFER_USAGE_MICROMAP_STORAGE_BIT_EXT
                                      : VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR));
    life->create = MAKE(VkAccelerationStructureCreateInfoKHR, .buffer = life->storage.handle,
                        .size = 1024, .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    life->create_at = MAKE(VkAccelerationStructureCreateInfo2KHR,
                           .addressRange = {.address = life->storage.address, .size = 1024},
                           .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    life->create_micromap = MAKE(VkMicromapCreateInfoEXT, .buffer = life->storage.handle,
                                 .size = 1024, .type = VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT);
    life->create_nv = MAKE(VkAccelerationStructureCreateInfoNV, .info = scene->nv.info);
    life->nv_info = life->create_nv.info;
}

static VkAccelerationStructureKHR accel_for_capture(struct scene *scene)
{
    const STRUCT(VkAccelerationStructureCreateInfoKHR, info,
                 .createFlags =
                     VK_ACCELERATION_STRUCTURE_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT,
                 .buffer = scene_buffer(scene, 4096, ACCEL_USAGE).handle, .size = 1024,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    return scene_create_accel(scene, &info);
}

static void set_queries_of_objects(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    life->address_info = MAKE(VkAccelerationStructureDeviceAddressInfoKHR,
                              .accelerationStructure = (VkAccelerationStructureKHR)life->src);
    if (scene->command == COMMAND_GetAccelerationStructureOpaqueCaptureDescriptorDataEXT)
        life->capture_info = MAKE(VkAccelerationStructureCaptureDescriptorDataInfoEXT,
                                  .accelerationStructure = accel_for_capture(scene));
    life->version = MAKE(VkAccelerationStructureVersionInfoKHR, .pVersionData = life->version_data);
    life->micromap_version = MAKE(VkMicromapVersionInfoEXT, .pVersionData = life->version_data);
    life->sizes = MAKE(VkAccelerationStructureBuildSizesInfoKHR);
    life->micromap_sizes = MAKE(VkMicromapBuildSizesInfoEXT);
    life->build_type = VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR;
    life->build_argument = &scene->infos[INDEXED];
    life->counts_argument = &scene->ranges[INDEXED][0].primitiveCount;
    life->requirements_info =
        MAKE(VkAccelerationStructureMemoryRequirementsInfoNV,
             .type = VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_OBJECT_NV,
             .accelerationStructure = (VkAccelerationStructureNV)life->src);
    life->requirements = MAKE(VkMemoryRequirements2);
}

void scene_ask_sizes_of(struct scene *scene, uint32_t build)
{
    struct scene_life *life = &scene->life;
    const VkAccelerationStructureBuildGeometryInfoKHR *info = &scene->infos[build];
    for (uint32_t i = 0; i < SCENE_GEOMETRIES; i++)
        scene->counts[build][i] = scene->ranges[build][i].primitiveCount;
    life->build_argument = info;
    life->counts_argument = info->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR
                                ? NULL
                                : scene->counts[build];
}

static void set_binding(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    if (scene->command != COMMAND_BindAccelerationStructureMemoryNV)
        return;
    const VkAccelerationStructureNV accel = scene_nv_create(scene);
    life->bindings[0] =
        MAKE(VkBindAccelerationStructureMemoryInfoNV, .accelerationStructure = accel,
             .memory = scene_nv_allocate(scene, accel, 0).handle);
    life->binding_count = 1;
}

bool command_writes_descriptors(enum build_command command)
{
    return command == COMMAND_UpdateDescriptorSets || command == COMMAND_CmdPushDescriptorSet ||
           command == COMMAND_CmdPushDescriptorSet2 ||
           command == COMMAND_UpdateDescriptorSetWithTemplate;
}

SCENE_CREATES(create_set_layout, DescriptorSetLayout, VkDescriptorSetLayout,
              VkDescriptorSetLayoutCreateInfo)
SCENE_CREATES(create_descriptor_pool, DescriptorPool, VkDescriptorPool, VkDescriptorPoolCreateInfo)
SCENE_CREATES(create_update_template, DescriptorUpdateTemplate, VkDescriptorUpdateTemplate,
              VkDescriptorUpdateTemplateCreateInfo)
SCENE_CREATES(create_pipeline_layout, PipelineLayout, VkPipelineLayout, VkPipelineLayoutCreateInfo)

/* A set of two structures, or a layout to push them by. */
static void open_set(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    const VkDescriptorType type = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
    const bool pushes = command_is_recorded(scene->command);
    const VkDescriptorSetLayoutBinding binding = {0, type, 2, VK_SHADER_STAGE_COMPUTE_BIT, NULL};
    const STRUCT(VkDescriptorSetLayoutCreateInfo, layout_info, .bindingCount = 1,
                 .pBindings = &binding,
                 .flags = pushes ? VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT : 0);
    const VkDescriptorSetLayout layout = create_set_layout(scene, &layout_info);
    if (pushes) {
        const STRUCT(VkPipelineLayoutCreateInfo, info, .setLayoutCount = 1, .pSetLayouts = &layout);
        life->push.layout = create_pipeline_layout(scene, &info);
        return;
    }
    const VkDescriptorPoolSize size = {type, 2};
    const STRUCT(VkDescriptorPoolCreateInfo, pool_info, .maxSets = 1, .poolSizeCount = 1,
                 .pPoolSizes = &size);
    const STRUCT(VkDescriptorSetAllocateInfo, info,
                 .descriptorPool = create_descriptor_pool(scene, &pool_info),
                 .descriptorSetCount = 1, .pSetLayouts = &layout);
    GET(scene->vk->AllocateDescriptorSets(scene->fixture->device, &info, &life->write.dstSet));
    const VkDescriptorUpdateTemplateEntry entry = {
        .descriptorCount = 2, .descriptorType = type, .stride = sizeof(life->objects[0])};
    const STRUCT(VkDescriptorUpdateTemplateCreateInfo, template_info,
                 .descriptorUpdateEntryCount = 1, .pDescriptorUpdateEntries = &entry,
                 .descriptorSetLayout = layout);
    life->update_template = create_update_template(scene, &template_info);
    life->template_data = life->objects;
}

static void open_descriptors(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    life->objects[0] = life->objects[1] = (uint64_t)scene->infos[TLAS].dstAccelerationStructure;
    life->descriptor =
        MAKE(VkWriteDescriptorSetAccelerationStructureKHR, .accelerationStructureCount = 2,
             .pAccelerationStructures = (const void *)life->objects);
    life->descriptor_nv =
        MAKE(VkWriteDescriptorSetAccelerationStructureNV, .accelerationStructureCount = 2,
             .pAccelerationStructures = (const void *)life->objects);
    life->write = MAKE(VkWriteDescriptorSet, .pNext = &life->descriptor, .descriptorCount = 2,
                       .descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR);
    life->push = MAKE(VkPushDescriptorSetInfo, .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
                      .descriptorWriteCount = 1, .pDescriptorWrites = &life->write);
    open_set(scene);
}

/* Micromaps have structures with the same members. */
static void set_types_of_copies(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    const bool is_micromap = command_is_of_micromaps(scene->command);
    life->copy.sType = is_micromap ? VK_STRUCTURE_TYPE_COPY_MICROMAP_INFO_EXT
                                   : VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR;
    life->to_memory.sType = is_micromap
                                ? VK_STRUCTURE_TYPE_COPY_MICROMAP_TO_MEMORY_INFO_EXT
                                : VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_TO_MEMORY_INFO_KHR;
    life->from_memory.sType =
        is_micromap ? VK_STRUCTURE_TYPE_COPY_MEMORY_TO_MICROMAP_INFO_EXT
                    : VK_STRUCTURE_TYPE_COPY_MEMORY_TO_ACCELERATION_STRUCTURE_INFO_KHR;
}

void scene_life_open(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    if (!has_life_command(scene->vk, scene->command)) {
        scene_skip(scene, "the driver lacks the command");
        return;
    }
    if (command_is_of_micromaps(scene->command))
        open_micromaps(scene);
    else if (command_is_of_nv(scene->command))
        open_nv_structures(scene);
    else
        open_structures(scene);
    life->copy.src = (VkAccelerationStructureKHR)life->src;
    life->copy.dst = (VkAccelerationStructureKHR)life->dst;
    life->copy.mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR;
    life->destroyed = life->dst;
    open_query(scene);
    open_memory(scene);
    set_creation(scene);
    set_queries_of_objects(scene);
    set_binding(scene);
    set_types_of_copies(scene);
    if (command_builds_at_addresses(scene->command))
        scene_open_clusters(scene);
    if (command_writes_descriptors(scene->command))
        open_descriptors(scene);
}

void scene_use_nv_descriptor(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    scene_nv_open(scene);
    scene_nv_use_instances(scene);
    life->objects[0] = life->objects[1] = (uint64_t)scene->nv.dst;
    life->write.descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_NV;
    life->write.pNext = &life->descriptor_nv;
}

/* ---- the call */

/* The same mode of a micromap. */
static VkCopyAccelerationStructureModeKHR mode_of_command(enum build_command command,
                                                          VkCopyAccelerationStructureModeKHR mode)
{
    static const int modes[] = {
        [VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR] = VK_COPY_MICROMAP_MODE_CLONE_EXT,
        [VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR] = VK_COPY_MICROMAP_MODE_COMPACT_EXT,
        [VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR] = VK_COPY_MICROMAP_MODE_SERIALIZE_EXT,
        [VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR] =
            VK_COPY_MICROMAP_MODE_DESERIALIZE_EXT};
    return command_is_of_micromaps(command) && (unsigned)mode < sizeof(modes) / sizeof(modes[0])
               ? (VkCopyAccelerationStructureModeKHR)modes[mode]
               : mode;
}

static void translate_modes(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    life->copy.mode = mode_of_command(scene->command, life->copy.mode);
    life->to_memory.mode = mode_of_command(scene->command, life->to_memory.mode);
    life->from_memory.mode = mode_of_command(scene->command, life->from_memory.mode);
}

/* Takes over what the call has created, and forgets what it has destroyed. */
static void destroy_created(struct scene *scene, VkDevice device, uint64_t handle)
{
    const VkuDeviceDispatchTable *vk = scene_table_of(scene, device);
    if (scene->life.object_type == VK_OBJECT_TYPE_MICROMAP_EXT)
        vk->DestroyMicromapEXT(device, (VkMicromapEXT)handle, NULL);
    else if (scene->life.object_type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV)
        vk->DestroyAccelerationStructureNV(device, (VkAccelerationStructureNV)handle, NULL);
    else
        vk->DestroyAccelerationStructureKHR(device, (VkAccelerationStructureKHR)handle, NULL);
}

static bool is_skipped(const struct scene *scene)
{
    const struct fixture *fixture = scene->fixture;
    return fixture->instance.messages.count != 0 &&
           (fixture->instance.messages.answer == VK_TRUE || fixture->fails);
}

static void finish_call(struct scene *scene, VkResult result)
{
    const char *name = name_of(scene->command);
    if (result != VK_SUCCESS || is_skipped(scene))
        return;
    if (strncmp(name, "vkCreate", strlen("vkCreate")) == 0)
        scene_defer(scene, scene->device, scene->life.created, destroy_created);
    if (strncmp(name, "vkDestroy", strlen("vkDestroy")) == 0 && scene->life.destroyed != 0)
        scene_forget(scene, scene->life.destroyed);
}

/* Cases edit the info that builds and the creation have in common, or the creation's own. */
static void take_nv_info(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    const bool is_edited =
        memcmp(&life->create_nv.info, &life->nv_info, sizeof(life->nv_info)) != 0;
    if (!is_edited)
        life->create_nv.info = scene->nv.info;
}

VkResult scene_life_call(struct scene *scene)
{
    union life_arguments arguments = {0};
    translate_modes(scene);
    take_nv_info(scene);
    fill_life_arguments(scene, &arguments);
    if (scene->life.edit != NULL)
        scene->life.edit(scene, &arguments);
    const VkResult result = call_life_command(scene->vk, scene->command, &arguments);
    finish_call(scene, result);
    return result;
}
