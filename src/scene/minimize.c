/* SPDX-License-Identifier: Apache-2.0 */
/* Makes a capture small: leaves out parts, first large ones and then small ones, as long as the
 * replay of the rest still gives the finding (Zeller and Hildebrandt's delta debugging, by
 * complements). */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <vulkan/vulkan.h>

#include "src/base/text_buffer.h"
#include "src/platform/process.h"
#include "src/scene/tool.h"

enum { PATH_SIZE = 4096, COMMAND_SIZE = 4 * PATH_SIZE, LINE_SIZE = 4096 };

struct search {
    struct capture *capture;
    const char *finding;
    char program[PATH_SIZE], folder[PATH_SIZE], try[PATH_SIZE + 8]; /* of this program; temporary */
    uint32_t tries;
    bool has_failed; /* a try could not be written or started: `error` says why */
    struct capture_error *error;
};

/* ---- tries */

/* Appends a word of a shell command. */
static void append_word(struct text_buffer *text, const char *word)
{
    text_append(text, " '");
    for (; *word; word++)
        text_append_part(text, *word == '\'' ? "'\\''" : word, *word == '\'' ? 4 : 1);
    text_append(text, "'");
}

static void remove_folder(const char *path)
{
    char command[COMMAND_SIZE];
    struct text_buffer text;
    text_begin(&text, command, sizeof(command));
    text_append(&text, "rm -rf");
    append_word(&text, path);
    FILE *output = text.cut ? NULL : popen(command, "r");
    if (output)
        pclose(output);
}

static void show_progress(const struct search *search)
{
    if (isatty(STDERR_FILENO))
        fprintf(stderr, "\rassay-scene: %" PRIu32 " tries", search->tries);
}

/* Replays the try in a process of its own, which may crash. Returns whether it gave the finding. */
static bool replay_try(struct search *search)
{
    char command[COMMAND_SIZE], line[LINE_SIZE];
    struct text_buffer text;
    const bool compares = strstr(search->finding, "-compare-") != NULL;
    const size_t length = strlen(search->finding);
    bool is_found = false;
    text_begin(&text, command, sizeof(command));
    append_word(&text, search->program);
    text_append(&text, compares ? " replay --compare" : " replay --layer");
    append_word(&text, search->try);
    text_append(&text, " 2>/dev/null");
    FILE *output = text.cut ? NULL : popen(command, "r");
    search->has_failed |= !output;
    while (output && fgets(line, sizeof(line), output))
        is_found |= strncmp(line, "finding: ", 9) == 0 &&
                    strncmp(line + 9, search->finding, length) == 0 &&
                    strchr(" \n", line[9 + length]);
    if (output)
        pclose(output);
    return is_found;
}

/* Whether what is not left out still gives the finding. */
static bool still_finds(struct search *search)
{
    struct capture_error error;
    search->tries++;
    show_progress(search);
    if (search->has_failed)
        return false;
    if (!capture_write(search->capture, search->try, &error)) {
        *search->error = error;
        search->has_failed = true;
        return false;
    }
    const bool is_found = replay_try(search);
    remove_folder(search->try);
    return is_found;
}

/* ---- leaving out parts */

/* Parts of one kind: `left_out` has a flag for each, and `apply` makes the capture follow them. */
struct parts {
    bool *left_out;
    uint32_t count;
    void (*apply)(struct search *search, const struct parts *parts);
    uint32_t command, geometry; /* what they are parts of */
};

/* Leaves out parts [begin, end) unless the finding needs one of them. */
static void try_without(struct search *search, struct parts *parts, uint32_t begin, uint32_t end)
{
    bool *before = capture_allocate(NULL, end - begin, sizeof(*before));
    bool changes = false;
    memcpy(before, parts->left_out + begin, end - begin);
    for (uint32_t i = begin; i < end; i++) {
        changes |= !parts->left_out[i];
        parts->left_out[i] = true;
    }
    if (changes) {
        parts->apply(search, parts);
        if (!still_finds(search)) {
            memcpy(parts->left_out + begin, before, end - begin);
            parts->apply(search, parts);
        }
    }
    free(before);
}

static void reduce(struct search *search, struct parts *parts)
{
    for (uint32_t size = (parts->count + 1) / 2; parts->count && size && !search->has_failed;
         size = size == 1 ? 0 : (size + 1) / 2)
        for (uint32_t begin = 0; begin < parts->count; begin += size)
            try_without(search, parts, begin,
                        parts->count - begin < size ? parts->count : begin + size);
}

static struct parts make_parts(uint32_t count,
                               void (*apply)(struct search *search, const struct parts *parts))
{
    struct parts parts = {.count = count, .apply = apply};
    parts.left_out = capture_allocate(NULL, count + 1ull, sizeof(*parts.left_out));
    memset(parts.left_out, 0, (count + 1ull) * sizeof(*parts.left_out));
    return parts;
}

/* ---- commands */

