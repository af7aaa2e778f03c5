/* SPDX-License-Identifier: Apache-2.0 */
/* Programs of submits as text. */
#include <stdlib.h>
#include <string.h>

#include "program.h"

enum { TEXT_MAX = 2048, WORDS_MAX = 24 };

static bool is(const char *word, const char *other)
{
    return word && strcmp(word, other) == 0;
}

static uint32_t number_of(const char *word)
{
    char *end;
    const uint32_t number = word ? (uint32_t)strtoul(word, &end, 10) : 0;
    if (!word || end == word || *end)
        fail_msg("\"%s\" is no number", word ? word : "");
    return number;
}

static uint32_t object_of(const char *word)
{
    static const char names[] = "STUFG";
    const char *at = word && *word ? strchr(names, *word) : NULL;
    if (!at)
        fail_msg("\"%s\" is no object", word ? word : "");
    return (uint32_t)(at - names) + 1;
}

static bool is_fence(const char *word)
{
    return *word == 'F' || *word == 'G';
}

static struct operation operation_of(const char *word)
{
    const char *after = word + 1;
    struct operation operation = {.semaphore = object_of(word)};
    if (*after == '=' || *after == '>')
        operation.value = number_of(after + 1);
    else if (is(after, "/builds"))
        operation.reach = REACH_BUILDS;
    else if (is(after, "/nothing"))
        operation.reach = REACH_NOTHING;
    else if (*after)
        fail_msg("\"%s\" is no operation", word);
    return operation;
}

/* Reads a batch up to "then" or the end, and returns what follows. */
static const char *const *read_batch(struct call *call, const char *const *words)
{
    struct operation *operations = NULL;
    while (*++words && !is(*words, "then"))
        if (is(*words, "waits"))
            operations = call->wait;
        else if (is(*words, "signals"))
            operations = call->signal;
        else if (is(*words, "on"))
            call->queue = number_of(*++words);
        else if (is(*words, "fence"))
            call->fence = object_of(*++words);
        else if (is(*words, "begins"))
            call->is_under_way = true;
        else if (is(*words, "fails"))
            call->result = VK_ERROR_OUT_OF_HOST_MEMORY;
        else if (is(*words, "loses"))
            call->result = VK_ERROR_DEVICE_LOST;
        else if (operations)
            *operations++ = operation_of(*words);
        else
            fail_msg("\"%s\" is no part of a batch", *words);
    return words;
}

static void play_call(struct program *program, enum submission_kind kind, const char *const *words)
{
    const uint32_t name = number_of(*words);
    struct submission *submission = NULL;
    struct call call = {.queue = kind == SUBMIT_HOST_WORK ? 0 : name / 10};
    for (bool is_last = false; !is_last; words++) {
        call = (struct call){.name = number_of(*words), .queue = call.queue};
        words = read_batch(&call, words);
        if (!submission)
            submission = submission_begin(program->order, kind, QUEUE(call.queue));
        call_add_batch(submission, &call);
        is_last = !*words;
    }
    submission_set_fence(submission, FENCE(call.fence));
    assert_false(submission_prepare(submission));
    if (call.is_under_way) {
        assert_true(name < PROGRAM_NAMES);
        program->under_way[name] = submission;
    } else {
        submission_finish(submission, call.result);
    }
}

/* The end of a call under way. */
static bool end_call(struct program *program, const char *const *words)
{
    if (!is(words[1], "returns") && !is(words[1], "failed"))
        return false;
    struct submission *submission = program->under_way[number_of(*words)];
    assert_non_null(submission);
    submission_finish(submission,
                      is(words[1], "failed") ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_SUCCESS);
    return true;
}

static void expect_order(const struct program *program, uint32_t name, bool after,
                         const char *const *words)
{
    for (; *words; words++)
        if (follows(program, name, number_of(*words)) != after)
            fail_msg("%u %s %s", name, after ? "doesn't follow" : "follows", *words);
}

/* `said` of a wait or a signal: which signal it names, the last one of a batch. */
static void expect_signal(const struct program *program, uint32_t name, bool is_wait,
                          const char *word)
{
    const struct semaphore_operation *operation = find_operation(program, name, !is_wait);
    const uint64_t expected =
        is(word, "nothing") ? 0 : find_operation(program, number_of(word), true)->signal;
    const uint64_t found = is_wait ? operation->signal : operation->previous;
    assert_false(operation->is_met);
    if (found != expected || (!expected && !is(word, "nothing")))
        fail_msg("%u names signal %u, not %u", name, (uint32_t)found, (uint32_t)expected);
}

