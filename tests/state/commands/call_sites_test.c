/* SPDX-License-Identifier: Apache-2.0 */
/* Stacks, the modules of their addresses, the table of call sites, and the sites of a journal. */
#define _GNU_SOURCE /* sigaltstack, makecontext */
#include <dlfcn.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <ucontext.h>
#include <unistd.h>

#include "src/platform/modules.h"
#include "src/state/commands/call_sites.h"
#include "src/state/commands/journal.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

enum { OTHER_STACK = 256 * 1024, DEPTH = 5, THREADS = 4, THREAD_STACKS = 500, SITES_MAX = 16384 };

/* ---- walking */

typedef void walk_function(const void *frame, const void *first, struct call_stack *stack);

__attribute__((noipa, noinline)) static void walk_here(walk_function *walk,
                                                       struct call_stack *stack)
{
    walk(__builtin_frame_address(0), __builtin_return_address(0), stack);
    __asm__ volatile("" ::: "memory"); /* no tail call */
}

__attribute__((noipa, noinline)) static void walk_at_depth(int depth, walk_function *walk,
                                                           struct call_stack *stack)
{
    if (depth)
        walk_at_depth(depth - 1, walk, stack);
    else
        walk_here(walk, stack);
    __asm__ volatile("" ::: "memory");
}

static struct call_stack stack_at_depth(int depth, walk_function *walk)
{
    struct call_stack stack;
    walk_at_depth(depth, walk, &stack);
    return stack;
}

TEST(both_walks_find_the_callers)
{
    const struct call_stack by_frames = stack_at_depth(DEPTH, call_stack_walk_frames);
    const struct call_stack by_tables = stack_at_depth(DEPTH, call_stack_walk_tables);
    /* The callers of walk_here(), and of walk_at_depth() by itself. */
    assert_true(by_frames.count > 1 + DEPTH);
    assert_memory_equal(by_frames.addresses, by_tables.addresses, (1 + DEPTH) * sizeof(uintptr_t));
    assert_int_not_equal(by_frames.addresses[0], by_frames.addresses[1]);
    for (int i = 2; i <= DEPTH; i++)
        assert_int_equal(by_frames.addresses[i], by_frames.addresses[1]);
}

TEST(a_walk_ends_when_the_stack_is_full_of_frames)
{
    assert_int_equal(stack_at_depth(100, call_stack_walk_frames).count, CALL_STACK_FRAMES);
    assert_int_equal(stack_at_depth(100, call_stack_walk_tables).count, CALL_STACK_FRAMES);
}

static void *walk_in_thread(void *element)
{
    struct call_stack *stacks = element;
    stacks[0] = stack_at_depth(DEPTH, call_stack_walk_frames);
    stacks[1] = stack_at_depth(DEPTH, call_stack_walk_tables);
    return NULL;
}

TEST(a_thread_may_have_a_tiny_stack)
{
    struct call_stack stacks[2];
    pthread_attr_t attributes;
    pthread_t thread;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, (size_t)sysconf(_SC_THREAD_STACK_MIN) + 16384);
    assert_int_equal(pthread_create(&thread, &attributes, walk_in_thread, stacks), 0);
    pthread_join(thread, NULL);
    pthread_attr_destroy(&attributes);
    for (int i = 0; i < 2; i++)
        assert_true(stacks[i].count > 1 + DEPTH);
}

/* ---- other stacks */

static struct call_stack other_stacks[2];
static ucontext_t main_context, other_context;

static void walk_both(void)
{
    walk_in_thread(other_stacks);
}

static void assert_only_first_addresses(void)
{
    for (int i = 0; i < 2; i++) {
        assert_int_equal(other_stacks[i].count, 1);
        assert_true(other_stacks[i].addresses[0] != 0);
    }
}

TEST(a_coroutine_has_the_first_address_alone)
{
    char *memory = malloc(OTHER_STACK);
    getcontext(&other_context);
    other_context.uc_stack.ss_sp = memory;
    other_context.uc_stack.ss_size = OTHER_STACK;
    other_context.uc_link = &main_context;
    makecontext(&other_context, walk_both, 0);
    assert_int_equal(swapcontext(&main_context, &other_context), 0);
    assert_only_first_addresses();
    free(memory);
}

static void handle(int number)
{
    (void)number;
    walk_both();
}

