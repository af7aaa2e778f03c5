/* SPDX-License-Identifier: Apache-2.0 */
/* Advice about what becomes of a structure. Each predicate is silent about a structure whose use it
 * cannot follow: a clone may be compacted or updated in its place. */
#include "src/advice/rules.h"

static uint32_t count(const struct use_view *use, enum structure_use kind)
{
    return use->uses->counts[kind];
}

/* Whether builds alone have written it, and it stayed for long. */
static bool is_kept(const struct use_view *use)
{
    return count(use, USE_BUILT) && !count(use, USE_FILLED) && !count(use, USE_COPIED) &&
           use->lived >= use->limits->of[ADVICE_LIMIT_submissions];
}

static bool allows(const struct use_view *use, VkBuildAccelerationStructureFlagBitsKHR flag)
{
    return use->uses->flags & flag;
}

/* Whether `smaller` bytes instead of `size` save more than the limit. */
static bool is_worth_it(const struct use_view *use, VkDeviceSize size, VkDeviceSize smaller)
{
    const double percent = use->limits->of[ADVICE_LIMIT_percent];
    return smaller < size && (double)(size - smaller) * 100 > (double)size * percent;
}

/* Whether the structure was built once and never updated. */
static bool is_static(const struct use_view *use)
{
    return is_kept(use) && count(use, USE_BUILT) == 1 && !count(use, USE_UPDATED);
}

/* ---- memory */

bool structure_is_destroyed_before_its_device(const struct use_view *use, struct finding *finding,
                                              uint64_t *weight)
{
    *weight = use->accel->size;
    return !use->is_left || violated(finding, "", "of {} is alive at vkDestroyDevice",
                                     count_of(use->accel->size, "byte"));
}

bool created_structure_is_built(const struct use_view *use, struct finding *finding,
                                uint64_t *weight)
{
    *weight = use->accel->size;
    if (!use->is_old || count(use, USE_BUILT) || count(use, USE_UPDATED) || count(use, USE_FILLED))
        return true;
    return violated(finding, "", "of {} was never built or copied to during {} or more",
                    count_of(use->accel->size, "byte"),
                    count_of(use->limits->of[ADVICE_LIMIT_submissions], "submission"));
}

/* An update or a compacted copy of it may be used in its place. */
bool built_structure_is_referred_to(const struct use_view *use, struct finding *finding,
                                    uint64_t *weight)
{
    *weight = use->accel->size;
    if (!use->references_are_known ||
        use->accel->type != VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR || !is_kept(use) ||
        count(use, USE_UPDATED) || count(use, USE_UPDATE_SOURCE) || count(use, USE_COMPACTED) ||
        count(use, USE_REFERRED_TO))
        return true;
    return violated(finding, "",
                    "of {} was built {}, and no instance of a top-level structure referred to it "
                    "while it was kept for {}",
                    count_of(use->accel->size, "byte"), count_of(count(use, USE_BUILT), "time"),
                    count_of(use->lived, "submission"));
}

/* A structure that is built again may need its size for a later build. */
bool structure_has_the_size_of_its_build(const struct use_view *use, struct finding *finding,
                                         uint64_t *weight)
{
    const VkDeviceSize size = use->accel->size, needed = use->uses->needed_size;
    if (!is_static(use) || !needed || !is_worth_it(use, size, needed) ||
        size - needed < use->limits->of[ADVICE_LIMIT_bytes])
        return true;
    *weight = size - needed;
    return violated(finding, "", "was created with {}, and its only build needs {}",
                    count_of(size, "byte"), count_of(needed, "byte"));
}

/* ---- compaction */

bool allowed_compaction_is_used(const struct use_view *use, struct finding *finding,
                                uint64_t *weight)
{
    const bool is_queried = count(use, USE_SIZE_QUERIED);
    if (!is_static(use) || !allows(use, VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR) ||
        (is_queried && (use->size_may_be_unknown || use->uses->compacted_size)) ||
        count(use, USE_COMPACTED))
        return true;
    *weight = use->accel->size;
    return violated(finding, "",
                    is_queried ? "of {} was built once with ALLOW_COMPACTION, and its compacted "
                                 "size was queried and not read. It was never compacted, though it "
                                 "was kept for {}"
                               : "of {} was built once with ALLOW_COMPACTION and never compacted, "
                                 "though it was kept for {}",
                    count_of(use->accel->size, "byte"), count_of(use->lived, "submission"));
}

