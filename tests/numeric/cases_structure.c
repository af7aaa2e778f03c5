/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 44, 45 and 47: refits, deep trees, copies. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cases.h"

#define REFITS 10000

static void wobble(struct fixture_mesh *mesh, const float *rest, int step)
{
    for (uint32_t i = 0; i < 3 * mesh->vertex_count; i++)
        mesh->positions[i] = rest[i] + 0.3f * sinf((float)step * 0.01f + (float)(i % 97));
}

/* Many small steps, then the same positions in one: the same bytes. */
CASE(44, 0, 0, "10,000 refits", "shared edges")
{
    if (setting.threads > 1 || setting.accuracy != TRACE_EXACT) /* nothing to do with refits */
        return;
    struct fixture_mesh mesh = fixture_sphere(4, 1, (float[3]){0, 0, 0});
    struct builder_statistics before, after;
    float *rest = fixture_allocate((uint64_t)mesh.vertex_count * 12);
    memcpy(rest, mesh.positions, (size_t)mesh.vertex_count * 12);
    INPUT(mesh, input, &mesh);
    void *structure = case_build(&input);
    uint64_t size = builder_size(structure);
    void *fresh = fixture_allocate(size);
    builder_clone(structure, fresh, size);
    builder_measure(structure, &before);
    for (int step = 1; step <= REFITS; step++) {
        wobble(&mesh, rest, step);
        fixture_refit(&input.input, structure, structure, NULL);
    }
    builder_measure(structure, &after);
    EXPECT(fixture_refit(&input.input, fresh, fresh, NULL) == BUILDER_OK);
    EXPECT(memcmp(structure, fresh, size) == 0);
    printf("        SAH cost at quality %d: %.2f built, %.2f after %d refits\n", setting.quality,
           before.sah, after.sah, REFITS);
    /* In place and from elsewhere; and back to where it began: what the build wrote. */
    void *again = case_build(&input);
    memcpy(mesh.positions, rest, (size_t)mesh.vertex_count * 12);
    EXPECT(fixture_refit(&input.input, structure, again, NULL) == BUILDER_OK);
    void *first = case_build(&input);
    EXPECT(memcmp(first, again, size) == 0);
    input.range.primitiveCount--;
    EXPECT(fixture_refit(&input.input, structure, again, NULL) == BUILDER_INCOMPATIBLE);
}

/* Each triangle is twice as far and twice as large as the one before: splits by cost peel off one
 * at a time. */
CASE(45, 600, 0, "deep skewed tree", "deep tree")
{
    enum { COUNT = 200 };
    float corners[9 * COUNT];
    for (int i = 0; i < COUNT; i++) {
        float at = ldexpf(1, i - 100);
        float one[9] = {at, 0, 0, at * 1.5f, 0, 0, at, at * 0.5f, 0};
        memcpy(corners + (size_t)9 * i, one, sizeof(one));
    }
    void *structure = case_triangles(corners, COUNT);
    struct builder_statistics statistics;
    builder_measure(structure, &statistics);
    EXPECT(statistics.depth <= 80);
    for (int i = 0; i < COUNT; i += 9) {
        float at = ldexpf(1, i - 100);
        EXPECT(case_closest(structure, fixture_ray(at * 1.125f, at * 0.125f, at, 0, 0, -1))
                   .primitive == (uint32_t)i);
    }
}

/* Finds the copy where the original was. */
struct moved {
    const void *from, *to;
};

static const void *find_moved(void *context, uint64_t reference)
{
    const struct moved *moved = context;
    return reference == 0x1234 ? moved->to : NULL;
}

void *case_serialize(const void *structure, const struct builder_uuids *uuids, uint64_t *size)
{
    *size = builder_serialized_size(structure);
    void *bytes = fixture_allocate(*size);
    EXPECT(builder_serialize(structure, uuids, bytes, *size - 1) == BUILDER_TOO_SMALL);
    EXPECT(builder_serialize(structure, uuids, bytes, *size) == BUILDER_OK);
    return bytes;
}

void *case_deserialize(const void *bytes, uint64_t size, const struct builder_uuids *uuids)
{
    uint64_t header[3];
    memcpy(header, (const uint8_t *)bytes + 2 * VK_UUID_SIZE, sizeof(header));
    EXPECT(header[0] == size);
    void *structure = fixture_allocate(header[1]);
    EXPECT(builder_deserialize(bytes, size - 1, uuids, structure, header[1]) != BUILDER_OK);
    EXPECT(builder_deserialize(bytes, size, uuids, structure, header[1]) == BUILDER_OK);
    return structure;
}

void *case_compact(const void *structure)
{
    const uint64_t size = builder_compacted_size(structure);
    void *compacted = fixture_allocate(size);
    EXPECT(builder_compact(structure, compacted, size - 1) == BUILDER_TOO_SMALL);
    EXPECT(builder_compact(structure, compacted, size) == BUILDER_OK);
    EXPECT(builder_size(compacted) == size && builder_compacted_size(compacted) == size);
    return compacted;
}

static bool hits_are_same(const struct trace_hit *a, const struct trace_hit *b)
{
    return a->t == b->t && a->u == b->u && a->v == b->v && a->geometry == b->geometry &&
           a->primitive == b->primitive && a->instance == b->instance &&
           a->custom_index == b->custom_index && a->sbt_offset == b->sbt_offset &&
           a->front_face == b->front_face && a->opaque == b->opaque;
}

CASE(47, 0, 0, "serialize, relocate, deserialize", "shared edges")
{
    struct fixture_mesh mesh = fixture_sphere(4, 1, (float[3]){0, 0, 0});
    struct builder_uuids uuids = {{1, 2, 3}, {4, 5, 6}}, others = {{1, 2, 3}, {4, 5, 7}};
    void *blas = case_mesh(&mesh);
    uint64_t compacted_size = builder_compacted_size(blas), size;
    EXPECT(compacted_size <= builder_size(blas) &&
           (double)builder_size(blas) <= 1.25 * (double)compacted_size);
    void *compacted = case_compact(blas), *bytes = case_serialize(compacted, &uuids, &size);
    struct moved moved = {blas, case_deserialize(bytes, size, &uuids)};
    EXPECT(builder_deserialize(bytes, size, &others, compacted, compacted_size) ==
           BUILDER_INCOMPATIBLE);

    VkAccelerationStructureInstanceKHR instance = fixture_instance(blas);
    void *tlas = case_instances(&instance, 1);
    bytes = case_serialize(tlas, &uuids, &size);
    EXPECT(builder_reference_count(tlas) == 1);
    uint64_t reference = 0x1234;
    memcpy((uint8_t *)bytes + 56, &reference, sizeof(reference));
    void *relocated = case_deserialize(bytes, size, &uuids);
    struct trace_scene scenes[2] = {
        {.structure = tlas, .accuracy = setting.accuracy, .resolver = fixture_resolver()},
        {.structure = relocated, .accuracy = setting.accuracy, .resolver = {find_moved, &moved}},
    };
    uint64_t random = 71;
    for (int i = 0; i < 50; i++) {
        struct trace_ray ray = fixture_ray(2, 2, 2, 0, 0, 0);
        case_uniform(&random, -3, -1, ray.direction);
        struct trace_hit hits[2] = {{0}};
        bool is_hit = trace_closest(&scenes[0], &ray, &hits[0]);
        EXPECT(is_hit == trace_closest(&scenes[1], &ray, &hits[1]));
        EXPECT(hits_are_same(&hits[0], &hits[1]));
    }
}
