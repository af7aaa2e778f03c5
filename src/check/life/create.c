/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of the creation of structures and micromaps. */
#include "arguments.h"
#include "src/base/chain.h"
#include "src/check/assemble/views.h"
#include "src/check/call/check.h"
#include "src/check/life/life.h"

static void view_chain(struct walk *walk, struct create_view *create, const void *chain)
{
    create->chain_known = chain_is_readable(walk->context, chain);
    if (!create->chain_known)
        return;
    create->has_motion_info =
        chain_find(chain, VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_MOTION_INFO_NV) != NULL;
    create->has_captured_data =
        chain_find(chain, VK_STRUCTURE_TYPE_OPAQUE_CAPTURE_DESCRIPTOR_DATA_CREATE_INFO_EXT) != NULL;
}

static void find_buffer(struct walk *walk, struct create_view *create, VkBuffer buffer)
{
    if (walk->context->level >= LEVEL_STATE)
        resources_look_up_buffer(walk->context->resources, buffer, &create->buffer);
}

static void view_accel(struct walk *walk, struct create_view *create,
                       const VkAccelerationStructureCreateInfoKHR *info)
{
    create->type = (uint32_t)info->type;
    create->create_flags = info->createFlags;
    create->offset = info->offset;
    create->size = info->size;
    create->device_address = info->deviceAddress;
    view_chain(walk, create, info->pNext);
    find_buffer(walk, create, info->buffer);
}

static void view_accel_at(struct walk *walk, struct create_view *create,
                          const VkAccelerationStructureCreateInfo2KHR *info)
{
    create->by_address = true;
    create->type = (uint32_t)info->type;
    create->create_flags = info->createFlags;
    create->address_flags = info->addressFlags;
    create->address = info->addressRange.address;
    create->size = info->addressRange.size;
    view_chain(walk, create, info->pNext);
    if (walk->context->level < LEVEL_STATE)
        return;
    resources_look_up_address(walk->context->resources, create->address, &create->storage);
    if (create->storage.status == ADDRESS_IN_BUFFER && !create->storage.is_shared)
        find_buffer(walk, create, create->storage.buffer);
}

static void view_micromap(struct walk *walk, struct create_view *create,
                          const VkMicromapCreateInfoEXT *info)
{
    create->is_micromap = true;
    create->type = (uint32_t)info->type;
    create->create_flags = info->createFlags;
    create->offset = info->offset;
    create->size = info->size;
    create->device_address = info->deviceAddress;
    find_buffer(walk, create, info->buffer);
}

static void view_nv_accel(struct create_view *create,
                          const VkAccelerationStructureCreateInfoNV *info)
{
    create->nv_info = &info->info;
    create->is_nv = true;
    create->compacted_size = info->compactedSize;
}

/* The parameters of all four commands are alike. */
static const void *create_info(struct walk *walk, const struct call_view *call, size_t size)
{
    const struct arguments_of_CreateAccelerationStructureKHR *arguments = call->arguments;
    return check_read(walk->context, arguments->pCreateInfo, size);
}

/* Returns false if the create info is not readable. */
static bool view_arguments(struct walk *walk, const struct call_view *call,
                           struct create_view *create)
{
    const void *info = NULL;
    switch ((int)call->command) {
    case COMMAND_CreateAccelerationStructure2KHR:
        info = create_info(walk, call, sizeof(VkAccelerationStructureCreateInfo2KHR));
        if (info)
            view_accel_at(walk, create, info);
        break;
    case COMMAND_CreateAccelerationStructureNV:
        info = create_info(walk, call, sizeof(VkAccelerationStructureCreateInfoNV));
        if (info)
            view_nv_accel(create, info);
        break;
    case COMMAND_CreateMicromapEXT:
        info = create_info(walk, call, sizeof(VkMicromapCreateInfoEXT));
        if (info)
            view_micromap(walk, create, info);
        break;
    default:
        info = create_info(walk, call, sizeof(VkAccelerationStructureCreateInfoKHR));
        if (info)
            view_accel(walk, create, info);
        break;
    }
    return info != NULL;
}

void check_create(struct walk *walk, const struct call_view *call)
{
    struct create_view create = {.call = call};
    const struct location location = check_argument(call, "pCreateInfo");
    if (!view_arguments(walk, call, &create))
        return;
    walk_create(walk, &create, &location);
    if (create.nv_info)
        check_nv_info(walk, call, create.nv_info);
}
