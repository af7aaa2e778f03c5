/* SPDX-License-Identifier: Apache-2.0 */
/* A ray-tracing application that copes with a lack of memory: what it asks for and does not get it
 * asks for again. It builds much that is valid, and then makes one mistake or other. */
#ifndef SCARCE_APPLICATION_H
#define SCARCE_APPLICATION_H

#include <stdbool.h>
#include <stddef.h>

/* What its messenger heard, and what went wrong. */
extern struct outcome {
    bool is_creating_instance;
    unsigned expected; /* messages about mistakes, */
    unsigned mistakes; /* of so many */
    char wrong[4096];  /* a message that should not have been, or what failed; "": all is well */
} outcome;

/* Lives once, from vkCreateInstance to vkDestroyInstance. */
void application_live(void);

#endif
