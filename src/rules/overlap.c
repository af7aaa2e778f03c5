/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about pairs of ranges: either two ranges of the same structure, or two ranges that share
 * memory. Pairs of the same structure have their own rules and aren't also reported as sharing
 * memory. */
#include "src/rules/predicates.h"

static bool is_pair_of(const struct pair_view *pair, enum range_role a, enum range_role b)
{
    return pair->a.role == a && pair->b.role == b;
}

static bool is_pair_of_update(const struct pair_view *pair)
{
    return is_pair_of(pair, ROLE_DST, ROLE_SRC) && !pair->b.is_micromap && !pair->b.is_instance;
}

static bool is_pair_with_micromap(const struct pair_view *pair)
{
    return is_pair_of(pair, ROLE_DST, ROLE_SRC) && pair->b.is_micromap &&
           pair->a.build != pair->b.build;
}

static bool is_pair_with_instance(const struct pair_view *pair)
{
    return is_pair_of(pair, ROLE_DST, ROLE_SRC) && pair->b.is_instance &&
           pair->a.build != pair->b.build;
}

static bool is_same_structure(const struct pair_view *pair)
{
    return pair->a.handle && pair->a.handle == pair->b.handle;
}

/* The ranges of builds of micromaps have no handles. */
static bool is_of_micromaps(const struct pair_view *pair)
{
    return pair->call->command >= BUILD_COMMAND_COUNT;
}

static const char *field_name(const struct pair_view *pair, enum range_role role)
{
    switch (role) {
    case ROLE_DST:
        return is_of_micromaps(pair) ? "dstMicromap" : "dstAccelerationStructure";
    case ROLE_SRC:
        return "srcAccelerationStructure";
    case ROLE_SCRATCH:
        break;
    }
    return "scratchData";
}

static struct value structure(VkAccelerationStructureKHR handle)
{
    return object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, handle_number(handle));
}

static bool is_same(const struct pair_view *pair, struct finding *finding)
{
    return violated(finding, field_name(pair, pair->a.role), "{} is also {}",
                    structure(pair->a.handle),
                    field_of(pair->b.build, field_name(pair, pair->b.role)));
}

/* Both ranges are scratch. */
static bool shares_host_memory(const struct pair_view *pair, struct finding *finding)
{
    return violated(finding, "scratchData", "shares host memory [{}, {}) with {}",
                    hex(pair->shared.begin), hex(pair->shared.end),
                    field_of(pair->b.build, "scratchData"));
}

static bool shares(const struct pair_view *pair, struct finding *finding)
{
    if (pair->shared.memory == memory_of_host())
        return shares_host_memory(pair, finding);
    struct value memory = object(VK_OBJECT_TYPE_DEVICE_MEMORY, handle_number(pair->shared.memory));
    if (pair->a.role == ROLE_SCRATCH || is_of_micromaps(pair))
        return violated(finding, field_name(pair, pair->a.role),
                        "shares bytes [{}, {}) of {} with {}", hex(pair->shared.begin),
                        hex(pair->shared.end), memory,
                        field_of(pair->b.build, field_name(pair, pair->b.role)));
    return violated(finding, field_name(pair, pair->a.role),
                    "{} shares bytes [{}, {}) of {} with {}", structure(pair->a.handle),
                    hex(pair->shared.begin), hex(pair->shared.end), memory,
                    field_of(pair->b.build, field_name(pair, pair->b.role)));
}

/* ---- An update in place has one structure as its dst and as its src. What is wrong with the dst
 * is wrong with the src: the message about the dst names the id about the src. */

static bool either_is_in_place(const struct pair_view *pair)
{
    return pair->a.is_in_place || pair->b.is_in_place;
}

static bool names_rule_of_src(const struct pair_view *pair, struct finding *finding, enum rule rule)
{
    return either_is_in_place(pair) && also_violates(finding, rule);
}

/* `pair` is of a src; `rule` is the one about the dst. */
static bool is_named_with_dst(bool is_in_place, struct finding *finding, enum rule rule)
{
    return is_in_place && is_reported_with(finding, rule);
}

bool no_dst_is_built_twice(const struct pair_view *pair, struct finding *finding)
{
    return !is_pair_of(pair, ROLE_DST, ROLE_DST) || pair->a.build == pair->b.build ||
           !is_same_structure(pair) || is_same(pair, finding) ||
           names_rule_of_src(pair, finding, RULE_no_src_is_the_dst_of_another_build);
}

