/* SPDX-License-Identifier: Apache-2.0 */
/* scene_fuzz SEED SCRATCH COUNT: changes the files of the capture in folder SEED at random, so many
 * times, and has all that assay-scene does read the result, in folder SCRATCH. SCRATCH has the
 * arrays of SEED already. A crash, or what a sanitizer finds, is a failure. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/scene/tool.h"
#include "tests/unit/random.h"

enum { FILE_SIZE = 1 << 16, FILES = 64, PATH_SIZE = 512 };

struct file {
    char name[PATH_SIZE];
    char bytes[FILE_SIZE];
    size_t size;
};
static struct file files[FILES];
static uint32_t file_count;

static void read_file(const char *folder, const char *name)
{
    struct file *file = &files[file_count++];
    char path[2 * PATH_SIZE];
    snprintf(file->name, sizeof(file->name), "%s", name);
    snprintf(path, sizeof(path), "%s/%s", folder, name);
    FILE *from = file_count < FILES ? fopen(path, "rb") : NULL;
    if (!from)
        abort();
    file->size = fread(file->bytes, 1, sizeof(file->bytes), from);
    fclose(from);
}

static void write_file(const char *folder, const struct file *file)
{
    char path[2 * PATH_SIZE];
    snprintf(path, sizeof(path), "%s/%s", folder, file->name);
    FILE *to = fopen(path, "wb");
    if (!to || fwrite(file->bytes, 1, file->size, to) != file->size)
        abort();
    fclose(to);
}

/* Puts a text in the place of `length` bytes. */
static void replace(struct file *file, size_t at, size_t length, const char *text)
{
    const size_t size = strlen(text);
    if (file->size - length + size > FILE_SIZE)
        return;
    memmove(file->bytes + at + size, file->bytes + at + length, file->size - at - length);
    memcpy(file->bytes + at, text, size);
    file->size += size - length;
}

/* Finds the word around a place: digits, or what is between quotation marks. */
static void find_word(const struct file *file, size_t *at, size_t *length)
{
    const char *ends = "\",:{}[]\n";
    size_t begin = *at, end = *at;
    while (begin > 0 && !strchr(ends, file->bytes[begin - 1]))
        begin--;
    while (end < file->size && !strchr(ends, file->bytes[end]))
        end++;
    *at = begin;
    *length = end - begin;
}

static void mutate(struct file *file, struct random *random)
{
    static const char *const words[] = {
        "0",          "1",
        "2",          "3",
        "4",          "5",
        "-1",         "4294967295",
        "4294967296", "9223372036854775807",
        "1e9",        "null",
        "{}",         "[]",
        "\"\"",       "true",
        "0x0",        "0xffffffffffffffff",
        "aabbs",      "triangles",
        "instances",  "vertices",
        "indices",    "update",
        "spheres",    "build",
        "compact",    "Copy",
        "Build",      "VK_FORMAT_R16G16B16A16_SFLOAT",
        "<f4",        "|u1",
        "<u2",
    };
    size_t at = random_below(random, (uint32_t)file->size), length;
    switch (random_below(random, 6)) {
    case 0: { /* a word of the same file */
        char word[PATH_SIZE];
        size_t from = random_below(random, (uint32_t)file->size);
        find_word(file, &from, &length);
        snprintf(word, sizeof(word), "%.*s", (int)(length < 100 ? length : 100),
                 file->bytes + from);
        find_word(file, &at, &length);
        replace(file, at, length, word);
        break;
    }
    case 1:
    case 2:
    case 3:
        find_word(file, &at, &length);
        replace(file, at, length, words[random_below(random, sizeof(words) / sizeof(*words))]);
        break;
    case 4: { /* without some bytes */
        length = random_below(random, 64);
        replace(file, at, length < file->size - at ? length : file->size - at, "");
        break;
    }
    default:
        file->bytes[at] = (char)random_below(random, 256);
    }
}

/* Reads the capture in all ways. The same folder cannot be written twice. */
static bool play(const char *folder)
{
    struct capture capture;
    struct capture_error error;
    const struct export_options options[] = {
        {.at = NULL}, {.at = "frame:1", .colors_flags = true, .has_plain_nodes = true}};
    const struct report_options report = {.json = "/dev/null", .device = "none", .rays = 4};
    const bool is_read = capture_open(&capture, folder, &error);
    if (is_read) {
        info_print(&capture, false, true, &error);
        for (int i = 0; i < 2; i++)
            export_gltf(&capture, "/dev/null", &options[i], &error);
        export_view(&capture, "/dev/null", 4000, &error);
        report_capture(&capture, &report, &error);
        for (uint32_t i = 0; i < capture.line_count; i++)
            capture.lines[i].is_changed = true;
        capture_write(&capture, "/dev/null/folder", &error);
    }
    capture_close(&capture);
    return is_read;
}

int main(int count, char **words)
{
    static struct file before;
    char data[2 * PATH_SIZE];
    if (count != 4 || !freopen("/dev/null", "w", stdout))
        return 1;
    struct random random = random_of("scene_fuzz");
    read_file(words[1], "builds.jsonl");
    read_file(words[1], "findings.jsonl");
    snprintf(data, sizeof(data), "%s/data", words[1]);
    struct dirent **entries;
    const int entry_count = scandir(data, &entries, NULL, alphasort);
    for (int i = 0; i < entry_count; i++) {
        snprintf(data, sizeof(data), "data/%s", entries[i]->d_name);
        if (entries[i]->d_name[0] != '.')
            read_file(words[1], data);
        free(entries[i]);
    }
    free(entries);
    for (uint32_t i = 0; i < file_count; i++)
        write_file(words[2], &files[i]);
    unsigned read = 0;
    const unsigned rounds = (unsigned)strtoul(words[3], NULL, 10);
    for (unsigned i = 0; i < rounds; i++) {
        /* mostly the lines: they are what is read */
        struct file *file =
            &files[random_below(&random, 3) ? 0 : random_below(&random, file_count)];
        before = *file;
        for (uint32_t n = 1 + random_below(&random, 3); n && file->size; n--)
            mutate(file, &random);
        write_file(words[2], file);
        read += play(words[2]);
        *file = before;
        write_file(words[2], file);
    }
    fprintf(stderr, "%u of %u captures could be read\n", read, rounds);
    return read == 0 || read == rounds;
}
