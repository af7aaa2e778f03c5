/* SPDX-License-Identifier: Apache-2.0 */
/* The machine's steps as VK_NV_ray_tracing takes them. Of a shape it knows the flags, and what kind
 * of structure it is. */
#include <stdlib.h>

#include "machine.h"

static void create_structure(struct machine *machine, uint32_t index)
{
    struct scene *scene = machine->scene;
    const VkAccelerationStructureNV handle = scene_nv_create(scene);
    const struct test_memory memory = scene_nv_allocate(scene, handle, 0);

    scene_nv_bind(scene, handle, memory.handle, 0);
    machine->nv[index].handle = handle;
    machine->nv[index].memory = memory.handle;
}

void machine_nv_open(struct machine *machine)
{
    struct scene *scene = machine->scene;

    machine->is_nv = true;
    scene_nv_open(scene);
    if (machine->good.geometry_type == VK_GEOMETRY_TYPE_AABBS_KHR)
        scene_nv_use_boxes(scene);
    if (machine->good.geometry_type == VK_GEOMETRY_TYPE_INSTANCES_KHR)
        scene_nv_use_instances(scene);
    scene->nv.info.flags = machine->good.flags;
    scene_nv_give_objects(scene);
    for (uint32_t i = 0; i < STRUCTURES; i++)
        create_structure(machine, i);
}

static void record(struct machine *machine, const struct step *step, uint32_t dst)
{
    struct scene_nv *nv = &machine->scene->nv;
    const bool is_update = step->action == ACTION_UPDATE;

    nv->info.flags = machine_shape(machine, step)->flags;
    machine->vk->CmdBuildAccelerationStructureNV(
        machine->command_buffers[step->object], &nv->info, nv->instance_data, 0, is_update,
        machine->nv[dst].handle, is_update ? machine->nv[step->src].handle : VK_NULL_HANDLE,
        nv->scratch, 0);
    nv->info.flags = machine->good.flags;
}

static void build(struct machine *machine, const struct step *step, uint32_t dst)
{
    machine_begin_build(machine, step);
    record(machine, step, dst);
    machine_end_build(machine, step);
}

static void copy(struct machine *machine, const struct step *step)
{
    machine->vk->CmdCopyAccelerationStructureNV(
        machine->command_buffers[step->object], machine->nv[step->dst].handle,
        machine->nv[step->src].handle,
        step->action == ACTION_COMPACT ? VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR
                                       : VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    machine_barrier(machine, machine->command_buffers[step->object]);
}

/* No build ranges: they are not in a buffer. */
static VkBuffer find_input(const struct machine *machine, enum input input)
{
    const struct scene_nv *nv = &machine->scene->nv;
    const VkBuffer inputs[INPUTS] = {
        [VERTICES] = nv->vertices.handle,         [INDICES] = nv->indices.handle,
        [TRANSFORMS] = nv->transforms.handle,     [BOXES] = nv->boxes.handle,
        [INSTANCES_INPUT] = nv->instances.handle, [SCRATCH] = nv->scratch,
    };
    if (inputs[input] == VK_NULL_HANDLE)
        abort();
    return inputs[input];
}

bool machine_nv_step(struct machine *machine, const struct step *step)
{
    struct scene *scene = machine->scene;
    switch (step->action) {
    case ACTION_BUILD:
    case ACTION_UPDATE:
        build(machine, step, step->dst);
        return true;
    case ACTION_BUILD_PAIR:
        build(machine, step, step->dst);
        build(machine, step, step->src);
        return true;
    case ACTION_CLONE:
    case ACTION_COMPACT:
        copy(machine, step);
        return true;
    case ACTION_CREATE:
        create_structure(machine, step->object);
        return true;
    case ACTION_DESTROY:
        scene_destroy(scene, (uint64_t)machine->nv[step->object].handle);
        return true;
    case ACTION_FREE_MEMORY:
        scene_destroy(scene, (uint64_t)machine->nv[step->object].memory);
        return true;
    case ACTION_DESTROY_INPUT:
        scene_destroy(scene, (uint64_t)find_input(machine, (enum input)step->detail));
        return true;
    default:
        return false;
    }
}

bool machine_nv_takes(const struct program *program)
{
    for (const struct step *step = program->steps; step->action != ACTION_END_OF_PROGRAM; step++)
        switch (step->action) {
        case ACTION_FILL:
        case ACTION_RESET_QUERIES:
        case ACTION_QUERY:
        case ACTION_CREATE_GENERIC:
        case ACTION_CREATE_COMPACTED:
        case ACTION_CREATE_FITTING:
        case ACTION_CREATE_SPARSE:
        case ACTION_DESTROY_BUFFER:
        case ACTION_FREE_INPUT:
        case ACTION_RENEW_INPUT:
            return false;
        default:
            if ((step->action >= ACTION_HOST_BUILD && step->action < ACTION_BATCH) ||
                (step->action >= ACTION_HOST_RESET_QUERIES && step->action < ACTION_CREATE))
                return false;
        }
    return true;
}
