/* SPDX-License-Identifier: Apache-2.0 */
#include "layer/hazards/traced.h"

#include <string.h>

#include "observers.h"
#include "src/base/readable.h"

enum {
    WRITTEN_MAX = 16, /* buffers of one command; more count as writes anywhere */
    TRACED_MAX = 16,  /* structures that one command may trace; more are unknown */
};

/* A command while it is recorded. */
struct shader_recording {
    struct hazard_recording *recording;
    const struct shader_command *command;
    struct descriptor_sets *sets;
    struct shader_pipeline *pipeline; /* NULL: unknown */
    struct hazard_bytes written[WRITTEN_MAX];
    uint64_t written_objects[WRITTEN_MAX];
    uint32_t written_count;
    bool writes_anywhere;
};

/* Notes for the summary that a table with a bound is full. */
static void note_full(const struct layer_device *device, const char *what)
{
    reporter_add_unchecked(device->instance->reporter, what, 1);
}

/* Returns UINT32_MAX if it is unknown what the descriptors of a binding are. */
static uint32_t find_bound(const struct shader_recording *shaders,
                           const struct shader_binding *binding, struct held_descriptor *found,
                           uint32_t count)
{
    const struct bound_shaders *bound = shaders->recording->journal->bound;
    if (binding->set >= BOUND_SETS)
        note_full(shaders->recording->device,
                  "uses of descriptor sets with a higher number than the layer tracks");
    return bound ? bound_shaders_find(bound, shaders->sets, shaders->command->point, binding->set,
                                      binding->binding, found, count)
                 : UINT32_MAX;
}

/* ---- what shaders may write */

/* Returns false if the bytes are unknown. A null descriptor has none. */
static bool add_written(struct shader_recording *shaders, const struct held_descriptor *item)
{
    struct hazard_recording *recording = shaders->recording;
    struct memory_bytes all;
    if (!item->handle)
        return true;
    if (!item->is_buffer || shaders->written_count == WRITTEN_MAX ||
        !resources_find_buffer_bytes(recording->device->resources,
                                     (VkBuffer)(uintptr_t)item->handle, &all) ||
        !all.memory_id)
        return false;
    if (item->offset >= all.size)
        return true;
    const uint64_t begin = all.begin + item->offset;
    const uint64_t size =
        item->range < all.size - item->offset ? item->range : all.size - item->offset;
    shaders->written_objects[shaders->written_count] = item->handle;
    shaders->written[shaders->written_count++] =
        (struct hazard_bytes){all.memory_id, begin, begin + size};
    return true;
}

static void find_written(struct shader_recording *shaders)
{
    const struct shader_bindings *stores =
        shaders->pipeline ? &shader_pipeline_facts(shaders->pipeline)->stores : NULL;
    struct held_descriptor found[WRITTEN_MAX];
    shaders->writes_anywhere = !stores || stores->has_others;
    for (uint32_t i = 0; !shaders->writes_anywhere && i < stores->count; i++) {
        const uint32_t count = find_bound(shaders, &stores->items[i], found, WRITTEN_MAX);
        shaders->writes_anywhere |= count > WRITTEN_MAX;
        for (uint32_t k = 0; !shaders->writes_anywhere && k < count; k++)
            shaders->writes_anywhere |= !add_written(shaders, &found[k]);
        if (shaders->writes_anywhere && count != UINT32_MAX &&
            (count > WRITTEN_MAX || shaders->written_count == WRITTEN_MAX))
            note_full(shaders->recording->device,
                      "commands whose shaders may write more buffers than the layer tracks");
    }
    if (shaders->writes_anywhere)
        shaders->written_count = 0;
}

