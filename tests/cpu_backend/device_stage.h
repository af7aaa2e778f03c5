/* SPDX-License-Identifier: Apache-2.0 */
/* A stage (host_stage.h) whose scenes are built by command buffers, from device-local copies of
 * their data. */
#ifndef CPU_BACKEND_DEVICE_STAGE_H
#define CPU_BACKEND_DEVICE_STAGE_H

#include "host_stage.h"

struct device_stage {
    struct stage stage;
    VkQueue queue;
    VkCommandPool pool;
};

const char *device_stage_open(struct device_stage *stage, const char *platform);
void device_stage_close(struct device_stage *stage);
/* What main() returns: opens the stage on the platform that the arguments name, and runs tests. */
int device_stage_main(struct device_stage *stage, int argc, char **argv, int (*run_all)(void));

/* A buffer in mapped memory, for any use that the tests make of one. */
struct device_buffer {
    VkBuffer handle;
    VkDeviceMemory memory;
    VkDeviceAddress address;
    void *bytes;
};
struct device_buffer device_buffer_create(struct device_stage *stage, VkDeviceSize size);
void device_buffer_destroy(struct device_stage *stage, struct device_buffer *buffer);

VkCommandBuffer device_begin(struct device_stage *stage, VkCommandBufferLevel level);
void device_end(struct device_stage *stage, VkCommandBuffer commands);
/* Submits, and waits with a fence. */
void device_run(struct device_stage *stage, VkCommandBuffer commands);
/* Ends it, runs it and frees it. */
void device_finish(struct device_stage *stage, VkCommandBuffer commands);

/* Makes all that was written visible to all that follows. */
void device_barrier(struct device_stage *stage, VkCommandBuffer commands);

/* A host build's parameters (stage_triangles, stage_instances, stage_create_for) with the same data
 * in buffers. Not to be moved. */
struct device_build {
    struct stage_build *host;
    VkDeviceSize size; /* of the data */
    VkAccelerationStructureGeometryKHR geometry;
    VkAccelerationStructureBuildGeometryInfoKHR info;
    struct device_buffer staging, data, scratch;
};
void device_build_create(struct device_stage *stage, struct stage_build *host, VkDeviceSize size,
                         struct device_build *build);
void device_build_destroy(struct device_stage *stage, struct device_build *build);

/* Records an upload of the host's data as it is now, by way of the staging buffer, which must not
 * be in use; and a build of `dst`, an update where `src` isn't VK_NULL_HANDLE, with barriers
 * around. */
void device_upload(struct device_stage *stage, VkCommandBuffer commands,
                   struct device_build *build);
void device_build(struct device_stage *stage, VkCommandBuffer commands, struct device_build *build,
                  VkAccelerationStructureKHR dst, VkAccelerationStructureKHR src);

/* No message until now. */
void device_expect_silence(struct device_stage *stage);

/* A structure's serialized form, by the host; for free(). */
void *device_serialize(struct device_stage *stage, VkAccelerationStructureKHR structure,
                       size_t *size);
void device_expect_same_bytes(struct device_stage *stage, VkAccelerationStructureKHR a,
                              VkAccelerationStructureKHR b);

#endif