TEST(a_signal_on_another_stack_has_the_first_address_alone)
{
    stack_t stack = {.ss_sp = malloc(OTHER_STACK), .ss_size = OTHER_STACK}, before;
    struct sigaction action = {.sa_handler = handle, .sa_flags = SA_ONSTACK}, action_before;
    memset(other_stacks, 0, sizeof(other_stacks));
    sigaltstack(&stack, &before);
    sigaction(SIGUSR1, &action, &action_before);
    raise(SIGUSR1);
    sigaction(SIGUSR1, &action_before, NULL);
    sigaltstack(&before, NULL);
    assert_only_first_addresses();
    free(stack.ss_sp);
}

/* ---- registers that hold no frame pointer */

struct record {
    const void *caller;
    uintptr_t return_address;
};

/* Returns how many addresses a walk finds that begins at the first of these records. */
static uint32_t count_from(const struct record *records)
{
    struct call_stack stack;
    call_stack_walk_frames(records, (const void *)(uintptr_t)1, &stack);
    assert_int_equal(stack.addresses[0], 1);
    return stack.count;
}

/* Where frames are. ASan may move locals of a known size to the heap. */
#define RECORDS_ON_STACK(count) __builtin_alloca_with_align((count)*record_size, 128)
static volatile size_t record_size = sizeof(struct record);

TEST(a_walk_ends_at_what_is_no_frame_pointer)
{
    struct record *records = RECORDS_ON_STACK(4);
    static struct record elsewhere = {NULL, 9};
    records[0] = (struct record){&records[1], 1};
    records[1] = (struct record){&records[2], 2};
    records[2] = (struct record){NULL, 3};
    assert_int_equal(count_from(records), 3);
    const void *const callers[] = {&records[1] /* itself */, &records[0] /* back */,
                                   (const char *)&records[2] + 8, &elsewhere,
                                   (const void *)(UINTPTR_MAX - 15)};
    for (int i = 0; i < 5; i++) {
        records[1].caller = callers[i];
        assert_int_equal(count_from(records), 2);
    }
    records[1] = (struct record){&records[2], 0}; /* does not return */
    assert_int_equal(count_from(records), 1);
}

TEST(a_walk_stays_in_the_stack)
{
    pthread_attr_t attributes;
    void *begin;
    size_t size;
    assert_int_equal(pthread_getattr_np(pthread_self(), &attributes), 0);
    pthread_attr_getstack(&attributes, &begin, &size);
    pthread_attr_destroy(&attributes);
    const char *end = (const char *)begin + size;
    struct record *records = RECORDS_ON_STACK(2);
    records[0] = (struct record){end, 1};
    records[1] = (struct record){0};
    assert_int_equal(count_from(records), 1);
    records[0].caller = end + 4096;
    assert_int_equal(count_from(records), 1);
}

/* ---- modules */

/* No call comes before this label, but one before that. */
__asm__(
    ".text\n"
    ".balign 16\n"
    ".skip 16\n"
    ".globl call_sites_test_no_call\n"
    "call_sites_test_no_call:\n"
    ".skip 16\n");
extern const char call_sites_test_no_call[];

static void *open_library(const char *path, const char *symbol, uintptr_t *address)
{
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    assert_non_null(library);
    *address = (uintptr_t)dlsym(library, symbol) + 1;
    assert_int_not_equal(*address, 1);
    return library;
}

TEST(modules_have_paths_and_kinds)
{
    static struct module_place place;
    static char program[MODULE_PATH_SIZE];
    uintptr_t address;
    assert_true(readlink("/proc/self/exe", program, sizeof(program) - 1) > 0);
    assert_true(module_find(stack_at_depth(1, call_stack_walk_frames).addresses[0], &place));
    assert_string_equal(place.path, program);
    assert_true(place.follows_call);
    assert_false(place.is_vulkan || place.is_layer);
    assert_true(module_find((uintptr_t)call_sites_test_no_call, &place));
    assert_false(place.follows_call);
    assert_false(module_find((uintptr_t)&place, &place));
    assert_false(module_find(0, &place));
    void *library = open_library(LAYER_LIKE, "vkNegotiateLoaderLayerInterfaceVersion", &address);
    assert_true(module_find(address, &place));
    assert_string_equal(place.path, LAYER_LIKE);
    assert_true(place.is_vulkan && place.is_layer);
    dlclose(library);
    assert_false(module_find(address, &place));
    assert_int_equal(chdir("/"), 0);
    library = open_library(&LAYER_LIKE[1], "vkNegotiateLoaderLayerInterfaceVersion", &address);
    assert_true(module_find(address, &place));
    assert_string_equal(place.path, LAYER_LIKE);
    dlclose(library);
}

