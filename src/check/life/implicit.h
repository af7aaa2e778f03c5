/* SPDX-License-Identifier: Apache-2.0 */
/* The types of the tables that vuid-tables/implicit_tables.py writes from vk.xml, and their checks.
 * One row says what the specification requires of one member, or parameter, in the same words for
 * all commands. */
#ifndef ASSAY_CHECK_LIFE_IMPLICIT_H
#define ASSAY_CHECK_LIFE_IMPLICIT_H

#include <stdbool.h>
#include <stdint.h>

enum implicit_kind {
    IMPLICIT_STYPE,  /* `value` */
    IMPLICIT_CHAIN,  /* each structure is one of `values` */
    IMPLICIT_UNIQUE, /* no two structures of a chain have one type */
    IMPLICIT_ENUM,   /* one of `values` */
    IMPLICIT_FLAGS,  /* bits of `values` */
    IMPLICIT_ZERO,
    IMPLICIT_LENGTH,  /* not 0 */
    IMPLICIT_POINTER, /* it is readable, as far as the call reads or writes there */
    IMPLICIT_HANDLE,  /* an object that exists */
    IMPLICIT_PARENT,  /* an object of this device */
    IMPLICIT_ADDRESS, /* a device address in a buffer */
    IMPLICIT_QUEUES,  /* the device has a queue */
};

struct implicit_scope;

/* An enumerant, a bit of flags, or the type of a chained structure. */
struct implicit_value {
    uint64_t value;
    uint64_t owners; /* see registry_owners[]: one of these is enabled; 0: always valid */
    const char *name;
    const struct implicit_scope *scope; /* of a chained structure that has ids; or NULL */
};

struct implicit_check {
    uint16_t rule; /* enum rule */
    uint8_t kind;  /* enum implicit_kind */
    uint8_t size;  /* of the member, bytes */
    uint16_t also; /* a rule that the same mistake violates, + 1; 0: none */
    /* A member of a union, which counts if the enumerant at an offset is one of these bits; 0: no
     * such member. */
    uint16_t selections, selector_at;
    uint16_t at; /* of the member in its structure, bytes */
    bool is_pointer;
    bool is_array;              /* of `count` elements, or as many as another member says */
    bool is_optional;           /* NULL, VK_NULL_HANDLE and 0 are valid */
    bool elements_are_optional; /* likewise for the elements of an array */
    bool counts_through;        /* that member is in the structure that a pointer leads to */
    uint8_t count_size;         /* 0: `count` elements */
    uint16_t count_at, pointer_at;
    uint32_t count;
    uint16_t element; /* of an array, bytes */
    uint16_t pointee; /* what each element points to, bytes; 0: the elements are no pointers */
    uint16_t value_count;
    const char *field, *parameter;
    const char *type;
    uint64_t value; /* VkStructureType or VkObjectType */
    const struct implicit_value *values;
};

/* A parameter, or a member of a union, that leads to structures with ids. */
struct implicit_visit {
    const char *parameter;
    uint16_t at;
    uint16_t selections, selector_at; /* as in struct implicit_check */
    const struct implicit_scope *scope;
    bool is_array;
    uint16_t count_at;
};

/* A structure, or the arguments of a command. */
struct implicit_scope {
    uint32_t size;
    const struct implicit_check *checks;
    uint32_t check_count;
    const struct implicit_visit *visits;
    uint32_t visit_count;
};

/* A structure that the device reads. */
struct implicit_read {
    const char *name;
    const struct implicit_scope *scope;
};

#endif
