/* SPDX-License-Identifier: Apache-2.0 */
/* The machine's objects, and which part of it takes a step. */
#include "machine.h"

#include <stdlib.h>
#include <string.h>

const char *machine_name(uint32_t command_buffer)
{
    static const char *const names[COMMAND_BUFFERS] = {"A", "B", "C", "D", "P", "R", "S", "T"};
    return names[command_buffer];
}

static bool is_secondary(uint32_t command_buffer)
{
    return command_buffer == S || command_buffer == T;
}

/* ---- objects */

uint32_t machine_family(const struct fixture *fixture, uint32_t queue)
{
    const uint32_t first = fixture_find_family(fixture, VK_QUEUE_COMPUTE_BIT, 0);
    for (uint32_t i = first + 1; i < fixture->family_count && queue == 1; i++)
        if ((fixture->families[i].queueFlags & VK_QUEUE_COMPUTE_BIT) != 0)
            return i;
    return queue == 0 ? first : UINT32_MAX;
}

static void create_structure(struct machine *machine, uint32_t index, VkDeviceSize size,
                             VkAccelerationStructureTypeKHR type)
{
    machine->structures[index].handle =
        scene_accel_in(machine->scene, &machine->structures[index].buffer, 0, size, type);
}

void machine_allocate(struct machine *machine, uint32_t command_buffer)
{
    machine->command_buffers[command_buffer] = scene_allocate_command_buffer(
        machine->scene, machine->pools[command_buffer],
        is_secondary(command_buffer) ? VK_COMMAND_BUFFER_LEVEL_SECONDARY
                                     : VK_COMMAND_BUFFER_LEVEL_PRIMARY);
    const STRUCT(VkDebugUtilsObjectNameInfoEXT, name, .objectType = VK_OBJECT_TYPE_COMMAND_BUFFER,
                 .objectHandle = (uint64_t)(uintptr_t)machine->command_buffers[command_buffer],
                 .pObjectName = machine_name(command_buffer));
    MACHINE_CALL(machine, SetDebugUtilsObjectNameEXT, machine->device, &name);
}

void machine_create_pool(struct machine *machine, uint32_t command_buffer)
{
    const uint32_t family = machine_family(machine->scene->fixture, QUEUE_OF(command_buffer));
    if (family == UINT32_MAX)
        return;
    machine->pools[command_buffer] = scene_pool(machine->scene, family, 0);
    machine_allocate(machine, command_buffer);
}

SCENE_CREATES(create_fence, Fence, VkFence, VkFenceCreateInfo)
SCENE_CREATES(create_semaphore, Semaphore, VkSemaphore, VkSemaphoreCreateInfo)
SCENE_CREATES(create_query_pool, QueryPool, VkQueryPool, VkQueryPoolCreateInfo)
SCENE_CREATES(create_event, Event, VkEvent, VkEventCreateInfo)

static VkSemaphore create_semaphore_of(struct machine *machine, VkSemaphoreType type,
                                       bool is_shared)
{
    const STRUCT(VkExportSemaphoreCreateInfo, export_info,
                 .handleTypes = VK_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD_BIT);
    const STRUCT(VkSemaphoreTypeCreateInfo, type_info, .pNext = is_shared ? &export_info : NULL,
                 .semaphoreType = type);
    return create_semaphore(machine->scene, &MAKE(VkSemaphoreCreateInfo, .pNext = &type_info));
}

void machine_open(struct machine *machine, struct fixture *fixture,
                  VkAccelerationStructureTypeKHR type)
{
    memset(machine, 0, sizeof(*machine));
    machine->scene = scene_open(fixture, COMMAND_DEVICE);
    machine->vk = &fixture->vk;
    machine->device = fixture->device;
    machine->type = type;
    machine->last_update.command_buffer = machine->last_bad.command_buffer = NOWHERE;
    for (uint32_t i = 0; i < STRUCTURES; i++) {
        machine->structures[i].buffer =
            scene_buffer(machine->scene, MACHINE_ACCEL_SIZE, ACCEL_USAGE);
        create_structure(machine, i, MACHINE_ACCEL_SIZE, type);
    }
    machine->scratch = scene_buffer(
        machine->scene, (VkDeviceSize)COMMAND_BUFFERS * 2 * MACHINE_ACCEL_SIZE, SCRATCH_USAGE);
    machine->blob = scene_buffer(machine->scene, MACHINE_ACCEL_SIZE, SCRATCH_USAGE);
    for (uint32_t i = 0; i < QUEUES; i++) {
        const uint32_t family = machine_family(fixture, i);
        if (family != UINT32_MAX)
            machine->vk->GetDeviceQueue(machine->device, family, 0, &machine->queues[i]);
    }
    for (uint32_t i = 0; i < COMMAND_BUFFERS; i++)
        machine_create_pool(machine, i);
    machine->fence = create_fence(machine->scene, &MAKE(VkFenceCreateInfo));
    machine->queries = create_query_pool(
        machine->scene, &MAKE(VkQueryPoolCreateInfo,
                              .queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                              .queryCount = QUERIES));
    for (uint32_t i = 0; i < EVENTS; i++)
        machine->events[i] = create_event(
            machine->scene,
            &MAKE(VkEventCreateInfo, .flags = i == G ? VK_EVENT_CREATE_DEVICE_ONLY_BIT : 0));
    for (uint32_t i = 1; i <= DEFERRED_OPERATIONS; i++)
        machine_create_operation(machine, i);
    for (uint32_t i = 0; i < SEMAPHORES; i++) {
        machine->binaries[i] = create_semaphore_of(machine, VK_SEMAPHORE_TYPE_BINARY, false);
        machine->timelines[i] = create_semaphore_of(machine, VK_SEMAPHORE_TYPE_TIMELINE, false);
    }
    if (fixture->platform->is_null)
        machine->timelines[FOREIGN] =
            create_semaphore_of(machine, VK_SEMAPHORE_TYPE_TIMELINE, true);
}

