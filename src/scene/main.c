/* SPDX-License-Identifier: Apache-2.0 */
/* assay-scene: looks at captures, replays them, makes them small, and reports on their scenes. */
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/text_buffer.h"
#include "src/scene/tool.h"

enum {
    STATUS_FAILURE = 2,
    REPEATS_MOST = 10000,
    RAYS_MOST = 10000000,
    LIMIT_DEFAULT = 8,
    LIMIT_MOST = 4096
};

static const char help[] =
    "usage: assay-scene info CAPTURE [--json] [--all]\n"
    "       assay-scene export CAPTURE FILE.glb [--at POINT] [--tlas NAME|ID]\n"
    "                   [--color structure|flags] [--plain-nodes]\n"
    "       assay-scene view CAPTURE FILE.json [--limit MIB]\n"
    "       assay-scene replay CAPTURE [--layer] [--compare] [--time] [--repeat N]\n"
    "                   [--dump FOLDER]\n"
    "       assay-scene minimize CAPTURE FOLDER --finding ID\n"
    "       assay-scene report CAPTURE [--html FILE] [--json FILE] [--at POINT]\n"
    "                   [--tlas NAME|ID] [--camera X,Y,Z,X,Y,Z] [--rays N]\n"
    "                   [--device NAME|none]\n"
    "\n"
    "Looks at what an application has built: a folder that setting `capture` of the layer\n"
    "VK_LAYER_ASSAY_validation has written.\n"
    "\n"
    "info: lists structures, the effects that the scene uses, and those that it never uses\n"
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
    "view: the data of the 3D view on the page of assay-run --html, which calls this\n"
    "  --limit MIB         how much data, at most (default: 8)\n"
    "\n"
    "replay: builds all of it again, in order, on the first device that the Vulkan loader\n"
    "gives and that builds acceleration structures\n"
    "  --layer             under the layer, at level content; its findings are printed\n"
    "  --compare           the same, and the layer compares the driver's hits with its\n"
    "                      reference builder's\n"
    "  --time              print how long each call took on the device\n"
    "  --repeat N          build each call N times\n"
    "  --dump FOLDER       write the structures, serialized, to FOLDER/ID.bin: as they are when\n"
    "                      they are destroyed, or at the end\n"
    "\n"
    "minimize: writes the smallest capture that still gives a finding when it is replayed\n"
    "  --finding ID        such as VUID-VkAabbPositionsKHR-minX-03546, or the id of a\n"
    "                      difference between driver and reference (ASSAY-compare-...)\n"
    "\n"
    "report: what accuracy costs on this scene, where it is fragile, which effects it has, and\n"
    "what it wastes. It needs no GPU; a device with ray queries gets a column of its own\n"
    "  --html FILE         a page to look at, without other files\n"
    "  --json FILE         all figures (docs/report.md)\n"
    "  --at, --tlas        as those of export\n"
    "  --camera X,Y,Z,X,Y,Z\n"
    "                      where the camera is, and a point that it looks at; default: it sees\n"
    "                      all of the scene\n"
    "  --rays N            rays of each set; default: 20000\n"
    "  --device NAME|none  the device with this in its name, or none; default: the first that\n"
    "                      has ray queries, or else builds structures\n"
    "\n"
    "  --help              this text\n"
    "  --version           the version\n"
    "\n"
    "exit status:\n"
    "  0   success; of replay: all builds and copies succeeded\n"
    "  2   wrong arguments, an unreadable or damaged capture, a file that cannot be written,\n"
    "      or a build that failed or could not be replayed\n";

/* Prints a line. Names are the application's, and could hold anything. */
static int complain(const char *what, const char *about)
{
    char line[CAPTURE_ERROR_SIZE];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_append(&text, what);
    text_append_escaped(&text, about, strlen(about));
    fflush(stdout);
    fprintf(stderr, "assay-scene: %s\n", line);
    return STATUS_FAILURE;
}

struct arguments {
    const char *capture, *output, *finding;
    uint32_t limit; /* MiB */
    bool is_json, lists_all;
    struct export_options export;
    struct replay_options replay;
    struct report_options report;
};

