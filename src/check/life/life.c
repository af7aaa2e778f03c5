/* SPDX-License-Identifier: Apache-2.0 */
/* Validates a call: first the call as a whole, then the structures that it names. */
#include "src/check/life/life.h"

#include "arguments.h"
#include "src/check/assemble/views.h"
#include "src/check/walk/rows.h"

WALK_ALL(copy)
WALK_ALL(create)
WALK_ALL(query)
WALK_ALL(size_query)
WALK_ALL(micromap_info)
WALK_ALL(built_micromap)
WALK_ALL(micromap_triangles)
WALK_ALL(lookup)
WALK_ALL(binding)
WALK_ALL(capture)
WALK_ALL(descriptor)
WALK_ALL(templated)
WALK_ALL(queried)
WALK_ALL(read_queries)
WALK_ALL(destroyed)

struct location check_argument(const struct call_view *call, const char *parameter)
{
    return (struct location){
        .command = call->command, .subject = SUBJECT_ARGUMENT, .argument = parameter};
}

struct location check_element(const struct call_view *call, const char *parameter, uint32_t index)
{
    return (struct location){.command = call->command,
                             .subject = SUBJECT_ARGUMENT,
                             .argument = parameter,
                             .is_element = true,
                             .build = index};
}

const void *check_read(struct check_context *context, const void *pointer, size_t size)
{
    return readable(context->readable, pointer, size)
               ? align_array(context, pointer, size, _Alignof(void *))
               : NULL;
}

const void *check_info_argument(struct check_context *context, const struct call_view *call,
                                size_t size)
{
    const struct arguments_of_CmdCopyAccelerationStructureKHR *recorded = call->arguments;
    const struct arguments_of_CopyAccelerationStructureKHR *hosted = call->arguments;
    return check_read(context, command_is_recorded(call->command) ? recorded->pInfo : hosted->pInfo,
                      size);
}

static void check_operands(struct walk *walk, const struct call_view *call)
{
    switch ((int)call->command) {
    case COMMAND_CreateAccelerationStructure2KHR:
    case COMMAND_CreateAccelerationStructureKHR:
    case COMMAND_CreateAccelerationStructureNV:
    case COMMAND_CreateMicromapEXT:
        check_create(walk, call);
        break;
    case COMMAND_CmdCopyAccelerationStructureKHR:
    case COMMAND_CmdCopyAccelerationStructureNV:
    case COMMAND_CmdCopyAccelerationStructureToMemoryKHR:
    case COMMAND_CmdCopyMemoryToAccelerationStructureKHR:
    case COMMAND_CmdCopyMemoryToMicromapEXT:
    case COMMAND_CmdCopyMicromapEXT:
    case COMMAND_CmdCopyMicromapToMemoryEXT:
    case COMMAND_CopyAccelerationStructureKHR:
    case COMMAND_CopyAccelerationStructureToMemoryKHR:
    case COMMAND_CopyMemoryToAccelerationStructureKHR:
    case COMMAND_CopyMemoryToMicromapEXT:
    case COMMAND_CopyMicromapEXT:
    case COMMAND_CopyMicromapToMemoryEXT:
        check_copy(walk, call);
        break;
    case COMMAND_CmdWriteAccelerationStructuresPropertiesKHR:
    case COMMAND_CmdWriteAccelerationStructuresPropertiesNV:
    case COMMAND_CmdWriteMicromapsPropertiesEXT:
    case COMMAND_WriteAccelerationStructuresPropertiesKHR:
    case COMMAND_WriteMicromapsPropertiesEXT:
        check_query(walk, call);
        break;
    case COMMAND_GetQueryPoolResults:
        check_read_queries(walk, call);
        break;
    case COMMAND_GetAccelerationStructureBuildSizesKHR:
        check_size_query(walk, call);
        break;
    case COMMAND_BuildMicromapsEXT:
    case COMMAND_CmdBuildMicromapsEXT:
        check_micromap_builds(walk, call);
        break;
    case COMMAND_GetMicromapBuildSizesEXT:
        check_micromap_size_query(walk, call);
        break;
    case COMMAND_BindAccelerationStructureMemoryNV:
        check_bindings(walk, call);
        break;
    case COMMAND_GetAccelerationStructureOpaqueCaptureDescriptorDataEXT:
        check_capture(walk, call);
        break;
    case COMMAND_GetAccelerationStructureDeviceAddressKHR:
    case COMMAND_GetAccelerationStructureHandleNV:
        check_lookup(walk, call);
        break;
    case COMMAND_UpdateDescriptorSets:
    case COMMAND_CmdPushDescriptorSet:
    case COMMAND_CmdPushDescriptorSet2:
        check_descriptors(walk, call);
        break;
    case COMMAND_UpdateDescriptorSetWithTemplate:
        check_templated(walk, call);
        break;
    case COMMAND_DestroyBuffer:
    case COMMAND_FreeMemory:
    case COMMAND_DestroyAccelerationStructureKHR:
    case COMMAND_DestroyAccelerationStructureNV:
    case COMMAND_DestroyMicromapEXT:
        check_destroyed(walk, call);
        break;
    default:
        check_addressed(walk, call);
        break;
    }
}

void check_life(struct check_context *context, const struct call_view *call)
{
    struct aligned_copies copies = {NULL};
    struct walk walk;
    walk_start(&walk, context);
    context->copies = &copies;
    walk_call(&walk, call, LEVEL_PARAMETERS);
    walk_call(&walk, call, LEVEL_STATE);
    if (check_implicit(&walk, call))
        check_operands(&walk, call);
    if (copies.first)
        aligned_copies_release(&copies);
}
