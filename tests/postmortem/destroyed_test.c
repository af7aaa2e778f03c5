/* SPDX-License-Identifier: Apache-2.0 */
/* The ring of destroyed objects, by their addresses. */
#include "src/state/resources/destroyed.h"

#include "tests/fixture/objects.h"
#include "tests/unit/unit_test.h"

TEST(test_ring)
{
    struct destroyed_objects *destroyed;
    struct destroyed_object object = {.type = VK_OBJECT_TYPE_BUFFER, .handle = 1, .size = 16};
    GET(destroyed_objects_create(&destroyed));
    destroyed_objects_add(destroyed, &object); /* had no address */
    assert_false(destroyed_objects_find_range(destroyed, 0, &object));
    for (uint64_t i = 1; i <= DESTROYED_MAX + 1; i++) {
        object.handle = i;
        object.address = 256 * i;
        destroyed_objects_add(destroyed, &object);
    }
    assert_false(destroyed_objects_find(destroyed, VK_OBJECT_TYPE_BUFFER, 256, &object));
    assert_false(destroyed_objects_find(destroyed, VK_OBJECT_TYPE_BUFFER, 512 + 16, &object));
    assert_true(destroyed_objects_find(destroyed, VK_OBJECT_TYPE_BUFFER, 512 + 15, &object));
    assert_int_equal(object.handle, 2);
    destroyed_objects_count_submission(destroyed);
    object = (struct destroyed_object){
        .type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, .handle = 7, .address = 512, .size = 64};
    destroyed_objects_add(destroyed, &object);
    assert_true(
        destroyed_objects_find(destroyed, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, 512, &object));
    assert_int_equal(object.handle, 7);
    assert_int_equal(object.submissions, 1);
    assert_true(
        destroyed_objects_find(destroyed, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, 768, &object));
    assert_int_equal(object.type, VK_OBJECT_TYPE_BUFFER);
    assert_true(destroyed_objects_find_range(destroyed, 512 + 63, &object));
    assert_int_equal(object.handle, 7);
    destroyed_objects_destroy(destroyed);
}
