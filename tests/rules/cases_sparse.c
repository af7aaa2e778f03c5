/* SPDX-License-Identifier: Apache-2.0 */
/* Structures in sparse buffers: pages that they share, and pages that are missing. */
#include "case.h"
#include "placing.h"

/* Where bytes are is known as far as bindings are known to have executed. */
static const struct setup with_sparse = {.enable = ENABLE_SPARSE, .level = "execution"};

/* Two sparse buffers, of the scene that is played; their pages are counted on. */
enum { PAGES = 4, FIRST = 0, SECOND = PAGES };
static struct test_buffer buffers[2];
static struct test_memory memory; /* of 2 * PAGES pages */
static VkDeviceSize page_size;

static struct test_buffer aliased_buffer(struct scene *scene, VkBufferUsageFlags usage)
{
    return scene_sparse_buffer(scene, PAGES * page_size, usage,
                               VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT |
                                   VK_BUFFER_CREATE_SPARSE_ALIASED_BIT);
}

static void make_pages(struct scene *scene)
{
    const struct test_buffer probe =
        scene_sparse_buffer(scene, 65536, ACCEL_USAGE, VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT);
    page_size = scene_sparse_page(scene, &probe);
    for (int i = 0; i < 2; i++)
        buffers[i] = aliased_buffer(scene, ACCEL_USAGE);
    memory = scene_allocate(scene, 2 * PAGES * page_size);
}

static void bind_page(struct scene *scene, uint32_t page, VkDeviceSize memory_page)
{
    scene_bind_sparse(scene, &buffers[page / PAGES], page % PAGES * page_size, page_size,
                      memory.handle, memory_page * page_size);
}

static void unbind_page(struct scene *scene, uint32_t page)
{
    scene_bind_sparse(scene, &buffers[page / PAGES], page % PAGES * page_size, page_size,
                      VK_NULL_HANDLE, 0);
}

static void place_dst_at(struct scene *scene, uint32_t build, VkDeviceSize page)
{
    place_dst(scene, build, &buffers[page / PAGES], page % PAGES * page_size);
}

static void grow_beyond_a_page(struct scene *scene, uint32_t build)
{
    place_grow(scene, build, page_size);
}

