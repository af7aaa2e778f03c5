/* SPDX-License-Identifier: Apache-2.0 */
/* scene_rewrite FROM TO [EDIT...]: reads a capture, changes it and writes it. Edits: `all` (each
 * line is made of what was read), `without LINE`, `geometry LINE INDEX` (leaves it out), and `cut
 * LINE` (keeps the first vertex of the first geometry alone, in an array of its own). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/scene/capture.h"

static struct captured_line *line_of(struct capture *capture, const char *number)
{
    return &capture->lines[strtoul(number, NULL, 10) - 1];
}

static int fail(const struct capture_error *error)
{
    puts(error->text);
    return 1;
}

int main(int count, char **words)
{
    struct capture capture;
    struct capture_error error;
    bool is_done = count > 2 && capture_open(&capture, words[1], &error);
    for (int i = 3; is_done && i < count; i++) {
        if (strcmp(words[i], "all") == 0) {
            for (uint32_t j = 0; j < capture.line_count; j++)
                capture.lines[j].is_changed = true;
            continue;
        }
        struct captured_line *line = line_of(&capture, words[i + 1]);
        struct captured_geometry *geometries = capture.commands[line->index].geometries;
        line->is_changed = true;
        if (strcmp(words[i], "without") == 0) {
            line->is_left_out = true;
        } else if (strcmp(words[i], "geometry") == 0) {
            geometries[strtoul(words[i + 2], NULL, 10)].is_left_out = true;
            i++;
        } else {
            struct captured_input *input = &geometries[0].inputs[0];
            const struct captured_data data = capture.data[input->data];
            const void *rows = capture_load_data(&capture, input->data, &error);
            if (!rows)
                return fail(&error);
            const uint32_t old = input->data;
            input->data = capture_add_data(&capture, data.element, data.columns, 1, rows);
            input->count = 1;
            capture_release_data(&capture, old);
        }
        i++;
    }
    is_done = is_done && capture_write(&capture, words[2], &error);
    capture_close(&capture);
    return is_done ? 0 : fail(&error);
}
