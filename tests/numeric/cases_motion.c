/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 48 to 53: triangles and instances that move (VK_NV_ray_tracing_motion_blur). */
#include <math.h>
#include <string.h>

#include "cases.h"

#define MOTION VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV
#define STRIDE 160 /* of motion instances */

static const float times[] = {0, 1, 0.5f, 0.25f, 1e-30f, 0x1.fffffep-1f, 0.3f};
enum { TIMES = sizeof(times) / sizeof(times[0]) };

/* Linear in time, rounded once. */
static float at_time(float from, float to, float time)
{
    return (float)(from * (1 - (double)time) + to * (double)time);
}

static void *build_moving(const float *from, const float *to, uint32_t triangles)
{
    INPUT(triangles, input, from, triangles);
    fixture_input_motion(&input, to);
    return case_build(&input);
}

/* Each triangle goes its own way; brute force takes those of the ray's time. */
CASE(48, 10, 0, "triangles that move", "motion")
{
    enum { COUNT = 60 };
    float from[9 * COUNT], to[9 * COUNT], now[9 * COUNT];
    uint64_t random = 73;
    for (int i = 0; i < COUNT; i++) {
        float place[2][3];
        for (int j = 0; j < 2; j++)
            case_uniform(&random, -10, 10, place[j]);
        for (int j = 0; j < 9; j++) {
            from[9 * i + j] = place[0][j % 3] + fixture_uniform(&random, -1, 1);
            to[9 * i + j] = place[1][j % 3] + fixture_uniform(&random, -1, 1);
        }
    }
    void *structure = build_moving(from, to, COUNT);
    for (int i = 0; i < 5 * TIMES; i++) {
        float time = times[i % TIMES], origin[3];
        for (int j = 0; j < 9 * COUNT; j++)
            now[j] = at_time(from[j], to[j], time);
        case_uniform(&random, -15, 15, origin);
        struct trace_ray ray =
            case_ray_into(now + 9 * (fixture_random(&random) % COUNT), origin, &random);
        ray.time = time;
        case_check_ray(structure, now, COUNT, ray);
    }
}

/* A closed mesh that swells, turns and goes away: at any time each ray from its inside meets one
 * triangle, at edges and vertices too. */
CASE(49, 600, 450, "closed mesh that moves", "motion")
{
    struct fixture_mesh mesh = fixture_sphere(3, 1, (float[3]){0.1f, 0.2f, 0.3f});
    struct fixture_mesh then = fixture_sphere(3, 2.5f, (float[3]){40, -3, 0.7f});
    uint64_t random = 79;
    for (uint32_t i = 0; i < then.vertex_count; i++) {
        float *at = then.positions + 3 * (size_t)i, x = at[0] - 40;
        at[0] = 40 + 0.8f * x - 0.6f * (at[1] + 3);
        at[1] = -3 + 0.6f * x + 0.8f * (at[1] + 3);
    }
    INPUT(mesh, input, &mesh);
    fixture_input_motion(&input, then.positions);
    void *structure = case_build(&input);
    for (uint32_t i = 0; i < 3 * mesh.triangle_count; i++) {
        uint32_t vertices[2] = {mesh.indices[i], mesh.indices[i - i % 3 + (i + 1) % 3]};
        float time = times[i % TIMES], ends[2][3], origin[3], target[3];
        const float centers[2][3] = {{0.1f, 0.2f, 0.3f}, {40, -3, 0.7f}};
        for (int j = 0; j < 3; j++) {
            for (int end = 0; end < 2; end++)
                ends[end][j] = at_time(mesh.positions[3 * vertices[end] + j],
                                       then.positions[3 * vertices[end] + j], time);
            origin[j] = at_time(centers[0][j], centers[1][j], time);
            origin[j] += i % 2 ? 0 : fixture_uniform(&random, -0.4f, 0.4f);
            target[j] = i % 3 == 0 ? ends[0][j] : 0.5f * (ends[0][j] + ends[1][j]);
        }
        struct trace_ray ray = case_ray_to(origin, target);
        ray.time = time;
        EXPECT(case_count(structure, ray) == 1);
    }
}

/* Vertices of time 1 count for activity and for what may be read. */
CASE(50, 0, 0, "inactive at one time", "motion")
{
    const float from[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0};
    float to[18];
    memcpy(to, from, sizeof(to));
    to[3] = NAN;
    INPUT(triangles, input, from, 2);
    fixture_input_motion(&input, to);
    void *structure = case_build(&input);
    EXPECT(report.active == 1 && report.inactive == 1);
    struct trace_ray ray = case_ray_down(5.25f, 0.25f);
    EXPECT(case_closest(structure, ray).primitive == 1);
    input.geometry.triangles.motion_vertices_size = sizeof(to) - 4;
    EXPECT(case_fails(&input) && report.out_of_range > 0);
    /* what isn't built for motion doesn't look at times */
    input.input.flags = 0;
    structure = case_build(&input);
    ray.time = 0.75f;
    EXPECT(case_closest(structure, ray).t == 1);
}

