/* SPDX-License-Identifier: Apache-2.0 */
/* Each hard case of tests/numeric is named by the report of assay-scene: its input by a detector of
 * fragile inputs, or its rays by a set of rays. */
int numeric_main(int count, char **arguments);
#define main numeric_main
#include "tests/numeric/main.c"
#undef main
#include <string.h>

#include "src/scene/report/report.h"

#define SET_NAME(kind, text, says) text,
static const char *const sets[] = {RAY_SET_LIST(SET_NAME)};

static struct fragile_list found; /* of the case that runs */

void *__real_fixture_build(const struct builder_input *input, struct builder_report *to);
void *__wrap_fixture_build(const struct builder_input *input, struct builder_report *to);
void *__wrap_fixture_build(const struct builder_input *input, struct builder_report *to)
{
    void *structure = __real_fixture_build(input, to);
    fragile_find(input, structure, &found);
    return structure;
}

static bool is_named(const char *name)
{
    for (uint32_t i = 0; i < found.count; i++)
        if (strcmp(fragile_name(found.items[i].kind), name) == 0)
            return true;
    for (size_t i = 0; i < sizeof(sets) / sizeof(sets[0]); i++)
        if (strcmp(sets[i], name) == 0)
            return true;
    return false;
}

int main(void)
{
    int missing = 0;
    for (int i = 1; i <= CASES; i++) {
        current = cases[i];
        setting = (struct setting){BUILDER_BALANCED, TRACE_EXACT, 1};
        fixture_scope_begin();
        current->run();
        fixture_scope_end();
        const bool is_good =
            current->report_name ? is_named(current->report_name) : found.count == 0;
        missing += !is_good;
        printf("case %d (%s)%s", i, current->name, is_good ? ":" : " MISSES ");
        printf("%s:", is_good ? "" : current->report_name ? current->report_name : "nothing");
        for (uint32_t n = 0; n < found.count; n++)
            printf(" [%s %g]", fragile_name(found.items[n].kind), found.items[n].figure);
        printf("\n");
        found.count = 0;
    }
    free(found.items);
    printf("%d of %d cases are named\n", CASES - missing, CASES);
    return missing != 0;
}
