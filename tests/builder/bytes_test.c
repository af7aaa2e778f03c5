/* SPDX-License-Identifier: Apache-2.0 */
/* The same input gives the same bytes, the same hits and the same amount of work: today as when the
 * digests below were written. Other tests ask whether a tree is right, but most mistakes in a
 * builder only make its trees worse, which no ray tells.
 *
 * If you change the builder on purpose, replace the digests by those that the test prints, after a
 * look at the nodes and the area heuristic beside them. */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "tests/builder/digest.h"
#include "tests/builder/fixture.h"
#include "tests/unit/unit_test.h"

enum { QUALITIES = 3, PARTS = 4, RAYS = 120 };

/* ---- scenes; none takes a number from libm, whose last bits differ by version */

struct scene {
    struct fixture_input input;
    float *numbers;
    VkAccelerationStructureInstanceKHR *instances;
    float extent; /* rays start within twice of it */
};

/* Triangles of random sizes, some far larger than others. */
static void fill_soup(float *corners, uint32_t triangles, float extent, uint64_t seed)
{
    for (uint32_t i = 0; i < triangles; i++) {
        float size = fixture_uniform(&seed, 0.05f, 1), at[3];
        size *= size * size * extent / 4;
        for (int j = 0; j < 3; j++)
            at[j] = fixture_uniform(&seed, -extent, extent);
        for (int j = 0; j < 9; j++)
            corners[9 * i + (uint32_t)j] = at[j % 3] + fixture_uniform(&seed, -size, size);
    }
}

static void make_triangles(struct scene *scene, uint32_t count, uint64_t seed)
{
    scene->extent = 64;
    scene->numbers = fixture_allocate(count * 9 * sizeof(float));
    fill_soup(scene->numbers, count, scene->extent, seed);
    fixture_input_triangles(&scene->input, scene->numbers, count);
}

static void few(struct scene *scene)
{
    make_triangles(scene, 13, 5);
}

static void many(struct scene *scene)
{
    make_triangles(scene, 3000, 7);
}

/* A triangle in each square of a sheet; every fifth is inactive. */
static void sheet(struct scene *scene)
{
    const uint32_t count = 900;
    make_triangles(scene, count, 9);
    for (uint32_t i = 0; i < count; i++) {
        const float x = (float)(i % 30), y = (float)(i / 30);
        const float corners[9] = {x, y, 0, x + 1, y, 0, x, y + 1, 0.25f};
        memcpy(scene->numbers + 9 * i, corners, sizeof(corners));
        if (i % 5 == 4)
            scene->numbers[9 * i] = NAN;
    }
    scene->extent = 30;
}

/* Centers that double from one to the next. */
static void row(struct scene *scene)
{
    float at = 0x1p-20f;
    make_triangles(scene, 40, 13);
    for (uint32_t i = 0; i < 40; i++, at *= 2)
        for (uint32_t j = 0; j < 3; j++) {
            scene->numbers[9 * i + 3 * j] = at;
            scene->numbers[9 * i + 3 * j + 1] = j == 1;
            scene->numbers[9 * i + 3 * j + 2] = j == 2;
        }
    scene->extent = 1;
}

static void moved(struct scene *scene)
{
    static const VkTransformMatrixKHR transform = {{{0, 2, 0, 3}, {-1, 0, 0, 4}, {0, 0.5f, 3, 5}}};
    make_triangles(scene, 300, 17);
    fixture_input_transform(&scene->input, &transform);
}

static void in_motion(struct scene *scene)
{
    const uint32_t count = 300;
    scene->extent = 64;
    scene->numbers = fixture_allocate(2 * count * 9 * sizeof(float));
    fill_soup(scene->numbers, count, scene->extent, 19);
    fill_soup(scene->numbers + count * 9, count, scene->extent, 23);
    fixture_input_triangles(&scene->input, scene->numbers, count);
    fixture_input_motion(&scene->input, scene->numbers + count * 9);
}