static void apply_commands(struct search *search, const struct parts *parts)
{
    for (uint32_t i = 0; i < parts->count; i++)
        search->capture->lines[search->capture->commands[i].line].is_left_out = parts->left_out[i];
}

static bool is_left_out(const struct capture *capture, uint32_t command)
{
    return capture->lines[capture->commands[command].line].is_left_out;
}

/* ---- geometries */

static void apply_geometries(struct search *search, const struct parts *parts)
{
    struct captured_command *command = &search->capture->commands[parts->command];
    search->capture->lines[command->line].is_changed = true;
    for (uint32_t i = 0; i < parts->count; i++)
        command->geometries[i].is_left_out = parts->left_out[i];
}

/* ---- primitives */

/* The array whose rows are the primitives, and how many of its rows one has. NULL: none. */
static struct captured_input *rows_of(struct captured_geometry *geometry, uint32_t *rows)
{
    const struct captured_input *input = capture_input_of(geometry, CAPTURE_INDICES);
    *rows = 3;
    if (geometry->type == CAPTURE_TRIANGLES && !input)
        input = capture_input_of(geometry, CAPTURE_VERTICES);
    if (geometry->type == CAPTURE_AABBS || geometry->type == CAPTURE_INSTANCES) {
        input = capture_input_of(geometry, geometry->type == CAPTURE_AABBS ? CAPTURE_BOXES
                                                                           : CAPTURE_INSTANCE_ROWS);
        *rows = 1;
    }
    return (struct captured_input *)input;
}

/* The rows before anything was left out. */
struct whole {
    uint32_t data, rows, count;
};

static struct whole whole; /* of the geometry that is reduced; a program of one thread */

static void apply_primitives(struct search *search, const struct parts *parts)
{
    struct capture *capture = search->capture;
    struct captured_command *command = &capture->commands[parts->command];
    struct captured_geometry *geometry = &command->geometries[parts->geometry];
    uint32_t rows;
    struct captured_input *input = rows_of(geometry, &rows);
    const struct captured_data data = capture->data[whole.data];
    const size_t size = (size_t)rows * data.row_size;
    const unsigned char *from = capture_load_data(capture, whole.data, search->error);
    search->has_failed |= !from;
    if (!from)
        return;
    unsigned char *kept = capture_allocate(NULL, parts->count + 1ull, size);
    uint32_t count = 0;
    for (uint32_t i = 0; i < parts->count; i++)
        if (!parts->left_out[i])
            memcpy(kept + size * count++, from + size * i, size);
    capture->lines[command->line].is_changed = true;
    geometry->primitive_count = count;
    input->count = (uint64_t)count * rows;
    input->data =
        count ? capture_add_data(capture, data.element, data.columns, (uint64_t)count * rows, kept)
              : whole.data;
    free(kept);
}

static void reduce_primitives(struct search *search, uint32_t command, uint32_t index)
{
    struct captured_geometry *geometry = &search->capture->commands[command].geometries[index];
    uint32_t rows;
    const struct captured_input *input = rows_of(geometry, &rows);
    if (!input || input->data == CAPTURE_NONE ||
        search->capture->data[input->data].rows != (uint64_t)geometry->primitive_count * rows)
        return;
    whole = (struct whole){.data = input->data};
    struct parts parts = make_parts(geometry->primitive_count, apply_primitives);
    parts.command = command;
    parts.geometry = index;
    reduce(search, &parts);
    free(parts.left_out);
}

/* ---- what nothing names any more */

/* Whether an instance that is left may have the reference. */
static bool may_refer(struct search *search, const struct captured_command *command,
                      uint64_t reference)
{
    const size_t at = offsetof(VkAccelerationStructureInstanceKHR, accelerationStructureReference);
    for (uint32_t i = 0; i < command->geometry_count; i++) {
        const struct captured_geometry *geometry = &command->geometries[i];
        const struct captured_input *input = capture_input_of(geometry, CAPTURE_INSTANCE_ROWS);
        if (geometry->is_left_out || !input || !geometry->primitive_count)
            continue;
        const unsigned char *rows =
            input->data != CAPTURE_NONE &&
                    search->capture->data[input->data].element == CAPTURE_INSTANCE
                ? capture_load_data(search->capture, input->data, search->error)
                : NULL;
        if (!rows)
            return true;
        const struct captured_data *data = &search->capture->data[input->data];
        for (uint64_t row = 0; row < data->rows; row++)
            if (memcmp(rows + row * data->row_size + at, &reference, sizeof(reference)) == 0)
                return true;
    }
    return false;
}

static void leave_out_references(struct search *search)
{
    for (uint32_t i = 0; i < search->capture->command_count; i++) {
        struct captured_command *command = &search->capture->commands[i];
        if (is_left_out(search->capture, i) || !search->capture->lines[command->line].is_changed)
            continue;
        for (uint32_t n = 0; n < command->reference_count; n++)
            command->references[n].is_left_out =
                !may_refer(search, command, command->references[n].reference);
    }
}

