/* SPDX-License-Identifier: Apache-2.0 */
/* Structures in sparse buffers: pages that they share, and pages that are missing. */
#include "case.h"
#include "placing.h"

/* Where bytes are is known as far as bindings are known to have executed. */
static const struct setup with_sparse = {.enable = ENABLE_SPARSE, .level = "execution"};

enum { PAGES = 4 };

struct sparse_pair {
    struct test_buffer buffers[2];
    struct test_memory memory; /* of 2 * PAGES pages */
    VkDeviceSize page;
};

static struct sparse_pair make_sparse_pair(struct scene *scene)
{
    struct sparse_pair pair;
    const struct test_buffer probe =
        scene_sparse_buffer(scene, 65536, ACCEL_USAGE, VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT);

    pair.page = scene_sparse_page(scene, &probe);
    for (int i = 0; i < 2; i++)
        pair.buffers[i] = scene_sparse_buffer(scene, PAGES * pair.page, ACCEL_USAGE,
                                              VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT |
                                                  VK_BUFFER_CREATE_SPARSE_ALIASED_BIT);
    pair.memory = scene_allocate(scene, 2 * PAGES * pair.page);
    return pair;
}

static void bind_page(struct scene *scene, const struct sparse_pair *pair, int buffer,
                      VkDeviceSize page, VkDeviceSize memory_page)
{
    scene_bind_sparse(scene, &pair->buffers[buffer], page * pair->page, pair->page,
                      pair->memory.handle, memory_page * pair->page);
}

/* The dsts of INDEXED and AABBS, each in a buffer of its own. */
static void place_dsts(struct scene *scene, const struct sparse_pair *pair)
{
    place_dst(scene, INDEXED, &pair->buffers[0], 0);
    place_dst(scene, AABBS, &pair->buffers[1], 0);
}

/* The first page of one and the last of the other: the same memory page. */
static void alias_sparse_pages(struct scene *scene)
{
    const struct sparse_pair pair = make_sparse_pair(scene);
    bind_page(scene, &pair, 0, 0, 3);
    bind_page(scene, &pair, 1, 2, 3);
    place_dst(scene, INDEXED, &pair.buffers[0], 0);
    place_dst(scene, AABBS, &pair.buffers[1], 2 * pair.page);
}

static void use_sparse_pages_apart(struct scene *scene)
{
    const struct sparse_pair pair = make_sparse_pair(scene);
    bind_page(scene, &pair, 0, 0, 3);
    bind_page(scene, &pair, 1, 0, 4);
    place_dsts(scene, &pair);
}

/* Structures over the first two pages of each buffer, which are bound to these of the memory. */
static void use_two_pages_each(struct scene *scene, const VkDeviceSize pages[2][2])
{
    const struct sparse_pair pair = make_sparse_pair(scene);
    for (int buffer = 0; buffer < 2; buffer++)
        for (VkDeviceSize page = 0; page < 2; page++)
            bind_page(scene, &pair, buffer, page, pages[buffer][page]);
    place_grow(scene, INDEXED, pair.page);
    place_grow(scene, AABBS, pair.page);
    place_dsts(scene, &pair);
}

/* They are bound in opposite order, and meet in one page only. */
static void alias_second_page_with_first(struct scene *scene)
{
    use_two_pages_each(scene, (const VkDeviceSize[2][2]){{0, 5}, {5, 1}});
}

static void interleave_pages(struct scene *scene)
{
    use_two_pages_each(scene, (const VkDeviceSize[2][2]){{0, 2}, {1, 3}});
}

static void alias_pages_in_order(struct scene *scene)
{
    use_two_pages_each(scene, (const VkDeviceSize[2][2]){{0, 1}, {1, 2}});
}

static void use_pages_in_order(struct scene *scene)
{
    use_two_pages_each(scene, (const VkDeviceSize[2][2]){{0, 1}, {2, 3}});
}