static void boxes(struct scene *scene)
{
    const uint32_t count = 700;
    VkAabbPositionsKHR *box = fixture_allocate(count * sizeof(*box));
    uint64_t seed = 29;
    scene->extent = 64;
    for (uint32_t i = 0; i < count; i++) {
        float *numbers = &box[i].minX;
        for (int j = 0; j < 3; j++) {
            numbers[j] = fixture_uniform(&seed, -64, 64);
            numbers[3 + j] = numbers[j] + fixture_uniform(&seed, 0, i % 7 ? 2 : 30);
        }
        if (i % 11 == 10)
            box[i].minX = NAN;
    }
    fixture_input_aabbs(&scene->input, box, count);
}

/* Spheres, or with `swept` capsules, of random radii; every ninth has none. */
static void make_spheres(struct scene *scene, bool swept)
{
    const uint32_t count = 400;
    uint64_t seed = 31;
    float *centers = fixture_allocate(2 * count * 3 * sizeof(float));
    float *radii = fixture_allocate(2 * count * sizeof(float));
    scene->extent = 64;
    for (uint32_t i = 0; i < 2 * count; i++) {
        for (int j = 0; j < 3; j++)
            centers[3 * i + (uint32_t)j] = fixture_uniform(&seed, -64, 64);
        radii[i] = i % 9 == 8 ? 0 : fixture_uniform(&seed, 0.1f, 6);
    }
    if (swept)
        fixture_input_spheres(&scene->input, VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV, count,
                              centers, radii, 2 * count);
    else
        fixture_input_spheres(&scene->input, VK_GEOMETRY_TYPE_SPHERES_NV, 2 * count, centers, radii,
                              2 * count);
}

static void spheres(struct scene *scene)
{
    make_spheres(scene, false);
}

static void capsules(struct scene *scene)
{
    make_spheres(scene, true);
}

/* ---- a top level, whose references are numbers so that its bytes hold no address */

static const void *find_numbered(void *context, uint64_t reference)
{
    static void *blas[2];
    (void)context;
    for (uint32_t i = 0; i < 2 && !blas[i]; i++) {
        static struct scene small[2];
        (i == 0 ? few : boxes)(&small[i]);
        blas[i] = fixture_build(&small[i].input.input, NULL);
    }
    return reference - 1 < 2 ? blas[reference - 1] : NULL;
}

static void instances(struct scene *scene)
{
    const uint32_t count = 150;
    uint64_t seed = 37;
    scene->extent = 500;
    scene->instances = fixture_allocate(count * sizeof(*scene->instances));
    for (uint32_t i = 0; i < count; i++) {
        VkAccelerationStructureInstanceKHR *instance = &scene->instances[i];
        *instance = fixture_instance(NULL);
        instance->accelerationStructureReference = i % 4; /* 0 and 3 lead nowhere */
        instance->instanceCustomIndex = 7 * i;
        instance->instanceShaderBindingTableRecordOffset = 5 * i;
        instance->mask = i % 5 ? 0xff : 1;
        instance->flags = i % 16;
        for (int j = 0; j < 12; j++)
            instance->transform.matrix[j / 4][j % 4] =
                j % 4 == 3 ? fixture_uniform(&seed, -400, 400) : fixture_uniform(&seed, -1, 1);
    }
    fixture_input_instances(&scene->input, scene->instances, count);
    scene->input.input.resolver = (struct builder_resolver){find_numbered, NULL};
}

