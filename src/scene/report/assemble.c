/* SPDX-License-Identifier: Apache-2.0 */
/* Makes a scene of a capture: inputs of the reference builder, and trees. */
#include <inttypes.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "src/platform/aligned.h"
#include "src/platform/clock.h"
#include "src/scene/report/report.h"

enum { LARGE_MESH = 1 << 15 }; /* primitives; one that has more is built by several threads */

/* ---- helpers of all parts */

struct parallel {
    atomic_uint next;
    uint32_t count;
    void (*work)(void *context, uint32_t index);
    void *context;
};

static void *run_parallel(void *user)
{
    struct parallel *parallel = user;
    for (uint32_t i; (i = atomic_fetch_add(&parallel->next, 1)) < parallel->count;)
        parallel->work(parallel->context, i);
    return NULL;
}

void report_parallel(uint32_t count, void (*work)(void *context, uint32_t index), void *context)
{
    struct parallel parallel = {.count = count, .work = work, .context = context};
    pthread_t threads[REPORT_THREADS - 1];
    uint32_t started = 0;
    while (started < REPORT_THREADS - 1 &&
           pthread_create(&threads[started], NULL, run_parallel, &parallel) == 0)
        started++;
    run_parallel(&parallel);
    while (started > 0)
        pthread_join(threads[--started], NULL);
}

void report_progress(const struct report *report, const char *part)
{
    if (report->options->shows_progress)
        fprintf(stderr, "assay-scene: %s\n", part);
}

double report_cpu_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec * 1e9 + (double)now.tv_nsec;
}

const char *report_name(const struct report *report, uint32_t structure)
{
    static char name[32];
    const struct captured_structure *captured = &report->capture->structures[structure];
    snprintf(name, sizeof(name), "structure %" PRIu64, captured->id);
    return captured->name ? captured->name : name;
}

static void *allocate_zeroed(size_t count, size_t size)
{
    return memset(capture_allocate(NULL, count + 1, size), 0, (count + 1) * size);
}

/* ---- meshes */

/* Reads the corners of triangles: nine floats each, all NaN if a vertex is not in the capture.
 * Returns how many triangles lack one. */
static uint32_t read_corners(const struct triangle_rows *rows, float *to)
{
    uint32_t missing = 0;
    for (uint64_t triangle = 0; triangle < rows->count; triangle++, to += 9) {
        uint64_t row;
        int corner = 0;
        for (; corner < 3 && triangle_rows_find(rows, 3 * triangle + (uint64_t)corner, &row);
             corner++)
            rows->format->read(rows->vertices.bytes + row * rows->vertices.size, to + 3 * corner);
        for (int i = 0; i < 9 && corner < 3; i++)
            to[i] = NAN;
        missing += corner < 3;
    }
    return missing;
}

static void read_triangles(struct report *report, const struct captured_geometry *geometry,
                           struct builder_geometry *to, uint32_t *count, uint32_t *missing)
{
    struct triangle_rows rows;
    if (!triangle_rows_load(report->capture, geometry, &rows, report->error)) {
        report->left_out[OTHER_GEOMETRIES]++;
        rows_release(report->capture, geometry);
        return;
    }
    const size_t size = rows.count * 9 * sizeof(float);
    float *corners = allocate_zeroed(size, 1);
    report->left_out[NOT_IN_CAPTURE] += geometry->primitive_count - rows.count;
    *missing = read_corners(&rows, corners);
    report->left_out[NOT_IN_CAPTURE] += *missing;
    to->triangles = (struct builder_triangles){
        .vertex_format = VK_FORMAT_R32G32B32_SFLOAT,
        .index_type = VK_INDEX_TYPE_NONE_KHR,
        .max_vertex = (uint32_t)(3 * rows.count),
        .vertex_stride = 3 * sizeof(float),
        .vertices = corners,
        .vertices_size = size,
    };
    if (rows.transform.count) {
        void *matrix = capture_allocate(NULL, 1, sizeof(VkTransformMatrixKHR));
        to->triangles.transforms =
            memcpy(matrix, rows.transform.bytes, sizeof(VkTransformMatrixKHR));
        to->triangles.transforms_size = sizeof(VkTransformMatrixKHR);
    }
    /* The rows of the second set of vertices have the same places. */
    const struct rows motion =
        rows_load(report->capture, geometry, CAPTURE_MOTION_VERTICES, report->error);
    if (motion.count && motion.count == rows.vertices.count && motion.size >= rows.format->size) {
        float *moved = allocate_zeroed(size, 1);
        rows.vertices.bytes = motion.bytes;
        read_corners(&rows, moved);
        to->triangles.motion_vertices = moved;
        to->triangles.motion_vertices_size = size;
    }
    *count = (uint32_t)rows.count;
    rows_release(report->capture, geometry);
}

