/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of clusters and of partitioned structures, and queries of their sizes. */
#include "layer/intercepts/intercepts.h"

#include "observers.h"

void note_cluster_sizes(struct layer_device *device,
                        const VkClusterAccelerationStructureInputInfoNV *info)
{
    if (info->opType <= VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_GET_CLUSTER_TEMPLATE_INDICES_NV)
        size_queries_note_count(device->size_queries,
                                (enum asked_count)(ASKED_CLUSTERS + info->opType),
                                info->maxAccelerationStructureCount);
}

void note_partition_sizes(struct layer_device *device,
                          const VkPartitionedAccelerationStructureInstancesInputNV *info)
{
    struct size_queries *queries = device->size_queries;
    size_queries_note_count(queries, ASKED_INSTANCES, info->instanceCount);
    size_queries_note_count(queries, ASKED_INSTANCES_PER_PARTITION,
                            info->maxInstancePerPartitionCount);
    size_queries_note_count(queries, ASKED_PARTITIONS, info->partitionCount);
    size_queries_note_count(queries, ASKED_GLOBAL_INSTANCES,
                            info->maxInstanceInGlobalPartitionCount);
}
