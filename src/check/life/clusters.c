/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of builds of clusters and of partitioned structures, of queries of their sizes,
 * and of descriptors of partitioned structures. */
#include "arguments.h"
#include "src/base/chain.h"
#include "src/check/assemble/views.h"
#include "src/check/life/life.h"
#include "src/check/walk/rows.h"
#include "src/view/cluster_view.h"

#define WALK(subject) static WALK_ALL(subject)
WALK(cluster_input)
WALK(cluster_triangles)
WALK(cluster_build)
WALK(partition_input)
WALK(partition_build)
WALK(partition_descriptors)
WALK(partition_descriptor)

/* ---- addresses */

static struct built_address view_address(struct check_context *context, const char *field,
                                         VkDeviceAddress address, bool is_ignored, bool is_indirect)
{
    struct built_address view = {
        .field = field, .address = address, .is_ignored = is_ignored, .is_indirect = is_indirect};
    if (context->level >= LEVEL_STATE && !is_ignored && !is_indirect)
        resources_look_up_address(context->resources, address, &view.facts);
    return view;
}

/* The query takes the same structure as the build, which the caller has found valid. */
static void find_sizes(struct walk *walk, const void *input, struct size_facts *sizes)
{
    const struct check_context *context = walk->context;
    if (context->level >= LEVEL_STATE && !walk->findings)
        context->hooks->find_input_sizes(context->user, input, sizes);
}

/* ---- clusters */

static void check_cluster_input(struct walk *walk, const struct call_view *call,
                                const struct location *location, const char *triangles_argument,
                                const VkClusterAccelerationStructureInputInfoNV *info)
{
    const struct check_context *context = walk->context;
    const struct cluster_input_view input = {.call = call, .info = info};
    struct cluster_triangles_view triangles = {.call = call};
    const struct location of_triangles = check_argument(call, triangles_argument);
    walk_cluster_input(walk, &input, location);
    if (info->opType == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_MOVE_OBJECTS_NV ||
        info->opType == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_CLUSTERS_BOTTOM_LEVEL_NV)
        return;
    triangles.input =
        check_read(walk->context, info->opInput.pTriangleClusters, sizeof(*triangles.input));
    if (!triangles.input)
        return;
    if (context->level >= LEVEL_STATE)
        triangles.vertex_format_supported =
            context->hooks->vertex_format_supported(context->user, triangles.input->vertexFormat);
    walk_cluster_triangles(walk, &triangles, &of_triangles);
}

static void check_cluster_size_query(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_GetClusterAccelerationStructureBuildSizesNV *arguments =
        call->arguments;
    const struct location location = check_argument(call, NULL);
    const VkClusterAccelerationStructureInputInfoNV *info =
        check_read(walk->context, arguments->pInfo, sizeof(*info));
    if (info)
        check_cluster_input(walk, call, &location, "pInfo->opInput.pTriangleClusters", info);
}