/* ---- commands */

static bool run_info(struct capture *capture, const struct arguments *arguments,
                     struct capture_error *error)
{
    return info_print(capture, arguments->is_json, arguments->lists_all, error);
}

static bool run_export(struct capture *capture, const struct arguments *arguments,
                       struct capture_error *error)
{
    return export_gltf(capture, arguments->output, &arguments->export, error);
}

static bool run_view(struct capture *capture, const struct arguments *arguments,
                     struct capture_error *error)
{
    return export_view(capture, arguments->output, (uint64_t)arguments->limit << 20, error);
}

static bool run_replay(struct capture *capture, const struct arguments *arguments,
                       struct capture_error *error)
{
    setvbuf(stdout, NULL, _IOLBF, 0); /* a driver's crash would lose what was not printed */
    return replay_capture(capture, &arguments->replay, error);
}

static bool run_minimize(struct capture *capture, const struct arguments *arguments,
                         struct capture_error *error)
{
    return minimize_capture(capture, arguments->finding, arguments->output, error);
}

static bool run_report(struct capture *capture, const struct arguments *arguments,
                       struct capture_error *error)
{
    struct report_options options = arguments->report;
    options.at = arguments->export.at;
    options.tlas = arguments->export.tlas;
    options.shows_progress = true;
    return report_capture(capture, &options, error);
}

static const struct command {
    const char *name, *options; /* letters of `all_options` below */
    const char *output;         /* what the second argument is; NULL: there is none */
    bool (*run)(struct capture *capture, const struct arguments *arguments,
                struct capture_error *error);
} commands[] = {
    {"info", "ja", NULL, run_info},
    {"export", "ptcn", "the file to write, such as scene.glb", run_export},
    {"view", "m", "the file to write, such as view.json", run_view},
    {"replay", "loird", NULL, run_replay},
    {"minimize", "f", "the folder to write", run_minimize},
    {"report", "hjptkyv", NULL, run_report},
};

static const struct option all_options[] = {
    {"html", required_argument, NULL, 'h'},
    {"json", no_argument, NULL, 'j'}, /* of report with the name of a file */
    {"all", no_argument, NULL, 'a'},
    {"at", required_argument, NULL, 'p'},
    {"tlas", required_argument, NULL, 't'},
    {"color", required_argument, NULL, 'c'},
    {"plain-nodes", no_argument, NULL, 'n'},
    {"limit", required_argument, NULL, 'm'},
    {"layer", no_argument, NULL, 'l'},
    {"compare", no_argument, NULL, 'o'},
    {"time", no_argument, NULL, 'i'},
    {"repeat", required_argument, NULL, 'r'},
    {"dump", required_argument, NULL, 'd'},
    {"finding", required_argument, NULL, 'f'},
    {"camera", required_argument, NULL, 'k'},
    {"rays", required_argument, NULL, 'y'},
    {"device", required_argument, NULL, 'v'},
    {NULL, 0, NULL, 0},
};
enum { OPTIONS = sizeof(all_options) / sizeof(all_options[0]) };

/* Reads six numbers. */
static bool read_camera(const char *value, struct report_options *report)
{
    char *end = NULL;
    for (int i = 0; i < 6; i++, value = end + 1) {
        report->camera[i] = strtod(value, &end);
        if (end == value || *end != (i < 5 ? ',' : '\0') || !isfinite(report->camera[i]))
            return false;
    }
    report->has_camera = true;
    return true;
}

static bool read_number(const char *text, uint32_t most, uint32_t *number)
{
    char *end;
    *number = (uint32_t)strtoul(text, &end, 10);
    return !*end && *number && *number <= most;
}