/* They were in one page, then one of them was bound elsewhere. */
static void rebind_page(struct scene *scene)
{
    const struct sparse_pair pair = make_sparse_pair(scene);
    bind_page(scene, &pair, 0, 0, 3);
    bind_page(scene, &pair, 1, 0, 3);
    bind_page(scene, &pair, 1, 0, 2);
    place_dsts(scene, &pair);
}

static void rebind_page_onto_another(struct scene *scene)
{
    const struct sparse_pair pair = make_sparse_pair(scene);
    bind_page(scene, &pair, 0, 0, 3);
    bind_page(scene, &pair, 1, 0, 2);
    place_dsts(scene, &pair);
    bind_page(scene, &pair, 1, 0, 3);
}

static void leave_pages_unbound(struct scene *scene)
{
    const struct sparse_pair pair = make_sparse_pair(scene);
    place_dst(scene, INDEXED, &pair.buffers[0], 0);
}

static void leave_second_page_unbound(struct scene *scene)
{
    const struct sparse_pair pair = make_sparse_pair(scene);
    bind_page(scene, &pair, 0, 0, 0);
    scene->infos[INDEXED].dstAccelerationStructure =
        scene_accel_in(scene, &pair.buffers[0], 0, pair.page + 512,
                       VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

static void bind_only_the_pages_needed(struct scene *scene)
{
    const struct sparse_pair pair = make_sparse_pair(scene);
    bind_page(scene, &pair, 0, 1, 0);
    bind_page(scene, &pair, 0, 2, 1);
    scene->infos[INDEXED].dstAccelerationStructure =
        scene_accel_in(scene, &pair.buffers[0], pair.page, pair.page + 512,
                       VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

static void unbind_page(struct scene *scene)
{
    const struct sparse_pair pair = make_sparse_pair(scene);
    bind_page(scene, &pair, 0, 0, 0);
    place_dst(scene, INDEXED, &pair.buffers[0], 0);
    scene_bind_sparse(scene, &pair.buffers[0], 0, pair.page, VK_NULL_HANDLE, 0);
}

static void unbind_another_page(struct scene *scene)
{
    const struct sparse_pair pair = make_sparse_pair(scene);
    bind_page(scene, &pair, 0, 0, 0);
    bind_page(scene, &pair, 0, 1, 1);
    place_dst(scene, INDEXED, &pair.buffers[0], 0);
    scene_bind_sparse(scene, &pair.buffers[0], pair.page, pair.page, VK_NULL_HANDLE, 0);
}

static void free_memory_of_pages(struct scene *scene)
{
    const struct sparse_pair pair = make_sparse_pair(scene);
    bind_page(scene, &pair, 0, 0, 0);
    place_dst(scene, INDEXED, &pair.buffers[0], 0);
    scene_destroy(scene, (uint64_t)pair.memory.handle);
}

/* Scratch in a page that a dst has, too, or in the next one. */
static void put_scratch_in_page(struct scene *scene, VkDeviceSize memory_page)
{
    const struct sparse_pair pair = make_sparse_pair(scene);
    const struct test_buffer scratch = scene_sparse_buffer(scene, PAGES * pair.page, SCRATCH_USAGE,
                                                           VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT |
                                                               VK_BUFFER_CREATE_SPARSE_ALIASED_BIT);
    bind_page(scene, &pair, 0, 0, 3);
    scene_bind_sparse(scene, &scratch, 0, pair.page, pair.memory.handle, memory_page * pair.page);
    place_dst(scene, INDEXED, &pair.buffers[0], 0);
    place_scratch(scene, AABBS, &scratch, 0);
}

/* A sparse page and a plain buffer in one memory. */
static void bind_beside_plain(struct scene *scene, VkDeviceSize memory_page)
{
    const struct sparse_pair pair = make_sparse_pair(scene);
    struct test_buffer plain = scene_create_buffer(scene, pair.page, ACCEL_USAGE);
    scene_bind(scene, &plain, &pair.memory, 3 * pair.page);
    bind_page(scene, &pair, 0, 0, memory_page);
    place_dst(scene, INDEXED, &pair.buffers[0], 0);
    place_dst(scene, AABBS, &plain, 0);
}

/* A copy of the source, whose page is unbound then. */
static void update_from_unbound_page(struct scene *scene)
{
    const struct sparse_pair pair = make_sparse_pair(scene);
    VkCopyAccelerationStructureInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR,
        .src = scene->infos[UPDATE].srcAccelerationStructure,
        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR,
    };
    bind_page(scene, &pair, 0, 0, 0);
    place_src(scene, UPDATE, &pair.buffers[0], 0);
    info.dst = scene->infos[UPDATE].srcAccelerationStructure;
    if (scene->command == COMMAND_HOST)
        expect_success(
            scene->vk->CopyAccelerationStructureKHR(scene->fixture->device, VK_NULL_HANDLE, &info),
            "vkCopyAccelerationStructureKHR");
    else
        scene->vk->CmdCopyAccelerationStructureKHR(scene->command_buffer, &info);
    scene_bind_sparse(scene, &pair.buffers[0], 0, pair.page, VK_NULL_HANDLE, 0);
}

static const struct test_case cases[] = {
    SHARED(RULE(dst_and_dst_are_apart), .setup = &with_sparse, .submits = true),
    CASE("dsts_in_one_sparse_page", .mutate = alias_sparse_pages,
         .mutate_twin = use_sparse_pages_apart),
    CASE("dsts_meet_in_one_of_two_sparse_pages", .mutate = alias_second_page_with_first,
         .mutate_twin = interleave_pages),
    CASE("dsts_over_sparse_pages_in_order", .mutate = alias_pages_in_order,
         .mutate_twin = use_pages_in_order),
    CASE("dsts_after_rebinding_a_sparse_page", .mutate = rebind_page_onto_another,
         .mutate_twin = rebind_page),
    CASE("dst_and_scratch_in_one_sparse_page", RULE(dst_and_scratch_are_apart),
         .commands = ON_COMMAND_BUFFERS, EITHER_CALL_SIZE(put_scratch_in_page, 3, 4)),
    CASE("dst_in_sparse_and_dst_in_plain_buffer", EITHER_CALL_SIZE(bind_beside_plain, 3, 2)),

    SHARED(RULE(dst_is_backed_by_memory), .setup = &with_sparse, .submits = true),
    CASE("dst_in_sparse_buffer_without_pages", .mutate = leave_pages_unbound,
         .mutate_twin = use_sparse_pages_apart, .path = "pInfos[0].dstAccelerationStructure"),
    CASE("dst_in_sparse_buffer_with_one_page_of_two", .mutate = leave_second_page_unbound,
         .mutate_twin = bind_only_the_pages_needed),
    CASE("dst_in_sparse_page_unbound_again", .mutate = unbind_page,
         .mutate_twin = unbind_another_page),
    CASE("dst_in_sparse_page_of_freed_memory", .mutate = free_memory_of_pages,
         .mutate_twin = use_sparse_pages_apart),
    CASE("src_in_sparse_page_unbound_again", RULE(update_src_is_backed_by_memory),
         .mutate = update_from_unbound_page, .path = "pInfos[4].srcAccelerationStructure"),

    SHARED(RULE(dst_is_backed_by_memory), .silent = true, .commands = ON_COMMAND_BUFFERS,
           .setup = &with_sparse),
    /* Pages may still be bound before the command buffer is submitted. */
    CASE("dst_in_sparse_buffer_without_pages_when_recorded", .mutate = leave_pages_unbound),
    CASE("dst_in_sparse_page_of_freed_memory_when_recorded", .mutate = free_memory_of_pages),
    CASE("dsts_in_one_sparse_page_when_recorded", RULE(dst_and_dst_are_apart),
         .mutate = alias_sparse_pages),
};

CASE_LIST(cases_sparse, cases);
