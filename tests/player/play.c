/* SPDX-License-Identifier: Apache-2.0 */
/* Plays the lines of programs. */
#include "tests/player/play.h"

#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- programs that are not judged */

static struct play *unjudged; /* whose line is played, or NULL */

static _Noreturn void leave_line(void)
{
    longjmp(unjudged->next_line, 1);
}

void *play_block(struct play *play, size_t size)
{
    const struct platform *platform = play->platform;
    const bool can_fail = platform->pause_allocations;
    const int before = can_fail ? platform->pause_allocations() : 0;
    struct play_block *block = calloc(1, sizeof(*block) + size);
    if (can_fail)
        platform->resume_allocations(before);
    if (!block)
        abort();
    block->next = play->blocks;
    play->blocks = block;
    return block->bytes;
}

const void *play_copy_for_call(struct play *play, const void *array, size_t size)
{
    return memcpy(play_block(play, size), array, size);
}

void play_lend(struct play *play, const void *array, size_t size)
{
    play->lent = array;
    play->lent_size = size;
    play->lent_before = play_copy_for_call(play, array, size);
}

void play_expect_unmodified(struct play *play)
{
    if (memcmp(play->lent, play->lent_before, play->lent_size) == 0)
        return;
    report_say(&play->report, "the call has modified its parameters\n");
    play->report.outcome = OUTCOME_FAILED;
}

void play_free_blocks(struct play *play)
{
    while (play->blocks) {
        struct play_block *next = play->blocks->next;
        free(play->blocks);
        play->blocks = next;
    }
}

/* ---- what ends a program */

_Noreturn void play_fail(const struct play *play, const char *what)
{
    if (unjudged)
        leave_line();
    const struct program_line *line = &play->program->lines[play->at];
    fprintf(stderr, "%s, line %u: not understood: %s\n    %s\n", play->program->name, line->number,
            what, line->text);
    exit(2);
}

void play_note_result(struct play *play, VkResult result)
{
    if (play->result == VK_SUCCESS &&
        (result < 0 || result == VK_NOT_READY || result == VK_TIMEOUT))
        play->result = result;
}

void play_give_up_if_scarce(struct play *play, VkResult result)
{
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY && play->repeats)
        longjmp(play->gives_up, 1);
}

void play_end_recording(struct play *play, VkCommandBuffer commands)
{
    const VkResult result = play->vk.EndCommandBuffer(commands);
    play_give_up_if_scarce(play, result);
    play_note_result(play, result);
}

/* ---- lines */

/* close [leaving NAME...]: destroys all objects but these structures, and the device, which other
 * programs do not share then */
static void close_all(struct play *play, char **words)
{
    for (char **name = words + 1; words[1] && *++name;)
        play_object(play, *name)->structure = VK_NULL_HANDLE;
    play_destroy_objects(play);
    play_close_device(play);
    play->is_closed = true;
}

static void play_command(struct play *play, char **words)
{
    if (play_is(words[0], "alias"))
        play_alias(play, words);
    else if (play_is(words[0], "back"))
        play_back(play, words);
    else if (play_is(words[0], "place"))
        play_put(play, words);
    else if (play_is(words[0], "init"))
        play_init(play, words);
    else if (play_is(words[0], "close"))
        close_all(play, words);
    else if (!play_fault(play, words) && !play_foreign(play, words) && !play_host(play, words) &&
             !play_label(play, words) && !play_messenger(play, words) && !play_wild(play, words) &&
             !play_command_buffer(play, words) && !play_life(play, words) &&
             !play_records(play, words) && !play_submit(play, words) && !play_sync(play, words) &&
             !play_shader(play, words) && !play_cpu(play, words) && !play_copy(play, words) &&
             !play_reference(play, words) && !play_build(play, words))
        play_fail(play, "unknown command");
}

/* A call that the messenger asks to skip returns VK_ERROR_VALIDATION_FAILED_EXT, if anything. */
static void judge_result(struct play *play, const struct program_line *line, bool is_mistake)
{
    const VkResult expected = line->result ? play_result_named(play, line->result) : VK_SUCCESS;
    if (play->result == expected || play->is_scarce ||
        (is_mistake && !line->result && play->result == VK_ERROR_VALIDATION_FAILED_EXT))
        return;
    report_say(&play->report, "the call returned %d instead of %d\n", play->result, expected);
    play->report.outcome = OUTCOME_FAILED;
}

/* `repeat COUNT` executes the commands behind it COUNT times; these may have another `repeat`. */
void play_words(struct play *play, char *const *line)
{
    char *words[PROGRAM_WORDS + 1];
    size_t count = 0;
    while (line[count])
        count++;
    memcpy(words, line, (count + 1) * sizeof(words[0]));
    for (char **word = words; *word;) {
        if (play_is(word[0], "repeat")) {
            for (uint64_t i = play_number(play, word[1]); i > 0; i--)
                play_words(play, word + 2);
            return;
        }
        if (play_is(word[0], "floats")) {
            play_floats(play, word);
            return;
        }
        if (play_is(word[0], "when")) {
            play_await(play);
            return;
        }
        char **end = word;
        while (*end && !play_is(*end, ";"))
            end++;
        const bool is_last = !*end;
        *end = NULL;
        if (*word)
            play_command(play, word);
        word = is_last ? end : end + 1;
    }
}

