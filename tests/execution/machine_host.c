/* SPDX-License-Identifier: Apache-2.0 */
/* What the host builds, copies and queries itself, and the operations that it defers to. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "machine.h"
#include "tests/fixture/copies.h"

/* ---- operations */

SCENE_DESTROYS(destroy_operation, DestroyDeferredOperationKHR, VkDeferredOperationKHR)

void machine_create_operation(struct machine *machine, uint32_t operation)
{
    VkDeferredOperationKHR *handle = &machine->operations[operation];
    MACHINE_CALL(machine, CreateDeferredOperationKHR, machine->device, NULL, handle);
    scene_defer(machine->scene, machine->device, (uint64_t)*handle, destroy_operation);
}

/* ---- builds and copies */

/* Before a call that is to fail. */
static void arm(const struct machine *machine, const struct step *step, const char *name)
{
    if (step->value != 0)
        machine->scene->fixture->platform->null_driver.fail_next(name, VK_ERROR_OUT_OF_HOST_MEMORY);
}

static void fill_build(struct machine *machine, struct shape_arguments *arguments,
                       const struct step *step, uint32_t dst, uint32_t index)
{
    shape_fill(arguments, machine->scene, machine_shape(machine, step), true);
    arguments->info.dstAccelerationStructure = machine->structures[dst].handle;
    arguments->info.scratchData.hostAddress =
        machine->scratch.host + (size_t)index * MACHINE_ACCEL_SIZE;
}

static void build(struct machine *machine, const struct step *step)
{
    const bool is_pair = step->action == ACTION_HOST_BUILD_PAIR;
    const bool is_update = step->action == ACTION_HOST_UPDATE;
    struct shape_arguments arguments[2];
    fill_build(machine, &arguments[0], step, step->dst, 0);
    fill_build(machine, &arguments[1], step, step->src, 1);
    if (is_update) {
        arguments[0].info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
        arguments[0].info.srcAccelerationStructure = machine->structures[step->src].handle;
        machine->last_update = (struct place){BY_HOST, 0};
    } else if (step->detail == BAD) {
        machine->last_bad = (struct place){BY_HOST, is_pair};
    }
    const VkAccelerationStructureBuildGeometryInfoKHR infos[2] = {arguments[0].info,
                                                                  arguments[1].info};
    const VkAccelerationStructureBuildRangeInfoKHR *const ranges[2] = {arguments[0].ranges,
                                                                       arguments[1].ranges};
    arm(machine, step, "vkBuildAccelerationStructuresKHR");
    machine->result = machine->vk->BuildAccelerationStructuresKHR(
        machine->device, machine->operations[step->object], is_pair ? 2 : 1, infos, ranges);
}

void machine_host(struct machine *machine, const struct step *step)
{
    const VkDeferredOperationKHR operation = machine->operations[step->object];
    const VkCopyAccelerationStructureInfoKHR copy = machine_copy(machine, step);
    const VkCopyMemoryToAccelerationStructureInfoKHR filling =
        deserialize_info((uintptr_t)machine->blob.host, machine->structures[step->dst].handle);
    switch (step->action) {
    case ACTION_HOST_CLONE:
    case ACTION_HOST_COMPACT:
        machine->result =
            machine->vk->CopyAccelerationStructureKHR(machine->device, operation, &copy);
        break;
    case ACTION_HOST_FILL:
        machine->result =
            machine->vk->CopyMemoryToAccelerationStructureKHR(machine->device, operation, &filling);
        break;
    case ACTION_JOIN:
        machine->result = machine->vk->DeferredOperationJoinKHR(machine->device, operation);
        break;
    case ACTION_ASK:
        machine->result = machine->vk->GetDeferredOperationResultKHR(machine->device, operation);
        break;
    case ACTION_FAIL_OPERATION:
        machine->scene->fixture->platform->null_driver.fail_next("vkGetDeferredOperationResultKHR",
                                                                 VK_ERROR_OUT_OF_HOST_MEMORY);
        break;
    case ACTION_RENEW_OPERATION:
        scene_destroy(machine->scene, (uint64_t)operation);
        machine_create_operation(machine, step->object);
        break;
    default:
        build(machine, step);
    }
}

/* ---- queries of compacted sizes, as the host resets and reads them */

/* Reads query 0 with a stride that leaves room for two results; its availability may come second.
 */
static void read_queries(struct machine *machine, VkQueryResultFlags flags)
{
    uint64_t words[4] = {0};
    const VkResult result = machine->vk->GetQueryPoolResults(
        machine->device, machine->queries, 0, 1, sizeof(words), words, sizeof(words), flags);
    uint32_t first_half;
    memcpy(&first_half, words, sizeof(first_half));
    if (result == VK_SUCCESS)
        machine->compacted = flags & VK_QUERY_RESULT_64_BIT ? words[0] : first_half;
    else if (result != VK_NOT_READY)
        expect_success(result, "vkGetQueryPoolResults");
}

static void query_on_the_host(struct machine *machine, uint32_t structure)
{
    MACHINE_CALL(machine, WriteAccelerationStructuresPropertiesKHR, machine->device, 1,
                 &machine->structures[structure].handle,
                 VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                 sizeof(machine->compacted), &machine->compacted, sizeof(machine->compacted));
}

void machine_query(struct machine *machine, const struct step *step)
{
    switch (step->action) {
    case ACTION_HOST_RESET_QUERIES:
        machine->vk->ResetQueryPool(machine->device, machine->queries, 0, QUERIES);
        break;
    case ACTION_CANNOT_READ:
        machine->scene->fixture->platform->null_driver.fail_next("vkGetQueryPoolResults",
                                                                 VK_NOT_READY);
        break;
    case ACTION_HOST_QUERY:
        query_on_the_host(machine, step->src);
        break;
    default:
        read_queries(machine, (VkQueryResultFlags)step->value);
    }
}