static void keep_structure(const struct capture *capture, uint32_t structure, bool *structures,
                           bool *buffers)
{
    if (structure == CAPTURE_NONE)
        return;
    structures[structure] = true;
    if (capture->structures[structure].buffer != CAPTURE_NONE)
        buffers[capture->structures[structure].buffer] = true;
}

static void find_named(const struct capture *capture, const struct captured_command *command,
                       bool *structures, bool *buffers)
{
    keep_structure(capture, command->dst, structures, buffers);
    keep_structure(capture, command->src, structures, buffers);
    for (uint32_t i = 0; i < command->reference_count; i++)
        if (!command->references[i].is_left_out)
            keep_structure(capture, command->references[i].structure, structures, buffers);
    if (command->scratch_buffer != CAPTURE_NONE)
        buffers[command->scratch_buffer] = true;
    for (uint32_t i = 0; i < command->geometry_count; i++)
        for (uint32_t n = 0; n < command->geometries[i].input_count; n++)
            if (command->geometries[i].inputs[n].buffer != CAPTURE_NONE)
                buffers[command->geometries[i].inputs[n].buffer] = true;
}

static void leave_out_unnamed(struct capture *capture)
{
    bool *structures = calloc(capture->structure_count + 1ull, 1),
         *buffers = calloc(capture->buffer_count + 1ull, 1),
         *memories = calloc(capture->memory_count + 1ull, 1);
    for (uint32_t i = 0; structures && buffers && memories && i < capture->command_count; i++)
        if (!is_left_out(capture, i))
            find_named(capture, &capture->commands[i], structures, buffers);
    for (uint32_t i = 0; buffers && memories && i < capture->buffer_count; i++)
        if (buffers[i] && capture->buffers[i].memory != CAPTURE_NONE)
            memories[capture->buffers[i].memory] = true;
    for (uint32_t i = 0; structures && buffers && memories && i < capture->line_count; i++) {
        struct captured_line *line = &capture->lines[i];
        line->is_left_out |= (line->kind == CAPTURE_STRUCTURE && !structures[line->index]) ||
                             (line->kind == CAPTURE_BUFFER && !buffers[line->index]) ||
                             (line->kind == CAPTURE_MEMORY && !memories[line->index]);
    }
    free(structures);
    free(buffers);
    free(memories);
}

/* ---- all of it */

static void reduce_all(struct search *search)
{
    struct capture *capture = search->capture;
    struct parts commands = make_parts(capture->command_count, apply_commands);
    reduce(search, &commands);
    free(commands.left_out);
    for (uint32_t i = 0; i < capture->command_count && !search->has_failed; i++) {
        if (is_left_out(capture, i))
            continue;
        struct parts geometries = make_parts(capture->commands[i].geometry_count, apply_geometries);
        geometries.command = i;
        if (geometries.count > 1)
            reduce(search, &geometries);
        for (uint32_t n = 0; n < geometries.count; n++)
            if (!geometries.left_out[n])
                reduce_primitives(search, i, n);
        free(geometries.left_out);
    }
    leave_out_references(search);
    leave_out_unnamed(capture);
}

static void print_rest(const struct capture *capture, uint32_t tries)
{
    uint32_t commands = 0, geometries = 0;
    uint64_t primitives = 0;
    for (uint32_t i = 0; i < capture->command_count; i++) {
        const struct captured_command *command = &capture->commands[i];
        commands += !is_left_out(capture, i);
        for (uint32_t n = 0; n < command->geometry_count && !is_left_out(capture, i); n++) {
            geometries += !command->geometries[n].is_left_out;
            primitives +=
                command->geometries[n].is_left_out ? 0 : command->geometries[n].primitive_count;
        }
    }
    printf("tries: %" PRIu32 "; left: %" PRIu32 " commands, %" PRIu32 " geometries, %" PRIu64
           " primitives\n",
           tries, commands, geometries, primitives);
}

bool minimize_capture(struct capture *capture, const char *finding, const char *folder,
                      struct capture_error *error)
{
    struct search search = {.capture = capture, .finding = finding, .error = error};
    const char *temporary = getenv("TMPDIR");
    process_executable(search.program, sizeof(search.program));
    snprintf(search.folder, sizeof(search.folder), "%s/assay-scene-XXXXXX",
             temporary && temporary[0] ? temporary : "/tmp");
    if (!mkdtemp(search.folder)) {
        snprintf(error->text, sizeof(error->text), "%.512s: %s", search.folder, strerror(errno));
        return false;
    }
    snprintf(search.try, sizeof(search.try), "%s/try", search.folder);
    bool is_found = still_finds(&search);
    if (!is_found && !search.has_failed)
        snprintf(error->text, sizeof(error->text),
                 "the replay of the whole capture does not give %.512s", finding);
    if (is_found)
        reduce_all(&search);
    is_found = is_found && !search.has_failed && capture_write(capture, folder, error);
    if (is_found)
        print_rest(capture, search.tries);
    remove_folder(search.folder);
    return is_found;
}
