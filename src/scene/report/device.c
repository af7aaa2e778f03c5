/* SPDX-License-Identifier: Apache-2.0 */
/* The scene on a device that traces rays: what its builds take with each flag, and its answers for
 * the same rays. Triangles are those of the reference builder: positions, transformed, without
 * indices. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "report_trace.h"
#include "src/scene/driver.h"
#include "src/scene/report/report.h"

#define FLAG(name) VK_BUILD_ACCELERATION_STRUCTURE_##name##_BIT_KHR
#define SCRATCH_MOST ((VkDeviceSize)256 << 20) /* of the builds that are recorded together */
enum {
    ALIGNMENT = 256,
    TIMES = 4, /* passes, of which the fastest counts */
    TRACE_ALL = 1,
    GROUP = 64,
};

static const struct {
    const char *name;
    VkBuildAccelerationStructureFlagsKHR flags;
} ways[] = {
    {"none", 0},
    {"PREFER_FAST_TRACE", FLAG(PREFER_FAST_TRACE)},
    {"PREFER_FAST_BUILD", FLAG(PREFER_FAST_BUILD)},
    {"LOW_MEMORY", FLAG(LOW_MEMORY)},
    {"PREFER_FAST_TRACE | ALLOW_UPDATE", FLAG(PREFER_FAST_TRACE) | FLAG(ALLOW_UPDATE)},
    {"PREFER_FAST_BUILD | ALLOW_UPDATE", FLAG(PREFER_FAST_BUILD) | FLAG(ALLOW_UPDATE)},
    /* the last: its structures are those that rays are traced through */
    {"PREFER_FAST_TRACE | ALLOW_COMPACTION", FLAG(PREFER_FAST_TRACE) | FLAG(ALLOW_COMPACTION)},
};
enum { WAYS = sizeof(ways) / sizeof(ways[0]) };

/* One structure: of a mesh, or the last, the top level. */
struct device_build {
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureGeometryKHR *geometries;   /* owned */
    VkAccelerationStructureBuildRangeInfoKHR *ranges; /* owned */
    VkAccelerationStructureBuildSizesInfoKHR sizes;
    VkAccelerationStructureKHR handle;
    VkDeviceSize offset; /* in `storage` */
    VkDeviceAddress address;
};

struct device {
    struct report *report;
    struct driver driver;
    struct capture_error error;
    struct device_build *builds; /* of the meshes, and then of the top level */
    struct driver_buffer inputs, instances, storage, scratch, rays, answers;
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkShaderModule module;
    VkPipeline pipeline;
    VkDescriptorPool pool;
    VkDescriptorSet set;
};

static bool succeeds(struct device *device, const char *call, VkResult result)
{
    return result == VK_SUCCESS || driver_fail(&device->error, call, result);
}