static void *build_instances(const void *instances, uint32_t count, bool has_pointers)
{
    INPUT(instances, input, instances, count);
    input.input.flags = MOTION;
    input.geometry.instances.size = count * (has_pointers ? sizeof(uint64_t) : STRIDE);
    input.geometry.instances.array_of_pointers = has_pointers;
    return case_build(&input);
}

/* Rays into the triangle where `matrix` puts it meet it in `moving` as in a TLAS with that
 * matrix. */
static void expect_same_hits(const void *blas, const void *moving,
                             const VkTransformMatrixKHR *matrix, float time, double precision)
{
    VkAccelerationStructureInstanceKHR instance = fixture_instance(blas);
    instance.transform = *matrix;
    void *still = case_instances(&instance, 1);
    uint64_t random = 83;
    for (int i = 0; i < 6; i++) {
        float corners[9], origin[3];
        for (int j = 0; j < 9; j++) {
            const float *row = matrix->matrix[j % 3], *at = fixture_triangle + j / 3 * 3;
            corners[j] = row[0] * at[0] + row[1] * at[1] + row[2] * at[2] + row[3];
        }
        for (int j = 0; j < 3; j++)
            origin[j] = matrix->matrix[j][3] + fixture_uniform(&random, -4, 4);
        struct trace_ray ray = case_ray_into(corners, origin, &random);
        struct trace_hit hits[2] = {{0}};
        ray.time = time;
        bool is_hit = case_trace(still, ray, &hits[0]);
        bool is_met = case_trace(moving, ray, &hits[1]);
        if (precision == 0)
            EXPECT(is_hit == is_met && hits[0].t == hits[1].t && hits[0].u == hits[1].u);
        else
            EXPECT(is_met && fabs(hits[1].t - 1) < precision);
    }
}

CASE(51, 0, 0, "instances between two matrices", "motion")
{
    void *blas = case_triangles(fixture_triangle, 1);
    uint8_t bytes[2][STRIDE] = {{0}};
    VkAccelerationStructureMatrixMotionInstanceNV moving = {
        .transformT0 = {{{1, 0, 0, 5}, {0, 1, 0, -2}, {0, 0, 1, 0}}},
        .transformT1 = {{{2, 0.5f, 0, -90}, {-1, 1, 0.25f, 12}, {0.5f, 0, 3, 1}}},
        .mask = 0xff,
        .instanceCustomIndex = 7,
        .accelerationStructureReference = (uintptr_t)blas,
    };
    uint32_t type = VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV;
    memcpy(bytes[1], &type, sizeof(type));
    memcpy(bytes[1] + 8, &moving, sizeof(moving));
    VkAccelerationStructureInstanceKHR still = fixture_instance(blas); /* of type 0 */
    still.transform.matrix[0][3] = 1e6f;
    memcpy(bytes[0] + 8, &still, sizeof(still));
    void *array = build_instances(bytes, 2, false);
    _Alignas(16) VkAccelerationStructureMatrixMotionInstanceNV aligned = moving;
    const uint64_t pointer = (uintptr_t)&aligned | type;
    void *by_pointer = build_instances(&pointer, 1, true);
    for (int i = 0; i < TIMES; i++) {
        VkTransformMatrixKHR now;
        for (int j = 0; j < 12; j++)
            now.matrix[j / 4][j % 4] = at_time(moving.transformT0.matrix[j / 4][j % 4],
                                               moving.transformT1.matrix[j / 4][j % 4], times[i]);
        expect_same_hits(blas, array, &now, times[i], 0);
        expect_same_hits(blas, by_pointer, &now, times[i], 0);
    }
    struct trace_ray ray = case_ray_down(5.25f, -1.75f);
    struct trace_hit hit = {0};
    EXPECT(case_trace(array, ray, &hit) && hit.custom_index == 7 && hit.instance == 1);
    ray.origin[0] = 1e6f + 0.25f;
    ray.origin[1] = 0.25f;
    ray.time = 0.7f;
    EXPECT(case_closest(array, ray).instance == 0);
}

