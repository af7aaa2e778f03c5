/* SPDX-License-Identifier: Apache-2.0 */
#include "src/capture/folder.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "src/capture/hash.h"
#include "src/platform/files.h"

enum { NAME_SIZE = LOG_PATH_SIZE + 64, PENDING_SIZE = 1 << 16 };

/* ---- the folder */

static bool make_name(char name[NAME_SIZE], const struct capture_folder *folder, const char *file)
{
    struct text_buffer text;
    text_begin(&text, name, NAME_SIZE);
    text_append(&text, folder->path);
    text_append(&text, file);
    return !text.cut;
}

/* Makes the folders of a path that don't exist. */
static int make_folders(char *path)
{
    for (char *at = path + 1; (at = strchr(at, '/')); at++) {
        *at = '\0';
        file_make_folder(path); /* what matters is whether the last one can be made */
        *at = '/';
    }
    return file_make_folder(path);
}

int capture_folder_open(struct capture_folder *folder, const char *path, uint64_t limit)
{
    char name[NAME_SIZE];
    struct text_buffer text;
    *folder = (struct capture_folder){.limit = limit};
    text_begin(&text, folder->path, sizeof(folder->path));
    text_append(&text, path);
    if (text.cut || !text.length)
        return text.cut ? ENAMETOOLONG : ENOENT;
    make_name(name, folder, "/data");
    int error = make_folders(name);
    if (error)
        return error;
    make_name(name, folder, "/builds.jsonl");
    folder->lines = file_open_new(name);
    return folder->lines ? 0 : errno;
}

void capture_folder_close(struct capture_folder *folder)
{
    if (folder->lines) {
        capture_folder_flush(folder);
        fclose(folder->lines);
    }
    free(folder->pending);
    handle_table_release(&folder->known);
    handle_table_drop(&folder->held, free);
    folder->lines = NULL;
}

/* ---- writing */

static bool may_write(struct capture_folder *folder, uint64_t size)
{
    if (!folder->lines || folder->error || folder->is_full)
        return false;
    folder->is_full = size > folder->limit - folder->written;
    if (!folder->is_full)
        folder->written += size;
    return !folder->is_full;
}

/* Writes all of two parts. Returns 0 or an error number. */
static int write_parts(FILE *file, const char *first, size_t first_size, const char *second,
                       size_t second_size)
{
    const int descriptor = file_descriptor(file);
    while (first_size + second_size) {
        size_t done;
        int error = file_write(descriptor, first, first_size, second, second_size, &done);
        if (error)
            return error;
        const size_t of_first = done < first_size ? done : first_size;
        first += of_first;
        first_size -= of_first;
        second += done - of_first;
        second_size -= done - of_first;
    }
    return 0;
}

/* Writes to a file, and keeps the error. */
static bool write_to(struct capture_folder *folder, FILE *file, const char *first,
                     size_t first_size, const char *second, size_t second_size)
{
    struct write_signals blocked;
    file_block_signals(&blocked);
    const int error = write_parts(file, first, first_size, second, second_size);
    file_unblock_signals(&blocked, error);
    folder->error = error;
    return !error;
}

bool capture_folder_flush(struct capture_folder *folder)
{
    const size_t size = folder->pending_size;
    folder->pending_size = 0;
    return !size ||
           (!folder->error && write_to(folder, folder->lines, folder->pending, size, "", 0));
}

/* Lines that follow each other are written at once. */
static bool add_parts(struct capture_folder *folder, const char *first, size_t first_size,
                      const char *second, size_t second_size)
{
    const size_t size = first_size + second_size;
    if (!may_write(folder, size))
        return false;
    if (!folder->pending)
        folder->pending = malloc(PENDING_SIZE);
    if (size > PENDING_SIZE - folder->pending_size && !capture_folder_flush(folder))
        return false;
    if (!folder->pending || size > PENDING_SIZE)
        return write_to(folder, folder->lines, first, first_size, second, second_size);
    memcpy(folder->pending + folder->pending_size, first, first_size);
    memcpy(folder->pending + folder->pending_size + first_size, second, second_size);
    folder->pending_size += size;
    return true;
}

bool capture_folder_add_line(struct capture_folder *folder, const char *line, size_t size)
{
    return add_parts(folder, line, size, "", 0);
}

bool capture_folder_add_command(struct capture_folder *folder, uint64_t number, bool is_kept,
                                const char *line, size_t size)
{
    char begin[48];
    const int length = snprintf(begin, sizeof(begin), "{\"n\":%" PRIu64 ",%s", number,
                                is_kept ? "\"kept\":1," : "");
    return add_parts(folder, begin, (size_t)length, line + 1, size - 1);
}

/* ---- arrays */

enum { HEADER_SIZE = 256, HEADER_ALIGNMENT = 64, PREFIX = 10 };
_Static_assert(HEADER_SIZE % HEADER_ALIGNMENT == 0, "the data is aligned");

/* Composes the header of NumPy's format 1.0: a magic number, the version, the size of the rest in
 * two bytes, and a dictionary, padded with spaces. */
