/* SPDX-License-Identifier: Apache-2.0 */
/* records LINE, LINE: what setting record_builds has written to the log since the last time, as
 * words:
 *
 *     submit q0 c0                   build c0.1 B1 2           update c0.2 B1>B2 2
 *     clone host B1>B2               deserialize c0 B1         size B1 as read | wrong
 *     destroy B1                     instances c0.1 T0 B1*3 B2*1
 *
 * A build has its position in the command buffer and its primitives; ` 0x7` behind them are its
 * flags, if they are not those of most programs. `nowhere` is behind a structure that has no memory
 * any more, and `without scratch` behind a build whose scratch size is not known. `records
 * nothing`: there is no line.
 *
 * unchecked TEXT: ends the instance, whose summary then has that text among what was not checked.
 *
 * The program has the lines
 *
 *     setting record_builds true
 *     setting log_format json
 *     setting log_filename records       a file of the process */
#include "tests/player/play.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LINE_SIZE = 65536, TEXT_SIZE = 4096 };

/* ---- members of a line */

static const char *member(const char *line, const char *key)
{
    char text[64];
    snprintf(text, sizeof(text), "\"%s\":", key);
    const char *found = strstr(line, text);
    return found ? found + strlen(text) : NULL;
}

static uint64_t number(const char *line, const char *key)
{
    const char *found = member(line, key);
    return found ? strtoull(found + (*found == '"'), NULL, 0) : 0;
}

/* ---- names of objects */

static const char *name_of(const struct play *play, uint64_t handle, const char *letters)
{
    for (unsigned i = 0; i < play->object_count; i++) {
        const struct play_object *object = &play->objects[i];
        const uint64_t own = object->name[0] == 'c' ? (uint64_t)(uintptr_t)object->commands
                             : play->is_nv          ? (uint64_t)object->nv
                                                    : (uint64_t)object->structure;
        if (strchr(letters, object->name[0]) && own == handle)
            return object->name;
    }
    return handle || letters[0] != 'c' ? "?" : "host";
}

static unsigned queue_of(const struct play *play, const char *line)
{
    const uint64_t handle = number(line, "queue");
    unsigned i = 0;
    while (i < PLAY_QUEUES && (uint64_t)(uintptr_t)play->queues[i] != handle)
        i++;
    return i;
}

/* ---- a line as words */

__attribute__((format(printf, 2, 3))) static void append(char *text, const char *format, ...)
{
    const size_t length = strlen(text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text + length, TEXT_SIZE - length, format, arguments);
    va_end(arguments);
}

static void append_submission(const struct play *play, char *text, const char *line)
{
    append(text, "submit q%u", queue_of(play, line));
    const char *buffers = member(line, "command_buffers");
    for (const char *at = buffers; (at = strstr(at, "\"0x")) && at < strchr(buffers, ']');
         at = strchr(at + 1, '"') + 1)
        append(text, " %s", name_of(play, strtoull(at + 1, NULL, 0), "c"));
}

static const uint64_t usual_flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR |
                                    VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR;

static void append_command(const struct play *play, char *text, const char *line)
{
    const char *mode = member(line, "mode") + 1;
    append(text, "%.*s %s", (int)strcspn(mode, "\""), mode,
           name_of(play, number(line, "command_buffer"), "c"));
    if (member(line, "build"))
        append(text, ".%u", (unsigned)number(line, "build"));
    append(text, " ");
    if (member(line, "src"))
        append(text, "%s>", name_of(play, number(line, "src"), "BT"));
    append(text, "%s", name_of(play, number(line, "dst"), "BT"));
    if (member(line, "primitives"))
        append(text, " %u%s", (unsigned)number(line, "primitives"),
               member(line, "geometries") ? "" : " of no geometry");
    if (number(line, "flags") & ~usual_flags)
        append(text, " 0x%x", (unsigned)number(line, "flags"));
    if (!member(line, "memory") || !number(line, "size"))
        append(text, " nowhere");
    else if (member(line, "build") && !number(line, "scratch_size"))
        append(text, " without scratch");
}