static void read_boxes(struct report *report, const struct captured_geometry *geometry,
                       struct builder_geometry *to, uint32_t *count)
{
    const struct rows rows = rows_load(report->capture, geometry, CAPTURE_BOXES, report->error);
    *count =
        (uint32_t)(rows.count < geometry->primitive_count ? rows.count : geometry->primitive_count);
    report->left_out[NOT_IN_CAPTURE] += geometry->primitive_count - *count;
    const size_t size = *count * sizeof(VkAabbPositionsKHR);
    void *boxes = allocate_zeroed(size, 1);
    if (size)
        memcpy(boxes, rows.bytes, size);
    to->aabbs =
        (struct builder_aabbs){.data = boxes, .size = size, .stride = sizeof(VkAabbPositionsKHR)};
    rows_release(report->capture, geometry);
}

void report_read_mesh(struct report *report, uint32_t command, struct report_mesh *mesh)
{
    const struct captured_command *build = &report->capture->commands[command];
    const uint32_t count = build->geometry_count;
    struct builder_geometry *geometries = allocate_zeroed(count, sizeof(*geometries));
    VkAccelerationStructureBuildRangeInfoKHR *ranges = allocate_zeroed(count, sizeof(*ranges));
    bool is_of_boxes = count > 0;
    for (uint32_t i = 0; i < count; i++)
        is_of_boxes &= build->geometries[i].type == CAPTURE_AABBS;
    mesh->command = command;
    mesh->structure = build->dst;
    mesh->sources = allocate_zeroed(count, sizeof(*mesh->sources));
    mesh->missing = allocate_zeroed(count, sizeof(*mesh->missing));
    mesh->input = (struct builder_input){
        .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
        .flags = build->flags,
        .geometry_count = count,
        .geometries = geometries,
        .ranges = ranges,
    };
    for (uint32_t i = 0; i < count; i++) {
        const struct captured_geometry *geometry = &build->geometries[i];
        geometries[i].type =
            is_of_boxes ? VK_GEOMETRY_TYPE_AABBS_KHR : VK_GEOMETRY_TYPE_TRIANGLES_KHR;
        geometries[i].flags = geometry->flags;
        geometries[i].triangles.vertex_format = VK_FORMAT_R32G32B32_SFLOAT;
        geometries[i].triangles.index_type = VK_INDEX_TYPE_NONE_KHR;
        geometries[i].triangles.vertex_stride = 12;
        if (is_of_boxes)
            read_boxes(report, geometry, &geometries[i], &ranges[i].primitiveCount);
        else if (geometry->type == CAPTURE_TRIANGLES)
            read_triangles(report, geometry, &geometries[i], &ranges[i].primitiveCount,
                           &mesh->missing[i]);
        else
            report->left_out[OTHER_GEOMETRIES]++;
        mesh->primitives += ranges[i].primitiveCount;
        if (!source_open(&mesh->sources[i], false, &geometries[i], &ranges[i]))
            mesh->sources[i].count = 0;
    }
}

