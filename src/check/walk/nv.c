/* SPDX-License-Identifier: Apache-2.0 */
/* The rows of the NV command's subjects, as code: see walk.c. */
#include "rows_by_subject.h"
#include "src/check/walk/walk.h"
#include "src/rules/predicates.h"

/* Asks one predicate, if its row is of the level and wanted. */
#define ASK(name, row_level, view)                                                                 \
    if (LEVEL_##row_level == level && walk->wants[RULE_##name] && !name(view, &finding))           \
        walk_report(walk, RULE_##name, &location, &finding);

#define ASK_NV_CALL(name, level) ASK(name, level, nv_call)

void walk_nv_call(struct walk *walk, const struct nv_call_view *nv_call, enum level level)
{
    const struct location location = {.command = COMMAND_NV, .subject = SUBJECT_PARAMETER};
    struct finding finding;
    ROWS_OF_nv_call(ASK_NV_CALL);
}

#define ASK_NV_INFO(name, level) ASK(name, level, nv_info)

void walk_nv_info(struct walk *walk, const struct nv_info_view *nv_info, enum level level)
{
    const struct location location = {.command = COMMAND_NV, .subject = SUBJECT_BUILD};
    struct finding finding;
    ROWS_OF_nv_info(ASK_NV_INFO);
}

#define ASK_NV_GEOMETRY(name, level) ASK(name, level, nv_geometry)

void walk_nv_geometry(struct walk *walk, const struct nv_geometry_view *nv_geometry,
                      enum level level)
{
    const struct location location = {
        .command = COMMAND_NV, .subject = SUBJECT_GEOMETRY, .geometry = nv_geometry->index};
    struct finding finding;
    ROWS_OF_nv_geometry(ASK_NV_GEOMETRY);
}
