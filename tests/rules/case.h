/* SPDX-License-Identifier: Apache-2.0 */
/* Cases as data: a mutation of the valid call, the rules that it must break, and a twin, the
 * near-miss that must stay silent. */
#ifndef RULES_CASE_H
#define RULES_CASE_H

#include "scene.h"

/* One assignment to a member of struct scene, just before the call. */
struct edit {
    size_t offset;
    size_t size; /* 0 ends a list */
    bool adds;   /* to what is there */
    uint64_t value;
};

#define EDIT_MEMBER(member) offsetof(struct scene, member), sizeof(((struct scene *)0)->member)
#define SET(member, value)                                                                         \
    {                                                                                              \
        EDIT_MEMBER(member), false, (uint64_t)(value)                                              \
    }
#define ADD(member, value)                                                                         \
    {                                                                                              \
        EDIT_MEMBER(member), true, (uint64_t)(value)                                               \
    }
#define EDITS(...) ((const struct edit[]){__VA_ARGS__, {0, 0, false, 0}})

#define TRIANGLES(build, index) geometries[build][index].geometry.triangles
#define BOXES(build, index) geometries[build][index].geometry.aabbs
#define INSTANCES(build, index) geometries[build][index].geometry.instances

#define RULES(...)                                                                                 \
    .rules = (const enum rule[]){__VA_ARGS__},                                                     \
    .rule_count = sizeof((const enum rule[]){__VA_ARGS__}) / sizeof(enum rule)

/* Commands that a case is made for; 0: all that have the ids of its rules; NV's only for rules of
 * its own subjects and of the call as a whole: it does not take the structures of the others. */
enum command_mask {
    ON_DEVICE = 1 << COMMAND_DEVICE,
    ON_INDIRECT = 1 << COMMAND_INDIRECT,
    ON_HOST = 1 << COMMAND_HOST,
    ON_NV = 1 << COMMAND_NV,
    ON_COMMAND_BUFFERS = ON_DEVICE | ON_INDIRECT,
    ON_WITH_RANGES = ON_DEVICE | ON_HOST,
};

/* A command that takes no build of a kind at all. */
struct refusal {
    enum build_command command;
    enum rule rule;
};
extern const struct refusal indirect_takes_no_micromap, host_takes_no_dense_geometry;

struct test_case {
    const char *name;
    const enum rule *rules;
    uint32_t rule_count;
    bool silent; /* the mutation is valid: it shows that the rules stay silent */

    /* Makes the call one that the case is about, and valid: before the mutation and the twin. For
     * content_test alone. */
    void (*prepare)(struct scene *scene);
    /* The mutation: the function first, then the edits. */
    void (*mutate)(struct scene *scene);
    const struct edit *edits;
    /* The near-miss, likewise. Without any, the unmutated call is the twin. */
    void (*mutate_twin)(struct scene *scene);
    const struct edit *twin_edits;

    /* What is done after the mutated call, and after the twin: what breaks the rule when it is
     * submitted wants `forwards`. */
    void (*then)(struct scene *scene);
    void (*twin_then)(struct scene *scene);

    uint32_t commands; /* enum command_mask */
    /* Where the case is played, too: there it breaks that rule beside its own, and the unmutated
     * call is the twin. NULL: nowhere. */
    const struct refusal *refusal;
    const struct setup *setup;
    const struct setup *twin_setup; /* where the setup itself is what breaks the rule */
    bool needs_null_driver;
    bool spares_drivers; /* of what it does no driver need be proof, as the null driver and backend
                            cpu are */
    /* The twin, or the mutation of a silent case, breaks no rule that there is, but may lead to
     * what backend cpu can't build from: then the host's call fails. */
    bool may_fail_on_cpu;
    bool keep_arrays;   /* not to be repeated with ppGeometries */
    bool forwards;      /* the callback lets the call pass; null driver only */
    bool below_content; /* what the data says is wrong, too, and the case isn't about that */
    bool submits;       /* what is recorded is judged when it is submitted */
    /* For content_test, which plays the cases of level content by command buffers, too: */
    bool is_wild;         /* a driver that trusts the data reads where nothing is */
    bool has_pointers;    /* which a shader has to follow */
    bool is_for_the_call; /* its data is the host's, or parameters break rules, too */

    const char *path; /* that each message has to contain; "pGeometries[" fits ppGeometries too */
    uint32_t count;   /* messages of the first rule; 0: any number */
};

struct case_list {
    const char *name;
    const struct test_case *cases;
    size_t count;
};

#define CASE_LIST(name_, cases_)                                                                   \
    const struct case_list name_ = {#name_, (cases_), sizeof(cases_) / sizeof((cases_)[0])}

/* One a file. */
extern const struct case_list cases_host, cases_host_memory, cases_limits, cases_disabling,
    cases_call, cases_recording, cases_pointers, cases_build, cases_build_state, cases_scratch,
    cases_empty, cases_geometry, cases_chain, cases_address, cases_alignment, cases_range,
    cases_indirect, cases_indirect_contents, cases_instance_addresses, cases_overlap, cases_memory,
    cases_pairs, cases_silent, cases_sparse, cases_two_mistakes, cases_update, cases_content,
    cases_content_update, cases_micromap_contents, cases_instances, cases_dense, cases_motion,
    cases_motion_instances, cases_spheres, cases_radii, cases_micromap, cases_micromap_data,
    cases_micromap_use, cases_micromap_state, cases_micromap_update, cases_displacement, cases_nv,
    cases_nv_contents, cases_nv_info, cases_nv_geometry, cases_nv_update;

/* A page that cannot be read. */
void *unreadable_page(void);
/* `size` bytes that end where an unreadable page begins, zeroed; kept to the end of the program. */
void *bytes_before_unreadable_page(size_t size);

#endif