void report_free_mesh(struct report_mesh *mesh)
{
    for (uint32_t i = 0; i < mesh->input.geometry_count; i++) {
        const struct builder_geometry *geometry = &mesh->input.geometries[i];
        if (geometry->type == VK_GEOMETRY_TYPE_AABBS_KHR) {
            free((void *)(uintptr_t)geometry->aabbs.data);
            continue;
        }
        free((void *)(uintptr_t)geometry->triangles.vertices);
        free((void *)(uintptr_t)geometry->triangles.motion_vertices);
        free((void *)(uintptr_t)geometry->triangles.transforms);
    }
    free((void *)(uintptr_t)mesh->input.geometries);
    free((void *)(uintptr_t)mesh->input.ranges);
    free(mesh->sources);
    free(mesh->missing);
    aligned_free(mesh->tree);
    *mesh = (struct report_mesh){0};
}

/* Returns the mesh of a structure, which is read at its first use. Copies of a structure share it.
 */
static uint32_t mesh_of(struct report *report, uint32_t structure)
{
    uint32_t *mesh = &report->mesh_of[structure];
    for (uint32_t i = 0; i < report->mesh_count && *mesh == CAPTURE_NONE; i++)
        if (report->meshes[i].command == report->builds[structure])
            *mesh = i;
    if (*mesh == CAPTURE_NONE) {
        *mesh = report->mesh_count++;
        report_read_mesh(report, report->builds[structure], &report->meshes[*mesh]);
        report->meshes[*mesh].structure = structure;
    }
    return *mesh;
}

/* ---- instances */

/* Copies a row of moving instances, with another reference. */
static void copy_moving(const uint8_t *row, uint64_t reference, uint8_t *to)
{
    VkAccelerationStructureMotionInstanceNV motion;
    memcpy(&motion, row, sizeof(motion));
    if (motion.type == VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV)
        motion.data.matrixMotionInstance.accelerationStructureReference = reference;
    else if (motion.type == VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV)
        motion.data.srtMotionInstance.accelerationStructureReference = reference;
    else
        motion.data.staticInstance.accelerationStructureReference = reference;
    memcpy(to, &motion, sizeof(motion));
}

enum { MOTION_STRIDE = 160 };

static void read_instances(struct report *report)
{
    const struct captured_command *build = &report->capture->commands[report->builds[report->top]];
    const struct captured_geometry *geometry = &build->geometries[0];
    const struct rows rows =
        rows_load(report->capture, geometry, CAPTURE_INSTANCE_ROWS, report->error);
    const uint64_t count =
        rows.count < geometry->primitive_count ? rows.count : geometry->primitive_count;
    const bool is_moving = rows.size == sizeof(VkAccelerationStructureMotionInstanceNV);
    report->left_out[NOT_IN_CAPTURE] += geometry->primitive_count - count;
    report->instance_count = (uint32_t)count;
    report->instances = allocate_zeroed(count, sizeof(*report->instances));
    if (is_moving)
        report->motion_instances = allocate_zeroed(count, MOTION_STRIDE);
    for (uint32_t i = 0; i < count; i++) {
        struct placing placing;
        uint32_t structure = CAPTURE_NONE, mesh = CAPTURE_NONE;
        const enum left_out why = rows_read_instance(&rows, i, &placing)
                                      ? contents_find_instance(report->capture, report->builds,
                                                               build, &placing, &structure)
                                      : LEFT_UNKNOWN;
        if (why == LEFT_OUT)
            mesh = mesh_of(report, structure);
        else
            report->left_out[why]++;
        const uint64_t reference = mesh == CAPTURE_NONE ? 0 : mesh + 1ull;
        if (mesh != CAPTURE_NONE)
            report->meshes[mesh].instances++;
        report->instances[i] = placing.instance;
        report->instances[i].accelerationStructureReference = reference;
        if (is_moving)
            copy_moving(rows.bytes + (uint64_t)i * rows.size, reference,
                        (uint8_t *)report->motion_instances + (size_t)i * MOTION_STRIDE);
    }
    rows_release(report->capture, geometry);
}