static VkDeviceSize align(VkDeviceSize size)
{
    return (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

/* ---- inputs */

/* Writes the triangles of a geometry. Those that are inactive stay so. */
static void write_triangles(const struct source *source, uint32_t count, float *to)
{
    for (uint32_t i = 0; i < count; i++, to += 9) {
        struct triangle_record triangle;
        if (source_triangle(source, i, &triangle) != SOURCE_ACTIVE) {
            for (int n = 0; n < 9; n++)
                to[n] = NAN;
            continue;
        }
        memcpy(to, triangle.a, sizeof(triangle.a));
        memcpy(to + 3, triangle.b, sizeof(triangle.b));
        memcpy(to + 6, triangle.c, sizeof(triangle.c));
    }
}

static VkDeviceSize size_of_geometry(const struct report_mesh *mesh, uint32_t geometry)
{
    return align(mesh->input.ranges[geometry].primitiveCount *
                 (mesh->input.geometries[geometry].type == VK_GEOMETRY_TYPE_AABBS_KHR
                      ? sizeof(VkAabbPositionsKHR)
                      : 9 * sizeof(float)));
}

static void describe_mesh(struct device *device, const struct report_mesh *mesh,
                          struct device_build *build, VkDeviceSize *at)
{
    const uint32_t count = mesh->input.geometry_count;
    build->geometries = capture_allocate(NULL, count + 1ull, sizeof(*build->geometries));
    build->ranges = capture_allocate(NULL, count + 1ull, sizeof(*build->ranges));
    build->info = (VkAccelerationStructureBuildGeometryInfoKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
        .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
        .geometryCount = count,
        .pGeometries = build->geometries};
    for (uint32_t i = 0; i < count; i++) {
        const struct builder_geometry *from = &mesh->input.geometries[i];
        const uint32_t primitives = mesh->input.ranges[i].primitiveCount;
        const VkDeviceOrHostAddressConstKHR address = {.deviceAddress =
                                                           device->inputs.address + *at};
        VkAccelerationStructureGeometryKHR *geometry = &build->geometries[i];
        *geometry = (VkAccelerationStructureGeometryKHR){
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
            .geometryType = from->type,
            .flags = from->flags};
        build->ranges[i] = (VkAccelerationStructureBuildRangeInfoKHR){.primitiveCount = primitives};
        if (from->type == VK_GEOMETRY_TYPE_AABBS_KHR) {
            memcpy(device->inputs.memory.bytes + *at, from->aabbs.data, from->aabbs.size);
            geometry->geometry.aabbs = (VkAccelerationStructureGeometryAabbsDataKHR){
                .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR,
                .data = address,
                .stride = sizeof(VkAabbPositionsKHR)};
        } else {
            write_triangles(&mesh->sources[i], primitives,
                            (float *)(void *)(device->inputs.memory.bytes + *at));
            geometry->geometry.triangles = (VkAccelerationStructureGeometryTrianglesDataKHR){
                .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR,
                .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
                .vertexData = address,
                .vertexStride = 3 * sizeof(float),
                .maxVertex = primitives ? 3 * primitives - 1 : 0,
                .indexType = VK_INDEX_TYPE_NONE_KHR};
        }
        *at += size_of_geometry(mesh, i);
    }
}

static void describe_top(struct device *device, struct device_build *build)
{
    build->geometries = capture_allocate(NULL, 1, sizeof(*build->geometries));
    build->ranges = capture_allocate(NULL, 1, sizeof(*build->ranges));
    *build->ranges = (VkAccelerationStructureBuildRangeInfoKHR){.primitiveCount =
                                                                    device->report->instance_count};
    *build->geometries = (VkAccelerationStructureGeometryKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
        .geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR,
        .geometry.instances = {
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR,
            .data.deviceAddress = device->instances.address}};
    build->info = (VkAccelerationStructureBuildGeometryInfoKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
        .type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
        .geometryCount = 1,
        .pGeometries = build->geometries};
}

static bool make_inputs(struct device *device)
{
    const struct report *report = device->report;
    const VkBufferUsageFlags usage =
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
    VkDeviceSize size = ALIGNMENT;
    for (uint32_t i = 0; i < report->mesh_count; i++)
        for (uint32_t n = 0; n < report->meshes[i].input.geometry_count; n++)
            size += size_of_geometry(&report->meshes[i], n);
    if (!driver_make_buffer(&device->driver, size, usage, &device->inputs, &device->error) ||
        !driver_make_buffer(&device->driver,
                            align((report->instance_count + 1ull) * sizeof(*report->instances)),
                            usage, &device->instances, &device->error))
        return false;
    VkDeviceSize at = 0;
    for (uint32_t i = 0; i < report->mesh_count; i++)
        describe_mesh(device, &report->meshes[i], &device->builds[i], &at);
    describe_top(device, &device->builds[report->mesh_count]);
    return true;
}

/* ---- structures */

static void free_structures(struct device *device)
{
    for (uint32_t i = 0; i <= device->report->mesh_count; i++) {
        device->driver.vk.DestroyAccelerationStructureKHR(device->driver.device,
                                                          device->builds[i].handle, NULL);
        device->builds[i].handle = VK_NULL_HANDLE;
    }
    driver_destroy_buffer(&device->driver, &device->storage);
    driver_destroy_buffer(&device->driver, &device->scratch);
}

static VkDeviceSize scratch_of(const struct device_build *build)
{
    return align(build->sizes.buildScratchSize + ALIGNMENT);
}

/* Creates all structures, of one size each, and scratch for as many as are built together. */
static bool make_structures(struct device *device, VkBuildAccelerationStructureFlagsKHR flags)
{
    struct driver *driver = &device->driver;
    const uint32_t count = device->report->mesh_count + 1;
    VkDeviceSize storage = 0, scratch = 0, most = 0;
    for (uint32_t i = 0; i < count; i++) {
        struct device_build *build = &device->builds[i];
        uint32_t *counts =
            capture_allocate(NULL, build->info.geometryCount + 1ull, sizeof(*counts));
        for (uint32_t n = 0; n < build->info.geometryCount; n++)
            counts[n] = build->ranges[n].primitiveCount;
        build->info.flags = flags;
        build->sizes = (VkAccelerationStructureBuildSizesInfoKHR){
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
        driver->vk.GetAccelerationStructureBuildSizesKHR(
            driver->device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &build->info, counts,
            &build->sizes);
        free(counts);
        build->offset = storage;
        storage += align(build->sizes.accelerationStructureSize);
        scratch += scratch_of(build);
        most = scratch_of(build) > most ? scratch_of(build) : most;
    }
    scratch = scratch > SCRATCH_MOST ? SCRATCH_MOST : scratch;
    if (!driver_make_buffer(driver, storage, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR,
                            &device->storage, &device->error) ||
        !driver_make_buffer(driver, (scratch > most ? scratch : most) + ALIGNMENT,
                            VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, &device->scratch, &device->error))
        return false;
    for (uint32_t i = 0; i < count; i++) {
        struct device_build *build = &device->builds[i];
        const VkAccelerationStructureCreateInfoKHR info = {
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR,
            .buffer = device->storage.handle,
            .offset = build->offset,
            .size = build->sizes.accelerationStructureSize,
            .type = build->info.type};
        if (!succeeds(device, "vkCreateAccelerationStructureKHR",
                      driver->vk.CreateAccelerationStructureKHR(driver->device, &info, NULL,
                                                                &build->handle)))
            return false;
        build->info.dstAccelerationStructure = build->handle;
        build->address = driver->vk.GetAccelerationStructureDeviceAddressKHR(
            driver->device,
            &(VkAccelerationStructureDeviceAddressInfoKHR){
                .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR,
                .accelerationStructure = build->handle});
    }
    return true;
}

static void write_instances(const struct device *device)
{
    const struct report *report = device->report;
    for (uint32_t i = 0; i < report->instance_count; i++) {
        VkAccelerationStructureInstanceKHR instance = report->instances[i];
        const uint64_t mesh = instance.accelerationStructureReference;
        instance.accelerationStructureReference = mesh ? device->builds[mesh - 1].address : 0;
        memcpy(device->instances.memory.bytes + i * sizeof(instance), &instance, sizeof(instance));
    }
}

/* Records builds [begin, end) as one call. */
static void record_builds(struct device *device, uint32_t begin, uint32_t end)
{
    VkAccelerationStructureBuildGeometryInfoKHR *infos =
        capture_allocate(NULL, end - begin, sizeof(*infos));
    const VkAccelerationStructureBuildRangeInfoKHR **ranges =
        capture_allocate(NULL, end - begin, sizeof(*ranges));
    for (uint32_t i = begin; i < end; i++) {
        infos[i - begin] = device->builds[i].info;
        ranges[i - begin] = device->builds[i].ranges;
    }
    device->driver.vk.CmdBuildAccelerationStructuresKHR(device->driver.commands, end - begin, infos,
                                                        ranges);
    driver_order_all(&device->driver);
    free(infos);
    free((void *)ranges);
}

/* Builds all structures. Returns false with an error. */
static bool build_all(struct device *device, double *ns)
{
    const uint32_t count = device->report->mesh_count;
    if (!driver_begin(&device->driver, &device->error))
        return false;
    driver_begin_time(&device->driver);
    driver_order_all(&device->driver);
    for (uint32_t begin = 0, end; begin <= count; begin = end) {
        VkDeviceSize used = 0;
        /* The top level is built alone, after all others. */
        for (end = begin; end <= count && (end == begin || end < count); end++) {
            struct device_build *build = &device->builds[end];
            if (used + scratch_of(build) + ALIGNMENT > device->scratch.size) /* never the first */
                break;
            build->info.scratchData.deviceAddress = align(device->scratch.address + used);
            used += scratch_of(build);
        }
        record_builds(device, begin, end);
    }
    driver_end_time(&device->driver);
    if (!driver_run(&device->driver, &device->error))
        return false;
    *ns = driver_read_time(&device->driver);
    return true;
}

/* Sums the compacted sizes of the meshes. */
static bool find_compacted(struct device *device, uint64_t *bytes)
{
    struct driver *driver = &device->driver;
    const uint32_t count = device->report->mesh_count;
    const VkQueryPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                        .queryType =
                                            VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                                        .queryCount = count};
    VkQueryPool pool;
    if (!succeeds(device, "vkCreateQueryPool",
                  driver->vk.CreateQueryPool(driver->device, &info, NULL, &pool)))
        return false;
    bool is_done = driver_begin(driver, &device->error);
    if (is_done) {
        driver->vk.CmdResetQueryPool(driver->commands, pool, 0, count);
        for (uint32_t i = 0; i < count; i++)
            driver->vk.CmdWriteAccelerationStructuresPropertiesKHR(
                driver->commands, 1, &device->builds[i].handle,
                VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, pool, i);
        is_done = driver_run(driver, &device->error);
    }
    *bytes = 0;
    for (uint32_t i = 0; i < count && is_done; i++) {
        uint64_t size = 0;
        is_done =
            succeeds(device, "vkGetQueryPoolResults",
                     driver->vk.GetQueryPoolResults(driver->device, pool, i, 1, sizeof(size), &size,
                                                    sizeof(size), VK_QUERY_RESULT_64_BIT));
        *bytes += size;
    }
    driver->vk.DestroyQueryPool(driver->device, pool, NULL);
    return is_done;
}

/* ---- rays */

struct constants {
    uint64_t rays, answers;
    uint32_t count, mode;
};

static bool make_pipeline(struct device *device)
{
    struct driver *driver = &device->driver;
    const VkDescriptorSetLayoutBinding binding = {.descriptorType =
                                                      VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR,
                                                  .descriptorCount = 1,
                                                  .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
    const VkDescriptorSetLayoutCreateInfo set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
        .bindingCount = 1,
        .pBindings = &binding};
    const VkPushConstantRange range = {.stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
                                       .size = sizeof(struct constants)};
    const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1};
    const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = 1,
                                             .poolSizeCount = 1,
                                             .pPoolSizes = &size};
    const VkShaderModuleCreateInfo module = {.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                             .codeSize = sizeof(report_trace),
                                             .pCode = report_trace};
    if (!succeeds(device, "vkCreateDescriptorSetLayout",
                  driver->vk.CreateDescriptorSetLayout(driver->device, &set, NULL,
                                                       &device->set_layout)) ||
        !succeeds(device, "vkCreateDescriptorPool",
                  driver->vk.CreateDescriptorPool(driver->device, &pool, NULL, &device->pool)) ||
        !succeeds(device, "vkCreateShaderModule",
                  driver->vk.CreateShaderModule(driver->device, &module, NULL, &device->module)))
        return false;
    const VkPipelineLayoutCreateInfo layout = {.sType =
                                                   VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                               .setLayoutCount = 1,
                                               .pSetLayouts = &device->set_layout,
                                               .pushConstantRangeCount = 1,
                                               .pPushConstantRanges = &range};
    const VkDescriptorSetAllocateInfo sets = {.sType =
                                                  VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                              .descriptorPool = device->pool,
                                              .descriptorSetCount = 1,
                                              .pSetLayouts = &device->set_layout};
    if (!succeeds(
            device, "vkCreatePipelineLayout",
            driver->vk.CreatePipelineLayout(driver->device, &layout, NULL, &device->layout)) ||
        !succeeds(device, "vkAllocateDescriptorSets",
                  driver->vk.AllocateDescriptorSets(driver->device, &sets, &device->set)))
        return false;
    const VkComputePipelineCreateInfo pipeline = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = device->module,
                  .pName = "main"},
        .layout = device->layout};
    return succeeds(device, "vkCreateComputePipelines",
                    driver->vk.CreateComputePipelines(driver->device, VK_NULL_HANDLE, 1, &pipeline,
                                                      NULL, &device->pipeline));
}