/* ---- the table */

static struct call_stack stack_of(uintptr_t first, uintptr_t second, uintptr_t third)
{
    return (struct call_stack){third ? 3 : second ? 2 : 1, {first, second, third}};
}

/* A table of one stack, which has this site. */
static struct call_site site_of(enum call_stack_kind kind, struct call_stack stack)
{
    struct call_sites *sites = call_sites_create(kind);
    const struct call_site *site = call_sites_find(sites, &stack);
    const struct call_site found = *site;
    assert_ptr_equal(call_sites_find(sites, &stack), site);
    assert_int_equal(call_sites_count(sites), 1);
    for (uint32_t i = 0; i < found.count; i++)
        assert_string_equal(call_frame_module(&found.frames[i]),
                            found.frames[i].module ? found.frames[i].module : "unknown module");
    call_sites_destroy(sites);
    return found;
}

TEST(what_is_no_return_address_ends_a_call_site)
{
    const struct call_stack real = stack_at_depth(2, call_stack_walk_frames);
    const uintptr_t a = real.addresses[0], b = real.addresses[1];
    const uintptr_t none = (uintptr_t)call_sites_test_no_call, data = (uintptr_t)&other_stacks;
    assert_int_equal(site_of(CALL_STACK_BY_FRAMES, stack_of(a, b, 0)).count, 2);
    assert_int_equal(site_of(CALL_STACK_BY_FRAMES, stack_of(a, none, b)).count, 1);
    assert_int_equal(site_of(CALL_STACK_BY_TABLES, stack_of(a, none, b)).count, 3);
    /* Code outside of modules is compiled at run time, or unloaded; at the end it is likely none.
     */
    assert_int_equal(site_of(CALL_STACK_BY_FRAMES, stack_of(a, data, b)).count, 3);
    assert_int_equal(site_of(CALL_STACK_BY_FRAMES, stack_of(a, data, 0)).count, 1);
    assert_int_equal(site_of(CALL_STACK_BY_TABLES, stack_of(a, data, 0)).count, 2);
    const struct call_site site = site_of(CALL_STACK_BY_FRAMES, stack_of(data, 0, 0));
    assert_int_equal(site.count, 1);
    assert_null(site.frames[0].module);
    assert_int_equal(site.frames[0].offset, data);
}

TEST(frames_of_layers_are_left_out_unless_there_are_no_others)
{
    const uintptr_t own = stack_at_depth(0, call_stack_walk_frames).addresses[0];
    uintptr_t layer;
    void *library = open_library(LAYER_LIKE, "vkNegotiateLoaderLayerInterfaceVersion", &layer);
    assert_int_equal(site_of(CALL_STACK_BY_TABLES, stack_of(layer, own, 0)).count, 1);
    assert_int_equal(site_of(CALL_STACK_BY_TABLES, stack_of(layer, layer, 0)).count, 2);
    dlclose(library);
}

TEST(a_module_that_was_unloaded_is_still_named)
{
    struct call_sites *sites = call_sites_create(CALL_STACK_BY_FRAMES);
    uintptr_t address;
    void *library = open_library(PLAIN_LIBRARY, "plain_entry", &address);
    struct call_stack stack = stack_of(address, 0, 0);
    const struct call_site *site = call_sites_find(sites, &stack);
    dlclose(library);
    assert_ptr_equal(call_sites_find(sites, &stack), site);
    assert_string_equal(site->frames[0].module, PLAIN_LIBRARY);
    stack = stack_of(address + 1, 0, 0);
    assert_null(call_sites_find(sites, &stack)->frames[0].module);
    assert_int_equal(call_sites_count(sites), 2);
    call_sites_destroy(sites);
}

TEST(a_full_table_knows_the_stacks_that_it_has)
{
    struct call_sites *sites = call_sites_create(CALL_STACK_BY_FRAMES);
    for (uintptr_t i = 1; i <= SITES_MAX; i++) {
        const struct call_stack stack = stack_of(i, 0, 0);
        assert_int_equal(call_sites_find(sites, &stack)->frames[0].offset, i);
    }
    struct call_stack stack = stack_of(SITES_MAX + 1, 0, 0);
    assert_null(call_sites_find(sites, &stack));
    stack = stack_of(SITES_MAX, 0, 0);
    assert_int_equal(call_sites_find(sites, &stack)->frames[0].offset, SITES_MAX);
    assert_int_equal(call_sites_count(sites), SITES_MAX);
    call_sites_destroy(sites);
}