static void add_writes(const struct shader_recording *shaders)
{
    const struct hazard_use use = {.kind = shaders->command->write, .role = HAZARD_SHADER};
    if (shaders->writes_anywhere || shaders->written_count)
        atomic_store(&shaders->recording->device->shaders_write, true);
    if (shaders->writes_anywhere)
        hazard_recording_add_anywhere(shaders->recording, &use);
    for (uint32_t i = 0; i < shaders->written_count; i++)
        hazard_recording_add(shaders->recording, &use, VK_OBJECT_TYPE_BUFFER,
                             shaders->written_objects[i], &shaders->written[i]);
}

/* ---- what shaders trace */

/* Adds an entry for a structure. One that is destroyed has no memory. Returns false if it is
 * unknown where the structure lies. */
static bool add_structure(const struct shader_recording *shaders, enum hazard_role role,
                          uint64_t structure)
{
    struct hazard_recording *recording = shaders->recording;
    const struct hazard_use use = {.kind = shaders->command->trace, .role = role};
    struct accel_facts facts;
    resources_look_up_accel(recording->device->resources,
                            (VkAccelerationStructureKHR)(uintptr_t)structure, &facts);
    if (facts.alive == YES) {
        if (!facts.memory || facts.is_sparse || !facts.size ||
            !hazard_memory_id(recording->journal, recording->device->resources, facts.memory))
            return false;
        hazard_recording_add_accel(recording, &use, &facts, 1);
        return true;
    }
    struct hazard_entry *entry = hazard_recording_add_entry(recording, HAZARD_ACCESS, &use);
    if (!entry)
        return false;
    entry->object_type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    entry->object = structure;
    return true;
}

/* Finds the structures that the command may trace, `traced` alone if that is known. Returns 0 if
 * others may be traced, too. */
static uint32_t find_traced(const struct shader_recording *shaders,
                            const struct traced_descriptor *traced, uint64_t found[TRACED_MAX])
{
    const struct shader_bindings *used = &shader_pipeline_facts(shaders->pipeline)->structures;
    struct held_descriptor items[TRACED_MAX];
    uint32_t count = 0;
    for (uint32_t i = 0; i < used->count; i++) {
        const struct shader_binding *binding = &used->items[i];
        const bool is_other = traced->is_known &&
                              (binding->set != traced->set || binding->binding != traced->binding);
        const uint32_t all = is_other ? 0 : find_bound(shaders, binding, items, TRACED_MAX);
        if (all > TRACED_MAX - count) {
            if (all != UINT32_MAX)
                note_full(shaders->recording->device,
                          "commands that may trace more structures than the layer tracks");
            return 0;
        }
        for (uint32_t k = 0; k < all; k++)
            if (!traced->is_known || items[k].element == traced->element)
                found[count++] = items[k].handle;
    }
    return used->has_others && !traced->is_known ? 0 : count;
}

/* Adds the structures that a command traces for certain, and its trace. Behind an unknown structure
 * nothing is known of the trace. A null descriptor is traced without an access. */
static void add_trace(const struct shader_recording *shaders,
                      const struct traced_descriptor *traced)
{
    uint64_t found[TRACED_MAX];
    const uint32_t count = find_traced(shaders, traced, found);
    for (uint32_t i = 0; i < count; i++)
        if (!found[i])
            return;
    for (uint32_t i = 0; i < count; i++)
        if (!add_structure(shaders, HAZARD_TRACED, found[i]))
            return;
    if (!unknown_is_set(&shaders->recording->journal->accesses_unknown))
        hazard_recording_add_anywhere(
            shaders->recording,
            &(struct hazard_use){.kind = shaders->command->trace, .role = HAZARD_SHADER});
}

/* Adds the structures of descriptors that must be valid because the shaders use them statically,
 * whether or not they are traced. */
static void add_used(const struct shader_recording *shaders)
{
    const struct shader_bindings *used = &shader_pipeline_facts(shaders->pipeline)->structures;
    for (uint32_t i = 0; i < used->count; i++) {
        struct held_descriptor item;
        if (find_bound(shaders, &used->items[i], &item, 1) == 1 && item.must_be_valid &&
            item.handle)
            add_structure(shaders, HAZARD_USED, item.handle);
    }
}