bool compaction_size_is_used(const struct use_view *use, struct finding *finding, uint64_t *weight)
{
    const VkDeviceSize size = use->accel->size, compacted = use->uses->compacted_size;
    if (!is_static(use) || count(use, USE_COMPACTED) || !compacted ||
        !is_worth_it(use, size, compacted))
        return true;
    *weight = size - compacted;
    return violated(finding, "",
                    "of {} has a compacted size of {}, which the application has read, and was "
                    "never compacted, though it was kept for {}",
                    count_of(size, "byte"), count_of(compacted, "byte"),
                    count_of(use->lived, "submission"));
}

/* ---- contents */

/* An application may build an empty structure before there is anything to put in it: silent once a
 * build had something, or was not read. */
bool structure_can_be_hit(const struct use_view *use, struct finding *finding, uint64_t *weight)
{
    const struct structure_contents *contents = &use->uses->contents;
    const uint32_t builds = count(use, USE_BUILT) + count(use, USE_UPDATED);
    *weight = use->accel->size;
    if (!builds || use->uses->hollow_builds != builds || count(use, USE_FILLED))
        return true;
    return !contents->primitives
               ? violated(finding, "", "was built {}, always from nothing: no ray can hit it",
                          count_of(builds, "time"))
               : violated(
                     finding, "",
                     "was built {}, and no ray can hit it: of the {} of its last build, {} are "
                     "inactive, and the others {}",
                     count_of(builds, "time"), count_of(contents->primitives, "primitive"),
                     number(contents->inactive),
                     phrase(contents->is_top ? "have mask 0" : "are degenerate"));
}

enum { COMPARED_MIN = 2 }; /* builds of which none had another input than the one before */

static uint32_t builds_of(const struct use_view *use)
{
    return count(use, USE_BUILT) + count(use, USE_UPDATED);
}

/* A build restores what other writes have overwritten. Input that rests for a while is no waste if
 * it changes as long. */
static bool repeats_its_input(const struct use_view *use)
{
    const struct input_repeats *repeats = &use->uses->repeats;
    const uint32_t builds = builds_of(use), same = builds - repeats->since + 1;
    return builds == use->uses->read_builds && use->uses->hollow_builds != builds &&
           !count(use, USE_FILLED) && !repeats->is_shared && repeats->equal_ones >= COMPARED_MIN &&
           same >= use->limits->of[ADVICE_LIMIT_builds] && (uint64_t)2 * same >= builds;
}

bool structure_is_built_from_new_input(const struct use_view *use, struct finding *finding,
                                       uint64_t *weight)
{
    const struct input_repeats *repeats = &use->uses->repeats;
    const uint32_t same = builds_of(use) - repeats->since + 1;
    *weight = same;
    return !repeats_its_input(use) ||
           violated(
               finding, "",
               "was built {} and updated {}. The last {} {} seem to have read the same input: the "
               "layer compared {} of them with the one before, and bytes and parameters were the "
               "same",
               count_of(count(use, USE_BUILT), "time"), count_of(count(use, USE_UPDATED), "time"),
               number(same), phrase(count(use, USE_UPDATED) ? "builds and updates" : "builds"),
               number(repeats->equal_ones));
}

/* ---- flags */

static bool is_rebuilt(const struct use_view *use)
{
    const uint32_t builds = count(use, USE_BUILT);
    return builds >= use->limits->of[ADVICE_LIMIT_builds] && (uint64_t)4 * builds > use->lived &&
           !repeats_its_input(use);
}

/* Top-level structures are better built for tracing, even each frame. */
bool rebuilt_structure_is_not_built_for_tracing(const struct use_view *use, struct finding *finding,
                                                uint64_t *weight)
{
    if (!is_rebuilt(use) || use->accel->type != VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR ||
        !allows(use, VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR) ||
        count(use, USE_UPDATED) || count(use, USE_FILLED) || count(use, USE_COPIED) ||
        count(use, USE_COMPACTED))
        return true;
    *weight = count(use, USE_BUILT);
    return violated(
        finding, "", "was built {} in {}, each time with PREFER_FAST_TRACE, and never updated",
        count_of(count(use, USE_BUILT), "time"), count_of((uint64_t)use->lived + 1, "submission"));
}

/* Whether one copy alone has written it, of what was built in haste, and it stayed for long. */
static bool is_kept_copy(const struct use_view *use)
{
    return use->uses->is_hasty_copy && !count(use, USE_BUILT) && !count(use, USE_UPDATED) &&
           count(use, USE_FILLED) == 1 && !count(use, USE_COPIED) && !count(use, USE_COMPACTED) &&
           !count(use, USE_UPDATE_SOURCE) &&
           use->lived >= use->limits->of[ADVICE_LIMIT_submissions];
}

