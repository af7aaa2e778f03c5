/* SPDX-License-Identifier: Apache-2.0 */
/* What backend cpu keeps: handles of structures, scratch, private data, and memory that is probed
 * before it is touched. tests/programs/backend has the trees of structures, which are made late. */
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "src/bvh/bvh.h"
#include "src/cpu/device.h"
#include "src/cpu/host.h"
#include "src/cpu/structures.h"
#include "src/snapshots/memory.h"
#include "tests/fixture/objects.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

#define FIRST_HANDLE (1ull << 62)

/* ---- handles */

static uint64_t add(struct cpu_structures *structures, VkAccelerationStructureTypeKHR type,
                    uint64_t buffer, uint64_t offset)
{
    const struct cpu_structure_info info = {
        .type = type, .size = 256, .buffer_id = buffer, .buffer_size = 65536, .offset = offset};
    uint64_t handle;
    GET(cpu_structures_add(structures, &info, &handle));
    assert_true(handle >= FIRST_HANDLE);
    assert_int_equal(handle % 256, 0);
    return handle;
}

static uint64_t add_bottom(struct cpu_structures *structures)
{
    return add(structures, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, 1, 0);
}

static uint64_t add_generic(struct cpu_structures *structures, uint64_t buffer, uint64_t offset)
{
    return add(structures, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR, buffer, offset);
}

static struct cpu_structures *open_structures(void)
{
    struct cpu_structures *structures;
    GET(cpu_structures_create(&structures));
    return structures;
}

#define STRUCTURES_TEST(name)                                                                      \
    TEST_WITH(name, struct cpu_structures *structures, open_structures, cpu_structures_destroy)

STRUCTURES_TEST(test_handles)
{
    struct cpu_structures *others = open_structures();
    struct cpu_structure_info info;
    uint64_t first = add_bottom(structures), second = add_bottom(others);
    assert_int_not_equal(first, second);
    assert_true(cpu_structures_find(structures, first, &info));
    assert_int_equal(info.size, 256);
    assert_false(cpu_structures_find(structures, second, &info));
    assert_false(cpu_structures_find(structures, first + 1, &info));
    assert_false(cpu_structures_find(structures, 0, &info));

    cpu_structures_remove(structures, first);
    assert_false(cpu_structures_find(structures, first, &info));
    for (int i = 0; i < 1000; i++) {
        uint64_t handle = add_bottom(structures);
        assert_int_not_equal(handle, first);
        cpu_structures_remove(structures, handle);
    }
    cpu_structures_remove(structures, first);
    cpu_structures_remove(structures, 12345);
    cpu_structures_destroy(others);
}

/* As far apart as their offsets in the buffer, whatever came and went between. */
STRUCTURES_TEST(test_generic_handles)
{
    uint64_t a = add_generic(structures, 1, 512);
    uint64_t other = add_generic(structures, 2, 512);
    uint64_t b = add_generic(structures, 1, 4096);
    assert_int_equal(b - a, 4096 - 512);
    assert_true(other - a >= 65536 && a - other >= 65536);
    assert_int_not_equal(add_generic(structures, 1, 512), a);

    cpu_structures_remove(structures, a);
    uint64_t c = add_generic(structures, 1, 0);
    assert_int_equal(b - c, 4096);
    add_generic(structures, 1, 1 << 20); /* behind the buffer's end: anywhere */
}

/* ---- memory and scratch */

enum { PAGES = 3 };

/* Pages that can be written, read, and neither. */
static char *map_pages(size_t page)
{
    char *pages =
        mmap(NULL, PAGES * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_ptr_not_equal(pages, MAP_FAILED);
    memset(pages, 'x', PAGES * page);
    mprotect(pages + page, page, PROT_READ);
    mprotect(pages + 2 * page, page, PROT_NONE);
    return pages;
}

TEST(test_probing)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    char *pages = map_pages(page);
    struct host_memory host;
    host_memory_init(&host);
    struct input_memory memory = host_memory_of(&host);
    const void *bytes;
    const uint64_t address = (uintptr_t)pages + 5;
    const struct {
        uint64_t address, size, found;
    } rows[] = {{address, 100, 100},
                {address, 3 * page, 2 * page - 5},
                {address, UINT64_MAX, 2 * page - 5},
                {address + 2 * page, 1, 0},
                {0, 16, 0},
                {16, 16, 0},
                {UINT64_MAX - 3, 16, 0}};
    for (size_t i = 0; i < ARRAY_COUNT(rows); i++)
        assert_int_equal(memory.find(memory.context, rows[i].address, rows[i].size, &bytes),
                         rows[i].found);
    memory.find(memory.context, address, 100, &bytes);
    assert_ptr_equal(bytes, pages + 5);
    host_memory_release(&host);

    assert_true(memory_is_writable(pages + 1, page - 1));
    assert_int_equal(pages[1], 'x');
    assert_false(memory_is_writable(pages + 1, page));
    assert_false(memory_is_writable(pages + page, 1));
    assert_false(memory_is_writable(NULL, 1));
    assert_false(memory_is_writable(pages, UINT64_MAX));
    assert_true(memory_is_writable(NULL, 0));
    munmap(pages, PAGES * page);
    size_t large = 1000 * page;
    char *heap = calloc(1, large);
    assert_true(memory_is_writable(heap, large));
    free(heap);
}

