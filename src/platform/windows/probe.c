/* SPDX-License-Identifier: Apache-2.0 */
/* Probes memory: VirtualQuery never touches it, so that a guard page stays one. */
#include "src/platform/probe.h"

#include <windows.h>

static const uintptr_t page_size = (uintptr_t)1 << PROBE_PAGE_SHIFT;

enum {
    WRITABLE = PAGE_READWRITE | PAGE_WRITECOPY | PAGE_EXECUTE_READWRITE | PAGE_EXECUTE_WRITECOPY,
    READABLE = WRITABLE | PAGE_READONLY | PAGE_EXECUTE_READ
};

static bool allows(const void *address, DWORD protections)
{
    MEMORY_BASIC_INFORMATION region;
    return VirtualQuery(address, &region, sizeof(region)) != 0 && region.State == MEM_COMMIT &&
           region.Protect & protections && !(region.Protect & PAGE_GUARD);
}

bool probe_page(uintptr_t end)
{
    return allows((const void *)(end - 1), READABLE);
}

/* ReadProcessMemory alone would end guards. VirtualQuery alone would let another thread free the
 * page before the copy. */
static bool copy_from_page(void *to, const void *from, size_t size)
{
    SIZE_T copied;
    return allows(from, READABLE) &&
           ReadProcessMemory(GetCurrentProcess(), from, to, size, &copied);
}

size_t probe_copy(void *to, const void *from, size_t size)
{
    size_t first = page_size - ((uintptr_t)from & (page_size - 1));
    if (first > size)
        first = size;
    if (!copy_from_page(to, from, first))
        return 0;
    bool copies_all = first == size ||
                      copy_from_page((char *)to + first, (const char *)from + first, size - first);
    return copies_all ? size : first;
}

bool probe_writable(char *const bytes[], unsigned count)
{
    for (unsigned i = 0; i < count; i++)
        if (!allows(bytes[i], WRITABLE))
            return false;
    return true;
}