/* Without a top-level structure all others stand at the origin. */
static void place_all(struct report *report)
{
    report->instances =
        allocate_zeroed(report->capture->structure_count, sizeof(*report->instances));
    for (uint32_t i = 0; i < report->capture->structure_count; i++) {
        const uint32_t command = report->builds[i];
        if ((report->top != CAPTURE_NONE && report->top != i) || command == CAPTURE_NONE ||
            contents_is_top(report->capture, command))
            continue;
        const uint32_t mesh = mesh_of(report, i);
        report->meshes[mesh].instances++;
        report->instances[report->instance_count++] = (VkAccelerationStructureInstanceKHR){
            .transform = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}},
            .mask = 0xff,
            .accelerationStructureReference = mesh + 1ull};
    }
}

static const void *find_mesh(void *context, uint64_t reference)
{
    const struct report *report = context;
    return reference && reference <= report->mesh_count ? report->meshes[reference - 1].tree : NULL;
}

bool report_assemble(struct report *report)
{
    struct capture *capture = report->capture;
    report->command_count = capture->command_count;
    report->error->text[0] = '\0';
    if (report->options->at &&
        !capture_find_point(capture, report->options->at, &report->command_count, report->error))
        return false;
    report->builds = contents_find_builds(capture, report->command_count);
    if (!contents_find_top(capture, report->builds, report->command_count, report->options->tlas,
                           &report->top, report->error))
        return false;
    report->meshes = allocate_zeroed(capture->structure_count, sizeof(*report->meshes));
    report->mesh_of = capture_allocate(NULL, capture->structure_count, sizeof(*report->mesh_of));
    memset(report->mesh_of, 0xff, capture->structure_count * sizeof(*report->mesh_of));
    if (report->top != CAPTURE_NONE && contents_is_top(capture, report->builds[report->top]))
        read_instances(report);
    else
        place_all(report);
    uint64_t active = 0;
    for (uint32_t i = 0; i < report->mesh_count; i++) {
        active += report->meshes[i].primitives;
        report->has_motion |=
            (report->meshes[i].input.flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV) != 0;
    }
    report->has_motion |= report->motion_instances != NULL;
    if (!report->error->text[0] && !active)
        snprintf(report->error->text, sizeof(report->error->text),
                 "%s: the scene has no triangle and no AABB whose data is in the capture",
                 capture->folder);
    return !report->error->text[0];
}

void report_release(struct report *report)
{
    for (uint32_t i = 0; i < report->mesh_count; i++)
        report_free_mesh(&report->meshes[i]);
    free(report->meshes);
    free(report->mesh_of);
    free(report->builds);
    free(report->instances);
    free(report->motion_instances);
    aligned_free(report->tree);
}

/* ---- trees */

static void *allocate_tree(uint64_t size)
{
    void *memory = aligned_allocate(BUILDER_ALIGNMENT, (size + BUILDER_ALIGNMENT) /
                                                           BUILDER_ALIGNMENT * BUILDER_ALIGNMENT);
    return memory ? memory : capture_allocate(NULL, SIZE_MAX, 2);
}

/* Returns NULL if the builder rejects the input. */
static void *build_tree(const struct builder_input *input, struct builder_report *built,
                        uint64_t *size)
{
    struct builder_sizes sizes;
    if (builder_get_sizes(input, NULL, &sizes) != BUILDER_OK)
        return NULL;
    void *tree = allocate_tree(sizes.structure), *scratch = allocate_tree(sizes.build_scratch);
    if (builder_build(input, tree, sizes.structure, scratch, sizes.build_scratch, built) !=
        BUILDER_OK) {
        aligned_free(tree);
        tree = NULL;
    }
    aligned_free(scratch);
    *size = tree ? builder_compacted_size(tree) : 0;
    return tree;
}

uint64_t report_build_mesh(struct report_mesh *mesh, enum builder_quality quality,
                           VkBuildAccelerationStructureFlagsKHR without, uint32_t threads)
{
    struct builder_input input = mesh->input;
    uint64_t size = 0;
    input.quality = quality;
    input.flags &= ~without;
    input.threads = threads;
    aligned_free(mesh->tree);
    mesh->tree = build_tree(&input, &mesh->built, &size);
    return size;
}