TEST(without_memory_there_is_no_call_site)
{
    const struct call_stack stack = stack_at_depth(2, call_stack_walk_frames);
    struct call_sites *sites;
    WITHOUT_MEMORY(sites = call_sites_create(CALL_STACK_BY_FRAMES));
    assert_null(sites);
    call_sites_destroy(NULL);
    sites = call_sites_create(CALL_STACK_BY_FRAMES);
    for (int count = 0; memory_is_scarce(count); count++)
        call_sites_find(sites, &stack);
    memory_fail_no_more();
    assert_true(call_sites_find(sites, &stack)->count > 2);
    ALLOCATES_NOTHING(call_sites_find(sites, &stack));
    assert_int_equal(call_sites_count(sites), 1);
    call_sites_destroy(sites);
}

static struct call_sites *shared_sites;

static void *add_stacks(void *element)
{
    const struct call_site **found = element;
    for (uintptr_t i = 0; i < THREAD_STACKS; i++) {
        const struct call_stack stack = stack_of(i + 1, i + 2, 0);
        found[i] = call_sites_find(shared_sites, &stack);
    }
    return NULL;
}

TEST(threads_share_the_sites_of_equal_stacks)
{
    static const struct call_site *found[THREADS][THREAD_STACKS];
    shared_sites = call_sites_create(CALL_STACK_BY_TABLES);
    unit_test_run_threads(THREADS, add_stacks, found, sizeof(found[0]));
    assert_int_equal(call_sites_count(shared_sites), THREAD_STACKS);
    for (int i = 1; i < THREADS; i++)
        assert_memory_equal(found[i], found[0], sizeof(found[0]));
    call_sites_destroy(shared_sites);
}

/* ---- journals */

static struct journal *open_journal(void)
{
    return journal_create(VK_NULL_HANDLE);
}

#define JOURNAL_TEST(name) TEST_WITH(name, struct journal *journal, open_journal, journal_release)

static const struct call_site site_a, site_b;

/* Adds a build with an entry of its own. */
static void add_build(struct journal *journal, uint32_t position, const struct label_stack *labels,
                      const struct call_site *site)
{
    struct journal_entry *entry = journal_begin_build(journal, false, false);
    const unsigned char size = entry->size;
    *entry = (struct journal_entry){.kind = entry->kind,
                                    .size = size,
                                    .origin = journal_note_origin(journal, labels, site),
                                    .built.position = position};
}

static const struct call_site *site_at(const struct journal *journal, uint32_t position)
{
    return journal_site(journal, journal_origin_at(journal, position));
}

static const char *label_at(const struct journal *journal, uint32_t position)
{
    const struct label_stack *labels =
        journal_labels(journal, journal_origin_at(journal, position));
    return labels && labels->count ? labels->labels[0].pLabelName : NULL;
}

JOURNAL_TEST(a_build_has_the_site_and_the_labels_of_its_call)
{
    struct label_stack labels = {0};
    assert_null(site_at(journal, 0));
    add_build(journal, 2, &labels, &site_a);
    add_build(journal, 3, &labels, &site_a);
    assert_int_equal(journal->origin_count, 1);
    label_stack_push(&labels, &(VkDebugUtilsLabelEXT){.pLabelName = "frame"});
    add_build(journal, 4, &labels, &site_a);
    label_stack_pop(&labels);
    add_build(journal, 5, &labels, NULL);
    add_build(journal, 6, &labels, &site_b);
    assert_null(site_at(journal, 1));
    assert_ptr_equal(site_at(journal, 2), &site_a);
    assert_ptr_equal(site_at(journal, 3), &site_a);
    assert_null(label_at(journal, 3));
    assert_ptr_equal(site_at(journal, 4), &site_a);
    assert_string_equal(label_at(journal, 4), "frame");
    assert_null(site_at(journal, 5));
    assert_ptr_equal(site_at(journal, 6), &site_b);
    assert_null(label_at(journal, 6));
    assert_null(site_at(journal, 7));
    label_stack_clear(&labels);
    journal_clear(journal);
    assert_null(site_at(journal, 6));
}