/* Returns false if the value is wrong. */
static bool read_option(struct arguments *arguments, int letter, const char *value)
{
    switch (letter) {
    case 'h':
        arguments->report.html = value;
        return true;
    case 'k':
        return read_camera(value, &arguments->report);
    case 'y':
        return read_number(value, RAYS_MOST, &arguments->report.rays);
    case 'v':
        arguments->report.device = value;
        return true;
    case 'j':
        arguments->is_json = true;
        arguments->report.json = value;
        return true;
    case 'a':
        arguments->lists_all = true;
        return true;
    case 'p':
        arguments->export.at = value;
        return true;
    case 't':
        arguments->export.tlas = value;
        return true;
    case 'c':
        arguments->export.colors_flags = strcmp(value, "flags") == 0;
        return arguments->export.colors_flags || strcmp(value, "structure") == 0;
    case 'n':
        arguments->export.has_plain_nodes = true;
        return true;
    case 'l':
        arguments->replay.uses_layer = true;
        return true;
    case 'o':
        arguments->replay.compares = true;
        return true;
    case 'i':
        arguments->replay.shows_times = true;
        return true;
    case 'm':
        return read_number(value, LIMIT_MOST, &arguments->limit);
    case 'r':
        return read_number(value, REPEATS_MOST, &arguments->replay.repeat);
    case 'd':
        arguments->replay.dump = value;
        return true;
    default:
        arguments->finding = value;
        return true;
    }
}

/* Returns 0, or a status after a complaint. */
static int read_arguments(int count, char **words, const struct command *command,
                          struct arguments *arguments)
{
    const bool is_report = command->run == run_report;
    struct option options[OPTIONS];
    int index;
    opterr = 0;
    memcpy(options, all_options, sizeof(options));
    for (int i = 0; i < OPTIONS; i++)
        if (options[i].val == 'j')
            options[i].has_arg = is_report ? required_argument : no_argument;
    for (int letter; (letter = getopt_long(count, words, ":", options, &index)) != -1;) {
        if (letter == ':')
            return complain("an option needs a value: ", words[optind - 1]);
        if (letter == '?' || !strchr(command->options, letter))
            return complain("unknown option: ",
                            letter == '?' ? words[optind - 1] : options[index].name);
        if (!read_option(arguments, letter, optarg))
            return complain("not a value of an option: ", optarg);
    }
    arguments->capture = words[optind];
    if (!arguments->capture)
        return complain("name a capture: the folder that setting `capture` has written", "");
    arguments->output = words[optind + 1];
    if (command->output && !arguments->output)
        return complain("name ", command->output);
    const int most = command->output ? 2 : 1;
    if (count - optind > most)
        return complain("one argument too many: ", words[optind + most]);
    if (is_report && !arguments->report.html && !arguments->report.json)
        return complain("name a file to write: --html FILE or --json FILE", "");
    if (command->run == run_minimize && !arguments->finding)
        return complain("name a finding: --finding ID", "");
    return 0;
}

static int run(const struct command *command, const struct arguments *arguments)
{
    struct capture capture;
    struct capture_error error;
    bool is_done = capture_open(&capture, arguments->capture, &error);
    if (is_done && capture.note)
        complain("", capture.note);
    is_done = is_done && command->run(&capture, arguments, &error);
    capture_close(&capture);
    if (!is_done)
        return complain("", error.text);
    return fflush(stdout) == 0 ? EXIT_SUCCESS : complain("standard output: ", strerror(errno));
}

int main(int count, char **words)
{
    if (count < 2)
        return complain(
            "name a command: info, export, view, replay, minimize or report; --help explains them",
            "");
    if (strcmp(words[1], "--help") == 0 || (words[2] && strcmp(words[2], "--help") == 0))
        return fputs(help, stdout) < 0;
    if (strcmp(words[1], "--version") == 0)
        return puts("assay-scene " ASSAY_VERSION) < 0;
    struct arguments arguments = {.limit = LIMIT_DEFAULT};
    for (size_t i = 0; i < sizeof(commands) / sizeof(commands[0]); i++)
        if (strcmp(words[1], commands[i].name) == 0) {
            const int status = read_arguments(count - 1, words + 1, &commands[i], &arguments);
            return status ? status : run(&commands[i], &arguments);
        }
    return complain("unknown command: ", words[1]);
}