/* What is said of a batch that was submitted; false if it is submitted only now. */
static bool expect(const struct program *program, const char *const *words)
{
    const char *said = words[1];
    const uint32_t name = number_of(words[0]);
    const struct heard *run = find_run(program, name);
    if (is(said, "after"))
        expect_order(program, name, true, words + 2);
    else if (is(said, "not") && is(words[2], "after"))
        expect_order(program, name, false, words + 3);
    else if (is(said, "known") || is(said, "unknown"))
        assert_true(run && run->predecessors_known == is(said, "known"));
    else if (is(said, "checked") || is(said, "unchecked"))
        assert_true(run && run->checked == is(said, "checked"));
    else if (is(said, "met"))
        assert_true(find_operation(program, name, false)->is_met);
    else if (is(said, "ends") || is(said, "behind"))
        expect_signal(program, name, is(said, "ends"), words[2]);
    else
        return false;
    return true;
}

static void expect_ran(const struct program *program, const char *const *words)
{
    uint32_t count = 0;
    for (; *words; words++, count++)
        assert_true(count < program->run_count && program->runs[count].name == number_of(*words));
    assert_int_equal(program->run_count, count);
}

/* What the host does with an object. */
static void touch(struct program *program, const char *verb, const char *word)
{
    const struct operation given = operation_of(word);
    if (is(verb, "signals"))
        signal_on_host(program, given.semaphore, given.value);
    else if (is(verb, "resets"))
        execution_order_reset_fence(program->order, FENCE(given.semaphore));
    else if (is(verb, "sees") && is_fence(word))
        execution_order_observe_fence(program->order, FENCE(given.semaphore));
    else if (is(verb, "sees"))
        execution_order_observe_semaphore(program->order, SEMAPHORE(given.semaphore), given.value,
                                          word[1] == '=');
    else if (is_fence(word))
        execution_order_remove_fence(program->order, FENCE(given.semaphore));
    else
        execution_order_remove_semaphore(program->order, SEMAPHORE(given.semaphore));
}

/* Expects what the hooks have counted. */
static bool expect_count(const struct program *program, const char *const *words)
{
    const struct {
        const char *name;
        uint32_t count;
    } counts[] = {{"checks", program->checks},     {"drops", program->drops},
                  {"losses", program->losses},     {"begun", program->begins},
                  {"failures", program->failures}, {"captured", program->captured}};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); i++)
        if (is(*words, counts[i].name)) {
            if (counts[i].count != number_of(words[1]))
                fail_msg("%u %s", counts[i].count, *words);
            return true;
        }
    return false;
}

static bool create(struct program *program, const char *kind, const char *const *words)
{
    const bool is_timeline = is(kind, "timeline") || is(kind, "shared");
    if (!is_timeline && !is(kind, "binary") && !is(kind, "fence"))
        return false;
    for (; *words; words++) {
        const struct operation given = operation_of(*words);
        if (is(kind, "fence"))
            execution_order_add_fence(program->order, FENCE(given.semaphore), false, false);
        else
            execution_order_add_semaphore(program->order, SEMAPHORE(given.semaphore),
                                          is_timeline ? VK_SEMAPHORE_TYPE_TIMELINE
                                                      : VK_SEMAPHORE_TYPE_BINARY,
                                          given.value, is(kind, "shared"));
    }
    return true;
}

static void play_statement(struct program *program, const char *const *words)
{
    if (is(*words, "idle"))
        wait_idle(program, words[1] ? number_of(words[1]) : 0);
    else if (is(*words, "ran"))
        expect_ran(program, words + 1);
    else if (is(*words, "bind"))
        play_call(program, SUBMIT_BINDINGS, words + 1);
    else if (is(*words, "work"))
        play_call(program, SUBMIT_HOST_WORK, words + 1);
    else if (is(*words, "host") && is(words[1], "signals"))
        touch(program, words[1], words[2]);
    else if (is(*words, "sees") || is(*words, "resets") || is(*words, "destroys"))
        touch(program, *words, words[1]);
    else if (!create(program, *words, words + 1) && !expect_count(program, words) &&
             !end_call(program, words) && !expect(program, words))
        play_call(program, SUBMIT_COMMANDS, words);
}

void play(struct program *program, const char *script)
{
    char text[TEXT_MAX], *rest, *statement_rest;
    assert_true(strlen(script) < sizeof(text));
    strcpy(text, script);
    for (char *statement = strtok_r(text, ";", &rest); statement;
         statement = strtok_r(NULL, ";", &rest)) {
        const char *words[WORDS_MAX] = {NULL};
        uint32_t count = 0;
        for (char *word = strtok_r(statement, " ", &statement_rest); word;
             word = strtok_r(NULL, " ", &statement_rest)) {
            assert_true(count + 1 < WORDS_MAX);
            words[count++] = word;
        }
        if (count)
            play_statement(program, words);
    }
}