/* Which members count is decided by the mode, and which are addresses of addresses by flags. */
static void view_cluster_addresses(struct check_context *context, struct cluster_build_view *view)
{
    const VkClusterAccelerationStructureCommandsInfoNV *info = view->info;
    const VkClusterAccelerationStructureOpModeNV mode = info->input.opMode;
    const bool is_explicit =
                   mode == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_EXPLICIT_DESTINATIONS_NV,
               is_implicit =
                   mode == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_IMPLICIT_DESTINATIONS_NV,
               computes = mode == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_COMPUTE_SIZES_NV;
    const VkDeviceAddress addresses = info->dstAddressesArray.deviceAddress,
                          sizes = info->dstSizesArray.deviceAddress;
#define VIEW(address, is_ignored, bit)                                                             \
    view_address(                                                                                  \
        context, #address, info->address, (is_ignored),                                            \
        info->addressResolutionFlags                                                               \
            &VK_CLUSTER_ACCELERATION_STRUCTURE_ADDRESS_RESOLUTION_INDIRECTED_##bit##_BIT_NV)
    view->dst = VIEW(dstImplicitData, !is_implicit, DST_IMPLICIT_DATA);
    view->scratch = VIEW(scratchData, false, SCRATCH_DATA);
    view->addresses = VIEW(dstAddressesArray.deviceAddress,
                           computes || (!is_explicit && !addresses), DST_ADDRESS_ARRAY);
    view->dst_sizes = VIEW(dstSizesArray.deviceAddress, !computes && !sizes, DST_SIZES_ARRAY);
    view->infos = VIEW(srcInfosArray.deviceAddress, false, SRC_INFOS_ARRAY);
    view->count = VIEW(srcInfosCount, !info->srcInfosCount, SRC_INFOS_COUNT);
#undef VIEW
}

static void check_cluster_build(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_CmdBuildClusterAccelerationStructureIndirectNV *arguments =
        call->arguments;
    struct check_context *context = walk->context;
    const struct location location = check_argument(call, "pCommandInfos"),
                          whole = check_argument(call, NULL);
    struct cluster_build_view view = {
        .call = call, .info = check_read(context, arguments->pCommandInfos, sizeof(*view.info))};
    if (!view.info)
        return;
    const VkClusterAccelerationStructureInputInfoNV *input = &view.info->input;
    check_cluster_input(walk, call, &whole, "pCommandInfos->input.opInput.pTriangleClusters",
                        input);
    find_sizes(walk, input, &view.sizes);
    if (context->size_queries)
        view.asked = size_queries_greatest(context->size_queries,
                                           (enum asked_count)(ASKED_CLUSTERS + input->opType));
    view_cluster_addresses(context, &view);
    walk_cluster_build(walk, &view, &location);
}

/* ---- partitioned structures */

static void check_partition_size_query(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_GetPartitionedAccelerationStructuresBuildSizesNV *arguments =
        call->arguments;
    const struct location location = check_argument(call, "pInfo");
    const struct partition_input_view view = {
        .call = call, .info = check_read(walk->context, arguments->pInfo, sizeof(*view.info))};
    if (view.info)
        walk_partition_input(walk, &view, &location);
}

static void check_partition_build(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_CmdBuildPartitionedAccelerationStructuresNV *arguments =
        call->arguments;
    struct check_context *context = walk->context;
    const struct location location = check_argument(call, "pBuildInfo");
    struct partition_build_view view = {
        .call = call, .info = check_read(context, arguments->pBuildInfo, sizeof(*view.info))};
    const VkBuildPartitionedAccelerationStructureInfoNV *info = view.info;
    if (!info)
        return;
    const struct partition_input_view input = {.call = call, .info = &info->input};
    walk_partition_input(walk, &input, &location);
    find_sizes(walk, &info->input, &view.sizes);
    if (context->size_queries) {
        const struct size_queries *queries = context->size_queries;
        view.asked.instances = size_queries_greatest(queries, ASKED_INSTANCES);
        view.asked.instances_per_partition =
            size_queries_greatest(queries, ASKED_INSTANCES_PER_PARTITION);
        view.asked.partitions = size_queries_greatest(queries, ASKED_PARTITIONS);
        view.asked.global_instances = size_queries_greatest(queries, ASKED_GLOBAL_INSTANCES);
    }
#define VIEW(address) view_address(context, #address, info->address, false, false)
    view.src = VIEW(srcAccelerationStructureData);
    view.dst = VIEW(dstAccelerationStructureData);
    view.scratch = VIEW(scratchData);
    view.infos = VIEW(srcInfos);
    view.count = VIEW(srcInfosCount);
#undef VIEW
    walk_partition_build(walk, &view, &location);
}

void check_addressed(struct walk *walk, const struct call_view *call)
{
    switch ((int)call->command) {
    case COMMAND_CmdBuildClusterAccelerationStructureIndirectNV:
        check_cluster_build(walk, call);
        break;
    case COMMAND_GetClusterAccelerationStructureBuildSizesNV:
        check_cluster_size_query(walk, call);
        break;
    case COMMAND_CmdBuildPartitionedAccelerationStructuresNV:
        check_partition_build(walk, call);
        break;
    case COMMAND_GetPartitionedAccelerationStructuresBuildSizesNV:
        check_partition_size_query(walk, call);
        break;
    default:
        break;
    }
}

void check_partition_descriptors(struct walk *walk, const struct call_view *call,
                                 struct location location, const VkWriteDescriptorSet *write)
{
    struct check_context *context = walk->context;
    struct partition_descriptors_view view = {.call = call, .write = write};
    if (!chain_is_readable(context, write->pNext))
        return;
    view.info = check_read(
        context,
        chain_find(write->pNext,
                   VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_PARTITIONED_ACCELERATION_STRUCTURE_NV),
        sizeof(*view.info));
    if (!view.info)
        return;
    walk_partition_descriptors(walk, &view, &location);
    const uint32_t count = view.info->accelerationStructureCount;
    const VkDeviceAddress *addresses =
        check_read(context, view.info->pAccelerationStructures, (size_t)count * sizeof(*addresses));
    for (uint32_t i = 0; addresses && context->level >= LEVEL_STATE && i < count; i++) {
        struct partition_descriptor_view descriptor = {.call = call};
        resources_look_up_address(context->resources, addresses[i], &descriptor.facts);
        location.geometry = i;
        walk_partition_descriptor(walk, &descriptor, &location);
    }
}