/* A dst of two pages. */
static void place_long_dst_at(struct scene *scene, uint32_t page)
{
    scene->infos[INDEXED].dstAccelerationStructure =
        scene_accel_in(scene, &buffers[0], page * page_size, page_size + 512,
                       VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

static void free_pages(struct scene *scene)
{
    scene_destroy(scene, (uint64_t)memory.handle);
}

#define BIND(page, memory_page) CALL_FOR(bind_page, page, memory_page)
#define DST(build, page) CALL_FOR(place_dst_at, build, page)
#define DSTS DST(INDEXED, FIRST), DST(AABBS, SECOND)
/* Structures over the first two pages of each buffer, which are bound to these of the memory. */
#define TWO_PAGES_EACH(first, second, third, fourth)                                               \
    BIND(FIRST, first), BIND(FIRST + 1, second), BIND(SECOND, third), BIND(SECOND + 1, fourth),    \
        CALL_WITH(grow_beyond_a_page, INDEXED), CALL_WITH(grow_beyond_a_page, AABBS), DSTS

/* Scratch in a page that a dst has, too, or in the next one. */
static void put_scratch_in_page(struct scene *scene, VkDeviceSize memory_page)
{
    const struct test_buffer scratch = aliased_buffer(scene, SCRATCH_USAGE);
    scene_bind_sparse(scene, &scratch, 0, page_size, memory.handle, memory_page * page_size);
    place_scratch(scene, AABBS, &scratch, 0);
}

/* A plain buffer in the memory, too, at its page 3. */
static void place_in_plain_buffer(struct scene *scene)
{
    struct test_buffer plain = scene_create_buffer(scene, page_size, ACCEL_USAGE);
    scene_bind(scene, &plain, &memory, 3 * page_size);
    place_dst(scene, AABBS, &plain, 0);
}

/* A copy of the source, whose page is unbound then. */
static void update_from_unbound_page(struct scene *scene)
{
    const VkAccelerationStructureKHR source = scene->infos[UPDATE].srcAccelerationStructure;
    bind_page(scene, FIRST, 0);
    place_src(scene, UPDATE, &buffers[0], 0);
    expect_success(scene_copy(scene, source, scene->infos[UPDATE].srcAccelerationStructure,
                              VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR),
                   "vkCopyAccelerationStructureKHR");
    unbind_page(scene, FIRST);
}

static const struct test_case cases[] = {
    SHARED(.setup = &with_sparse, .prepare = make_pages, .submits = true),
    CASE("dsts_in_one_sparse_page", RULE(dst_and_dst_are_apart),
         EDITS(BIND(FIRST, 3), BIND(SECOND + 2, 3), DST(INDEXED, FIRST), DST(AABBS, SECOND + 2)),
         TWIN_EDITS(BIND(FIRST, 3), BIND(SECOND, 4), DSTS)),
    CASE("dsts_meet_in_one_of_two_sparse_pages", RULE(dst_and_dst_are_apart),
         EDITS(TWO_PAGES_EACH(0, 5, 5, 1)), TWIN_EDITS(TWO_PAGES_EACH(0, 2, 1, 3))),
    CASE("dsts_over_sparse_pages_in_order", RULE(dst_and_dst_are_apart),
         EDITS(TWO_PAGES_EACH(0, 1, 1, 2)), TWIN_EDITS(TWO_PAGES_EACH(0, 1, 2, 3))),
    CASE("dsts_after_rebinding_a_sparse_page", RULE(dst_and_dst_are_apart),
         EDITS(BIND(FIRST, 3), BIND(SECOND, 2), DSTS, BIND(SECOND, 3)),
         TWIN_EDITS(BIND(FIRST, 3), BIND(SECOND, 3), BIND(SECOND, 2), DSTS)),
    CASE("dst_and_scratch_in_one_sparse_page", RULE(dst_and_scratch_are_apart),
         .commands = ON_COMMAND_BUFFERS,
         EDITS(BIND(FIRST, 3), DST(INDEXED, FIRST), CALL_WITH_SIZE(put_scratch_in_page, 3)),
         TWIN_EDITS(BIND(FIRST, 3), DST(INDEXED, FIRST), CALL_WITH_SIZE(put_scratch_in_page, 4))),
    CASE("dst_in_sparse_and_dst_in_plain_buffer", RULE(dst_and_dst_are_apart),
         EDITS(BIND(FIRST, 3), DST(INDEXED, FIRST), CALL(place_in_plain_buffer)),
         TWIN_EDITS(BIND(FIRST, 2), DST(INDEXED, FIRST), CALL(place_in_plain_buffer))),
    CASE("dst_in_sparse_buffer_without_pages", RULE(dst_is_backed_by_memory),
         EDITS(DST(INDEXED, FIRST)), TWIN_EDITS(BIND(FIRST, 3), BIND(SECOND, 4), DSTS),
         .path = "pInfos[0].dstAccelerationStructure"),
    CASE("dst_in_sparse_buffer_with_one_page_of_two", RULE(dst_is_backed_by_memory),
         EDITS(BIND(FIRST, 0), CALL_WITH(place_long_dst_at, FIRST)),
         TWIN_EDITS(BIND(FIRST + 1, 0), BIND(FIRST + 2, 1),
                    CALL_WITH(place_long_dst_at, FIRST + 1))),
    CASE("dst_in_sparse_page_unbound_again", RULE(dst_is_backed_by_memory),
         EDITS(BIND(FIRST, 0), DST(INDEXED, FIRST), CALL_WITH(unbind_page, FIRST)),
         TWIN_EDITS(BIND(FIRST, 0), BIND(FIRST + 1, 1), DST(INDEXED, FIRST),
                    CALL_WITH(unbind_page, FIRST + 1))),

    SHARED(.setup = &with_sparse, .submits = true),
    CASE("dst_in_sparse_page_of_freed_memory", RULE(dst_is_backed_by_memory), .prepare = make_pages,
         EDITS(BIND(FIRST, 0), DST(INDEXED, FIRST), CALL(free_pages)),
         TWIN_EDITS(BIND(FIRST, 3), BIND(SECOND, 4), DSTS)),
    CASE("src_in_sparse_page_unbound_again", RULE(update_src_is_backed_by_memory),
         .mutate = make_pages, EDITS(CALL(update_from_unbound_page)),
         .path = "pInfos[4].srcAccelerationStructure"),

    SHARED(RULE(dst_is_backed_by_memory), .silent = true, .commands = ON_COMMAND_BUFFERS,
           .setup = &with_sparse, .mutate = make_pages),
    /* Pages may still be bound before the command buffer is submitted. */
    CASE("dst_in_sparse_buffer_without_pages_when_recorded", EDITS(DST(INDEXED, FIRST))),
    CASE("dst_in_sparse_page_of_freed_memory_when_recorded",
         EDITS(BIND(FIRST, 0), DST(INDEXED, FIRST), CALL(free_pages))),
    CASE("dsts_in_one_sparse_page_when_recorded", RULE(dst_and_dst_are_apart),
         EDITS(BIND(FIRST, 3), BIND(SECOND + 2, 3), DST(INDEXED, FIRST), DST(AABBS, SECOND + 2))),
};

CASE_LIST(cases_sparse, cases);
