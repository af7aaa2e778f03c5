/* SPDX-License-Identifier: Apache-2.0 */
/* What descriptor sets hold. */
#include "src/state/resources/descriptors.h"

#include <string.h>

#include "tests/fixture/make.h"
#include "tests/unit/unit_test.h"

#define LAYOUT ((VkDescriptorSetLayout)(uintptr_t)0x10)
#define POOL ((VkDescriptorPool)(uintptr_t)0x20)
#define TOP_LEVEL(number) ((VkAccelerationStructureKHR)(uintptr_t)(number))
#define SET(number) ((VkDescriptorSet)(uintptr_t)(0x100 + (number)))

enum { TOP = 0, TOPS = 1, BUFFER = 2, TEXTURE = 3, BINDINGS = 4 };
enum { MUTABLE = BINDINGS }; /* of one test */

static struct descriptor_sets sets;

static void note_layout(uint32_t first, uint32_t count, VkDescriptorBindingFlags flags)
{
    static const VkDescriptorSetLayoutBinding bindings[] = {
        [TOP] = {TOP, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1, 0, NULL},
        [TOPS] = {TOPS, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 3, 0, NULL},
        [BUFFER] = {BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, 0, NULL},
        [TEXTURE] = {TEXTURE, VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, 1, 0, NULL},
        [MUTABLE] = {MUTABLE, VK_DESCRIPTOR_TYPE_MUTABLE_EXT, 1, 0, NULL}};
    const VkDescriptorBindingFlags all[BINDINGS] = {flags, flags, flags, flags};
    const STRUCT(VkDescriptorSetLayoutBindingFlagsCreateInfo, with_flags, .bindingCount = count,
                 .pBindingFlags = all);
    const STRUCT(VkDescriptorSetLayoutCreateInfo, info, .pNext = flags ? &with_flags : NULL,
                 .bindingCount = count, .pBindings = &bindings[first]);
    descriptor_sets_note_layout(&sets, LAYOUT, &info);
}

static void allocate(uint32_t number)
{
    const VkDescriptorSetLayout layout = LAYOUT;
    const VkDescriptorSet set = SET(number);
    const VkDescriptorSetAllocateInfo info = {
        .descriptorPool = POOL, .descriptorSetCount = 1, .pSetLayouts = &layout};
    descriptor_sets_allocate(&sets, &info, &set);
}

static void write_tops(uint32_t number, uint32_t binding, uint32_t element, uint32_t count)
{
    const VkAccelerationStructureKHR tops[4] = {TOP_LEVEL(1), TOP_LEVEL(2), TOP_LEVEL(3),
                                                TOP_LEVEL(4)};
    const STRUCT(VkWriteDescriptorSetAccelerationStructureKHR, structures,
                 .accelerationStructureCount = count, .pAccelerationStructures = tops);
    const STRUCT(VkWriteDescriptorSet, write, .pNext = &structures, .dstSet = SET(number),
                 .dstBinding = binding, .dstArrayElement = element, .descriptorCount = count,
                 .descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR);
    descriptor_sets_write(&sets, &write);
}

static struct held_descriptor found[4]; /* by the last find() */

static uint32_t find(uint32_t number, uint32_t binding)
{
    return descriptor_sets_find(&sets, (uint64_t)(uintptr_t)SET(number), binding, found, 4);
}

static void open_sets(void)
{
    memset(&sets, 0, sizeof(sets));
    note_layout(0, BINDINGS, 0);
}

static void close_sets(void)
{
    descriptor_sets_end(&sets);
}

TEST_BETWEEN(what_is_written_is_found, open_sets, close_sets)
{
    const VkDescriptorBufferInfo buffer = {(VkBuffer)(uintptr_t)7, 16, 32};
    STRUCT(VkWriteDescriptorSet, write, .dstSet = SET(0), .dstBinding = BUFFER,
           .descriptorCount = 1, .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
           .pBufferInfo = &buffer);
    struct held_set pushed = {.handle = 0};
    allocate(0);
    assert_int_equal(find(0, TOP), UINT32_MAX);
    write_tops(0, TOP, 0, 1);
    descriptor_sets_write(&sets, &write);
    assert_int_equal(find(0, TOP), 1);
    assert_true(!found[0].is_buffer && found[0].must_be_valid && found[0].handle == 1);
    assert_int_equal(find(0, BUFFER), 1);
    assert_true(found[0].is_buffer && found[0].handle == 7 && found[0].offset == 16 &&
                found[0].range == 32);
    assert_int_equal(find(1, TOP), UINT32_MAX);
    for (; write.dstArrayElement <= HELD_MAX; write.dstArrayElement++) /* there is no room */
        held_set_write(&pushed, &write);
    assert_int_equal(held_set_find(&pushed, BUFFER, found, 4), UINT32_MAX);
    held_set_clear(&pushed);
}

