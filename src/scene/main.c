/* SPDX-License-Identifier: Apache-2.0 */
/* assay-scene: looks at captures. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/text_buffer.h"
#include "src/scene/tool.h"

enum { STATUS_FAILURE = 2, WORDS_MOST = 2 };

static const char help[] =
    "usage: assay-scene info CAPTURE [--json] [--all]\n"
    "       assay-scene export CAPTURE FILE.glb [--at POINT] [--tlas NAME|ID]\n"
    "                   [--color structure|flags] [--plain-nodes]\n"
    "\n"
    "Looks at what an application has built: a folder that setting `capture` of the layer\n"
    "VK_LAYER_ASSAY_validation has written.\n"
    "\n"
    "info: what the capture has, and which effects the scene uses or enables in vain\n"
    "  --json              as JSON\n"
    "  --all               also what is beyond 40 rows of a table\n"
    "\n"
    "export: a top-level structure and all that it refers to, as glTF 2.0\n"
    "  --at POINT          as it was after frame:N, submission:N, build:N (the number n of a\n"
    "                      line) or label:TEXT; default: at the end\n"
    "  --tlas NAME|ID      the top-level structure; default: the last that was built\n"
    "  --color structure|flags\n"
    "                      what decides the colors: the structure (default), or the flags\n"
    "                      of the geometry\n"
    "  --plain-nodes       a node for each instance; otherwise more than 100 instances of one\n"
    "                      structure use EXT_mesh_gpu_instancing\n"
    "\n"
    "  --help              this text\n"
    "  --version           the version\n"
    "\n"
    "exit status:\n"
    "  0   success\n"
    "  2   wrong arguments, an unreadable or damaged capture, or a file that cannot be written\n";

/* Prints a line. Names are the application's, and could hold anything. */
static int complain(const char *what, const char *about)
{
    char line[CAPTURE_ERROR_SIZE];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_append(&text, what);
    text_append_escaped(&text, about, strlen(about));
    fprintf(stderr, "assay-scene: %s\n", line);
    return STATUS_FAILURE;
}

struct arguments {
    const char *words[WORDS_MOST];
    int word_count;
    bool is_export, is_json, lists_all;
    struct export_options export;
};

/* Returns whether a word is that option, and has its value or needs none. */
static const char *value_of(char **words, int *at, const char *option)
{
    if (strcmp(words[*at], option) != 0)
        return NULL;
    return words[*at + 1] ? words[++*at] : "";
}

/* Returns 0, or a status after a complaint. */
static int read_arguments(char **words, struct arguments *arguments)
{
    for (int i = 0; words[i]; i++) {
        const char *word = words[i], *value;
        if (word[0] != '-') {
            if (arguments->word_count == (arguments->is_export ? 2 : 1))
                return complain("one argument too many: ", word);
            arguments->words[arguments->word_count++] = word;
        } else if (!arguments->is_export && strcmp(word, "--json") == 0) {
            arguments->is_json = true;
        } else if (!arguments->is_export && strcmp(word, "--all") == 0) {
            arguments->lists_all = true;
        } else if (arguments->is_export && strcmp(word, "--plain-nodes") == 0) {
            arguments->export.has_plain_nodes = true;
        } else if (arguments->is_export && (value = value_of(words, &i, "--at"))) {
            arguments->export.at = value;
        } else if (arguments->is_export && (value = value_of(words, &i, "--tlas"))) {
            arguments->export.tlas = value;
        } else if (arguments->is_export && (value = value_of(words, &i, "--color"))) {
            arguments->export.colors_flags = strcmp(value, "flags") == 0;
            if (!arguments->export.colors_flags && strcmp(value, "structure") != 0)
                return complain("--color takes structure or flags, not ", value);
        } else {
            return complain("unknown option: ", word);
        }
    }
    if (arguments->word_count < 1)
        return complain("name a capture: the folder that setting `capture` has written", "");
    if (arguments->is_export && arguments->word_count < 2)
        return complain("name the file to write, such as scene.glb", "");
    return 0;
}

static int run(const struct arguments *arguments)
{
    struct capture capture;
    struct capture_error error;
    bool is_done = capture_open(&capture, arguments->words[0], &error);
    if (is_done && capture.note)
        complain("", capture.note);
    if (is_done && arguments->is_export)
        is_done = export_gltf(&capture, arguments->words[1], &arguments->export, &error);
    else if (is_done)
        is_done = info_print(&capture, arguments->is_json, arguments->lists_all, &error);
    capture_close(&capture);
    if (!is_done)
        return complain("", error.text);
    return fflush(stdout) == 0 ? EXIT_SUCCESS : complain("standard output: ", strerror(errno));
}

int main(int count, char **words)
{
    if (count < 2)
        return complain("name a command, info or export; --help explains them", "");
    if (strcmp(words[1], "--help") == 0 || (words[2] && strcmp(words[2], "--help") == 0))
        return fputs(help, stdout) < 0;
    if (strcmp(words[1], "--version") == 0)
        return puts("assay-scene " ASSAY_VERSION) < 0;
    struct arguments arguments = {.is_export = strcmp(words[1], "export") == 0};
    if (!arguments.is_export && strcmp(words[1], "info") != 0)
        return complain("unknown command: ", words[1]);
    const int status = read_arguments(words + 2, &arguments);
    return status ? status : run(&arguments);
}
