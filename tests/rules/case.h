/* SPDX-License-Identifier: Apache-2.0 */
/* Cases as data: a mutation of the valid call, the rules that it must break, and a twin, the
 * near-miss that must stay silent. */
#ifndef RULES_CASE_H
#define RULES_CASE_H

#include "scene.h"

/* One change of the scene, just before the call: mostly an assignment to a member of it. */
enum edit_kind {
    EDIT_END, /* of a list */
    EDIT_SET,
    EDIT_ADD,          /* to what is there */
    EDIT_COPY,         /* another member, of the same type */
    EDIT_POINT,        /* at another member */
    EDIT_MAKE_ADDRESS, /* what a function returns */
    EDIT_MAKE_STRUCTURE_WITH,
    EDIT_UNREADABLE, /* the pointer leads to an unreadable page */
    EDIT_DESTROY,    /* the object behind the handle */
    EDIT_CALL,       /* a function */
    EDIT_CALL_WITH,
    EDIT_CALL_WITH_SIZE,
    EDIT_CALL_FOR,
    EDIT_RECORD, /* by a function that takes the command buffer, too */
    EDIT_WRITE,  /* a number to what a buffer holds */
    EDIT_WRITE_FLOAT,
};

struct edit {
    enum edit_kind kind;
    size_t offset, size; /* of the member */
    uint64_t value;      /* or the offset of the other member, or the argument */
    uint32_t build;      /* or the offset in a buffer */
    union {
        float number;
        VkDeviceAddress (*make_address)(struct scene *scene);
        VkAccelerationStructureKHR (*make_structure_with)(struct scene *scene, uint32_t argument);
        void (*call)(struct scene *scene);
        void (*call_with)(struct scene *scene, uint32_t argument);
        void (*call_with_size)(struct scene *scene, VkDeviceSize argument);
        void (*call_for)(struct scene *scene, uint32_t build, VkDeviceSize argument);
        void (*record)(struct scene *scene, VkCommandBuffer command_buffer);
    };
};

#define EDIT(kind_, member, value_)                                                                \
    {                                                                                              \
        .kind = (kind_), .offset = offsetof(struct scene, member),                                 \
        .size = sizeof(((struct scene *)0)->member), .value = (uint64_t)(value_)                   \
    }
#define SET(member, value_) EDIT(EDIT_SET, member, value_)
#define ADD(member, value_) EDIT(EDIT_ADD, member, value_)
/* Compiles only if both members have as many bytes. */
#define COPY(member, other)                                                                        \
    EDIT(EDIT_COPY, member, offsetof(struct scene, other) / SAME_SIZE(member, other))
#define SAME_SIZE(member, other)                                                                   \
    (sizeof(((struct scene *)0)->member) == sizeof(((struct scene *)0)->other))
#define POINT(member, other) EDIT(EDIT_POINT, member, offsetof(struct scene, other))
#define MAKE(kind_, member_, member, function)                                                     \
    {                                                                                              \
        .kind = (kind_), .offset = offsetof(struct scene, member),                                 \
        .size = sizeof(((struct scene *)0)->member), .member_ = (function)                         \
    }
#define MAKE_ADDRESS(member, function) MAKE(EDIT_MAKE_ADDRESS, make_address, member, function)
/* The same of another handle. */
#define MAKE_HANDLE(member, function) MAKE_ADDRESS(member, function)
#define MAKE_STRUCTURE_WITH(member_, function, argument)                                           \
    {                                                                                              \
        .kind = EDIT_MAKE_STRUCTURE_WITH, .offset = offsetof(struct scene, member_),               \
        .size = sizeof(VkAccelerationStructureKHR), .value = (argument),                           \
        .make_structure_with = (function)                                                          \
    }
#define UNREADABLE(member) EDIT(EDIT_UNREADABLE, member, 0)
#define DESTROY(member) EDIT(EDIT_DESTROY, member, 0)
#define CALL(function)                                                                             \
    {                                                                                              \
        .kind = EDIT_CALL, .call = (function)                                                      \
    }
#define CALL_WITH(function, argument)                                                              \
    {                                                                                              \
        .kind = EDIT_CALL_WITH, .value = (argument), .call_with = (function)                       \
    }
#define CALL_WITH_SIZE(function, argument)                                                         \
    {                                                                                              \
        .kind = EDIT_CALL_WITH_SIZE, .value = (argument), .call_with_size = (function)             \
    }
#define CALL_FOR(function, build_, argument)                                                       \
    {                                                                                              \
        .kind = EDIT_CALL_FOR, .build = (build_), .value = (argument), .call_for = (function)      \
    }
#define RECORD(function)                                                                           \
    {                                                                                              \
        .kind = EDIT_RECORD, .record = (function)                                                  \
    }
/* Writes a number of a type, or a float, at an offset of what a buffer of the scene holds. */
#define WRITE(buffer, type, at, value_)                                                            \
    {                                                                                              \
        .kind = EDIT_WRITE, .offset = offsetof(struct scene, buffer), .size = sizeof(type),        \
        .value = (uint64_t)(value_), .build = (at)                                                 \
    }
#define WRITE_FLOAT(buffer, at, number_)                                                           \
    {                                                                                              \
        .kind = EDIT_WRITE_FLOAT, .offset = offsetof(struct scene, buffer), .build = (at),         \
        .number = (number_)                                                                        \
    }
