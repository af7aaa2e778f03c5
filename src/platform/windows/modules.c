/* SPDX-License-Identifier: Apache-2.0 */
/* Finds modules in the list of Windows. */
#include "src/platform/modules.h"

#include "src/platform/call_instruction.h"
#include "src/platform/windows/text.h"

bool module_find(uintptr_t address, struct module_place *place)
{
    HMODULE module;
    wchar_t path[WIDE_PATH_SIZE];
    MEMORY_BASIC_INFORMATION code;
    if (!GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS |
                                GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                            (LPCWSTR)address, &module) ||
        !VirtualQuery((const void *)address, &code, sizeof(code)))
        return false;
    place->path[0] = '\0';
    if (GetModuleFileNameW(module, path, WIDE_PATH_SIZE) < WIDE_PATH_SIZE)
        text_from_wide(path, place->path, sizeof(place->path));
    place->offset = address - (uintptr_t)module;
    place->is_layer = GetProcAddress(module, "vkNegotiateLoaderLayerInterfaceVersion");
    place->is_vulkan = place->is_layer || GetProcAddress(module, "vkGetInstanceProcAddr");
    place->follows_call = !(code.Protect & (PAGE_EXECUTE_READ | PAGE_EXECUTE_READWRITE)) ||
                          follows_call(code.BaseAddress, (const unsigned char *)address);
    return true;
}
