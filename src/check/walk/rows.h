/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluates the rules of a subject. ROWS_OF_subject(ROW, ...), which vuid-tables/subjects.py
 * generates from rules.def, expands to ROW(name, LEVEL, ...) for each row of a subject. The macros
 * below define functions with it. Include this file only in sources that define such functions. */
#ifndef ASSAY_CHECK_WALK_ROWS_H
#define ASSAY_CHECK_WALK_ROWS_H

#include "rows_by_subject.h"
#include "src/check/walk/walk.h"
#include "src/rules/predicates.h"

/* Evaluates one predicate if its rule is active. `location` is evaluated for a finding only. */
#define EVALUATE(name, row_level, view, location)                                                  \
    if (walk->active[RULE_##name] && !name(view, &finding))                                        \
        walk_report(walk, RULE_##name, location, &finding);

/* Evaluates one predicate if its rule is active and its row has `level`. */
#define EVALUATE_AT_LEVEL(name, row_level, view, location)                                         \
    if (LEVEL_##row_level == level && walk->active[RULE_##name] && !name(view, &finding))          \
        walk_report(walk, RULE_##name, location, &finding);

/* Defines walk_SUBJECT(walk, view, level), which evaluates the rows of one of the two levels of a
 * call. The rows are expanded once for each level, and the compiler removes those of the other
 * level. `location` is an expression of the view, which has the name of the subject. */
#define WALK_LEVEL(subject, location)                                                              \
    static inline __attribute__((always_inline)) void evaluate_##subject(                          \
        struct walk *walk, const struct subject##_view *subject, enum level level)                 \
    {                                                                                              \
        struct finding finding;                                                                    \
        ROWS_OF_##subject(EVALUATE_AT_LEVEL, subject, location)                                    \
    }                                                                                              \
    void walk_##subject(struct walk *walk, const struct subject##_view *subject, enum level level) \
    {                                                                                              \
        if (level == LEVEL_PARAMETERS)                                                             \
            evaluate_##subject(walk, subject, LEVEL_PARAMETERS);                                   \
        else                                                                                       \
            evaluate_##subject(walk, subject, LEVEL_STATE);                                        \
    }

/* Defines walk_SUBJECT(walk, view, location), which evaluates the rows of all levels, for subjects
 * that are validated once. */
#define WALK_ALL(subject)                                                                          \
    void walk_##subject(struct walk *walk, const struct subject##_view *subject,                   \
                        const struct location *location)                                           \
    {                                                                                              \
        struct finding finding;                                                                    \
        ROWS_OF_##subject(EVALUATE, subject, *location)                                            \
    }

#endif
