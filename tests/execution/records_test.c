/* SPDX-License-Identifier: Apache-2.0 */
/* Setting record_builds: the lines of programs, in the order in which their batches execute. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "machine.h"
#include "tests/state/unit_test.h"

enum { LINE_SIZE = 65536, TEXT_SIZE = 4096 };

static struct platform platform;
static struct fixture fixture;
static struct machine machine;
static char log_name[] = "/tmp/assay-records-XXXXXX";
static FILE *log_file;

/* ---- lines as words, such as: update A.1 X>Y 2 */

static const char *member(const char *line, const char *key)
{
    char text[64];
    snprintf(text, sizeof(text), "\"%s\":", key);
    const char *found = strstr(line, text);
    return found != NULL ? found + strlen(text) : NULL;
}

static uint64_t number(const char *line, const char *key)
{
    const char *found = member(line, key);
    return found != NULL ? strtoull(found + (*found == '"'), NULL, 0) : 0;
}

static char structure(const char *line, const char *key)
{
    const uint64_t handle = number(line, key);
    for (uint32_t i = 0; i < STRUCTURES; i++)
        if (handle == (machine.is_nv ? (uint64_t)machine.nv[i].handle
                                     : (uint64_t)machine.structures[i].handle))
            return "WXYZ"[i];
    return '?';
}

static const char *command_buffer(uint64_t handle)
{
    for (uint32_t i = 0; i < COMMAND_BUFFERS; i++)
        if (handle == (uint64_t)(uintptr_t)machine.command_buffers[i])
            return machine_name(i);
    return handle == 0 ? "host" : "?";
}

static int queue(const char *line)
{
    const uint64_t handle = number(line, "queue");
    return handle == (uint64_t)(uintptr_t)machine.queues[1] ? 1 : 0;
}

static void append(char *text, const char *format, ...)
{
    const size_t length = strlen(text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text + length, TEXT_SIZE - length, format, arguments);
    va_end(arguments);
}

static void append_submission(char *text, const char *line)
{
    append(text, "submit %d:", queue(line));
    const char *buffers = member(line, "command_buffers");
    for (const char *at = buffers; (at = strstr(at, "\"0x")) != NULL && at < strchr(buffers, ']');
         at = strchr(at + 1, '"') + 1)
        append(text, " %s", command_buffer(strtoull(at + 1, NULL, 0)));
}

/* A structure that is alive lies in memory. */
static void append_command(char *text, const char *line)
{
    const char *mode = member(line, "mode") + 1;
    append(text, "%.*s %s", (int)strcspn(mode, "\""), mode,
           command_buffer(number(line, "command_buffer")));
    if (member(line, "build") != NULL)
        append(text, ".%u", (unsigned)number(line, "build"));
    append(text, " ");
    if (member(line, "src") != NULL)
        append(text, "%c>", structure(line, "src"));
    append(text, "%c", structure(line, "dst"));
    if (member(line, "primitives") != NULL)
        append(text, " %u%s", (unsigned)number(line, "primitives"),
               member(line, "geometries") != NULL ? "" : " of no geometry");
    if (member(line, "memory") == NULL || number(line, "size") == 0)
        append(text, " nowhere");
}

static void append_line(char *text, const char *line)
{
    static const char *const ignored[] = {"Header", "Device", "Finding", "Summary"};
    const char *type = member(line, "Type") + 1;
    for (size_t i = 0; i < sizeof(ignored) / sizeof(ignored[0]); i++)
        if (strncmp(type, ignored[i], strlen(ignored[i])) == 0)
            return;
    append(text, text[0] != '\0' ? "; " : "");
    if (strncmp(type, "Submission", 10) == 0)
        append_submission(text, line);
    else if (strncmp(type, "CompactedSize", 13) == 0)
        append(text, "size %c %s", structure(line, "dst"),
               number(line, "compacted_size") == machine.compacted ? "as read" : "wrong");
    else
        append_command(text, line);
}

/* Compares the lines that have been added to the log since the last call. */
static void expect_lines(const char *name, const char *expected)
{
    static char line[LINE_SIZE], text[TEXT_SIZE];
    text[0] = '\0';
    while (fgets(line, sizeof(line), log_file) != NULL)
        append_line(text, line);
    fseek(log_file, 0, SEEK_CUR); /* under Wine, clearerr() is not enough to read on */
    if (strcmp(text, expected) != 0)
        fail_msg("%s:\n  got      %s\n  expected %s", name, text, expected);
}

/* ---- programs */