/* The same to an instance in a buffer of them. */
#define WRITE_REFERENCE(buffer, index, value) WRITE(buffer, uint64_t, 64 * (index) + 56, value)
#define WRITE_FLAGS(buffer, index, value) WRITE(buffer, uint8_t, 64 * (index) + 55, value)
#define WRITE_MATRIX(buffer, index, row, column, value)                                            \
    WRITE_FLOAT(buffer, 64 * (index) + 16 * (row) + 4 * (column), value)

/* Makes the pointer lead to a copy of so many bytes that ends where an unreadable page begins. */
#define PUT_AT_EDGE(member, size) CALL_FOR(put_at_edge, offsetof(struct scene, member), size)

#define EDIT_LIST(...) ((const struct edit[]){__VA_ARGS__, {.kind = EDIT_END}})
#define PREPARE_EDITS(...) .prepare_edits = EDIT_LIST(__VA_ARGS__)
#define EDITS(...) .edits = EDIT_LIST(__VA_ARGS__)
#define TWIN_EDITS(...) .twin_edits = EDIT_LIST(__VA_ARGS__)
/* One edit of the mutation, and the same of the twin with the last argument in place of the one
 * before it. */
#define EITHER_SET(member, mistake, valid)                                                         \
    EDITS(SET(member, mistake)), TWIN_EDITS(SET(member, valid))
#define EITHER_ADD(member, mistake, valid)                                                         \
    EDITS(ADD(member, mistake)), TWIN_EDITS(ADD(member, valid))
#define EITHER_ADDRESS(member, mistake, valid)                                                     \
    EDITS(MAKE_ADDRESS(member, mistake)), TWIN_EDITS(MAKE_ADDRESS(member, valid))
#define EITHER_CALL(function, mistake, valid)                                                      \
    EDITS(CALL_WITH(function, mistake)), TWIN_EDITS(CALL_WITH(function, valid))
#define EITHER_CALL_SIZE(function, mistake, valid)                                                 \
    EDITS(CALL_WITH_SIZE(function, mistake)), TWIN_EDITS(CALL_WITH_SIZE(function, valid))
#define EITHER_CALL_FOR(function, build, mistake, valid)                                           \
    EDITS(CALL_FOR(function, build, mistake)), TWIN_EDITS(CALL_FOR(function, build, valid))

#define TRIANGLES(build, index) geometries[build][index].geometry.triangles
#define BOXES(build, index) geometries[build][index].geometry.aabbs
#define INSTANCES(build, index) geometries[build][index].geometry.instances

#define RULE(name_) RULES(RULE_##name_)
#define RULES(...)                                                                                 \
    .rules = (const enum rule[]){__VA_ARGS__},                                                     \
    .rule_count = sizeof((const enum rule[]){__VA_ARGS__}) / sizeof(enum rule)

/* Rules that the mistake violates, too: the message of the case's first rule names their ids. The
 * case is played again with that rule muted, and then each has a message. */
#define NAMES(...)                                                                                 \
    .names = (const enum rule[]){__VA_ARGS__},                                                     \
    .name_count = sizeof((const enum rule[]){__VA_ARGS__}) / sizeof(enum rule)

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

/* One row of a list: a case, or what the cases below it share. */
struct test_case {
    const char *name; /* NULL: the row holds what the cases below it share, up to the next such row.
                         A case that has a member itself does not inherit it. */
    const enum rule *rules;
    uint32_t rule_count;
    const enum rule *names;
    uint32_t name_count;
    bool silent; /* the mutation is valid: it shows that the rules stay silent */

    /* Makes the call one that the case is about, and valid: before the mutation and the twin. */
    void (*prepare)(struct scene *scene);
    const struct edit *prepare_edits; /* after the function */
    /* The mutation: the function first, then the edits. */
    void (*mutate)(struct scene *scene);
    const struct edit *edits;
    /* The near-miss, likewise. Without any, the prepared call is the twin. */
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
    bool is_for_contents; /* rules_test does not play it */

    const char *path; /* that each message has to contain; "pGeometries[" fits ppGeometries too */
    uint32_t count;   /* messages of the first rule; 0: any number */
};

#define SETUP(...)                                                                                 \
    .setup = &(const struct setup)                                                                 \
    {                                                                                              \
        __VA_ARGS__                                                                                \
    }
#define TWIN_SETUP(...)                                                                            \
    .twin_setup = &(const struct setup)                                                            \
    {                                                                                              \
        __VA_ARGS__                                                                                \
    }
#define CASE(name_, ...)                                                                           \
    {                                                                                              \
        .name = (name_), __VA_ARGS__                                                               \
    }
/* Ends what the row of this kind above shared. */
#define SHARED(...)                                                                                \
    {                                                                                              \
        __VA_ARGS__                                                                                \
    }

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

/* Reads a row of a list, with what it inherits. False if it holds what others share. */
bool case_read(const struct case_list *list, size_t row, struct test_case *test_case);

/* Each file defines one. */
#define LIST(name_) extern const struct case_list cases_##name_;
#include "lists_of_rules_test.def"
#define LIST(name_) extern const struct case_list cases_##name_;
#include "lists_of_content_test.def"

/* A page that cannot be read. */
void *unreadable_page(void);
/* `size` bytes that end where an unreadable page begins, zeroed; kept to the end of the program. */
void *bytes_before_unreadable_page(size_t size);
void put_at_edge(struct scene *scene, uint32_t offset_of_pointer, VkDeviceSize size);

#endif
