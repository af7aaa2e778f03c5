/* SPDX-License-Identifier: Apache-2.0 */
/* The folder of a capture, without a device: paths that cannot be one, and which arrays inputs
 * become. layer_test.py has what the files hold. */
#include "src/capture/folder.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "src/capture/arrays.h"
#include "src/capture/hash.h"
#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

enum { PATH_SIZE = 256 };

static char parent[] = "/tmp/assay-capture-XXXXXX";

static const float rows[9];

static void path_of(char path[PATH_SIZE], const char *leaf)
{
    snprintf(path, PATH_SIZE, "%s/%s", parent, leaf);
}

static struct capture_folder open_in(const char *leaf, uint64_t limit)
{
    struct capture_folder folder;
    char path[PATH_SIZE];
    path_of(path, leaf);
    assert_int_equal(capture_folder_open(&folder, path, limit), 0);
    return folder;
}

/* Rows of another shape are another array; the same rows are written once. */
TEST(test_shapes_differ)
{
    char hash[CAPTURE_HASH_SIZE], other[CAPTURE_HASH_SIZE];
    struct capture_folder folder = open_in("shapes", 1 << 20);
    const struct capture_array triples = {"'<f4'", ", 3", 3, 12, rows},
                               numbers = {"'<f4'", ", 1", 9, 4, rows};
    assert_true(capture_folder_add_array(&folder, &triples, hash));
    assert_true(capture_folder_add_array(&folder, &numbers, other));
    assert_string_not_equal(hash, other);
    const uint64_t written = folder.written;
    assert_true(capture_folder_add_array(&folder, &triples, other));
    assert_string_equal(hash, other);
    assert_int_equal(folder.written, written);
    capture_folder_close(&folder);
}

TEST(test_limit)
{
    char hash[CAPTURE_HASH_SIZE];
    struct capture_folder folder = open_in("limit", 300);
    const struct capture_array array = {"'<f4'", ", 3", 3, 12, rows};
    assert_true(capture_folder_add_line(&folder, "{}\n", 3));
    assert_true(capture_folder_add_array(&folder, &array, hash)); /* 292 bytes */
    assert_false(capture_folder_add_line(&folder, "{123}\n", 6));
    assert_true(folder.is_full);
    assert_int_equal(folder.error, 0);
    assert_false(capture_folder_add_line(&folder, "{}\n", 3)); /* nothing may follow a gap */
    capture_folder_close(&folder);
}

TEST(test_bad_paths)
{
    struct capture_folder folder;
    char path[PATH_SIZE], bytes[2 * LOG_PATH_SIZE];
    memset(bytes, 'x', sizeof(bytes));
    bytes[sizeof(bytes) - 1] = '\0';
    assert_int_equal(capture_folder_open(&folder, "", 1), ENOENT);
    assert_int_equal(capture_folder_open(&folder, bytes, 1), ENAMETOOLONG);
    path_of(path, "file");
    fclose(fopen(path, "w"));
    assert_int_equal(capture_folder_open(&folder, path, 1), ENOTDIR);
    capture_folder_close(&folder);
    assert_false(capture_folder_add_line(&folder, "{}\n", 3));
}

/* A full disk, as far as a limit of the sizes of files behaves like one. */
TEST(test_disk_is_full)
{
    static const float many[3 * 1000];
    const struct capture_array array = {"'<f4'", ", 3", 1000, 12, many};
    char hash[CAPTURE_HASH_SIZE], part[PATH_SIZE];
    struct capture_folder folder = open_in("full", 1 << 20);
    struct rlimit before;
    getrlimit(RLIMIT_FSIZE, &before);
    setrlimit(RLIMIT_FSIZE, &(struct rlimit){1000, before.rlim_max});
    const bool is_written = capture_folder_add_array(&folder, &array, hash);
    setrlimit(RLIMIT_FSIZE, &before);
    assert_false(is_written);
    assert_int_equal(folder.error, EFBIG);
    path_of(part, "full/data/part");
    assert_int_equal(access(part, F_OK), -1); /* nothing half stays */
    capture_folder_close(&folder);
}

/* ---- arrays */

static uint64_t find_bytes(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    const uint64_t *end = context; /* no byte behind it can be read */
    *bytes = (const void *)(uintptr_t)address;
    return address >= *end ? 0 : size < *end - address ? size : *end - address;
}