static bool find_certain_trace(const struct shader_recording *shaders,
                               struct traced_descriptor *traced)
{
    const struct bound_shaders *bound = shaders->recording->journal->bound;
    struct shader_launch launch = {.pushed =
                                       bound ? &bound->constants[shaders->command->point] : NULL};
    memcpy(launch.base, shaders->command->base, sizeof(launch.base));
    memcpy(launch.size, shaders->command->size, sizeof(launch.size));
    *traced = (struct traced_descriptor){.is_known = false};
    return shader_pipeline_traces(shaders->pipeline, &launch, traced);
}

/* ---- commands */

/* Conditional rendering leaves dispatches out, and no traces of rays. */
static bool may_be_left_out(const struct shader_recording *shaders)
{
    const struct command_buffer *command_buffer = shaders->recording->command_buffer;
    return shaders->command->point == SHADERS_OF_COMPUTE &&
           (shaders->recording->journal->has_condition ||
            (command_buffer && command_buffer->inherits_conditions));
}

/* A command whose size is in device memory may run no shader, but its descriptors must be valid. */
static void record_shaders(struct shader_recording *shaders)
{
    const struct shader_facts *facts =
        shaders->pipeline ? shader_pipeline_facts(shaders->pipeline) : NULL;
    const bool uses_structures = facts && facts->is_known && facts->structures.count &&
                                 shaders->command->trace != ACCESS_KINDS;
    struct traced_descriptor traced;
    find_written(shaders);
    if (!shaders->writes_anywhere && !shaders->written_count && !uses_structures &&
        !(facts && facts->may_trace))
        return;
    hazard_recording_command(shaders->recording, shaders->command->name, NULL);
    add_writes(shaders);
    if (uses_structures)
        add_used(shaders);
    if (shaders->pipeline && shaders->command->trace != ACCESS_KINDS && shaders->command->size[0] &&
        !may_be_left_out(shaders) && find_certain_trace(shaders, &traced))
        add_trace(shaders, &traced);
}

void hazards_add_shaders(struct hazard_recording *recording, const struct shader_command *command)
{
    struct hazard_objects *objects = recording->device->hazard_objects;
    const struct bound_shaders *bound = recording->journal->bound;
    struct shader_recording shaders = {
        .recording = recording, .command = command, .sets = hazard_objects_sets(objects)};
    if (bound && objects)
        shaders.pipeline = shader_pipelines_find(hazard_objects_pipelines(objects),
                                                 bound->pipelines[command->point]);
    record_shaders(&shaders);
    shader_pipeline_release(shaders.pipeline);
}

/* ---- descriptor sets */

void hazards_note_set_layout(struct layer_device *device, VkDescriptorSetLayout layout,
                             const VkDescriptorSetLayoutCreateInfo *info)
{
    struct descriptor_sets *sets = hazard_objects_sets(device->hazard_objects);
    if (sets && !descriptor_sets_note_layout(sets, layout, info))
        note_full(device,
                  "layouts of descriptor sets with more structures and storage buffers "
                  "than the layer tracks");
}

void hazards_forget_set_layout(struct layer_device *device, VkDescriptorSetLayout layout)
{
    struct descriptor_sets *sets = hazard_objects_sets(device->hazard_objects);
    if (sets && layout)
        descriptor_sets_forget_layout(sets, layout);
}

void hazards_allocate_sets(struct layer_device *device, const VkDescriptorSetAllocateInfo *info,
                           VkDescriptorSet *all)
{
    struct descriptor_sets *sets = hazard_objects_sets(device->hazard_objects);
    if (sets)
        descriptor_sets_allocate(sets, info, all);
}

void hazards_free_sets(struct layer_device *device, uint32_t count, const VkDescriptorSet *all)
{
    struct descriptor_sets *sets = hazard_objects_sets(device->hazard_objects);
    if (sets)
        descriptor_sets_free(sets, count, all);
}

