/* SPDX-License-Identifier: Apache-2.0 */
/* The buffers and acceleration structures that were destroyed last, by their device addresses, for
 * messages about an address that is no longer valid. Has its own lock. */
#ifndef ASSAY_STATE_RESOURCES_DESTROYED_H
#define ASSAY_STATE_RESOURCES_DESTROYED_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

enum { DESTROYED_MAX = 256, DESTROYED_NAME_SIZE = 64 };

struct destroyed_object {
    VkObjectType type;      /* VK_OBJECT_TYPE_BUFFER or VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR */
    uint64_t handle, id;    /* as resources_find_id() returned */
    uint64_t address, size; /* address 0: it had none */
    uint64_t submissions;   /* calls that had submitted work when it was destroyed */
    uint64_t number;        /* 1 for the first object that was added */
    bool is_reported;       /* it was in use when it was destroyed, as is reported */
    char name[DESTROYED_NAME_SIZE]; /* debug name; "" if it had none */
};

struct destroyed_objects;

VkResult destroyed_objects_create(struct destroyed_objects **destroyed);
void destroyed_objects_destroy(struct destroyed_objects *destroyed); /* accepts NULL */

/* Adds an object, whose `submissions` and `number` are set here; forgets the oldest if there are
 * too many. An object without an address is not added. Returns the number of the last object. */
uint64_t destroyed_objects_add(struct destroyed_objects *destroyed,
                               const struct destroyed_object *object);

/* Finds the object that had an address last: a structure, if `type` is that of structures, whose
 * address is exactly this one; else a buffer that contained it. Returns false if there is none. */
bool destroyed_objects_find(struct destroyed_objects *destroyed, VkObjectType type,
                            uint64_t address, struct destroyed_object *object);

/* Finds the structure that had an address last and marks it as reported. Returns false if it is
 * marked, was destroyed before `submissions` calls had submitted work, or has a number beyond
 * `last`. */
bool destroyed_objects_report(struct destroyed_objects *destroyed, uint64_t address,
                              uint64_t submissions, uint64_t last, struct destroyed_object *object);

/* Finds the object, of either type, whose range had an address last. */
bool destroyed_objects_find_range(struct destroyed_objects *destroyed, uint64_t address,
                                  struct destroyed_object *object);

/* Counts a call that submits work; and returns their number. The first accepts NULL. */
void destroyed_objects_count_submission(struct destroyed_objects *destroyed);
uint64_t destroyed_objects_submissions(const struct destroyed_objects *destroyed);

#endif