static void note_layout_of(uint32_t structures)
{
    const VkDescriptorSetLayoutBinding binding = {
        TOP, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, structures, 0, NULL};
    const STRUCT(VkDescriptorSetLayoutCreateInfo, info, .bindingCount = 1, .pBindings = &binding);
    assert_int_equal(descriptor_sets_note_layout(&sets, LAYOUT, &info), structures <= HELD_MAX);
}

TEST_BETWEEN(a_set_with_room_for_too_many_descriptors_is_unknown, open_sets, close_sets)
{
    note_layout_of(HELD_MAX);
    allocate(0);
    write_tops(0, TOP, 0, 1);
    assert_int_equal(find(0, TOP), 1);
    note_layout_of(HELD_MAX + 1);
    allocate(1);
    write_tops(1, TOP, 0, 1);
    assert_int_equal(find(1, TOP), UINT32_MAX);
}

TEST_BETWEEN(an_array_goes_on_in_the_next_binding, open_sets, close_sets)
{
    allocate(0);
    write_tops(0, TOP, 0, 3);
    assert_int_equal(find(0, TOP), 1);
    assert_int_equal(found[0].handle, 1);
    assert_int_equal(find(0, TOPS), 2);
    assert_true(found[0].handle == 2 && found[1].handle == 3 && !found[0].must_be_valid);
    assert_int_equal(descriptor_sets_find(&sets, (uint64_t)(uintptr_t)SET(0), TOPS, &found[3], 1),
                     2);
    write_tops(0, TOPS, 2, 4); /* behind the last binding that is followed */
    assert_int_equal(find(0, TOP), UINT32_MAX);
}

TEST_BETWEEN(copies_are_followed, open_sets, close_sets)
{
    const STRUCT(VkCopyDescriptorSet, copy, .srcSet = SET(0), .srcBinding = TOP, .dstSet = SET(1),
                 .dstBinding = TOPS, .dstArrayElement = 1, .descriptorCount = 1);
    allocate(0);
    allocate(1);
    write_tops(0, TOP, 0, 1);
    descriptor_sets_copy(&sets, &copy);
    assert_int_equal(find(1, TOPS), 1);
    assert_true(found[0].handle == 1 && found[0].element == 1);
    descriptor_sets_forget_contents(&sets, SET(0));
    descriptor_sets_copy(&sets, &copy);
    assert_int_equal(find(1, TOPS), UINT32_MAX);
}

TEST_BETWEEN(sets_that_change_after_they_are_bound_are_unknown, open_sets, close_sets)
{
    note_layout(0, BINDINGS, VK_DESCRIPTOR_BINDING_UPDATE_AFTER_BIND_BIT);
    allocate(0);
    write_tops(0, TOP, 0, 1);
    assert_int_equal(find(0, TOP), UINT32_MAX);
    note_layout(0, BINDINGS, VK_DESCRIPTOR_BINDING_PARTIALLY_BOUND_BIT);
    allocate(1);
    write_tops(1, TOP, 0, 1);
    assert_int_equal(find(1, TOP), 1);
    assert_false(found[0].must_be_valid);
    note_layout(0, MUTABLE + 1, 0); /* what is not followed may be a structure */
    allocate(2);
    write_tops(2, TOP, 0, 1);
    assert_int_equal(find(2, TOP), UINT32_MAX);
}

/* More sets than any table has room for, and those that need no record. */
TEST_BETWEEN(freed_sets_give_their_records_back, open_sets, close_sets)
{
    enum { FRAMES = 1000, SETS = 100 };
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        for (uint32_t i = 0; i < SETS; i++) {
            allocate(frame * SETS + i);
            write_tops(frame * SETS + i, TOP, 0, 1);
        }
        assert_int_equal(sets.sets.count, SETS);
        if (frame % 2)
            descriptor_sets_end_pool(&sets, POOL);
        for (uint32_t i = 0; i < SETS; i++) {
            const VkDescriptorSet set = SET(frame * SETS + i);
            descriptor_sets_free(&sets, 1, &set);
        }
        assert_int_equal(sets.sets.count, 0);
    }
    descriptor_sets_forget_layout(&sets, LAYOUT);
    note_layout(TEXTURE, 1, 0);
    allocate(0);
    descriptor_sets_forget_contents(&sets, SET(0));
    assert_int_equal(sets.sets.count, 0);
    assert_int_equal(find(0, TOP), UINT32_MAX);
}
