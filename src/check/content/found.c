/* SPDX-License-Identifier: Apache-2.0 */
/* Keeps the findings about the data of a geometry until all of it has been read. */
#include <stdlib.h>

#include "src/base/array.h"
#include "src/check/content/content.h"

static struct content_finding *find_finding(const struct content *content, enum rule rule)
{
    const struct content_findings *findings = &content->findings;
    for (uint32_t i = 0; i < findings->count; i++)
        if (findings->items[i].rule == rule)
            return &findings->items[i];
    return NULL;
}

/* Without memory the first finding is reported at once, and no other one of the rule. */
void content_found(struct content *content, enum rule rule, struct location location,
                   const struct finding *finding, const char *element, uint64_t number)
{
    struct content_findings *findings = &content->findings;
    struct content_finding *first = find_finding(content, rule);
    content->violations++;
    if (first && first->last != number) {
        first->last = number;
        first->finding.more++;
    } else if (!first && ARRAY_HAS_ROOM(findings->items, findings->count, findings->capacity)) {
        first = &findings->items[findings->count++];
        *first = (struct content_finding){rule, location, *finding, number};
        first->finding.element = element;
    } else if (!first) {
        walk_report(content->walk, rule, location, finding);
        walk_stop_rule(content->walk, rule);
    }
}

void content_report(struct content *content)
{
    for (uint32_t i = 0; i < content->findings.count; i++) {
        const struct content_finding *found = &content->findings.items[i];
        walk_report(content->walk, found->rule, found->location, &found->finding);
    }
    free(content->findings.items);
    content->findings = (struct content_findings){0};
}
