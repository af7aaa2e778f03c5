/* SPDX-License-Identifier: Apache-2.0 */
/* Answers to rays, which are the reference's own, made worse in many ways, by a little and by much:
 * right ones are never blamed, and each mistake is called what it is. The same input also gives the
 * same rays, and the same answers to them the same judgements and messages: today as when the
 * digests below were written.
 *
 * If you change any of that on purpose, replace the digests by those that the test prints. */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "src/compare/judge.h"
#include "src/compare/summary.h"
#include "subject.h"
#include "tests/builder/digest.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

enum { RAYS = 3000, TOP_RAYS = 6000, LOOSE = 60 };
enum { WAYS = 24, LAST_WAY = 18 }; /* of answers; those of way 0 and behind the last are right */
enum { LEAST_SCALE = 6, SCALES = 18, TOLERATED_SCALE = 20 };

static struct compare_answer answers[TOP_RAYS];
static bool all_equal;

static void start(void)
{
    all_equal = true;
}

static void expect(const char *what, uint64_t digest, uint64_t expected)
{
    if (digest == expected)
        return;
    all_equal = false;
    print_message("%s: 0x%016" PRIx64 "\n", what, digest);
}

/* ---- subjects */

static const float octahedron[18] = {4, 0, 0, -4, 0, 0, 0, 4, 0, 0, -4, 0, 0, 0, 4, 0, 0, -4};
static const uint32_t octahedron_indices[24] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                                2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};

/* A closed body, a closed ring, a sheet with one triangle turned, and loose triangles, of which one
 * is inactive and one without area. */
static void make_triangles(struct subject *subject)
{
    static float loose[9 * LOOSE];
    static const float square[12] = {0, 0, 9, 8, 0, 9, 0, 8, 9, 8, 8, 9};
    static const uint32_t square_indices[6] = {0, 1, 2, 1, 2, 3}; /* not in opposite directions */
    uint32_t seed = 1;
    for (int i = 0; i < 9 * LOOSE; i++)
        loose[i] = 4 * fraction_next(&seed) + 6 * (float)(i / 9 % 5) * (i % 3 == 0) - 20;
    loose[9 * 7] = NAN;
    memcpy(loose + 9 * 11, loose + 9 * 11 + 3, 3 * sizeof(float));
    subject_begin(subject);
    subject_triangles(subject, octahedron, 6, octahedron_indices, 8);
    subject_triangles(subject, ring_vertices, FAN_VERTICES, ring_indices, FAN_TRIANGLES);
    subject_triangles(subject, square, 4, square_indices, 2);
    subject_triangles(subject, loose, 3 * LOOSE, NULL, LOOSE);
}

/* So far out that the tolerance is a good part of their size. */
static void make_far_ring(struct subject *subject)
{
    static float vertices[3 * FAN_VERTICES];
    uint32_t seed = 3;
    for (int i = 0; i < 3 * FAN_VERTICES; i++)
        vertices[i] = 700 + (ring_vertices[i] + fraction_next(&seed) * 0.5f) * 0.125f;
    subject_begin(subject);
    subject_triangles(subject, vertices, FAN_VERTICES, ring_indices, FAN_TRIANGLES);
}

static void make_boxes(struct subject *subject)
{
    static VkAabbPositionsKHR boxes[BOXES];
    subject_grid(subject, boxes);
    boxes[5].minX = NAN;
    boxes[6].maxY = boxes[6].minY; /* flat */
}

/* ---- answers */

static int scale_of(uint32_t ray)
{
    return LEAST_SCALE + (int)(ray / WAYS % SCALES);
}

/* A way to be wrong, or by 2 to the power of -scale nearly right. */
static void spoil_hit(struct compare_hit *hit, uint32_t way, int scale)
{
    const float little = ldexpf(1, -scale);
    switch (way) {
    case 1:
        hit->t *= 1 + little;
        break;
    case 2:
        hit->t -= little * fabsf(hit->t);
        break;
    case 3:
        hit->u += little;
        break;
    case 4:
        hit->v -= little;
        break;
    case 5:
        hit->kind ^= COMPARE_FRONT;
        break;
    case 6:
        hit->primitive++;
        break;
    case 7:
        hit->geometry++;
        break;
    case 8:
        hit->instance++;
        break;
    case 9:
        hit->primitive = 7; /* may be inactive */
        hit->geometry = 3;
        break;
    }
}

