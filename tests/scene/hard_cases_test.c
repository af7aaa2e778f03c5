/* SPDX-License-Identifier: Apache-2.0 */
/* Each hard case of tests/numeric is named by the report of assay-scene: its input by a detector of
 * fragile inputs, or its rays by a set of rays. */
int numeric_main(int count, char **arguments);
#define main numeric_main
#include "tests/numeric/main.c"
#undef main
#include <string.h>

#include "src/scene/report/report.h"

/* The name of a detector or of a set of rays for each case, by number. */
static const char *const names[CASES + 1] = {
    [1] = "inactive",
    [2] = "NaN in Y or Z",
    [3] = "inactive",
    [4] = "inactive",
    [5] = "two corners at one position",
    [6] = "two corners at one position",
    [7] = "corners on one line",
    [8] = "sliver",
    [9] = "one center",
    [10] = "coincident triangles",
    [11] = "axis without extent",
    [12] = "outlier",
    [13] = "products of coordinates underflow",
    [14] = "products of coordinates overflow",
    [15] = "small beside large",
    [16] = "axis", /* the builder makes +0 of -0: what is left are directions with -0 */
    [17] = "infinite box",
    [18] = "minimum above maximum",
    [19] = "box without extent",
    [20] = "boxes",
    [21] = "boxes",
    [22] = "axis",
    [23] = "shared edges",
    [24] = "vertices",
    [25] = "open edges",
    [26] = "surface",
    [27] = "surface",
    [28] = "boxes",
    [29] = "products of coordinates overflow",
    [30] = "axis",
    [31] = "far origin",
    [32] = "singular transform",
    [33] = "ill-scaled transform",
    [34] = "mirrored transform",
    [35] = "offsets in the build range",
    [36] = "positions of 16 bits or fewer",
    [37] = "positions of 16 bits or fewer",
    [38] = "fourth component",
    [39] = "offsets in the build range",
    [40] = "index out of range",
    [41] = "nothing active",
    [42] = "instance without a structure",
    [43] = "mask 0",
    [44] = "shared edges", /* its refits: "refits" of the report */
    [45] = "deep tree",
    [46] = "open edges",   /* about the builder's threads */
    [47] = "shared edges", /* about copies of structures */
    [48] = "motion",
    [49] = "motion",
    [50] = "motion",
    [51] = "motion",
    [52] = "motion",
    [53] = "motion",
    [54] = NULL, /* builds nothing */
    [55] = "opacity micromaps",
    [56] = "opacity micromaps",
    [57] = "opacity micromaps",
    [58] = "opacity micromaps",
    [59] = "spheres",
    [60] = "spheres",
    [61] = "spheres",
    [62] = "spheres",
    [63] = "spheres",
    [64] = "spheres",
    [65] = "dense geometry",
    [66] = "dense geometry",
    [67] = "dense geometry",
    [68] = "displacement",
    [69] = "displacement",
    [70] = "displacement",
    [71] = "displacement",
    [72] = "displacement",
    [73] = "displacement",
    [74] = "displacement",
    [75] = "displacement",
};

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
        const bool is_good = names[i] ? is_named(names[i]) : found.count == 0;
        missing += !is_good;
        printf("case %d (%s)%s", i, current->name, is_good ? ":" : " MISSES ");
        printf("%s:", is_good ? "" : names[i]);
        for (uint32_t n = 0; n < found.count; n++)
            printf(" [%s %g]", fragile_name(found.items[n].kind), found.items[n].figure);
        printf("\n");
        found.count = 0;
    }
    free(found.items);
    printf("%d of %d cases are named\n", CASES - missing, CASES);
    return missing != 0;
}