static bool make_rays(struct device *device, const struct ray_set sets[RAY_SETS])
{
    uint32_t most = 1;
    for (int set = 0; set < RAY_SETS; set++)
        most = sets[set].count > most ? sets[set].count : most;
    return driver_make_buffer(&device->driver, most * 32ull, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                              &device->rays, &device->error) &&
           driver_make_buffer(&device->driver, most * (VkDeviceSize)sizeof(struct answer),
                              VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, &device->answers, &device->error);
}

static void bind_top(struct device *device)
{
    const VkWriteDescriptorSetAccelerationStructureKHR structure = {
        .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR,
        .accelerationStructureCount = 1,
        .pAccelerationStructures = &device->builds[device->report->mesh_count].handle};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .pNext = &structure,
                                        .dstSet = device->set,
                                        .descriptorCount = 1,
                                        .descriptorType =
                                            VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR};
    device->driver.vk.UpdateDescriptorSets(device->driver.device, 1, &write, 0, NULL);
}

/* Traces a set of rays. Returns false with an error. */
static bool trace(struct device *device, const struct ray_set *set, uint32_t mode, double *ns)
{
    struct driver *driver = &device->driver;
    const struct constants constants = {device->rays.address, device->answers.address, set->count,
                                        mode};
    for (uint32_t i = 0; i < set->count; i++)
        memcpy(device->rays.memory.bytes + i * 32ull, &set->rays[i], 32);
    if (!driver_begin(driver, &device->error))
        return false;
    driver->vk.CmdBindPipeline(driver->commands, VK_PIPELINE_BIND_POINT_COMPUTE, device->pipeline);
    driver->vk.CmdBindDescriptorSets(driver->commands, VK_PIPELINE_BIND_POINT_COMPUTE,
                                     device->layout, 0, 1, &device->set, 0, NULL);
    driver->vk.CmdPushConstants(driver->commands, device->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                                sizeof(constants), &constants);
    driver_begin_time(&device->driver);
    driver->vk.CmdDispatch(driver->commands, (set->count + GROUP - 1) / GROUP, 1, 1);
    driver_end_time(&device->driver);
    driver_order_all(&device->driver);
    if (!driver_run(driver, &device->error))
        return false;
    *ns = driver_read_time(&device->driver);
    return true;
}

