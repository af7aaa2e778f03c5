/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 46, 69 and 70: displaced meshes as a whole (VK_NV_displacement_micromap). */
#include <math.h>
#include <string.h>

#include "cases.h"
#include "displacement_encoder.h"
#include "src/bvh/structure.h"

/* ---- a closed mesh whose triangles have two levels: where they meet, edges are decimated */

/* The same on both sides of an edge. */
static uint16_t value_of_place(void *context, uint32_t triangle, uint32_t level, uint32_t u,
                               uint32_t v)
{
    const struct fixture_mesh *mesh = context;
    const uint32_t weights[3] = {(1u << level) - u - v, u, v};
    double at[3] = {0};
    uint64_t sum = 0;
    for (int i = 0; i < 3; i++)
        for (int axis = 0; axis < 3; axis++)
            at[axis] +=
                (double)mesh
                    ->positions[3 * mesh->indices[3 * triangle + (uint32_t)i] + (uint32_t)axis] *
                weights[i] / (1u << level);
    for (int axis = 0; axis < 3; axis++)
        sum = (sum + (uint64_t)(int64_t)lround(at[axis] * 65536)) * UINT64_C(0x9e3779b97f4a7c15);
    return (uint16_t)(sum >> 53);
}

static bool has_edge(const struct fixture_mesh *mesh, uint32_t triangle, uint32_t from, uint32_t to)
{
    for (uint32_t i = 0; i < 3; i++)
        if (mesh->indices[3 * triangle + i] == from &&
            mesh->indices[3 * triangle + (i + 1) % 3] == to)
            return true;
    return false;
}

static uint8_t decimated_edges(const struct fixture_mesh *mesh, const uint8_t *levels,
                               uint32_t triangle)
{
    uint8_t edges = 0;
    for (uint32_t other = 0; other < mesh->triangle_count; other++)
        for (uint32_t i = 0; i < 3; i++)
            if (levels[other] < levels[triangle] &&
                has_edge(mesh, other, mesh->indices[3 * triangle + (i + 1) % 3],
                         mesh->indices[3 * triangle + i]))
                edges |= (uint8_t)(1u << i);
    return edges;
}

/* From the center, along everything that rounding or ties could let slip: one hit each. */
static void check_closed(const void *structure)
{
    const struct structure_header *header = structure;
    const struct displaced_record *records = structure_records(header);
    for (uint32_t i = 0; i < header->record_count; i += 3) {
        const struct triangle_record *triangle = &records[i].triangle;
        for (int way = 0; way < 3; way++) {
            struct trace_ray ray = fixture_ray(0, 0, 0, 0, 0, 0);
            for (int axis = 0; axis < 3; axis++)
                ray.direction[axis] = triangle->a[axis] + (way > 0 ? triangle->b[axis] : 0) +
                                      (way > 1 ? triangle->c[axis] : 0);
            EXPECT(case_count(structure, ray) == 1);
        }
    }
}

/* From within an instance, bounds of which are those of what is displaced. */
static void check_instance(const void *blas)
{
    VkAccelerationStructureInstanceKHR instance = fixture_instance(blas);
    uint64_t random = 139;
    for (int axis = 0; axis < 3; axis++)
        instance.transform.matrix[axis][3] = 10 * (float)axis;
    void *tlas = case_instances(&instance, 1);
    for (int i = 0; i < 100; i++) {
        struct trace_ray ray = fixture_ray(0, 10, 20, 0, 0, 0);
        case_uniform(&random, -1, 1, ray.direction);
        EXPECT(case_closest(tlas, ray).primitive < 48);
    }
}

CASE(69, 550, 450, "edges and vertices of a displaced closed mesh of two levels", "displacement")
{
    struct fixture_mesh mesh = fixture_sphere(2, 1, (float[3]){0, 0, 0});
    struct displaced displaced;
    uint8_t levels[48], edges[48];
    for (uint32_t i = 0; i < 48; i++)
        levels[i] = 2 + i * 7 % 3 % 2;
    for (uint32_t i = 0; i < 48; i++)
        edges[i] = decimated_edges(&mesh, levels, i);
    open_displaced(&displaced, 1, 48, levels, value_of_place, &mesh, mesh.positions,
                   (uint64_t)mesh.vertex_count * 12);
    displaced.displacement.flags = edges;
    displaced.displacement.flags_size = 48;
    displaced.displacement.flags_stride = 1;
    INPUT(mesh, input, &mesh);
    input.geometry.triangles.displacement = &displaced.displacement;
    void *structure = case_build(&input);
    check_closed(structure);
    check_instance(structure);
}

/* ---- updates and copies */

/* Same hits and bounds as a build of the same input. */
static void check_alike(const void *structure, const void *expected)
{
    uint64_t random = 107;
    case_expect_same_bounds(structure, expected);
    for (int i = 0; i < 20; i++) {
        float u = fixture_uniform(&random, 0, 0.5f), v = fixture_uniform(&random, 0, 0.5f);
        struct trace_ray ray = fixture_ray(4 * u, 4 * v, 50, 0.01f, 0.02f, -1);
        struct trace_hit hit = {0}, other = {0};
        EXPECT(case_trace(structure, ray, &hit) == case_trace(expected, ray, &other));
        EXPECT(hit.t == other.t && hit.u == other.u && hit.v == other.v);
    }
}