static void spoil(struct compare_answer *answer, uint32_t way, int scale, const struct ring *ring)
{
    const uint32_t count = answer->candidate_count;
    struct compare_hit *last = &answer->candidates[count ? count - 1 : 0];
    spoil_hit(&answer->closest, way, scale);
    if (way < 10 && answer->candidate_count)
        spoil_hit(last, way, scale);
    if (way == 10 && answer->candidate_count)
        answer->candidate_count--;
    if (way == 11)
        answer->candidate_count = 0;
    if (way == 12)
        answer->closest = (struct compare_hit){0};
    if (way == 13)
        answer->candidate_count += COMPARE_CANDIDATES;
    if (way == 14)
        answer->flags = COMPARE_CUT;
    if (way == 15) {
        answer->flags = COMPARE_ELSEWHERE;
        answer->closest.kind = 0;
    }
    if (way == 16 && answer->candidate_count)
        answer->closest = *last;
    for (uint32_t i = 0; way == 17 && ring && i < ring->count; i++)
        if (answer->candidate_count < COMPARE_CANDIDATES) {
            struct compare_hit *hit = &answer->candidates[answer->candidate_count++];
            *hit = answer->closest;
            hit->kind |= COMPARE_HIT;
            hit->geometry = ring->geometry;
            hit->primitive = ring->primitives[i];
        }
    if (way == 18 && answer->candidate_count < COMPARE_CANDIDATES) {
        answer->candidates[answer->candidate_count] = answer->closest;
        answer->candidates[answer->candidate_count].primitive = 3;
        answer->candidates[answer->candidate_count++].t *= 0.5f;
    }
}

/* Makes what the traversal answers wrong: `rings` may be NULL. */
static void spoil_all(const struct ring *rings, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t way = i % WAYS, found = answers[i].candidate_count;
        if (!rings && found > COMPARE_CANDIDATES)
            continue; /* without the rest, other instances are missed */
        if (way >= 1 && way <= LAST_WAY && found > COMPARE_CANDIDATES)
            answers[i].candidate_count = COMPARE_CANDIDATES;
        spoil(&answers[i], way, scale_of(i), rings ? &rings[i] : NULL);
    }
}

/* ---- what may be said of each way */

#define SAYS(name) (1u << DIFFERENCE_##name)

static const uint32_t said_of_ways[WAYS] = {
    [1] = SAYS(DISTANCE),
    [2] = SAYS(DISTANCE),
    [3] = SAYS(BARYCENTRICS),
    [4] = SAYS(BARYCENTRICS),
    [5] = SAYS(EXTRA) | SAYS(DISTANCE) | SAYS(FACING),
    [6] = SAYS(EXTRA) | SAYS(PRIMITIVE) | SAYS(DISTANCE),
    [7] = SAYS(EXTRA) | SAYS(PRIMITIVE) | SAYS(DISTANCE),
    [8] = SAYS(EXTRA) | SAYS(PRIMITIVE),
    [9] = SAYS(MISSED) | SAYS(EXTRA) | SAYS(PRIMITIVE),
    [10] = SAYS(MISSED),
    [11] = SAYS(MISSED),
    [12] = SAYS(MISSED),
    [13] = SAYS(DOUBLE) | SAYS(EXTRA) | SAYS(DISTANCE),
    [16] = SAYS(DISTANCE),
    [17] = SAYS(DOUBLE) | SAYS(DISTANCE),
    [18] = SAYS(DOUBLE) | SAYS(EXTRA) | SAYS(PRIMITIVE) | SAYS(DISTANCE),
};

/* A box that the ray does not meet is a right candidate, so of boxes only those are wrong that are
 * missed. A roundoff is never wrong. */
static void expect_said(uint32_t ray, const struct judgement *judgement, bool has_boxes)
{
    const uint32_t way = ray % WAYS;
    const bool is_spoiled = way >= 1 && way <= LAST_WAY;
    const uint32_t says = said_of_ways[way] | (has_boxes && is_spoiled ? SAYS(MISSED) : 0);
    if (!(says >> judgement->difference & 1) || (way <= 4 && scale_of(ray) >= TOLERATED_SCALE))
        fail_msg("ray %u, way %u by 2^-%d: %s", ray, way, scale_of(ray),
                 difference_id(judgement->difference));
}