/* Instances that stand, change their matrix, or turn; of the last kind one has no length. */
static void moving_instances(struct scene *scene)
{
    const uint32_t count = 90, stride = 160;
    uint64_t seed = 43;
    uint8_t *bytes = fixture_allocate(count * stride);
    instances(scene);
    for (uint32_t i = 0; i < count; i++) {
        VkAccelerationStructureMotionInstanceNV motion = {
            .type = (VkAccelerationStructureMotionInstanceTypeNV)(i % 3),
            .data.staticInstance = scene->instances[i]};
        if (i % 3 == VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV) {
            VkAccelerationStructureMatrixMotionInstanceNV *matrix =
                &motion.data.matrixMotionInstance;
            memset(matrix, 0, sizeof(*matrix));
            matrix->transformT0 = scene->instances[i].transform;
            matrix->transformT1 = scene->instances[i + 1].transform;
            matrix->mask = 0xff;
            matrix->accelerationStructureReference = 1 + i % 2;
        } else if (i % 3 == VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV) {
            VkAccelerationStructureSRTMotionInstanceNV *srt = &motion.data.srtMotionInstance;
            memset(srt, 0, sizeof(*srt));
            float *numbers = &srt->transformT0.sx; /* 2 times 16 */
            for (int j = 0; j < 32; j++)
                numbers[j] = fixture_uniform(&seed, -1, 1) * (j % 16 < 12 ? 1 : 200);
            if (i % 7 == 0)
                memset(&srt->transformT0.qx, 0, 4 * sizeof(float));
            srt->mask = 0xff;
            srt->accelerationStructureReference = 1 + i % 2;
        }
        memcpy(bytes + i * stride, &motion, sizeof(motion));
    }
    scene->input.geometry.instances = (struct builder_instances){bytes, count * stride, false};
    scene->input.range.primitiveCount = count;
    scene->input.input.flags = VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
}

/* ---- digests */

static enum trace_answer note_hit(void *context, struct trace_hit *candidate)
{
    digest_add_hit(context, candidate);
    return candidate->primitive % 3 == 1 ? TRACE_ACCEPT : TRACE_IGNORE;
}

static struct trace_ray random_ray(uint64_t *seed, float extent, uint32_t i)
{
    static const uint32_t flags[] = {0, TRACE_CULL_BACK_FACING, TRACE_CULL_FRONT_FACING,
                                     TRACE_CULL_OPAQUE, TRACE_NO_OPAQUE | TRACE_SKIP_AABBS};
    struct trace_ray ray = {.t_max = INFINITY,
                            .cull_mask = i % 3 ? 0xff : 2,
                            .flags = flags[i % 8 < 5 ? i % 8 : 0],
                            .time = (float)(i % 5) / 4};
    for (int j = 0; j < 3; j++) {
        ray.origin[j] = fixture_uniform(seed, -2 * extent, 2 * extent);
        ray.direction[j] = fixture_uniform(seed, -extent, extent) - ray.origin[j];
    }
    if (i % 6 == 5)
        ray.direction[i % 3] = 0;
    if (i % 10 == 9)
        ray.t_max = 0.75f;
    return ray;
}

static uint64_t digest_of_hits(const struct scene *scene, const void *structure,
                               enum trace_vectors vectors)
{
    uint64_t digest = DIGEST_BEGIN, seed = 41;
    for (uint32_t i = 0; i < RAYS; i++) {
        struct trace_ray ray = random_ray(&seed, scene->extent, i);
        for (int accuracy = TRACE_FAST; accuracy <= TRACE_EXACT; accuracy++) {
            struct trace_counters counters = {0};
            const struct trace_scene traced = {.structure = structure,
                                               .accuracy = (enum trace_accuracy)accuracy,
                                               .resolver = scene->input.input.resolver,
                                               .counters = &counters,
                                               .vectors = vectors};
            const struct trace_visitor visitor = {note_hit, &digest};
            struct trace_hit hit;
            trace_candidates(&traced, &ray, &visitor);
            if (trace_closest(&traced, &ray, &hit))
                digest_add_hit(&digest, &hit);
            digest_add(&digest, &counters, sizeof(counters));
        }
    }
    return digest;
}

static uint64_t digest_of_structure(const void *structure)
{
    uint64_t digest = DIGEST_BEGIN;
    digest_add_words(&digest, structure, builder_size(structure));
    return digest;
}

