/* SPDX-License-Identifier: Apache-2.0 */
/* The one way to walk rows: ROWS_OF_subject(ROW, ...), which vuid-tables/subjects.py generates from
 * rules.def, expands to ROW(name, LEVEL, ...) for each row of a subject. The macros below make
 * functions of that. Only the sources that define such functions include this file. */
#ifndef ASSAY_CHECK_WALK_ROWS_H
#define ASSAY_CHECK_WALK_ROWS_H

#include "rows_by_subject.h"
#include "src/check/walk/walk.h"
#include "src/rules/predicates.h"

/* Asks one predicate, if its rule is wanted. `location` is evaluated only for a finding. */
#define ASK(name, row_level, view, location)                                                       \
    if (walk->wants[RULE_##name] && !name(view, &finding))                                         \
        walk_report(walk, RULE_##name, location, &finding);

/* The same, if its row is of `level`. */
#define ASK_AT_LEVEL(name, row_level, view, location)                                              \
    if (LEVEL_##row_level == level && walk->wants[RULE_##name] && !name(view, &finding))           \
        walk_report(walk, RULE_##name, location, &finding);

/* Defines walk_SUBJECT(walk, view, level), which walks the rows of one of the two levels that a
 * call decides. The rows are expanded once for each: the compiler leaves out those of the other
 * level. `location` is an expression of the view, which has the name of the subject. */
#define WALK_LEVEL(subject, location)                                                              \
    static inline __attribute__((always_inline)) void ask_##subject(                               \
        struct walk *walk, const struct subject##_view *subject, enum level level)                 \
    {                                                                                              \
        struct finding finding;                                                                    \
        ROWS_OF_##subject(ASK_AT_LEVEL, subject, location)                                         \
    }                                                                                              \
    void walk_##subject(struct walk *walk, const struct subject##_view *subject, enum level level) \
    {                                                                                              \
        if (level == LEVEL_PARAMETERS)                                                             \
            ask_##subject(walk, subject, LEVEL_PARAMETERS);                                        \
        else                                                                                       \
            ask_##subject(walk, subject, LEVEL_STATE);                                             \
    }

/* Defines walk_SUBJECT(walk, view, location), which walks all rows of a subject that is met once,
 * whatever their levels. */
#define WALK_ALL(subject)                                                                          \
    void walk_##subject(struct walk *walk, const struct subject##_view *subject,                   \
                        const struct location *location)                                           \
    {                                                                                              \
        struct finding finding;                                                                    \
        ROWS_OF_##subject(ASK, subject, *location)                                                 \
    }

#endif