void machine_close(struct machine *machine)
{
    MACHINE_CALL(machine, DeviceWaitIdle, machine->device);
    scene_close(machine->scene);
}

static struct test_buffer *find_input(struct machine *machine, enum input input)
{
    struct scene *scene = machine->scene;
    struct test_buffer *const inputs[INPUTS] = {
        [VERTICES] = &scene->vertices,         [INDICES] = &scene->indices,
        [TRANSFORMS] = &scene->transforms,     [BOXES] = &scene->boxes,
        [INSTANCES_INPUT] = &scene->instances, [SCRATCH] = &machine->scratch,
        [RANGES] = &scene->indirect,
    };
    return inputs[input];
}

static void change_input(struct machine *machine, const struct step *step)
{
    struct test_buffer *input = find_input(machine, (enum input)step->detail);
    if (step->action != ACTION_FREE_INPUT)
        scene_destroy(machine->scene, (uint64_t)input->handle);
    if (step->action != ACTION_DESTROY_INPUT)
        scene_destroy(machine->scene, (uint64_t)input->memory);
    if (step->action == ACTION_RENEW_INPUT)
        *input = scene_buffer(machine->scene, input->size, input->usage);
}

/* Of the structure that a step creates. */
static VkDeviceSize size_of(const struct machine *machine, const struct step *step)
{
    if (step->action == ACTION_CREATE_FITTING)
        return shape_sizes(machine->scene, &machine->good).accelerationStructureSize;
    return step->action == ACTION_CREATE_COMPACTED ? machine->compacted - step->value
                                                   : MACHINE_ACCEL_SIZE;
}

static void create_sparse(struct machine *machine, uint32_t structure)
{
    struct scene *scene = machine->scene;
    struct test_buffer *buffer = &machine->structures[structure].buffer;
    *buffer = scene_sparse_buffer(scene, MACHINE_ACCEL_SIZE, ACCEL_USAGE,
                                  VK_BUFFER_CREATE_SPARSE_ALIASED_BIT);
    if (MACHINE_ACCEL_SIZE % scene_sparse_page(scene, buffer) != 0)
        abort();
    if (machine->pages.handle == VK_NULL_HANDLE)
        machine->pages = scene_allocate(scene, (VkDeviceSize)SPARSE_PAGES * MACHINE_ACCEL_SIZE);
    machine->structures[structure].handle =
        scene_accel_in(scene, buffer, 0, MACHINE_ACCEL_SIZE, machine->type);
}

static void change_structure(struct machine *machine, const struct step *step)
{
    struct scene *scene = machine->scene;
    const struct test_buffer *buffer = &machine->structures[step->object].buffer;
    if (step->action == ACTION_DESTROY)
        scene_destroy(scene, (uint64_t)machine->structures[step->object].handle);
    else if (step->action == ACTION_DESTROY_BUFFER)
        scene_destroy(scene, (uint64_t)buffer->handle);
    else if (step->action == ACTION_FREE_MEMORY)
        scene_destroy(scene, (uint64_t)buffer->memory);
    else if (step->action == ACTION_CREATE_SPARSE)
        create_sparse(machine, step->object);
    else
        create_structure(machine, step->object, size_of(machine, step),
                         step->action == ACTION_CREATE_GENERIC
                             ? VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR
                             : machine->type);
}

void machine_step(struct machine *machine, const struct step *step)
{
    if (machine->is_nv && machine_nv_step(machine, step))
        return;
    if (step->action >= ACTION_HOST_BUILD && step->action < ACTION_BATCH)
        machine_host(machine, step);
    else if (step->action < ACTION_BATCH)
        machine_record(machine, step);
    else if (step->action < ACTION_HOST_RESET_QUERIES)
        machine_submit(machine, step);
    else if (step->action < ACTION_CREATE)
        machine_query(machine, step);
    else if (step->action < ACTION_DESTROY_INPUT)
        change_structure(machine, step);
    else
        change_input(machine, step);
}