static void compose_header(const struct capture_array *array, char header[HEADER_SIZE])
{
    static const char magic[] = "\x93NUMPY\x01";
    struct text_buffer text;
    text_begin(&text, header + PREFIX, HEADER_SIZE - PREFIX);
    text_append(&text, "{'descr': ");
    text_append(&text, array->type);
    text_append(&text, ", 'fortran_order': False, 'shape': (");
    text_append_decimal(&text, array->count);
    text_append(&text, array->columns[0] ? array->columns : ",");
    text_append(&text, "), }");
    memset(header + PREFIX + text.length, ' ', HEADER_SIZE - PREFIX - text.length);
    header[HEADER_SIZE - 1] = '\n';
    memcpy(header, magic, sizeof(magic)); /* with the zero of version 1.0 */
    header[PREFIX - 2] = (char)(unsigned char)((HEADER_SIZE - PREFIX) & 0xff);
    header[PREFIX - 1] = (char)((HEADER_SIZE - PREFIX) >> 8);
}

/* The file gets its name when it is complete. */
static bool write_array(struct capture_folder *folder, const char *hash, const char *header,
                        const void *rows, uint64_t size)
{
    char file[CAPTURE_HASH_SIZE + 16], name[NAME_SIZE], part[NAME_SIZE];
    snprintf(file, sizeof(file), "/data/%s.npy", hash);
    make_name(name, folder, file);
    make_name(part, folder, "/data/part");
    file_remove(part); /* what a failure has left */
    FILE *written = file_open_new(part);
    if (!written) {
        folder->error = errno;
        return false;
    }
    bool is_whole = write_to(folder, written, header, HEADER_SIZE, rows, size);
    fclose(written);
    if (is_whole)
        folder->error = file_rename(part, name);
    if (folder->error)
        file_remove(part);
    return !folder->error;
}

/* An array in memory: the header, and the rows. */
struct held_array {
    char hash[CAPTURE_HASH_SIZE];
    uint32_t references;
    uint64_t size; /* of the rows */
    char bytes[];
};

static bool hold_array(struct capture_folder *folder, uint64_t key, const char *hash,
                       const char *header, const void *rows, uint64_t size)
{
    struct held_array *held = handle_table_find(&folder->held, key);
    if (held) {
        held->references++;
        return true;
    }
    held = malloc(sizeof(*held) + HEADER_SIZE + size);
    if (!held || !handle_table_set(&folder->held, key, held)) {
        free(held);
        return false;
    }
    memcpy(held->hash, hash, CAPTURE_HASH_SIZE);
    held->references = 1;
    held->size = size;
    memcpy(held->bytes, header, HEADER_SIZE);
    memcpy(held->bytes + HEADER_SIZE, rows, size);
    return true;
}

/* Half of a hash, as it is found by. */
static uint64_t key_of(uint64_t low)
{
    return low ? low : 1;
}

static bool add_array(struct capture_folder *folder, uint64_t key, const char *hash,
                      const char *header, const void *rows, uint64_t size)
{
    static char has_it;
    if (handle_table_find(&folder->known, key))
        return true;
    if (folder->holds)
        return hold_array(folder, key, hash, header, rows, size);
    if (!may_write(folder, HEADER_SIZE + size) || !write_array(folder, hash, header, rows, size))
        return false;
    handle_table_set(&folder->known, key, &has_it); /* without memory, it is written again */
    return true;
}

bool capture_folder_add_array(struct capture_folder *folder, const struct capture_array *array,
                              char hash[CAPTURE_HASH_SIZE])
{
    char header[HEADER_SIZE];
    const uint64_t size = array->count * array->size;
    compose_header(array, header);
    const uint64_t seed = capture_hash(header, HEADER_SIZE, 0).low;
    const struct capture_hash found = capture_hash(array->rows, size, seed);
    snprintf(hash, CAPTURE_HASH_SIZE, "%016" PRIx64 "%016" PRIx64, found.high, found.low);
    return add_array(folder, key_of(found.low), hash, header, array->rows, size);
}

/* Returns the next held array that a line names, or NULL at its end. `at` is moved behind it. */
static struct held_array *next_held(const struct capture_folder *folder, const char **at,
                                    const char *end)
{
    static const char key[] = "\"data\":\"";
    enum { KEY = sizeof(key) - 1, HALF = 16 };
    for (; end - *at >= KEY + CAPTURE_HASH_SIZE; ++*at) {
        if (memcmp(*at, key, KEY) != 0)
            continue;
        char half[HALF + 1] = "";
        memcpy(half, *at + KEY + HALF, HALF);
        struct held_array *held =
            handle_table_find(&folder->held, key_of(strtoull(half, NULL, 16)));
        if (!held)
            continue;
        *at += KEY;
        return held;
    }
    return NULL;
}

bool capture_folder_write_held(struct capture_folder *folder, const char *line, size_t size)
{
    const char *at = line;
    const bool holds = folder->holds;
    bool is_done = true;
    folder->holds = false;
    for (struct held_array *held; is_done && (held = next_held(folder, &at, line + size));) {
        const uint64_t low = strtoull(held->hash + 16, NULL, 16);
        is_done = add_array(folder, key_of(low), held->hash, held->bytes, held->bytes + HEADER_SIZE,
                            held->size);
    }
    folder->holds = holds;
    return is_done;
}

void capture_folder_let_go(struct capture_folder *folder, const char *line, size_t size)
{
    const char *at = line;
    for (struct held_array *held; (held = next_held(folder, &at, line + size));)
        if (!--held->references) {
            handle_table_remove(&folder->held, key_of(strtoull(held->hash + 16, NULL, 16)));
            free(held);
        }
}