static void append_instances(const struct play *play, char *text, const char *line)
{
    append(text, "instances %s.%u %s", name_of(play, number(line, "command_buffer"), "c"),
           (unsigned)number(line, "build"), name_of(play, number(line, "dst"), "BT"));
    const char *const structures = member(line, "structures");
    for (const char *at = structures; at && (at = strstr(at, "{\"handle\":")); at = strchr(at, '}'))
        append(text, " %s*%u", name_of(play, number(at, "handle"), "BT"),
               (unsigned)number(at, "instances"));
}

static void append_line(const struct play *play, char *text, const char *line)
{
    static const char *const ignored[] = {"Header", "Device", "Finding", "Summary"};
    const char *type = member(line, "Type") + 1;
    for (size_t i = 0; i < ARRAY_COUNT(ignored); i++)
        if (strncmp(type, ignored[i], strlen(ignored[i])) == 0)
            return;
    append(text, "%s", text[0] ? ", " : "");
    if (strncmp(type, "Submission", 10) == 0)
        append_submission(play, text, line);
    else if (strncmp(type, "CompactedSize", 13) == 0)
        append(text, "size %s %s", name_of(play, number(line, "dst"), "BT"),
               number(line, "compacted_size") == play->last_size ? "as read" : "wrong");
    else if (strncmp(type, "Instances", 9) == 0)
        append_instances(play, text, line);
    else if (strncmp(type, "Destroyed", 9) == 0)
        append(text, "destroy %s", name_of(play, number(line, "dst"), "BT"));
    else
        append_command(play, text, line);
}

/* ---- the log */

/* Reads on, to the end. */
static void read_log(struct play *play, char *text)
{
    static char line[LINE_SIZE];
    FILE *log = fopen(play->log_name, "rb");
    PLAY_REQUIRE(play, log != NULL);
    fseek(log, play->log_offset, SEEK_SET);
    while (fgets(line, sizeof(line), log))
        append_line(play, text, line);
    play->log_offset = ftell(log);
    fclose(log);
}

/* Before a program: what others wrote is not its own. */
void play_skip_records(struct play *play)
{
    char text[TEXT_SIZE] = "";
    if (play->log_name[0])
        read_log(play, text);
}

static void expect_unchecked(struct play *play, const char *wanted)
{
    static char line[LINE_SIZE];
    bool is_found = false;
    play_destroy_objects(play);
    play_close_instance(play);
    play->is_closed = true;
    FILE *log = fopen(play->log_name, "rb");
    PLAY_REQUIRE(play, log != NULL);
    while (fgets(line, sizeof(line), log)) {
        const char *unchecked = member(line, "Unchecked");
        is_found |= unchecked && strstr(unchecked, wanted);
    }
    fclose(log);
    play_close(play);
    if (is_found || play->is_scarce)
        return;
    report_say(&play->report, "the summary does not say \"%s\"\n", wanted);
    play->report.outcome = OUTCOME_FAILED;
}

bool play_records(struct play *play, char **words)
{
    char text[TEXT_SIZE] = "", wanted[TEXT_SIZE] = "";
    if (!play_is(words[0], "records") && !play_is(words[0], "unchecked"))
        return false;
    for (char **word = words + 1; *word; word++)
        append(wanted, "%s%s", word == words + 1 ? "" : " ", *word);
    if (play_is(words[0], "unchecked")) {
        expect_unchecked(play, wanted);
        return true;
    }
    read_log(play, text);
    if (strcmp(text, play_is(words[1], "nothing") ? "" : wanted) == 0)
        return true;
    report_say(&play->report, "recorded %s\n", text[0] ? text : "nothing");
    play->report.outcome = OUTCOME_FAILED;
    return true;
}