static bool time_rays(struct device *device, const struct ray_set *set, double *ns)
{
    *ns = INFINITY;
    for (int i = 0; i < TIMES; i++) {
        double now;
        if (!trace(device, set, 0, &now))
            return false;
        *ns = isnan(now) ? now : fmin(*ns, now / set->count);
    }
    return true;
}

static void set_time(json_t *object, const char *key, double time)
{
    if (!isnan(time))
        json_object_set_new(object, key, json_real(time));
}

/* ---- the part of the report */

static bool measure_way(struct device *device, int way, const struct ray_set *set, json_t *rows)
{
    double least = INFINITY, ns = NAN;
    uint64_t bytes = 0, scratch = 0, compacted = 0;
    free_structures(device);
    if (!make_structures(device, ways[way].flags))
        return false;
    write_instances(device);
    if (device->driver.traces)
        bind_top(device);
    for (int i = 0; i < TIMES; i++) {
        if (!build_all(device, &ns))
            return false;
        least = isnan(ns) ? ns : fmin(least, ns);
    }
    for (uint32_t i = 0; i <= device->report->mesh_count; i++) {
        bytes += device->builds[i].sizes.accelerationStructureSize;
        scratch += device->builds[i].sizes.buildScratchSize;
    }
    if (ways[way].flags & FLAG(ALLOW_COMPACTION) && !find_compacted(device, &compacted))
        return false;
    ns = (double)NAN;
    if (device->driver.traces && !time_rays(device, set, &ns))
        return false;
    json_t *row = json_pack("{s:s, s:I, s:I}", "flags", ways[way].name, "bytes", (json_int_t)bytes,
                            "scratch bytes", (json_int_t)scratch);
    set_time(row, "ms build", least / 1e6);
    set_time(row, "ns a ray", ns);
    if (compacted) {
        const uint64_t top =
            device->builds[device->report->mesh_count].sizes.accelerationStructureSize;
        json_object_set_new(row, "compacted bytes", json_integer((json_int_t)(compacted + top)));
    }
    json_array_append_new(rows, row);
    return true;
}

