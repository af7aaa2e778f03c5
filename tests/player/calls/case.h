/* SPDX-License-Identifier: Apache-2.0 */
/* Programs that edit one valid call (docs/contributing.md), as cases: the edits of the broken and
 * of the repaired program, and which rules the broken one violates. */
#ifndef ASSAY_TESTS_PLAYER_CALLS_CASE_H
#define ASSAY_TESTS_PLAYER_CALLS_CASE_H

#include <string.h>

#include "tests/player/program.h"
#include "tests/player/scene/placing.h"
#include "tests/player/tally.h"

/* ---- edits, which edits.py translates to C ---- */

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

/* What a line says behind `edit`, or behind `configure`, and the function that does it. */
struct call_edit {
    const char *text;
    void (*edit)(struct scene *scene);
    void (*configure)(struct null_driver_config *config);
    const char *path; /* what messages call the first member that it edits, or NULL */
};
struct call_edits {
    const char *group; /* the file of the lines */
    const struct call_edit *edits;
    size_t count;
};
#define EDITS(name) extern const struct call_edits call_edits_##name;
#include "all_edits.inc"
#undef EDITS

/* ---- cases ---- */

enum { CASE_RULES = 8, CASE_STEPS = 8 };

struct case_step {
    void (*edit)(struct scene *scene);
    bool is_changed; /* the other program lacks the line, or has another one */
};

/* What one of the two programs says. */
struct case_form {
    struct setup setup;
    struct case_step steps[CASE_STEPS];
    uint32_t step_count;
};

struct test_case {
    const struct source *source;
    unsigned variant;
    const char *name; /* of the program */
    enum rule rules[CASE_RULES];
    uint32_t rule_count;
    /* Rules that the mistake violates, too: the message of the first rule names their ids. The case
     * is played again with that rule muted, and then each has a message. */
    enum rule names[CASE_RULES];
    uint32_t name_count;
    bool silent;               /* there is one program, which is valid: the rules stay silent */
    struct case_form forms[2]; /* of the broken program, and of the repaired one */

    uint64_t commands; /* bits 1 << COMMAND_...; 0: all that have the ids of the rules */
    /* A command (such a bit) that takes no build of the case's kind: there the case breaks this
     * rule beside its own, and the unedited call is the twin. 0: none. */
    uint64_t refused;
    enum rule refusal;

    /* The lines of these names: */
    bool needs_drivers_sizes; /* setting limits = harsh cannot play it */
    bool spares_drivers;      /* it may crash any driver but the null driver and backend cpu */
    bool may_fail_on_cpu;   /* backend cpu may refuse the valid call: the host's call fails then */
    bool keep_arrays;       /* it is not repeated with ppGeometries */
    bool forwards;          /* the callback lets the call pass; null driver only */
    bool below_content;     /* its data is wrong, too, so level content cannot play it */
    bool needs_null_driver; /* line `only null` */
    /* For --submitted, which plays the cases of level content by command buffers: */
    bool is_wild;         /* a driver that trusts the data reads at invalid addresses */
    bool guard_protects;  /* setting guard keeps a driver from reading there */
    bool guard_warns;     /* setting guard adds warnings that belong to no rule */
    bool has_pointers;    /* a shader has to follow pointers of the data */
    bool is_for_the_call; /* --submitted does not play it */
    bool is_for_contents; /* only --submitted plays it */

    const char *path; /* that each message has to contain; "pGeometries[" fits ppGeometries too */
    uint32_t count;   /* messages of the first rule; 0: any number */
};

/* Whether the source is a program of a call: it is in folder calls. */
bool case_is_source(const struct source *source);
/* Reads the case of a source's variant, whose texts stay allocated. A mistake ends the process. */
void case_read(struct test_case *test_case, const struct source *source, unsigned variant);

/* Plays the programs of calls among the sources. `are_all`: no other is there, so that each id must
 * have fired and stayed silent (plan.c). */
void calls_play(const struct sources *sources, struct tally *tally, bool are_all);

/* To configure the null driver: it has vertex formats that no driver has to have, of packed, 64-bit
 * and 8-bit components. */
void offer_packed_format(struct null_driver_config *config);

#endif