bool report_refit_mesh(struct report_mesh *mesh, const struct builder_input *update)
{
    struct builder_sizes sizes;
    if (!mesh->tree || builder_get_sizes(update, NULL, &sizes) != BUILDER_OK)
        return false;
    void *scratch = allocate_tree(sizes.update_scratch);
    const bool is_done = builder_refit(update, mesh->tree, mesh->tree, builder_size(mesh->tree),
                                       scratch, sizes.update_scratch, NULL) == BUILDER_OK;
    aligned_free(scratch);
    return is_done;
}

struct builder_input report_top_input(struct report *report,
                                      VkBuildAccelerationStructureFlagsKHR without)
{
    const bool is_moving =
        report->motion_instances && !(without & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV);
    report->top_range =
        (VkAccelerationStructureBuildRangeInfoKHR){.primitiveCount = report->instance_count};
    report->top_geometry = (struct builder_geometry){
        .type = VK_GEOMETRY_TYPE_INSTANCES_KHR,
        .instances = {.data = is_moving ? report->motion_instances : report->instances,
                      .size = (uint64_t)report->instance_count *
                              (is_moving ? MOTION_STRIDE : sizeof(*report->instances))}};
    return (struct builder_input){.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
                                  .flags =
                                      is_moving ? VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV : 0,
                                  .geometry_count = 1,
                                  .geometries = &report->top_geometry,
                                  .ranges = &report->top_range,
                                  .resolver = {find_mesh, report}};
}

uint64_t report_build_top(struct report *report, enum builder_quality quality,
                          VkBuildAccelerationStructureFlagsKHR without)
{
    struct builder_input input = report_top_input(report, without);
    uint64_t size = 0;
    input.quality = quality;
    aligned_free(report->tree);
    report->tree = build_tree(&input, NULL, &size);
    if (!report->tree)
        capture_allocate(NULL, SIZE_MAX, 2);
    return size;
}

struct build_job {
    struct report *report;
    enum builder_quality quality;
    VkBuildAccelerationStructureFlagsKHR without;
    _Atomic uint64_t bytes;
};

static void build_small(void *context, uint32_t index)
{
    struct build_job *job = context;
    struct report_mesh *mesh = &job->report->meshes[index];
    if (mesh->primitives <= LARGE_MESH)
        job->bytes += report_build_mesh(mesh, job->quality, job->without, 1);
}

void report_build(struct report *report, enum builder_quality quality,
                  VkBuildAccelerationStructureFlagsKHR without, struct report_built *built)
{
    struct build_job job = {.report = report, .quality = quality, .without = without};
    const uint64_t begin = clock_process_cpu();
    *built = (struct report_built){0};
    report_parallel(report->mesh_count, build_small, &job);
    for (uint32_t i = 0; i < report->mesh_count; i++)
        if (report->meshes[i].primitives > LARGE_MESH)
            job.bytes += report_build_mesh(&report->meshes[i], quality, without, REPORT_THREADS);
    built->bytes = job.bytes + report_build_top(report, quality, without);
    built->ms = (double)(clock_process_cpu() - begin) / 1e6;
    uint64_t instances = 0;
    for (uint32_t i = 0; i < report->mesh_count; i++) {
        struct builder_statistics statistics = {.nodes = 0};
        if (!report->meshes[i].tree)
            continue;
        builder_measure(report->meshes[i].tree, &statistics);
        built->nodes += statistics.nodes;
        built->depth = statistics.depth > built->depth ? statistics.depth : built->depth;
        built->sah += statistics.sah * report->meshes[i].instances;
        instances += report->meshes[i].instances;
    }
    built->sah /= instances ? (double)instances : 1;
}

struct trace_scene report_scene(struct report *report, enum trace_accuracy accuracy)
{
    return (struct trace_scene){
        .structure = report->tree, .accuracy = accuracy, .resolver = {find_mesh, report}};
}
