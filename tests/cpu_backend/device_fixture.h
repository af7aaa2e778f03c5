/* SPDX-License-Identifier: Apache-2.0 */
/* A fixture (host_fixture.h) whose scenes are built by command buffers, from device-local copies of
 * their data. */
#ifndef ASSAY_TESTS_CPU_BACKEND_DEVICE_FIXTURE_H
#define ASSAY_TESTS_CPU_BACKEND_DEVICE_FIXTURE_H

#include "tests/cpu_backend/host_fixture.h"

struct device_fixture {
    struct fixture fixture;
    VkQueue queue;
    VkCommandPool pool;
};

const char *device_fixture_open(struct device_fixture *fixture, const char *platform);
void device_fixture_close(struct device_fixture *fixture);

/* A buffer for any use that the tests make of one. */
struct device_buffer device_buffer_create(struct device_fixture *fixture, VkDeviceSize size);
void device_buffer_destroy(struct device_fixture *fixture, struct device_buffer *buffer);

VkCommandBuffer device_begin(struct device_fixture *fixture, VkCommandBufferLevel level);
void device_end(struct device_fixture *fixture, VkCommandBuffer commands);
/* Submits, and waits with a fence. */
void device_run(struct device_fixture *fixture, VkCommandBuffer commands);
/* Ends it, runs it and frees it. */
void device_finish(struct device_fixture *fixture, VkCommandBuffer commands);

/* Makes all that was written visible to all that follows. */
void device_barrier(struct device_fixture *fixture, VkCommandBuffer commands);

/* A host build's parameters (fixture_triangles, fixture_instances, fixture_create_for) with the
 * same data in buffers. Not to be moved. */
struct device_build {
    struct fixture_build *host;
    VkDeviceSize size; /* of the data */
    VkAccelerationStructureGeometryKHR geometry;
    VkAccelerationStructureBuildGeometryInfoKHR info;
    struct device_buffer staging, data, scratch;
};
void device_build_create(struct device_fixture *fixture, struct fixture_build *host,
                         VkDeviceSize size, struct device_build *build);
void device_build_destroy(struct device_fixture *fixture, struct device_build *build);

/* Records an upload of the host's data as it is now, by way of the staging buffer, which must not
 * be in use; and a build of `dst`, an update where `src` isn't VK_NULL_HANDLE, with barriers
 * around. */
void device_upload(struct device_fixture *fixture, VkCommandBuffer commands,
                   struct device_build *build);
void device_build(struct device_fixture *fixture, VkCommandBuffer commands,
                  struct device_build *build, VkAccelerationStructureKHR dst,
                  VkAccelerationStructureKHR src);

/* Records a copy of a structure to another one, to memory, or from there. */
void device_copy(struct device_fixture *fixture, VkCommandBuffer commands,
                 VkAccelerationStructureKHR src, VkAccelerationStructureKHR dst,
                 VkCopyAccelerationStructureModeKHR mode);
void device_save(struct device_fixture *fixture, VkCommandBuffer commands,
                 VkAccelerationStructureKHR src, VkDeviceAddress dst);
void device_load(struct device_fixture *fixture, VkCommandBuffer commands, VkDeviceAddress src,
                 VkAccelerationStructureKHR dst);

/* The value of a query that has one. */
uint64_t device_query(struct device_fixture *fixture, VkQueryPool pool, uint32_t query);

/* No message until now. */
void device_expect_silence(struct device_fixture *fixture);

/* A structure's serialized form, by the host; for free(). */
void *device_serialize(struct device_fixture *fixture, VkAccelerationStructureKHR structure,
                       size_t *size);
void device_expect_same_bytes(struct device_fixture *fixture, VkAccelerationStructureKHR a,
                              VkAccelerationStructureKHR b);

#endif