/* The device traces triangles alone; so does the truth. */
static bool measure_set(struct device *device, const struct ray_set *set, json_t *rows)
{
    struct ray_set triangles = *set;
    struct wrong wrong = {.rays = 0};
    struct answer *truths = capture_allocate(NULL, set->count, sizeof(*truths));
    double ns;
    triangles.rays = capture_allocate(NULL, set->count, sizeof(*set->rays));
    for (uint32_t i = 0; i < set->count; i++) {
        triangles.rays[i] = set->rays[i];
        triangles.rays[i].flags |= TRACE_SKIP_AABBS;
    }
    answers_find(device->report, TRACE_EXACT, &triangles, truths);
    bool is_done = time_rays(device, set, &ns);
    const double time = ns;
    is_done = is_done && trace(device, set, TRACE_ALL, &ns);
    for (uint32_t i = 0; i < set->count && is_done; i++) {
        struct answer answer;
        memcpy(&answer, device->answers.memory.bytes + i * sizeof(answer), sizeof(answer));
        wrong_add(&wrong, &truths[i], &answer);
    }
    if (is_done) {
        json_t *row = wrong_make(&wrong);
        json_object_set_new(row, "set", json_string(set->name));
        set_time(row, "ns a ray", time);
        json_array_append_new(rows, row);
    }
    free(truths);
    free(triangles.rays);
    return is_done;
}

