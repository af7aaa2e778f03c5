/* SPDX-License-Identifier: Apache-2.0 */
/* What a case or a program expects of messages, and why it failed or was skipped. */
#ifndef ASSAY_TESTS_PLAYER_REPORT_H
#define ASSAY_TESTS_PLAYER_REPORT_H

#include "tests/fixture/messages.h"

enum outcome { OUTCOME_PASSED, OUTCOME_FAILED, OUTCOME_SKIPPED };
enum { REPORT_TEXT_MAX = 32 * 1024 };

struct report {
    enum outcome outcome;
    char text[REPORT_TEXT_MAX]; /* why it failed or was skipped */
};

__attribute__((format(printf, 2, 3))) void report_say(struct report *report, const char *format,
                                                      ...);

/* Adds the program, with a mark at the line of that index. */
struct program;
void report_program(struct report *report, const struct program *program, unsigned at);

/* A message that is expected. */
struct expected_message {
    const char *id;   /* the end of it */
    const char *text; /* see report_text_matches(); NULL: any */
    bool is_any;      /* several messages may have the id, of which one has the text */
};

/* Marks the messages that fit. Returns false if none does, and says so if `report` is not NULL. */
bool report_expect(struct report *report, const struct messages *messages,
                   const struct expected_message *expected, bool *is_expected);
/* Returns whether it is good so far, and all messages are marked; else says which came. */
bool report_judge(struct report *report, const struct messages *messages, const bool *is_expected,
                  bool good);
/* Returns whether there are no messages; else says which came in `call`, and when. */
bool report_expect_none(struct report *report, const struct messages *messages, const char *call,
                        const char *when);

/* Whether it is the whole id of a message, or the end of it behind a "-". */
bool report_id_ends(const char *id, const char *end);
/* Returns true if the parts of `wanted`, with " ... " between them, are in `text`, in this order;
 * what follows `NOT ` must not be in the rest. */
bool report_text_matches(const char *text, const char *wanted);
/* Where the sentence of the specification begins: it is not the layer's, and no message is expected
 * by it. */
const char *report_own_end(const struct message *message);

/* Whether what messages say beside the mistake is right: the hint of the row, counts that agree
 * with their nouns, and no id twice. */
bool report_judge_wording(struct report *report, const struct messages *messages);

#endif