static bool read_input(const void *bytes, uint64_t size, VkFormat format,
                       struct geometry_input input, struct capture_room *room,
                       struct capture_array *array)
{
    uint64_t end = (uint64_t)(uintptr_t)bytes + size;
    const struct input_memory memory = {.find = find_bytes, .context = &end};
    VkAccelerationStructureGeometryKHR geometry = {.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR};
    geometry.geometry.triangles.vertexFormat = format;
    input.address.deviceAddress = (uint64_t)(uintptr_t)bytes;
    input.most = input.most ? input.most : input.size;
    return capture_array_read(&memory, false, &geometry, NULL, &input, room, array);
}

TEST(test_types)
{
    static const struct {
        VkFormat format;
        uint64_t size;
        const char *type, *columns;
    } cases[] = {
        {VK_FORMAT_R32G32B32_SFLOAT, 12, "'<f4'", ", 3"},
        {VK_FORMAT_R32G32_SFLOAT, 8, "'<f4'", ", 2"},
        {VK_FORMAT_R16G16B16A16_SFLOAT, 6, "'<f2'", ", 3"},
        {VK_FORMAT_R16G16B16A16_SNORM, 6, "'<i2'", ", 3"},
        {VK_FORMAT_R16G16_UNORM, 4, "'<u2'", ", 2"},
        {VK_FORMAT_R8G8B8A8_SNORM, 3, "'|i1'", ", 3"},
        {VK_FORMAT_R64G64B64_SFLOAT, 24, "'<f8'", ", 3"},
        {VK_FORMAT_A2B10G10R10_UNORM_PACK32, 4, "'|u1'", ", 4"},
    };
    static const unsigned char bytes[64];
    struct capture_room room = {0};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        struct capture_array array;
        assert_true(read_input(
            bytes, sizeof(bytes), cases[i].format,
            (struct geometry_input){
                .role = INPUT_VERTEX, .count = 2, .stride = cases[i].size, .size = cases[i].size},
            &room, &array));
        assert_string_equal(array.type, cases[i].type);
        assert_string_equal(array.columns, cases[i].columns);
    }
    free(room.bytes);
}

/* Elements with gaps, at an offset; the last one is not whole. */
TEST(test_strides)
{
    static const uint16_t numbers[] = {9, 9, 1, 2, 8, 3, 4, 8, 5};
    static const uint16_t packed[] = {1, 2, 3, 4};
    struct capture_room room = {0};
    struct capture_array array;
    assert_true(
        read_input(numbers, sizeof(numbers), VK_FORMAT_R16G16_UNORM,
                   (struct geometry_input){
                       .role = INPUT_VERTEX, .offset = 4, .count = 3, .stride = 6, .size = 4},
                   &room, &array));
    assert_int_equal(array.count, 2);
    assert_memory_equal(array.rows, packed, sizeof(packed));
    free(room.bytes);
}

TEST(test_nothing_to_read)
{
    static const unsigned char bytes[16];
    struct capture_room room = {0};
    struct capture_array array;
    struct geometry_input input = {.role = INPUT_INDEX, .count = 3, .stride = 4, .size = 4};
    assert_false(read_input(bytes, 0, VK_FORMAT_UNDEFINED, input, &room, &array));
    assert_false(read_input(bytes, 3, VK_FORMAT_UNDEFINED, input, &room, &array));
    input.count = 0;
    assert_false(read_input(bytes, 16, VK_FORMAT_UNDEFINED, input, &room, &array));
    input.count = UINT64_MAX; /* its end wraps */
    assert_true(read_input(bytes, 16, VK_FORMAT_UNDEFINED, input, &room, &array));
    assert_int_equal(array.count, 4);
    input.stride = 0; /* all elements are one */
    assert_true(read_input(bytes, 16, VK_FORMAT_UNDEFINED, input, &room, &array));
    assert_int_equal(array.count, 1);
    free(room.bytes);
}

const char *unit_test_open(const char *name)
{
    (void)name;
    return mkdtemp(parent) ? NULL : "no folder in /tmp";
}

TEST(all_processors_hash_alike)
{
#ifdef CAPTURE_HAS_AVX2
    static unsigned char bytes[5000];
    struct random random = random_of("hash");
    for (size_t i = 0; i < sizeof(bytes); i++)
        bytes[i] = (unsigned char)random_below(&random, 256);
    for (size_t size = 0; size <= sizeof(bytes) && __builtin_cpu_supports("avx2"); size++) {
        const struct capture_hash one = capture_hash_anywhere(bytes, size, size),
                                  other = capture_hash_by_avx2(bytes, size, size);
        assert_true(one.high == other.high && one.low == other.low);
    }
#endif
}