/* What reports, sizes, statistics and copies say. */
static uint64_t digest_of_rest(const struct scene *scene, const void *structure,
                               const struct builder_report *report)
{
    static const struct builder_uuids uuids = {{'a'}, {'b'}};
    uint64_t digest = DIGEST_BEGIN, size = builder_serialized_size(structure);
    struct builder_statistics statistics;
    struct builder_sizes sizes;
    float bounds[6] = {0};
    builder_measure(structure, &statistics);
    builder_get_sizes(&scene->input.input, &scene->input.range.primitiveCount, &sizes);
    builder_bounds(structure, bounds, bounds + 3);
    digest_add(&digest, &sizes, sizeof(sizes));
    digest_add_words(&digest, bounds, sizeof(bounds));
    const uint64_t numbers[] = {report->active,
                                report->inactive,
                                report->undefined,
                                report->out_of_range,
                                report->unresolved,
                                report->singular,
                                report->transformed,
                                statistics.nodes,
                                statistics.leaves,
                                statistics.active,
                                statistics.depth,
                                (uint64_t)(statistics.sah * 0x1p20),
                                builder_reference_count(structure)};
    digest_add(&digest, numbers, sizeof(numbers));
    uint8_t *bytes = fixture_allocate(size);
    assert_int_equal(builder_serialize(structure, &uuids, bytes, size), BUILDER_OK);
    digest_add_words(&digest, bytes, size);
    size = builder_compacted_size(structure);
    uint8_t *compact = fixture_allocate(size);
    assert_int_equal(builder_compact(structure, compact, size), BUILDER_OK);
    digest_add_words(&digest, compact, size);
    return digest;
}

struct row_of_digests {
    const char *name;
    void (*make)(struct scene *scene);
    uint64_t expected[QUALITIES][PARTS]; /* structure, hits, rest; after an update: the bytes */
};

static void find_digests(const struct row_of_digests *wanted, enum builder_quality quality,
                         uint64_t found[PARTS])
{
    struct scene scene = {.extent = 1};
    struct builder_report report;
    wanted->make(&scene);
    scene.input.input.quality = quality;
    void *structure = fixture_build(&scene.input.input, &report);
    assert_non_null(structure);
    found[0] = digest_of_structure(structure);
    found[1] = digest_of_hits(&scene, structure, TRACE_VECTORS_BEST);
    assert_int_equal(found[1], digest_of_hits(&scene, structure, TRACE_VECTORS_AVX2));
    assert_int_equal(found[1], digest_of_hits(&scene, structure, TRACE_VECTORS_PLAIN));
    found[2] = digest_of_rest(&scene, structure, &report);
    if (scene.input.geometry.type == VK_GEOMETRY_TYPE_TRIANGLES_KHR)
        for (uint32_t i = 0; i < 9 * scene.input.range.primitiveCount; i++)
            scene.numbers[i] = scene.numbers[i] * 0.5f + (float)(i % 7);
    assert_int_equal(fixture_refit(&scene.input.input, structure, structure, NULL), BUILDER_OK);
    found[3] = digest_of_structure(structure);
}

static const struct row_of_digests rows[] = {
#include "tests/builder/bytes.def"
};

SCOPE_TEST(test_bytes)
{
    bool all_equal = true;
    for (size_t i = 0; i < sizeof(rows) / sizeof(rows[0]); i++) {
        uint64_t found[QUALITIES][PARTS];
        for (int quality = 0; quality < QUALITIES; quality++)
            find_digests(&rows[i], (enum builder_quality)quality, found[quality]);
        if (memcmp(found, rows[i].expected, sizeof(found)) == 0)
            continue;
        all_equal = false;
        print_message("{\"%s\", %s,\n", rows[i].name, rows[i].name);
        for (int quality = 0; quality < QUALITIES; quality++) {
            const uint64_t *parts = found[quality];
            print_message(" %s{0x%016" PRIx64 ", 0x%016" PRIx64 ", 0x%016" PRIx64 ", 0x%016" PRIx64
                          "}%s\n",
                          quality == 0 ? "{" : " ", parts[0], parts[1], parts[2], parts[3],
                          quality == QUALITIES - 1 ? "}}," : ",");
        }
    }
    assert_true(all_equal);
}
