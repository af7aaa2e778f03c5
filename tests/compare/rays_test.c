/* SPDX-License-Identifier: Apache-2.0 */
/* The same input and count give the same rays, today as when the digests below were written: a
 * report names a ray, and the next run has to trace it again. */
#include <inttypes.h>

#include "src/compare/rays.h"
#include "subject.h"
#include "tests/builder/digest.h"

enum { RAYS = 4096 };

static uint64_t digest_of_rays(const struct subject *subject)
{
    struct input_copy *copy = input_copy_create(&subject->input);
    struct reference reference;
    struct rays rays;
    uint64_t digest = DIGEST_BEGIN;
    assert_non_null(copy);
    assert_int_equal(reference_open(copy, &reference), VK_SUCCESS);
    assert_int_equal(rays_create(&reference, RAYS, &rays), VK_SUCCESS);
    digest_add(&digest, &rays.count, sizeof(rays.count));
    for (uint32_t i = 0; i < rays.count; i++) {
        const struct compare_ray *ray = &rays.rays[i];
        const struct aim *aim = &rays.aims[i];
        const struct ring *ring = &rays.rings[i];
        digest_add_words(&digest, ray->origin, sizeof(ray->origin));
        digest_add_words(&digest, ray->direction, sizeof(ray->direction));
        digest_add_words(&digest, &ray->t_min, sizeof(ray->t_min));
        digest_add_words(&digest, &ray->t_max, sizeof(ray->t_max));
        const uint32_t numbers[] = {(uint32_t)aim->at, aim->geometry,  aim->primitive,
                                    aim->corner,       ring->geometry, ring->count};
        digest_add(&digest, numbers, sizeof(numbers));
        digest_add(&digest, ring->primitives, ring->count * sizeof(ring->primitives[0]));
    }
    rays_free(&rays);
    reference_close(&reference);
    input_copy_free(copy);
    return digest;
}

static void fill_boxes(struct subject *subject)
{
    static VkAabbPositionsKHR boxes[BOXES];
    boxes_fill(boxes);
    subject_begin(subject);
    subject_boxes(subject, boxes, BOXES);
}

TEST(test_rays)
{
    static struct subject subject;
    static const struct {
        const char *name;
        void (*fill)(struct subject *subject);
        uint64_t expected;
    } cases[] = {
        {"soup", subject_soup, 0x9dbf9205a342cbaa},
        {"first vertex", subject_first_vertex, 0x04b6a9550c5b8b1a},
        {"ring", subject_ring, 0xb45c94b4e6e27011},
        {"boxes", fill_boxes, 0xe6d8b545d6d9b3f8},
    };
    bool all_equal = true;
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        cases[i].fill(&subject);
        const uint64_t found = digest_of_rays(&subject);
        if (found != cases[i].expected)
            print_message("%s: 0x%016" PRIx64 "\n", cases[i].name, found);
        all_equal &= found == cases[i].expected;
    }
    assert_true(all_equal);
}