/* Judges what the layer reported since the last time. */
static bool judge_line(struct play *play, unsigned line)
{
    if (!play_judges_whole(play)) {
        play_judge(play, (int)line);
        messages_clear(&play->fixture.messages);
    }
    if (play->report.outcome == OUTCOME_FAILED)
        report_program(&play->report, play->program, play->at);
    return play->report.outcome == OUTCOME_PASSED;
}

/* A line ends where something fails, or is missing. */
static void play_unjudged(struct play *play, const struct program_line *line)
{
    unjudged = play;
    get_fails = leave_line;
    play->fixture.messages.answer = play->answer;
    if (setjmp(play->next_line) == 0) {
        play_words(play, line->words);
    } else {
        play->recording = NULL;
        play->secondary = VK_NULL_HANDLE;
    }
    play->fixture.messages.answer = VK_FALSE;
    messages_clear(&play->fixture.messages);
    get_fails = NULL;
    unjudged = NULL;
}

/* ---- lines that hang */

#ifdef _WIN32 /* has no alarm */
static void watch(const struct play *play)
{
    (void)play;
}

static void stop_watching(void) {}
#else
enum { LINE_HANGS = 120 /* seconds; no line takes as long, however busy the machine is */ };

static const struct play *_Atomic watched; /* of several threads, the last one */

static void say(const char *text)
{
    const ssize_t written = write(STDERR_FILENO, text, strlen(text));
    (void)written;
}

/* A call of the program does not return, so only the process can end. */
static void report_hang(int number)
{
    const struct play *play = watched;
    (void)number;
    say(play->program->name);
    say(": hangs, in the line\n    ");
    say(play->at < play->program->line_count ? play->program->lines[play->at].text
                                             : "behind the last one");
    say("\n");
    _exit(1);
}

/* Ends the process if nothing more is played for a long time. */
static void watch(const struct play *play)
{
    if (!watched)
        signal(SIGALRM, report_hang);
    watched = play;
    alarm(LINE_HANGS);
}

static void stop_watching(void)
{
    alarm(0);
}
#endif

bool play_line(struct play *play, unsigned line)
{
    const struct program_line *played = &play->program->lines[line];
    const bool is_mistake = play_expects_mistake(play, (int)line);
    if (play_is_setup(played))
        return true;
    play->at = line;
    watch(play);
    play->result = VK_SUCCESS;
    if (play->is_unjudged) {
        play_unjudged(play, played);
    } else {
        play->fixture.messages.answer = is_mistake;
        play_words(play, played->words);
        play->fixture.messages.answer = VK_FALSE;
        judge_result(play, played, is_mistake);
    }
    if (!play->keeps_blocks)
        play_free_blocks(play);
    return play->is_unjudged || judge_line(play, line);
}

void play_text(struct play *play, struct program *program, const char *format, ...)
{
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    program->line_count = 0;
    program->used = 0;
    program_add(program, text, 1);
    play_line(play, 0);
}

/* ---- programs */

bool play_begin(struct play *play, const struct program *program)
{
    play->program = program;
    play->report = (struct report){.outcome = OUTCOME_PASSED};
    play->was_lost = false;
    play->is_unjudged = program_find(program, "unjudged", NULL);
    play->keeps_blocks = false;
    play->answer = VK_FALSE;
    play->last_size = 0;
    play->at = 0;
    const char *unknown = play_unknown_extension(program);
    if (unknown) {
        play->report.outcome = OUTCOME_FAILED;
        report_say(&play->report, "with %s: tests/player/device.c has no such extension\n",
                   unknown);
        return false;
    }
    const char *missing = play_open_device(play);
    if (missing) {
        play->report.outcome = OUTCOME_SKIPPED;
        report_say(&play->report, "%s", missing);
        return false;
    }
    messages_clear(&play->fixture.messages);
    play->is_closed = false;
    play_create_objects(play);
    play_note_references(play);
    if (!play->is_unjudged)
        play_skip_records(play);
    return true;
}

void play_end(struct play *play)
{
    if (!play->is_closed)
        play_destroy_objects(play);
    play_free_blocks(play);
    if (play->was_lost || play->is_unjudged || program_find(play->program, "alone", NULL) ||
        program_find(play->program, "fault", NULL))
        play_close_device(play);
    play_destroy_messenger(play);
    if (play->platform->is_null)
        play->platform->null_driver.reset();
    stop_watching();
}

void play_program(struct play *play, const struct program *program)
{
    if (!play_begin(play, program))
        return;
    const bool has_given_up = setjmp(play->gives_up) != 0;
    for (unsigned i = 0;
         !has_given_up && i < program->line_count && play->report.outcome == OUTCOME_PASSED; i++)
        play_line(play, i);
    const bool is_held = play->is_unjudged || program_find(program, "alone", NULL);
    if (play->report.outcome == OUTCOME_PASSED && !is_held && !has_given_up) {
        play->at = program->line_count - 1;
        if (!play->is_closed)
            play_finish(play);
        if (play_judges_whole(play))
            play_judge(play, -1);
        judge_line(play, program->line_count);
    } else if (!play->is_closed) {
        if (play->platform->is_null)
            play->platform->null_driver.end_hang();
        play->vk.DeviceWaitIdle(play->device);
    }
    play_end(play);
}
