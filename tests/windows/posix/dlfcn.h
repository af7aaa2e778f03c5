/* SPDX-License-Identifier: Apache-2.0 */
/* Libraries. The name of Linux's Vulkan loader stands for the tests' loader. */
#ifndef ASSAY_TESTS_WINDOWS_DLFCN_H
#define ASSAY_TESTS_WINDOWS_DLFCN_H

enum { RTLD_NOW, RTLD_LOCAL = 0 };

void *dlopen(const char *path, int mode);
void *dlsym(void *library, const char *name);
int dlclose(void *library);

#endif