bool kept_structure_is_not_built_in_haste(const struct use_view *use, struct finding *finding,
                                          uint64_t *weight)
{
    *weight = use->lived;
    if (is_kept_copy(use))
        return violated(finding, "",
                        "is a copy of a structure that was built once with PREFER_FAST_BUILD, and "
                        "was kept for {}",
                        count_of(use->lived, "submission"));
    if (!is_static(use) || count(use, USE_COMPACTED) ||
        !allows(use, VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR))
        return true;
    return violated(finding, "", "was built once with PREFER_FAST_BUILD and kept for {}",
                    count_of(use->lived, "submission"));
}

bool allowed_updates_are_made(const struct use_view *use, struct finding *finding, uint64_t *weight)
{
    if (!is_kept(use) || count(use, USE_UPDATE_SOURCE) || count(use, USE_UPDATED) ||
        count(use, USE_COMPACTED) ||
        !allows(use, VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR))
        return true;
    *weight = count(use, USE_BUILT);
    return violated(finding, "",
                    "was built {} with ALLOW_UPDATE and never updated, though it was kept for {}",
                    count_of(count(use, USE_BUILT), "time"), count_of(use->lived, "submission"));
}

/* ---- all structures */

bool builds_share_calls(const struct crowd_view *crowd, struct finding *finding, uint64_t *weight)
{
    *weight = crowd->single_calls;
    return !crowd->single_calls || crowd->single_calls < crowd->limits->of[ADVICE_LIMIT_calls] ||
           violated(finding, "",
                    "executed {} of vkCmdBuildAccelerationStructuresKHR in a row with one build "
                    "each. No build needs another one of them, and between them its command buffer "
                    "has nothing but barriers from builds to builds",
                    count_of(crowd->single_calls, "call"));
}

bool few_structures_are_small(const struct crowd_view *crowd, struct finding *finding,
                              uint64_t *weight)
{
    *weight = crowd->tiny;
    return !crowd->tiny || crowd->tiny < crowd->limits->of[ADVICE_LIMIT_structures] ||
           violated(finding, "", "had {} of at most {} at a time",
                    count_of(crowd->tiny, "bottom-level structure"),
                    count_of(crowd->limits->of[ADVICE_LIMIT_few_primitives], "primitive"));
}

/* ---- updates */

bool updates_suit_the_tree(const struct tree_view *tree, struct finding *finding, uint64_t *weight)
{
    *weight = tree->triangles;
    return !tree->refit_cost || tree->refit_cost < tree->limits->of[ADVICE_LIMIT_refit_times] ||
           violated(finding, "",
                    "was updated with pGeometries[{}], whose triangles have moved so far since the "
                    "last build that its tree costs rays {} times as much as a new one. The layer "
                    "has computed that with trees of its own over a sample of the triangles",
                    number(tree->geometry), real(tree->refit_cost));
}

bool top_level_is_newer_than_its_bottom_levels(const struct traced_view *traced,
                                               struct finding *finding, uint64_t *weight)
{
    *weight = 1;
    return !traced->changed ||
           violated(
               finding, "",
               "was traced though {}, to which an instance of it refers, was built, updated or "
               "copied to since its last build",
               object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, traced->changed));
}

/* ---- all rows */

/* In a function about `view`: judges it if the row is about such a view. */
#define ADVICE_IF_ABOUT_VIEW(subject, name)                                                          \
    {                                                                                                \
        const struct subject##_view *const subject =                                               \
            _Generic(view, const struct subject##_view *: view, default: NULL); \
        struct finding finding;                                                                      \
        uint64_t weight;                                                                             \
        if (subject && !name(subject, &finding, &weight))                                            \
            found(user, ADVICE_##name, &finding, weight);                                            \
    }

void advice_judge_use(const struct use_view *view, advice_found *found, void *user)
{
#define ADVICE(subject, name, kind, id, hint) ADVICE_IF_ABOUT_VIEW(subject, name)
#include "vuid-tables/advice.def"
}

void advice_judge_crowd(const struct crowd_view *view, advice_found *found, void *user)
{
#define ADVICE(subject, name, kind, id, hint) ADVICE_IF_ABOUT_VIEW(subject, name)
#include "vuid-tables/advice.def"
}

void advice_judge_mesh(const struct mesh_view *view, advice_found *found, void *user)
{
#define ADVICE(subject, name, kind, id, hint) ADVICE_IF_ABOUT_VIEW(subject, name)
#include "vuid-tables/advice.def"
}

void advice_judge_placing(const struct placing_view *view, advice_found *found, void *user)
{
#define ADVICE(subject, name, kind, id, hint) ADVICE_IF_ABOUT_VIEW(subject, name)
#include "vuid-tables/advice.def"
}