/* Some rays end before, or begin behind, what the answers have, or pass beside it. */
static void shorten(struct compare_ray *rays, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        if (i % 7 == 3 && answers[i].closest.kind)
            rays[i].t_max = answers[i].closest.t * 0.5f;
        if (i % 7 == 5 && answers[i].closest.kind)
            rays[i].t_min = answers[i].closest.t * 1.5f;
        if (i % 11 == 4)
            rays[i].origin[i % 3] += i % 2 ? 0.35f : 0.06f;
    }
}

/* ---- digests */

static void add_judgement(uint64_t *digest, bool differs, const struct judgement *judgement)
{
    digest_add(digest, &differs, sizeof(differs));
    if (!differs)
        return;
    const uint32_t numbers[] = {judgement->difference,       judgement->reason,
                                judgement->instance,         judgement->geometry,
                                judgement->primitive,        judgement->has_reference,
                                judgement->has_driver,       judgement->driver.kind,
                                judgement->driver.primitive, judgement->driver.instance};
    const float values[] = {(float)judgement->t, (float)judgement->u, (float)judgement->v};
    digest_add(digest, numbers, sizeof(numbers));
    digest_add_words(digest, values, sizeof(values));
    if (judgement->has_reference)
        digest_add_hit(digest, &judgement->reference);
}

static uint64_t digest_of_texts(const struct summary *summary)
{
    uint64_t digest = DIGEST_BEGIN;
    for (enum difference i = 0; i < DIFFERENCE_COUNT; i++) {
        char text[SUMMARY_TEXT];
        digest_add(&digest, &summary->found[i].count, sizeof(summary->found[i].count));
        if (summary->found[i].count == 0)
            continue;
        summary_describe(summary, i, text);
        digest_add(&digest, text, strlen(text));
    }
    return digest;
}

static const struct row {
    const char *test;
    void (*make)(struct subject *subject);
    uint64_t rays, rings, judgements, texts;
} rows[] = {
    {"test_triangles", make_triangles, 0xff6264ce2ea87830, 0x47626af5e611c574, 0x78f090b7fe28c93c,
     0x208bafe63c4ed6e5},
    {"test_far_ring", make_far_ring, 0x403428e1e7d14cbe, 0xd086a2bcf41177a4, 0x7506f0c6aec08d5d,
     0x34c18daf668b39bb},
    {"test_boxes", make_boxes, 0x01b0c4bc67e5633b, 0x8e87211ff8353505, 0x4167a5a4c52b0142,
     0xb5ea43bd63c551b7},
};

TEST_OF_ROWS(test_subject, rows, const struct row *row, start)
{
    struct subject subject;
    struct reference reference;
    struct rays rays;
    struct summary summary;
    uint64_t generated = DIGEST_BEGIN, rings = DIGEST_BEGIN, judged = DIGEST_BEGIN;
    row->make(&subject);
    const int before = allocations_now();
    struct input_copy *copy = input_copy_create(&subject.input);
    assert_non_null(copy);
    GET(reference_open(copy, &reference));
    GET(rays_create(&reference, RAYS, &rays));
    answer_exactly(reference.structure, NULL, rays.rays, rays.count, answers);
    spoil_all(rays.rings, rays.count);
    digest_add_words(&generated, rays.rays, rays.count * sizeof(*rays.rays));
    digest_add(&generated, rays.aims, rays.count * sizeof(*rays.aims));
    for (uint32_t i = 0; i < rays.count; i++) {
        struct judgement judgement;
        if (judge_ray(&reference, &rays, i, &answers[i], &judgement))
            expect_said(i, &judgement, row->make == make_boxes);
    }
    shorten(rays.rays, rays.count);
    for (uint32_t i = 0; i < rays.count; i++) {
        struct judgement judgement;
        const bool is_once = ring_is_hit_once(&reference, &rays, i);
        digest_add(&rings, &is_once, sizeof(is_once));
        digest_add(&rings, &rays.rings[i].count, sizeof(rays.rings[i].count));
        digest_add(&rings, rays.rings[i].primitives, rays.rings[i].count * sizeof(uint32_t));
        const bool differs = judge_ray(&reference, &rays, i, &answers[i], &judgement);
        add_judgement(&judged, differs, &judgement);
    }
    summary_make(&reference, &rays, answers, &summary);
    expect("rays", generated, row->rays);
    expect("rings", rings, row->rings);
    expect("judgements", judged, row->judgements);
    expect("texts", digest_of_texts(&summary), row->texts);
    rays_free(&rays);
    reference_close(&reference);
    input_copy_free(copy);
    assert_null(rays.rays);
    assert_null(reference.structure);
    assert_int_equal(allocations_now(), before);
    assert_true(all_equal);
}