bool no_src_is_the_dst_of_another_build(const struct pair_view *pair, struct finding *finding)
{
    return !is_pair_of_update(pair) || pair->a.build == pair->b.build || !is_same_structure(pair) ||
           is_same(pair, finding) ||
           is_named_with_dst(pair->b.is_in_place, finding, RULE_no_dst_is_built_twice);
}

bool update_src_and_dst_do_not_alias(const struct pair_view *pair, struct finding *finding)
{
    return !is_pair_of_update(pair) || pair->a.build != pair->b.build || !pair->shares_memory ||
           shares(pair, finding);
}

bool dst_and_update_src_are_apart(const struct pair_view *pair, struct finding *finding)
{
    return !is_pair_of_update(pair) || pair->a.build == pair->b.build || !pair->shares_memory ||
           shares(pair, finding) ||
           is_named_with_dst(pair->b.is_in_place, finding, RULE_dst_and_dst_are_apart);
}

bool dst_and_dst_are_apart(const struct pair_view *pair, struct finding *finding)
{
    return !is_pair_of(pair, ROLE_DST, ROLE_DST) || !pair->shares_memory || shares(pair, finding) ||
           names_rule_of_src(pair, finding, RULE_dst_and_update_src_are_apart);
}

bool dst_and_scratch_are_apart(const struct pair_view *pair, struct finding *finding)
{
    return !is_pair_of(pair, ROLE_DST, ROLE_SCRATCH) || !pair->shares_memory ||
           shares(pair, finding) ||
           (pair->a.is_in_place && also_violates(finding, RULE_scratch_and_update_src_are_apart));
}

bool scratch_and_scratch_are_apart(const struct pair_view *pair, struct finding *finding)
{
    return !is_pair_of(pair, ROLE_SCRATCH, ROLE_SCRATCH) || !pair->shares_memory ||
           shares(pair, finding);
}

bool scratch_and_update_src_are_apart(const struct pair_view *pair, struct finding *finding)
{
    return !is_pair_of(pair, ROLE_SRC, ROLE_SCRATCH) || pair->a.is_micromap ||
           pair->a.is_instance || !pair->shares_memory || shares(pair, finding) ||
           is_named_with_dst(pair->a.is_in_place, finding, RULE_dst_and_scratch_are_apart);
}

bool no_dst_is_a_micromap_of_another_build(const struct pair_view *pair, struct finding *finding)
{
    return !is_pair_with_micromap(pair) || !is_same_structure(pair) ||
           violated(finding, field_name(pair, ROLE_DST), "{} is a micromap that {} uses",
                    structure(pair->a.handle), field_of(pair->b.build, ""));
}

bool dst_and_micromaps_of_other_builds_are_apart(const struct pair_view *pair,
                                                 struct finding *finding)
{
    return !is_pair_with_micromap(pair) || !pair->shares_memory ||
           violated(finding, field_name(pair, ROLE_DST),
                    "{} shares memory of {} with micromap {} of {}", structure(pair->a.handle),
                    object(VK_OBJECT_TYPE_DEVICE_MEMORY, handle_number(pair->shared.memory)),
                    structure(pair->b.handle), field_of(pair->b.build, ""));
}

bool no_dst_is_an_instance_of_another_build(const struct pair_view *pair, struct finding *finding)
{
    return !is_pair_with_instance(pair) || !is_same_structure(pair) ||
           violated(finding, field_name(pair, ROLE_DST),
                    "{} is the structure that an instance of {} refers to",
                    structure(pair->a.handle), field_of(pair->b.build, ""));
}

bool dst_and_instances_of_other_builds_are_apart(const struct pair_view *pair,
                                                 struct finding *finding)
{
    return !is_pair_with_instance(pair) || !pair->shares_memory ||
           violated(finding, field_name(pair, ROLE_DST),
                    "{} shares memory of {} with {}, which an instance of {} refers to",
                    structure(pair->a.handle),
                    object(VK_OBJECT_TYPE_DEVICE_MEMORY, handle_number(pair->shared.memory)),
                    structure(pair->b.handle), field_of(pair->b.build, ""));
}
