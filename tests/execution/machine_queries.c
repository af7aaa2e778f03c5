/* SPDX-License-Identifier: Apache-2.0 */
/* The machine's queries of compacted sizes, as the host resets and reads them. */
#include <string.h>

#include "machine.h"

MACHINE_DESTROYS(QueryPool)

void machine_create_queries(struct machine *machine)
{
    const VkQueryPoolCreateInfo info = MAKE(
        VkQueryPoolCreateInfo, .queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
        .queryCount = QUERIES);
    MACHINE_CREATE(machine, QueryPool, &info, &machine->queries);
}

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
