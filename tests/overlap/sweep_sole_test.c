/* SPDX-License-Identifier: Apache-2.0 */
/* pairs_has_none_within() finds the builds that make no pair, before any range is collected. */
#include <string.h>

#include "src/check/overlap/pairs.h"
#include "tests/unit/unit_test.h"

struct sole {
    VkAccelerationStructureBuildGeometryInfoKHR info;
    struct check_context context;
    struct call_view call;
    struct build_view view;
};

/* A member of a build whose dst and scratch are bytes 100 to 199 and 200 to 299 of one memory
 * becomes another value. */
#define CHANGE(member, value)                                                                      \
#member, offsetof(struct sole, member), sizeof(((struct sole *)0)->member), value
static const struct change {
    const char *name;
    size_t offset, size;
    uint64_t value;
    bool is_plain, is_elsewhere; /* elsewhere: dst lies in another memory */
} changes[] = {
    {CHANGE(view.dst.begin, 100), true}, /* nothing changes */
    {CHANGE(view.dst.begin, 101), false},
    {CHANGE(view.dst.begin, 200), false},
    {CHANGE(view.dst.begin, 299), false},
    {CHANGE(view.dst.begin, 300), true},
    {CHANGE(view.dst.size, 90), true}, /* the smaller of two sizes counts */
    {CHANGE(view.sizes.acceleration_structure, 1000), false},
    {CHANGE(view.sizes.build_scratch, 101), true},
    {CHANGE(view.dst.begin, 200), true, .is_elsewhere = true},
    {CHANGE(view.sizes.known, false), false},
    {CHANGE(view.scratch.status, ADDRESS_UNKNOWN), false},
    {CHANGE(view.scratch.is_sparse, true), false},
    {CHANGE(view.dst.is_sparse, true), false},
    {CHANGE(info.srcAccelerationStructure, 5), false},
    {CHANGE(view.micromaps, 5), false},
    {CHANGE(context.level, LEVEL_PARAMETERS), false},
};

TEST(builds_without_pairs_are_plain)
{
    for (size_t i = 0; i < sizeof(changes) / sizeof(changes[0]); i++) {
        struct sole sole = {.context.level = LEVEL_STATE, .call.command = COMMAND_DEVICE};
        sole.view = (struct build_view){
            .call = &sole.call,
            .info = &sole.info,
            .dst = {.memory = (VkDeviceMemory)(changes[i].is_elsewhere ? 2ull : 1),
                    .begin = 100,
                    .size = 1000},
            .scratch = {.status = ADDRESS_IN_BUFFER,
                        .memory = (VkDeviceMemory)1,
                        .begin = 200,
                        .bytes_left = 100},
            .sizes = {.known = true, .acceleration_structure = 100, .build_scratch = 100}};
        memcpy((char *)&sole + changes[i].offset, &changes[i].value, changes[i].size);
        if (pairs_has_none_within(&sole.context, &sole.view) != changes[i].is_plain)
            fail_msg("%s = %d", changes[i].name, (int)changes[i].value);
    }
}
