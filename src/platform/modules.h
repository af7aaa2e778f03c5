/* SPDX-License-Identifier: Apache-2.0 */
/* The modules of the process: the program and its shared objects. */
#ifndef ASSAY_PLATFORM_MODULES_H
#define ASSAY_PLATFORM_MODULES_H

#include <stdbool.h>
#include <stdint.h>

enum { MODULE_PATH_SIZE = 4096 };

struct module_place {
    char path[MODULE_PATH_SIZE];
    /* The address as the module's own file has it, which is what addr2line takes: relative to where
     * the module was loaded or, for a program at a fixed address, the address itself. On Windows it
     * is relative to the image base. */
    uint64_t offset;
    bool is_vulkan;    /* the module is the Vulkan loader, or a layer */
    bool is_layer;     /* it is a layer */
    bool follows_call; /* the instruction before the address is a call */
};

/* Finds the module that has code at an address. Returns false if there is none. Allocates no
 * memory; takes the lock of the list of modules. */
bool module_find(uintptr_t address, struct module_place *place);

#endif
