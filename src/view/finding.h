/* SPDX-License-Identifier: Apache-2.0 */
/* The result of a predicate whose statement does not hold: the field, the value found and its
 * bound. A finding is plain data of fixed size: predicates neither allocate nor print. */
#ifndef ASSAY_VIEW_FINDING_H
#define ASSAY_VIEW_FINDING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/state/builds/built.h"
#include "vuid-tables/rules.h"

enum value_kind {
    VALUE_ADDRESS, /* a device address, shown like VALUE_HEX, which destroyed objects may have had
                    */
    VALUE_HEX,     /* an address or a bit pattern: 0x1010 */
    VALUE_FLAGS, /* a bit pattern with the names of its bits: 0x5 (ALLOW_UPDATE | PREFER_FAST_TRACE)
                  */
    VALUE_NUMBER,    /* a number without a noun: 256 */
    VALUE_COUNT,     /* a number with its noun: 1 byte, 2 bytes */
    VALUE_REAL,      /* a number with a fraction: 0.5 */
    VALUE_TEXT,      /* a string that outlives the report, such as an enumerant's spelling */
    VALUE_QUOTED,    /* a text from outside the layer, such as a path, cut to `number` bytes */
    VALUE_OBJECT,    /* a handle, shown with its type and debug name, and listed as an object */
    VALUE_DESTROYED, /* the handle of a destroyed object; another one may have it now */
    VALUE_FIELD,     /* a field of another build of the call: pInfos[build].text */
    VALUE_BUILT,     /* the command buffer or host call of an earlier build: see built_at() */
};

struct value {
    enum value_kind kind;
    uint32_t build;           /* VALUE_FIELD, VALUE_BUILT */
    VkObjectType object_type; /* VALUE_OBJECT, VALUE_DESTROYED; VALUE_ADDRESS: what should have it
                               */
    /* VALUE_ADDRESS, _HEX, _FLAGS, _NUMBER, _COUNT, _OBJECT, _DESTROYED, _BUILT */
    uint64_t number;
    union {
        const char
            *text;   /* VALUE_TEXT, VALUE_QUOTED, VALUE_FIELD; VALUE_COUNT: the noun's singular */
        double real; /* VALUE_REAL */
        uint64_t id; /* VALUE_DESTROYED: 0: the last object that had the handle; VALUE_BUILT: of
                      * the command buffer */
        /* VALUE_FLAGS: returns the name of a bit from after the prefix of its type on, such as
         * ALLOW_UPDATE_BIT_KHR, or NULL if it has none. */
        const char *(*name_of_bit)(uint64_t bit);
    };
};

enum { FINDING_VALUES = 6, FINDING_ALSO = 2, FINDING_REMARKS = 3, REMARK_VALUES = 5 };

/* A sentence behind the description of an error, which helps to find its cause. */
struct remark {
    const char *says; /* without its period; each {} stands for the next value */
    uint32_t value_count;
    struct value values[REMARK_VALUES];
};

struct finding {
    /* The field, relative to the subject, such as "scratchData.deviceAddress"; "" is the subject
     * itself. */
    const char *field;
    /* The description of the error, without its period; each {} stands for the next value. */
    const char *says;
    uint32_t value_count;
    struct value values[FINDING_VALUES];
    uint32_t remark_count;
    struct remark remarks[FINDING_REMARKS];
    /* An instance that the message shows as a whole. */
    bool has_instance;
    VkAccelerationStructureInstanceKHR instance;
    /* Other rules that the same mistake violates. The message names their ids. */
    uint32_t also_count;
    enum rule also[FINDING_ALSO];
    /* How many elements of the array violate the rule beside this one, and what they are: "more
     * instance". */
    uint64_t more;
    const char *element;
    /* The rule whose message names this one; if that rule is active, this finding is not reported.
     * RULE_COUNT: none. */
    enum rule reported_with;
};

static inline struct value hex(uint64_t number)
{
    return (struct value){.kind = VALUE_HEX, .number = number};
}

/* A device address at which no object of the type is: the message says which one was there. */
static inline struct value address_of_missing(VkObjectType type, uint64_t address)
{
    return (struct value){.kind = VALUE_ADDRESS, .object_type = type, .number = address};
}

static inline struct value number(uint64_t number)
{
    return (struct value){.kind = VALUE_NUMBER, .number = number};
}

/* `noun` is the singular, such as "byte". */
static inline struct value count_of(uint64_t number, const char *noun)
{
    return (struct value){.kind = VALUE_COUNT, .number = number, .text = noun};
}

static inline struct value real(double real)
{
    return (struct value){.kind = VALUE_REAL, .real = real};
}

static inline struct value phrase(const char *text)
{
    return (struct value){.kind = VALUE_TEXT, .text = text};
}

static inline struct value quoted(const char *text, size_t size)
{
    return (struct value){.kind = VALUE_QUOTED, .text = text, .number = size};
}