static void check_copies(const void *structure)
{
    const struct builder_uuids uuids = {{1}, {2}};
    uint64_t serialized;
    check_alike(case_compact(structure), structure);
    void *bytes = case_serialize(structure, &uuids, &serialized);
    void *again = case_deserialize(bytes, serialized, &uuids);
    EXPECT(memcmp(again, structure, builder_size(structure)) == 0);
    /* a part of a level that there isn't */
    struct structure_header *header = again;
    ((struct displaced_record *)structure_records(header))->part.level = 6;
    EXPECT(builder_serialize(again, &uuids, bytes, serialized) == BUILDER_OK);
    EXPECT(builder_deserialize(bytes, serialized, &uuids, again, builder_size(structure)) ==
           BUILDER_INCOMPATIBLE);
}

/* Other values, then other levels. */
CASE(70, 0, 0, "updates and copies of displaced triangles", "displacement")
{
    uint64_t random = 109;
    const uint8_t before[2] = {3, 2}, after[2] = {2, 3};
    const float pair[18] = {0, 0, 0, 4, 0, 0, 0, 4, 0, 4, 0, 0, 4, 4, 0, 0, 4, 0};
    const float vectors[18] = {0, 0, 1, 0, 0, 1, 0, 1, 1, 1, 0, 1, 0, 0, 2, 0, 0, 1};
    struct displaced displaced[3];
    struct fixture_input inputs[3];
    void *structures[3];
    for (int i = 0; i < 3; i++) {
        open_displaced(&displaced[i], 2, 2, i < 2 ? before : after, random_value, &random, vectors,
                       sizeof(vectors));
        fixture_input_triangles(&inputs[i], pair, 2);
        inputs[i].geometry.triangles.displacement = &displaced[i].displacement;
        structures[i] = case_build(&inputs[i]);
    }
    check_copies(structures[0]);
    void *updated = fixture_allocate(builder_size(structures[0]));
    for (int i = 1; i < 3; i++) {
        EXPECT(fixture_refit(&inputs[i].input, structures[0], updated, NULL) == BUILDER_OK);
        check_alike(updated, structures[i]);
        EXPECT(fixture_refit(&inputs[i].input, structures[0], structures[0], NULL) == BUILDER_OK);
        check_alike(structures[0], structures[i]);
    }
}

/* ---- beside triangles that aren't displaced, and enough for several threads */

CASE(46, 0, 0, "displaced triangles beside others", "displacement")
{
    static const float wall[9] = {9, -9, -9, 9, 9, -9, 9, 0, 9};
    struct fixture_mesh mesh = fixture_sphere(1, 1, (float[3]){0, 0, 0});
    struct displaced displaced;
    struct fixture_input parts[2], input;
    uint8_t levels[12];
    uint64_t random = 149;
    memset(levels, 5, sizeof(levels));
    open_displaced(&displaced, 1, 12, levels, value_of_place, &mesh, mesh.positions,
                   (uint64_t)mesh.vertex_count * 12);
    fixture_input_triangles(&parts[0], wall, 1);
    fixture_input_mesh(&parts[1], &mesh);
    parts[1].geometry.triangles.displacement = &displaced.displacement;
    const struct builder_geometry geometries[3] = {parts[0].geometry, parts[1].geometry,
                                                   parts[0].geometry};
    const VkAccelerationStructureBuildRangeInfoKHR ranges[3] = {parts[0].range, parts[1].range,
                                                                parts[0].range};
    input = parts[0];
    input.input.geometry_count = 3;
    input.input.geometries = geometries;
    input.input.ranges = ranges;
    void *structure = case_build(&input);
    EXPECT(report.active == 12 * 1024 + 2);
    if (setting.threads > 1 &&
        setting.accuracy == TRACE_EXACT) { /* this has nothing to do with rays */
        input.input.threads = 1;
        void *alone = fixture_build(&input.input, NULL);
        EXPECT(memcmp(structure, alone, builder_size(alone)) == 0);
    }
    for (int i = 0; i < 50; i++) {
        struct trace_ray ray = fixture_ray(0, 0, 0, 1, 0, 0);
        uint32_t of_geometry[3] = {0};
        ray.direction[1] = fixture_uniform(&random, -0.3f, 0.3f);
        ray.direction[2] = fixture_uniform(&random, -0.3f, 0.3f);
        const struct fixture_hits hits = case_hits(structure, ray);
        for (uint32_t j = 0; j < hits.count && j < 64; j++)
            of_geometry[hits.hits[j].geometry]++;
        EXPECT(of_geometry[0] == 1 && of_geometry[1] == 1 && of_geometry[2] == 1);
    }
}