/* T R S by the specification's words, in long double. */
static void srt_matrix(const VkSRTDataNV *a, const VkSRTDataNV *b, float time, long double m[3][4])
{
    long double e[16], q[4], length = 0;
    const float *from = &a->sx, *to = &b->sx;
    for (int i = 0; i < 16; i++)
        e[i] = from[i] * (1 - (long double)time) + to[i] * (long double)time;
    for (int i = 0; i < 4; i++)
        length += e[9 + i] * e[9 + i];
    for (int i = 0; i < 4; i++)
        q[i] = e[9 + i] / sqrtl(length);
    long double x = q[0], y = q[1], z = q[2], w = q[3];
    const long double s[3][4] = {
        {e[0], e[1], e[2], e[3]}, {0, e[4], e[5], e[6]}, {0, 0, e[7], e[8]}};
    const long double r[3][3] = {
        {1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
        {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
        {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)},
    };
    for (int i = 0; i < 12; i++) {
        m[i / 4][i % 4] = i % 4 == 3 ? e[13 + i / 4] : 0;
        for (int j = 0; j < 3; j++)
            m[i / 4][i % 4] += r[i / 4][j] * s[j][i % 4];
    }
}

static VkSRTDataNV random_srt(uint64_t *random)
{
    VkSRTDataNV srt;
    float *elements = &srt.sx, length = 0;
    for (int i = 0; i < 16; i++)
        elements[i] = fixture_uniform(random, -1, 1);
    for (int i = 0; i < 4; i++)
        length += elements[9 + i] * elements[9 + i];
    for (int i = 0; i < 4; i++)
        elements[9 + i] /= sqrtf(length);
    srt.sx += 3;
    srt.sy += 3;
    srt.sz += 3;
    srt.tx *= 50;
    return srt;
}

/* Bounds hold every point at every time, and the triangle is met where it is. */
CASE(52, 0, 0, "instances between two SRT transforms", "motion")
{
    void *blas = case_triangles(fixture_triangle, 1);
    uint64_t random = 89;
    for (int i = 0; i < 12; i++) {
        uint8_t bytes[STRIDE] = {0};
        VkAccelerationStructureSRTMotionInstanceNV moving = {
            .transformT0 = random_srt(&random),
            .transformT1 = random_srt(&random),
            .mask = 0xff,
            .accelerationStructureReference = (uintptr_t)blas,
        };
        uint32_t type = VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV;
        memcpy(bytes, &type, sizeof(type));
        memcpy(bytes + 8, &moving, sizeof(moving));
        void *tlas = build_instances(bytes, 1, false);
        float lower[3], upper[3], time = 0;
        EXPECT(builder_bounds(tlas, lower, upper));
        for (int j = 0; j <= 40; j++) {
            long double m[3][4];
            VkTransformMatrixKHR now;
            time = j < 40 ? (float)j / 40 : 1;
            srt_matrix(&moving.transformT0, &moving.transformT1, time, m);
            for (int k = 0; k < 12; k++)
                now.matrix[k / 4][k % 4] = (float)m[k / 4][k % 4];
            for (int corner = 0; corner < 9; corner++) {
                const float *at = fixture_triangle + corner / 3 * 3;
                const long double *row = m[corner % 3];
                long double x = row[0] * at[0] + row[1] * at[1] + row[2] * at[2] + row[3];
                EXPECT(x >= lower[corner % 3] && x <= upper[corner % 3]);
            }
            if (j % 8 == 0)
                expect_same_hits(blas, tlas, &now, time, 1e-4);
        }
        EXPECT(upper[1] - lower[1] < 40); /* not everything */
    }
}

/* Refits, copies and serialized forms of what moves. */
CASE(53, 0, 0, "refits and copies of what moves", "motion")
{
    const float to[9] = {8, 0, 0, 9, 0, 0, 8, 1, 0};
    float later[9] = {0, 8, 0, 1, 8, 0, 0, 9, 0};
    struct builder_uuids uuids = {{1}, {2}};
    uint64_t bytes_size;
    INPUT(triangles, input, fixture_triangle, 1);
    fixture_input_motion(&input, to);
    void *bytes = case_serialize(case_build(&input), &uuids, &bytes_size);
    void *again = case_deserialize(bytes, bytes_size, &uuids);
    struct trace_ray ray = case_ray_down(4.25f, 0.25f);
    ray.time = 0.5f;
    EXPECT(case_closest(again, ray).t == 1);
    input.geometry.triangles.motion_vertices = later;
    EXPECT(fixture_refit(&input.input, again, again, NULL) == BUILDER_OK);
    EXPECT(!case_meets(again, ray));
    ray.origin[0] = 0.25f;
    ray.origin[1] = 4.25f;
    EXPECT(case_closest(again, ray).t == 1);
    void *fresh = case_build(&input);
    EXPECT(memcmp(fresh, again, builder_size(fresh)) == 0);
    input.input.flags = 0; /* another kind of structure */
    EXPECT(fixture_refit(&input.input, again, again, NULL) == BUILDER_INCOMPATIBLE);
}