static inline struct value object(VkObjectType type, uint64_t handle)
{
    return (struct value){.kind = VALUE_OBJECT, .object_type = type, .number = handle};
}

/* `id`: as resources_find_id() returned while the object was alive; 0: the last object that had the
 * handle. */
static inline struct value destroyed_object(VkObjectType type, uint64_t handle, uint64_t id)
{
    return (struct value){.kind = VALUE_DESTROYED, .object_type = type, .number = handle, .id = id};
}

static inline struct value field_of(uint32_t build, const char *field)
{
    return (struct value){.kind = VALUE_FIELD, .build = build, .text = field};
}

/* Where a structure was built: in a command buffer, or by a call of the host. */
static inline struct value built_at(const struct built *built)
{
    return (struct value){.kind = VALUE_BUILT,
                          .number = handle_number(built->command_buffer),
                          .id = built->command_buffer_id,
                          .build = built->position};
}

/* The buffer of a structure that lies in no live memory, and why: a phrase that follows its name.
 */
struct holding_buffer {
    struct value value;
    const char *lacks;
};
static inline struct holding_buffer holding_buffer_of(VkBuffer handle, uint64_t id,
                                                      bool is_destroyed)
{
    const uint64_t number = handle_number(handle);
    if (is_destroyed)
        return (struct holding_buffer){destroyed_object(VK_OBJECT_TYPE_BUFFER, number, id),
                                       "which was destroyed"};
    return (struct holding_buffer){object(VK_OBJECT_TYPE_BUFFER, number),
                                   "which is not bound to memory, or whose memory was freed"};
}

__attribute__((cold)) bool finding_fill(struct finding *finding, const char *field,
                                        const char *says, const struct value *values,
                                        uint32_t value_count);

/* An array of values, and their count: two arguments. */
#define VALUES(...)                                                                                \
    (const struct value[]){__VA_ARGS__},                                                           \
        sizeof((const struct value[]){__VA_ARGS__}) / sizeof(struct value)

/* Fills a finding. Returns false. */
#define finding_says(finding, field, says, ...)                                                    \
    finding_fill((finding), (field), (says), VALUES(__VA_ARGS__))

/* A caller that needs only the result of a predicate passes no finding. */
static inline bool finding_is_wanted(const struct finding *finding)
{
    return finding != NULL;
}

/* Fills a finding if the caller passed one. Evaluates to false, so that a predicate can end with
 * `return violated(...)`. */
#define violated(finding, field, says, ...)                                                        \
    (finding_is_wanted(finding) && finding_says(finding, field, says, __VA_ARGS__))

/* As violated(), without values. */
static inline bool violated_plainly(struct finding *finding, const char *field, const char *says)
{
    return finding_is_wanted(finding) && finding_fill(finding, field, says, NULL, 0);
}

/* Adds a rule to `also`. Returns false, so that it can follow violated(): a || violated(...) ||
 * also_violates(...). */
static inline bool also_violates(struct finding *finding, enum rule rule)
{
    if (finding_is_wanted(finding) && finding->also_count < FINDING_ALSO)
        finding->also[finding->also_count++] = rule;
    return false;
}

/* Adds a remark, if there is room. Return false, too. */
__attribute__((cold)) bool finding_add_remark(struct finding *finding, const char *says,
                                              const struct value *values, uint32_t value_count);
#define remarks(finding, says, ...)                                                                \
    (finding_is_wanted(finding) && finding_add_remark((finding), (says), VALUES(__VA_ARGS__)))
static inline bool remarks_plainly(struct finding *finding, const char *says)
{
    return finding_is_wanted(finding) && finding_add_remark(finding, says, NULL, 0);
}

/* Lets the message show an instance. Returns false, too. */
static inline bool shows_instance(struct finding *finding,
                                  const VkAccelerationStructureInstanceKHR *instance)
{
    if (finding_is_wanted(finding)) {
        finding->has_instance = true;
        finding->instance = *instance;
    }
    return false;
}

/* Sets `reported_with`, and empties `also`. Returns false, too. */
static inline bool is_reported_with(struct finding *finding, enum rule rule)
{
    if (finding_is_wanted(finding)) {
        finding->reported_with = rule;
        finding->also_count = 0;
    }
    return false;
}

/* Fills the finding for a handle that is not a valid object of its type. `kind` is a phrase such as
 * "a buffer of this device". */
static inline bool violated_by_handle(struct finding *finding, const char *field,
                                      struct value handle, const char *kind)
{
    if (!finding_is_wanted(finding))
        return false;
    if (!handle.number)
        return finding_fill(finding, field, "is VK_NULL_HANDLE", NULL, 0);
    if (handle.kind == VALUE_OBJECT)
        handle = destroyed_object(handle.object_type, handle.number, 0);
    return finding_says(finding, field, "{} is not {}: it was destroyed or never created", handle,
                        phrase(kind));
}

#endif