void hazards_end_set_pool(struct layer_device *device, VkDescriptorPool pool)
{
    struct descriptor_sets *sets = hazard_objects_sets(device->hazard_objects);
    if (sets && pool)
        descriptor_sets_end_pool(sets, pool);
}

void hazards_update_sets(struct layer_device *device, uint32_t write_count,
                         const VkWriteDescriptorSet *writes, uint32_t copy_count,
                         const VkCopyDescriptorSet *copies)
{
    struct descriptor_sets *sets = hazard_objects_sets(device->hazard_objects);
    for (uint32_t i = 0; sets && i < write_count; i++)
        descriptor_sets_write(sets, &writes[i]);
    for (uint32_t i = 0; sets && i < copy_count; i++)
        descriptor_sets_copy(sets, &copies[i]);
}

/* What a template writes is not followed. */
void hazards_update_set_by_template(struct layer_device *device, VkDescriptorSet set)
{
    struct descriptor_sets *sets = hazard_objects_sets(device->hazard_objects);
    if (sets)
        descriptor_sets_forget_contents(sets, set);
}

/* ---- what is bound in command buffers */

/* Returns what is bound, for a change; NULL if memory runs out. */
static struct bound_shaders *change_bound(struct hazard_recording *recording)
{
    recording->journal->shaders_end = NULL;
    return bound_shaders_change(&recording->journal->bound);
}

void hazards_bind_pipeline(struct hazard_recording *recording, VkPipelineBindPoint bind_point,
                           VkPipeline pipeline)
{
    struct bound_shaders *bound = change_bound(recording);
    for (unsigned i = 0; bound && i < SHADER_POINTS; i++)
        if (shader_point_has((enum shader_point)i, shader_stages_of(bind_point)))
            bound->pipelines[i] = handle_number(pipeline);
}

/* Shader objects are not followed. */
void hazards_bind_shaders(struct hazard_recording *recording)
{
    struct bound_shaders *bound = change_bound(recording);
    if (bound)
        memset(bound->pipelines, 0, sizeof(bound->pipelines));
}

void hazards_bind_sets(struct hazard_recording *recording, const VkBindDescriptorSetsInfo *info)
{
    const VkDescriptorSet *sets = info->pDescriptorSets;
    for (enum shader_point point = 0; point < SHADER_POINTS; point++) {
        if (!shader_point_has(point, info->stageFlags))
            continue;
        struct bound_shaders *bound = change_bound(recording);
        for (uint32_t i = 0; bound && i < info->descriptorSetCount && info->firstSet < BOUND_SETS;
             i++)
            bound_shaders_bind_set(bound, point, info->firstSet + i,
                                   sets ? handle_number(sets[i]) : 0);
    }
}

void hazards_push_set(struct hazard_recording *recording, const VkPushDescriptorSetInfo *info)
{
    for (enum shader_point point = 0; point < SHADER_POINTS; point++) {
        if (!shader_point_has(point, info->stageFlags))
            continue;
        struct bound_shaders *bound = change_bound(recording);
        struct held_set *pushed = bound ? bound_shaders_push(bound, point, info->set) : NULL;
        for (uint32_t i = 0; pushed && i < info->descriptorWriteCount; i++)
            held_set_write(pushed, &info->pDescriptorWrites[i]);
    }
}

/* What a template pushes is not followed. */
void hazards_push_by_template(struct hazard_recording *recording, uint32_t set)
{
    hazards_bind_sets(recording, &(VkBindDescriptorSetsInfo){.stageFlags = VK_SHADER_STAGE_ALL,
                                                             .firstSet = set,
                                                             .descriptorSetCount = 1});
}

void hazards_push_constants(struct hazard_recording *recording, VkShaderStageFlags stages,
                            uint32_t offset, uint32_t size, const void *values)
{
    struct bound_shaders *bound = change_bound(recording);
    if (bound && readable(readable_cache_of_thread(), values, size))
        bound_shaders_push_constants(bound, stages, offset, size, values);
}