static void take(struct cpu_scratch_claims *claims, void *given, uint64_t size, bool is_owned,
                 struct cpu_scratch *scratch)
{
    GET(cpu_scratch_take(claims, given, size, scratch));
    assert_int_equal(scratch->owned != NULL, is_owned);
    assert_int_equal((uintptr_t)scratch->bytes % BUILDER_ALIGNMENT, 0);
    assert_int_equal(scratch->size, size);
    if (!is_owned)
        assert_true((char *)scratch->bytes >= (char *)given &&
                    (char *)scratch->bytes <= (char *)given + CPU_SCRATCH_SLACK);
    memset(scratch->bytes, 1, size);
}

TEST(test_scratch)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    char *pages = map_pages(page);
    struct cpu_scratch_claims claims;
    struct cpu_scratch scratch[5];
    cpu_scratch_claims_init(&claims);
    take(&claims, pages + 3, 1000, false, &scratch[0]);
    take(&claims, pages + 500, 1000, true, &scratch[1]); /* in use */
    take(&claims, pages + 2048, 1000, false, &scratch[2]);
    take(&claims, pages + page, 64, true, &scratch[3]); /* can't be written */
    take(&claims, NULL, 0, true, &scratch[4]);
    for (int i = 0; i < 5; i++)
        cpu_scratch_return(&scratch[i]);
    take(&claims, pages + 500, 1000, false, &scratch[1]);
    cpu_scratch_return(&scratch[1]);
    take(&claims, (void *)(uintptr_t)0x10, 1000, true, &scratch[0]);
    cpu_scratch_return(&scratch[0]);
    cpu_scratch_claims_release(&claims);
    munmap(pages, PAGES * page);
}

/* ---- private data; tests/programs/backend has what applications see of it */

TEST(test_private_data_without_memory)
{
    enum { OBJECTS = 100, SLOT = 7 };
    static const uint8_t uuid[VK_UUID_SIZE];
    struct cpu_device *device;
    GET(cpu_device_create(uuid, &device));
    struct cpu_private_data *data = &device->private_data;
    for (uint64_t object = 1; object <= OBJECTS; object++) {
        VkResult result = VK_ERROR_OUT_OF_HOST_MEMORY;
        for (int failing = 0; result != VK_SUCCESS; failing++) {
            memory_fail_after(failing);
            result = cpu_private_data_set(data, object, SLOT, 2 * object);
            assert_int_equal(result,
                             memory_fail_no_more() ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_SUCCESS);
        }
    }
    for (uint64_t object = OBJECTS; object > 0; object--) {
        assert_int_equal(cpu_private_data_get(data, object, SLOT), 2 * object);
        memory_fail_after(0);
        cpu_private_data_forget_object(data, object);
        memory_fail_no_more();
        assert_int_equal(cpu_private_data_get(data, object, SLOT), 0);
    }
    cpu_device_destroy(device);
}

/* ---- commands of the host that do nothing; tests/programs/backend has the mistakes of programs */

TEST(test_no_builds_and_no_memory_for_properties)
{
    static const uint8_t uuid[VK_UUID_SIZE];
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    const VkQueryType type = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR;
    const VkAccelerationStructureKHR wild = (VkAccelerationStructureKHR)(uintptr_t)0x1234567890;
    char *pages = map_pages(page);
    struct cpu_device *device;
    uint64_t operation, value = 1;
    GET(cpu_device_create(uuid, &device));
    GET(cpu_deferred_add(device->deferred, &operation));
    GET(cpu_host_build(device, 0, 0, NULL, NULL));
    assert_int_equal(cpu_host_build(device, operation, 0, NULL, NULL),
                     VK_OPERATION_NOT_DEFERRED_KHR);
    assert_int_equal(cpu_host_write_properties(device, 1, &wild, type, 8, pages + page, 8),
                     VK_ERROR_VALIDATION_FAILED);
    assert_int_equal(pages[page], 'x');
    assert_int_equal(
        cpu_host_write_properties(device, 1, (const void *)(pages + 2 * page), type, 8, &value, 8),
        VK_ERROR_VALIDATION_FAILED);
    assert_int_equal(value, 1);
    assert_int_equal(cpu_host_write_properties(device, 1, &wild, type, 8, &value, 8),
                     VK_ERROR_VALIDATION_FAILED);
    assert_int_equal(value, 0);
    cpu_device_destroy(device);
    munmap(pages, PAGES * page);
}
