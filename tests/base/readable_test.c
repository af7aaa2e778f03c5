/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the probe of application memory. */
#define _GNU_SOURCE /* MAP_ANONYMOUS */
#include <errno.h>
#include <signal.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#ifdef __linux__
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#endif
#ifdef _WIN32
#include <windows.h>
#endif

#include "src/base/readable.h"
#include "src/snapshots/memory.h"
#include "tests/unit/property.h"

enum { PAGES = 64 };

static size_t page_size;

/* Pages that may be taken away one by one. */
static char *map_pages(void)
{
    page_size = (size_t)sysconf(_SC_PAGESIZE);
    char *pages =
        mmap(NULL, PAGES * page_size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_ptr_not_equal(pages, MAP_FAILED);
    return pages;
}

static void unmap_pages(char *pages)
{
    munmap(pages, PAGES * page_size);
}

static void forbid(char *page)
{
    assert_int_equal(mprotect(page, page_size, PROT_NONE), 0);
}

static bool ask(const void *pointer, size_t size)
{
    struct readable_cache cache = {0};
    return readable(&cache, pointer, size);
}

TEST(unmapped_device_memory_is_probed_again)
{
    char *pages = map_pages();
    assert_true(readable(readable_cache_of_thread(), pages, 1));
    forbid(pages);
    readable_forget_all();
    assert_false(readable(readable_cache_of_thread(), pages, 1));
    unmap_pages(pages);
}

TEST(objects_are_readable)
{
    static const char constant[] = "text";
    int local = 0;
    assert_true(ask(&local, sizeof(local)));
    assert_true(ask(constant, sizeof(constant)));
    assert_true(ask((const void *)(uintptr_t)objects_are_readable, 1));
}

TEST(addresses_of_nothing_and_ranges_without_end_are_not)
{
    int local = 0;
    const struct {
        uintptr_t address;
        size_t size;
    } ranges[] = {
        {0, 1},
        {0, SIZE_MAX},
        {1, 1},
        {0x10, 8},
        {0xdddddddddddddddd, 4}, /* not canonical */
        {0xffffffff80000000, 4}, /* the kernel's */
        {UINTPTR_MAX - 3, 4},
        {UINTPTR_MAX - 3, 5}, /* these wrap */
        {(uintptr_t)&local, SIZE_MAX},
        {(uintptr_t)&local, SIZE_MAX - (uintptr_t)&local + 2},
        {(uintptr_t)&local, SIZE_MAX - (uintptr_t)&local},
        {(uintptr_t)&local, (size_t)UINT32_MAX * 112}, /* ends somewhere */
    };
    for (size_t i = 0; i < sizeof(ranges) / sizeof(ranges[0]); i++)
        if (ask((const void *)ranges[i].address, ranges[i].size))
            fail_msg("%#zx bytes at %#zx", ranges[i].size, (size_t)ranges[i].address);
    assert_true(ask(NULL, 0));
    assert_true(ask((const void *)UINTPTR_MAX, 0));
}

#define PAGES_TEST(name) TEST_WITH(name, char *pages, map_pages, unmap_pages)

/* ---- against a map of pages */

struct page_map {
    char *pages;
    bool is_closed[PAGES], was_found[PAGES]; /* found: since the cache was emptied */
    struct readable_cache cache;
};

static void page_map_begin(void *state)
{
    ((struct page_map *)state)->pages = map_pages();
}

static void page_map_end(void *state)
{
    unmap_pages(((struct page_map *)state)->pages);
}

static void page_map_protect(void *state, const uint32_t *operands)
{
    struct page_map *map = state;
    map->is_closed[operands[0]] = operands[1];
    EXPECT(mprotect(map->pages + operands[0] * page_size, page_size,
                    operands[1] ? PROT_NONE : PROT_READ) == 0);
}

/* Ranges begin and end at the edges of pages, beside them, and anywhere. The cache may remember a
 * page that was readable. */
static void page_map_ask(void *state, const uint32_t *operands)
{
    struct page_map *map = state;
    const size_t places[] = {0, 1, page_size - 1, property_hash(operands[0]) % page_size};
    const size_t begin = operands[0] * page_size + places[operands[1]];
    const size_t end = (operands[0] + operands[3]) * page_size + places[operands[2]];
    const size_t size = end > begin && end <= PAGES * page_size ? end - begin : 1;
    bool is_open = true, was_open = true;
    for (size_t i = begin / page_size; i <= (begin + size - 1) / page_size; i++) {
        is_open &= !map->is_closed[i];
        was_open &= !map->is_closed[i] || map->was_found[i];
    }
    EXPECT_EQUAL(ask(map->pages + begin, size), is_open);
    const bool is_found = readable(&map->cache, map->pages + begin, size);
    EXPECT(is_found ? was_open : !is_open);
    for (size_t i = begin / page_size; i <= (begin + size - 1) / page_size; i++) {
        if (map->is_closed[i] && !map->was_found[i])
            break;
        map->was_found[i] = true;
    }
}

static void page_map_forget(void *state, const uint32_t *operands)
{
    struct page_map *map = state;
    readable_forget(&map->cache);
    for (size_t i = 0; i < PAGES; i++)
        map->was_found[i] = false;
}

PROPERTY_TEST(readable_pages, .size = sizeof(struct page_map), .begin = page_map_begin,
              .end = page_map_end,
              .operations = {{"protect", page_map_protect, {PAGES, 2}, 10},
                             {"ask", page_map_ask, {PAGES, 4, 4, 12}, 40},
                             {"forget", page_map_forget, {0}, 1}},
              .sequences = 20, .steps = 500)

/* What was found readable is not asked for again: it still counts when it is gone. */
PAGES_TEST(readable_ranges_are_remembered)
{
    struct readable_cache cache = {0};
    for (size_t i = 0; i < READABLE_RANGES; i++) /* apart, so that each is a range of its own */
        assert_true(readable(&cache, pages + 4 * i * page_size, 2 * page_size));
    for (size_t i = 0; i < PAGES; i++)
        forbid(pages + i * page_size);
    assert_false(ask(pages, 1));
    for (size_t i = 0; i < READABLE_RANGES; i++) {
        assert_true(readable(&cache, pages + 4 * i * page_size, 2 * page_size));
        assert_true(readable(&cache, pages + (4 * i + 1) * page_size + 7, 9));
    }
}

/* More ranges than there is room for: the oldest is forgotten, and asked for again, but for pages
 * in which something began that was asked for lately. */
PAGES_TEST(the_oldest_range_is_forgotten)
{
    struct readable_cache cache = {0};
    for (size_t i = 0; i <= READABLE_RANGES; i++)
        assert_true(readable(&cache, pages + 3 * i * page_size, 2 * page_size));
    forbid(pages);
    forbid(pages + page_size);
    if (page_size == 4096) /* larger ones share elements of `recent` */
        assert_true(readable(&cache, pages, page_size));
    assert_false(readable(&cache, pages + page_size, 1));
    assert_false(readable(&cache, pages, page_size + 1));
    readable_forget(&cache);
    assert_false(readable(&cache, pages, 1));
}

/* A few milliseconds later the thread's is empty again. */
PAGES_TEST(what_a_thread_remembers_does_not_last)
{
    const struct timespec while_the_timer_advances = {.tv_nsec = 50 * 1000 * 1000};
    assert_true(readable(readable_cache_of_thread(), pages, 1));
    forbid(pages);
    nanosleep(&while_the_timer_advances, NULL);
    assert_false(readable(readable_cache_of_thread(), pages, 1));
}

#ifdef __linux__
/* From here on process_vm_readv fails, as in some sandboxes and in qemu. */
static void lose_process_vm_readv(void)
{
    struct sock_filter code[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_process_vm_readv, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | ENOSYS),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    struct sock_fprog program = {.len = sizeof(code) / sizeof(*code), .filter = code};
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
}

/* Valgrind itself needs process_vm_readv to probe without warnings. */
static bool is_under_valgrind;

const char *unit_test_open(const char *argument)
{
    is_under_valgrind = argument != NULL;
    return NULL;
}

TEST_IF(without_process_vm_readv, !is_under_valgrind)
{
    char *pages = map_pages(), *closed = pages + page_size, *constant = pages + 2 * page_size,
         bytes[8];
    forbid(closed);
    assert_int_equal(mprotect(constant, page_size, PROT_READ), 0);
    pages[0] = 'x';
    pid_t child = fork();
    if (child == 0) {
        signal(SIGSEGV, SIG_DFL);
        lose_process_vm_readv();
        bool copies = probe_copy(bytes, pages, 8) == 8 && bytes[0] == 'x' &&
                      probe_copy(bytes, closed - 4, 8) == 4 && probe_copy(bytes, closed, 8) == 0;
        bool probes = memory_is_writable(pages, page_size) && pages[0] == 'x' &&
                      !memory_is_writable(pages, page_size + 1) &&
                      !memory_is_writable(constant + 5, 1);
        _exit((copies ? 0 : 1) + (probes ? 0 : 2));
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    unmap_pages(pages);
    assert_int_equal(status, 0);
}
#endif

#ifdef _WIN32
/* An access would end the guard, which belongs to the application. */
PAGES_TEST(guard_pages_stay)
{
    char *guard = pages + page_size, bytes[16];
    DWORD before;
    MEMORY_BASIC_INFORMATION region;
    assert_true(VirtualProtect(guard, page_size, PAGE_READWRITE | PAGE_GUARD, &before));
    assert_int_equal(probe_copy(bytes, guard - 8, 16), 8);
    assert_int_equal(probe_copy(bytes, guard, 16), 0);
    assert_false(ask(guard, 1));
    assert_false(memory_is_writable(guard, 1));
    assert_true(VirtualQuery(guard, &region, sizeof(region)));
    assert_true(region.Protect & PAGE_GUARD);
}
#endif
