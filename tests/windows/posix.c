/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests use of POSIX, on Windows. */
#include <dlfcn.h>
#include <string.h>
#include <sys/mman.h>
#include <windows.h>

int setenv(const char *name, const char *value, int overwrite)
{
    return !overwrite && getenv(name) ? 0 : _putenv_s(name, value);
}

int unsetenv(const char *name)
{
    return _putenv_s(name, "");
}

long sysconf(int name)
{
    SYSTEM_INFO system;
    (void)name;
    GetSystemInfo(&system);
    return (long)system.dwPageSize;
}

char *mkdtemp(char *name)
{
    return _mktemp(name) && _mkdir(name) == 0 ? name : NULL;
}

/* Tests only pass such a descriptor on. */
int memfd_create(const char *name, unsigned flags)
{
    (void)name, (void)flags;
    return _dup(0);
}

/* malloc() aligns to 16 bytes, which is what tests ask for. */
void *aligned_alloc(size_t alignment, size_t size)
{
    return alignment <= 16 ? malloc(size) : NULL;
}

/* Here no linker wraps the functions that allocate (tests/CMakeLists.txt): MinGW-w64 allocates the
 * thread-local variables of the wrappers by these functions. */
void *__real_malloc(size_t size)
{
    return malloc(size);
}

void *__real_calloc(size_t count, size_t size)
{
    return calloc(count, size);
}

void *__real_realloc(void *old, size_t size)
{
    return realloc(old, size);
}

void *__real_aligned_alloc(size_t alignment, size_t size)
{
    return aligned_alloc(alignment, size);
}

char *__real_strdup(const char *text)
{
    return strdup(text);
}

void __real_free(void *block)
{
    free(block);
}

void *dlopen(const char *path, int mode)
{
    (void)mode;
    return (void *)LoadLibraryA(strcmp(path, "libvulkan.so.1") == 0 ? TEST_LOADER : path);
}

void *dlsym(void *library, const char *name)
{
    return (void *)GetProcAddress(library, name);
}

int dlclose(void *library)
{
    return !FreeLibrary(library);
}

static DWORD protection_of(int protection)
{
    return protection & PROT_WRITE ? PAGE_READWRITE : protection ? PAGE_READONLY : PAGE_NOACCESS;
}

void *mmap(void *at, size_t size, int protection, int flags, int file, long offset)
{
    (void)flags, (void)file, (void)offset;
    void *pages = VirtualAlloc(at, size, MEM_RESERVE | MEM_COMMIT, protection_of(protection));
    return pages ? pages : MAP_FAILED;
}

int mprotect(void *pages, size_t size, int protection)
{
    DWORD before;
    return VirtualProtect(pages, size, protection_of(protection), &before) ? 0 : -1;
}

/* A part of what mmap() returned becomes inaccessible and stays reserved. */
int munmap(void *pages, size_t size)
{
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    MEMORY_BASIC_INFORMATION region;
    size = (size + page - 1) / page * page;
    if (VirtualQuery(pages, &region, sizeof(region)) && region.AllocationBase == pages &&
        region.RegionSize <= size)
        return VirtualFree(pages, 0, MEM_RELEASE) ? 0 : -1;
    return VirtualFree(pages, size, MEM_DECOMMIT) ? 0 : -1;
}