/* ---- instances */

enum { INSTANCES = 80, LAST = INSTANCES - 1 };

/* Moved, mirrored and flipped, stretched too far to be judged, masked out,
 * inactive, and so large that its rays are infinite. */
static const struct top_instance instances[INSTANCES] = {
    {{.transform.matrix = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .mask = 1}, 0},
    {{.transform.matrix = {{0, -2, 0, 50}, {2, 0, 0, 0}, {0, 0, 3, 7}},
      .mask = 2,
      .flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FLIP_FACING_BIT_KHR},
     1},
    {{.transform.matrix = {{-1, 0, 0.5f, -20}, {0, 1, 0, 0}, {0, 0, 1, 9}}, .mask = 4}, 0},
    {{.transform.matrix = {{40, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .mask = 4}, 0},
    {{.transform.matrix = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .mask = 0}, 1},
    {{.transform.matrix = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .mask = 1}, TOP_NO_BOTTOM},
    {{.transform.matrix = {{1e38f, 0, 0, 0}, {0, 1e38f, 0, 0}, {0, 0, 1e38f, 0}}, .mask = 1}, 0},
    /* As far as it may be stretched, and further. */
    {{.transform.matrix = {{16, 0, 0, 300}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .mask = 1}, 0},
    {{.transform.matrix = {{16.01f, 0, 0, 600}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .mask = 1}, 0},
    /* More in one place than a ray remembers. */
    [9 ... LAST] = {{.transform.matrix = {{1}, {0, 1, 0, 200}, {0, 0, 1}}, .mask = 1}, 1},
};

TEST_OPENED(test_instances, start)
{
    struct subject subjects[2];
    struct input_copy *copies[2];
    struct top_reference top;
    struct top_rays rays;
    struct summary summary;
    uint64_t generated = DIGEST_BEGIN, judged = DIGEST_BEGIN;
    make_triangles(&subjects[0]);
    make_boxes(&subjects[1]);
    const int before = allocations_now();
    for (int i = 0; i < 2; i++)
        assert_non_null(copies[i] = input_copy_create(&subjects[i].input));
    const struct top_input input = {.count = INSTANCES,
                                    .bottom_count = 2,
                                    .instances = instances,
                                    .bottoms = (const struct input_copy *const *)copies};
    GET(top_reference_open(&input, &top));
    GET(top_rays_create(&top, TOP_RAYS, &rays));
    answer_exactly(top.structure, &top, rays.rays, rays.count, answers);
    spoil_all(NULL, rays.count);
    digest_add_words(&generated, rays.rays, rays.count * sizeof(*rays.rays));
    digest_add(&generated, rays.aims, rays.count * sizeof(*rays.aims));
    for (uint32_t i = 0; i < rays.count; i++) {
        struct judgement judgement;
        const bool differs = top_judge_ray(&top, &rays, i, &answers[i], &judgement);
        if (differs)
            expect_said(i, &judgement, true);
        add_judgement(&judged, differs, &judgement);
    }
    summary_make_top(&top, &rays, answers, &summary);
    expect("rays", generated, 0x6d99c9b71bb047af);
    expect("judgements", judged, 0x1fb5c5920f1c8234);
    expect("texts", digest_of_texts(&summary), 0x9f2413ff5e06d070);
    top_rays_free(&rays);
    top_reference_close(&top);
    for (int i = 0; i < 2; i++)
        input_copy_free(copies[i]);
    assert_null(rays.rays);
    assert_null(top.structure);
    assert_int_equal(allocations_now(), before);
    assert_true(all_equal);
}
