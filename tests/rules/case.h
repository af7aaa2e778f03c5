/* SPDX-License-Identifier: Apache-2.0 */
/* Cases as data: a mutation of the valid call, the rules that it must break, and a twin, the
 * near-miss that must stay silent. They are written in *.cases (docs/contributing.md); cases.py
 * makes rows and functions of them, by these macros. */
#ifndef ASSAY_TESTS_RULES_CASE_H
#define ASSAY_TESTS_RULES_CASE_H

#include <string.h>

#include "tests/rules/scene/scene.h"

/* Members are set and added to as numbers, whatever their type. */
#define SET(member, value) case_set(&(member), sizeof(member), (uint64_t)(value))
#define ADD(member, value) case_add(&(member), sizeof(member), (uint64_t)(value))
/* Compiles only if both members have as many bytes. */
#define COPY(member, other)                                                                        \
    memmove(&(member), &(other), sizeof(member) / (sizeof(member) == sizeof(other)))
#define DESTROY(member) scene_destroy(scene, (uint64_t)(member))
/* Writes a value at an offset of what a buffer of the scene holds. */
#define WRITE(buffer, at, type, value)                                                             \
    memcpy((buffer).bytes + (at), &(type){(type)(value)}, sizeof(type))

static inline void case_set(void *member, size_t size, uint64_t value)
{
    memcpy(member, &value, size);
}

static inline void case_add(void *member, size_t size, uint64_t value)
{
    uint64_t sum = 0;
    memcpy(&sum, member, size);
    case_set(member, size, sum + value);
}

#define TRIANGLES(build, index) geometries[build][index].geometry.triangles
#define BOXES(build, index) geometries[build][index].geometry.aabbs
#define INSTANCES(build, index) geometries[build][index].geometry.instances

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
    const char *place; /* file, line and text; NULL: the case is in none of the .cases */
    const enum rule *rules;
    uint32_t rule_count;
    /* Rules that the mistake violates, too: the message of the first rule names their ids. The case
     * is played again with that rule muted, and then each has a message. */
    const enum rule *names;
    uint32_t name_count;
    bool silent; /* the mutation is valid: it shows that the rules stay silent */

    /* Makes the call one that the case is about, and valid: before the mutation and the twin. */
    void (*prepare)(struct scene *scene);
    void (*wrong)(struct scene *scene); /* the mutation */
    void (*right)(struct scene *scene); /* the twin. NULL: the prepared call is it */

    uint64_t commands; /* enum command_mask, or bits 1 << COMMAND_... */
    /* Where the case is played, too: there it breaks that rule beside its own, and the unmutated
     * call is the twin. NULL: nowhere. */
    const struct refusal *refusal;
    const struct setup *setup;
    const struct setup *right_setup; /* where the setup itself is what breaks the rule */
    bool needs_null_driver;
    bool needs_drivers_sizes; /* not played with setting limits = harsh */
    bool spares_drivers; /* of what it does no driver need be proof, as the null driver and backend
                            cpu are */
    /* The twin, or a mutation that no error is about, may lead to what backend cpu cannot execute:
     * then the host's call fails. */
    bool may_fail_on_cpu;
    bool keep_arrays;   /* not to be repeated with ppGeometries */
    bool forwards;      /* the callback lets the call pass; null driver only */
    bool below_content; /* what the data says is wrong, too, and the case isn't about that */
    /* For --submitted, which plays the cases of level content by command buffers, too: */
    bool is_wild;         /* a driver that trusts the data reads where nothing is */
    bool has_pointers;    /* which a shader has to follow */
    bool is_for_the_call; /* its data is the host's, or parameters break rules, too */
    bool is_for_contents; /* rules_test does not play it */

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

/* To configure the null driver: it has vertex formats that no driver has to have, of packed, 64-bit
 * and 8-bit components. */
void offer_packed_format(struct null_driver_config *config);

/* Each file defines one. */
#define LIST(name_) extern const struct case_list cases_##name_;
#include "tests/rules/lists_of_calls.def"
#define LIST(name_) extern const struct case_list cases_##name_;
#include "tests/rules/lists_of_submissions.def"

/* A page that cannot be read. */
void *unreadable_page(void);
/* `size` bytes that end where an unreadable page begins, zeroed; kept to the end of the program. */
void *bytes_before_unreadable_page(size_t size);
/* Makes the pointer lead to a copy of so many of its bytes that ends there. */
void put_at_edge(struct scene *scene, void *pointer, size_t size);

#endif
