/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests of the loader share: the platform that the program's argument names, or the null
 * driver's; a call to report. */
#ifndef LOADER_TEST_H
#define LOADER_TEST_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/fixture/make.h"
#include "tests/fixture/messenger.h"
#include "tests/fixture/objects.h"
#include "tests/player/scene/scene.h"
#include "tests/unit/unit_test.h"

#define LENGTH(array) (sizeof(array) / sizeof((array)[0]))

extern struct platform platform;

/* A command that needs no instance, or needs no device: GLOBAL(CreateInstance)(...). */
#define GLOBAL(name) COMMAND_OF(VK_NULL_HANDLE, name)
#define COMMAND_OF(instance, name)                                                                 \
    ((PFN_vk##name)platform.get_instance_proc_addr(instance, "vk" #name))

/* A program may define it. It is called before the tests, when the platform is open; it returns
 * NULL, or the reason why all tests are skipped. */
__attribute__((weak)) const char *loader_test_open(void);

/* Whether the loader finds a layer in VK_LAYER_PATH, which becomes `folder`. */
bool layer_is_installed(const char *name, const char *folder);

/* Enables this layer and another one by the environment. Loaders order them by the variable that
 * enables them, or by the folders in which they find them: the nearest to the application is first.
 */
void enable_beside(const char *other, const char *folder, bool is_above);

/* Makes a valid call, of which nothing may be reported, and one with a mistake. Returns the number
 * of messages of the latter; if it is 1, the message is that of the mistake. */
uint32_t count_findings(const struct setup *setup);

#endif