static bool measure(struct device *device, const struct ray_set sets[RAY_SETS], json_t *flags,
                    json_t *rays)
{
    const char *wanted = device->report->options->device;
    if (!driver_open_to_trace(&device->driver, wanted, &device->error) || !make_inputs(device) ||
        (device->driver.traces && (!make_pipeline(device) || !make_rays(device, sets))))
        return false;
    for (int way = 0; way < WAYS; way++)
        if (!measure_way(device, way, &sets[RAYS_CAMERA], flags))
            return false;
    for (int set = 0; set < RAY_SETS && device->driver.traces; set++)
        if (!measure_set(device, &sets[set], rays))
            return false;
    return true;
}

static void close_device(struct device *device)
{
    struct driver *driver = &device->driver;
    if (driver->device) {
        free_structures(device);
        struct driver_buffer *const buffers[] = {&device->inputs, &device->instances, &device->rays,
                                                 &device->answers};
        for (size_t i = 0; i < sizeof(buffers) / sizeof(buffers[0]); i++)
            driver_destroy_buffer(driver, buffers[i]);
        driver->vk.DestroyPipeline(driver->device, device->pipeline, NULL);
        driver->vk.DestroyShaderModule(driver->device, device->module, NULL);
        driver->vk.DestroyPipelineLayout(driver->device, device->layout, NULL);
        driver->vk.DestroyDescriptorPool(driver->device, device->pool, NULL);
        driver->vk.DestroyDescriptorSetLayout(driver->device, device->set_layout, NULL);
    }
    for (uint32_t i = 0; i <= device->report->mesh_count; i++) {
        free(device->builds[i].geometries);
        free(device->builds[i].ranges);
    }
    free(device->builds);
    driver_close(driver);
}

void device_report(struct report *report, const struct ray_set sets[RAY_SETS])
{
    struct device device = {.report = report};
    const char *wanted = report->options->device;
    json_t *flags = json_array(), *rays = json_array(), *object;
    const size_t count = report->mesh_count + 1ull;
    device.builds = memset(capture_allocate(NULL, count, sizeof(*device.builds)), 0,
                           count * sizeof(*device.builds));
    report_progress(report, "device");
    if (wanted && strcmp(wanted, "none") == 0)
        object = json_pack("{s:s}", "missing", "No device was asked for (--device none).");
    else if (report->has_motion)
        object = json_pack("{s:s}", "missing", "Motion is not built on a device.");
    else if (!measure(&device, sets, flags, rays))
        object = json_pack("{s:o}", "missing",
                           json_sprintf("No device has built the scene: %s.", device.error.text));
    else
        object = json_pack(
            "{s:s, s:s, s:s, s:O, s:O}", "device", device.driver.properties.deviceName, "driver",
            device.driver.driver.driverInfo, "type",
            device.driver.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU ? "CPU" : "GPU",
            "flags", flags, "rays", rays);
    json_decref(flags);
    json_decref(rays);
    json_object_set_new(report->root, "device", object);
    close_device(&device);
}