static const struct program_of_lines {
    const char *name;
    const struct step *steps;
    const char *lines;
    bool is_nv;
} programs[] = {
    {"a build, an update in place and another",
     STEPS(RECORD(A, BUILD(A, X, GOOD), UPDATE(A, X, X), UPDATE(A, X, Y)), RUN(A)),
     "submit 0: A; build A.0 X 2; update A.1 X>X 2; update A.2 X>Y 2", false},
    {"recorded and not submitted", STEPS(GOOD_X(A)), "", false},
    {"submitted twice", STEPS(GOOD_X(A), RUN(A), IDLE, RUN(A)),
     "submit 0: A; build A.0 X 2; submit 0: A; build A.0 X 2", false},
    {"one call with two batches",
     STEPS(GOOD_X(A), UPDATE_XY(B), BATCH, WITH(A), BATCH, WITH(B), SUBMIT(0)),
     "submit 0: A; build A.0 X 2; submit 0: B; update B.0 X>Y 2", false},
    {"two builds in one call", STEPS(RECORD(A, BUILD_PAIR(A, X, Y, GOOD)), RUN(A)),
     "submit 0: A; build A.0 X 2; build A.1 Y 2", false},
    {"copies",
     STEPS(RECORD(A, BUILD(A, X, GOOD), CLONE(A, X, Y), COMPACT(A, X, Z), FILL(A, W)), RUN(A)),
     "submit 0: A; build A.0 X 2; clone A X>Y; compact A X>Z; deserialize A W", false},
    {"a secondary command buffer",
     STEPS(RECORD_BUILD(S, X, GOOD), RECORD(A, EXECUTE(A, S), UPDATE(A, X, Y)), RUN(A)),
     "submit 0: A; build S.0 X 2; update A.1 X>Y 2", false},
    {"by the host", STEPS(HOST_GOOD_X, HOST_UPDATE_XY, HOST_CLONE(X, Z), HOST_FILL(W)),
     "build host.0 X 2; update host.0 X>Y 2; clone host X>Z; deserialize host W", false},
    {"the host fails", STEPS(HOST_BUILD_FAILS(X, GOOD)), "", false},
    {"deferred by the host, not joined", STEPS(DEFERRED_BUILD(1, X, GOOD)), "", false},
    {"and joined", STEPS(DEFERRED_BUILD(1, X, GOOD), HOST_BUILD(Y, GOOD), JOIN(1), ASK(1)),
     "build host.0 Y 2; build host.0 X 2", false},
    {"the submission fails", STEPS(GOOD_X(A), BATCH, WITH(A), FAILED_SUBMIT(0)), "", false},
    {"held until another queue has signalled",
     STEPS(GOOD_X(A), RECORD_UPDATE(P, X, Y), RUN_AFTER(P, WAIT_FOR(0, 1)),
           RUN_BEFORE(A, SIGNAL_TO(0, 1))),
     "submit 0: A; build A.0 X 2; submit 1: P; update P.0 X>Y 2", false},
    {"destroyed while it was held",
     STEPS(RECORD_BUILD(P, X, GOOD), RUN_AFTER(P, WAIT_FOR(2, 1)), DESTROY(X),
           SIGNAL_FROM_HOST(2, 1)),
     "submit 1: P; build P.0 X 2 nowhere", false},
    {"a compacted size that the host reads",
     STEPS(RECORD(A, BUILD(A, X, GOOD), RESET_QUERIES(A), QUERY(A, X, 0)), RUN(A), IDLE,
           READ_QUERIES(0)),
     "submit 0: A; build A.0 X 2; size X as read", false},
    {"a compacted size that the host queries", STEPS(HOST_GOOD_X, HOST_QUERY(X)),
     "build host.0 X 2; size X as read", false},
    {"VK_NV_ray_tracing",
     STEPS(RECORD(A, BUILD(A, X, GOOD), UPDATE(A, X, Y), CLONE(A, X, Z)), RUN(A)),
     "submit 0: A; build A.0 X 4; update A.1 X>Y 4; clone A X>Z", true},
    /* The last one: the layer no longer knows the order when the machine has waited for it. */
    {"held forever", STEPS(RECORD_BUILD(P, X, GOOD), RUN_AFTER(P, WAIT_FOR(1, 1))), "", false},
};

static void play(const struct program_of_lines *program)
{
    machine_open(&machine, &fixture, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    machine.update_command = COMMAND_DEVICE;
    machine.good = machine.bad = shape_plain();
    if (program->is_nv)
        machine_nv_open(&machine);
    for (const struct step *step = program->steps; step->action != ACTION_END_OF_PROGRAM; step++)
        machine_step(&machine, step);
    expect_lines(program->name, program->lines);
    if (fixture.messages.count != 0)
        fail_msg("%s: %s", program->name, fixture.messages.items[0].text);
    machine_close(&machine);
    messages_clear(&fixture.messages);
    expect_lines("the end", "");
}

TEST(test_programs)
{
    for (size_t i = 0; i < sizeof(programs) / sizeof(programs[0]); i++)
        play(&programs[i]);
}

const char *unit_test_open(const char *argument)
{
    static const struct setup setup = {.enable = ENABLE_RAY_TRACING_NV};
    const int descriptor = mkstemp(log_name);
    if (descriptor < 0)
        return "no temporary file";
    close(descriptor);
    setenv("VK_ASSAY_VALIDATION_LOG_FORMAT", "json", 1);
    setenv("VK_ASSAY_VALIDATION_LOG_FILENAME", log_name, 1);
    setenv("VK_ASSAY_VALIDATION_RECORD_BUILDS", "true", 1);
    log_file = fopen(log_name, "rb");
    const char *missing = platform_open(&platform, "null");
    return missing != NULL ? missing : fixture_open(&fixture, &platform, &setup);
}

void unit_test_close(void)
{
    fixture_close(&fixture);
    fclose(log_file);
    unlink(log_name);
}
