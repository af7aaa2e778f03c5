/* SPDX-License-Identifier: Apache-2.0 */
#include "src/report/reported_queries.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

enum { WORDS_OF_PLACE = 8, WORDS_OF_VALUE = 3 };

/* Texts are literals: equal ones mostly have one address, and else count as different. */
uint64_t reported_query(enum rule rule, const struct location *location,
                        const struct finding *finding, const struct call_site *site)
{
    uint64_t words[WORDS_OF_PLACE + WORDS_OF_VALUE * FINDING_VALUES] = {
        rule,
        location->subject,
        location->geometry,
        location->geometry_by_pointer,
        (uintptr_t)location->argument,
        (uintptr_t)finding->field,
        (uintptr_t)finding->says,
        (uintptr_t)site,
    };
    for (uint32_t i = 0; i < finding->value_count; i++) {
        const struct value *value = &finding->values[i];
        uint64_t *to = words + WORDS_OF_PLACE + (size_t)WORDS_OF_VALUE * i;
        to[0] = value->kind;
        to[1] = value->number;
        to[2] = (uintptr_t)value->text;
    }
    return (XXH3_64bits(words, sizeof(words)) | 2) & ~REPORTED_SKIPS;
}

uint64_t reported_queries_find(struct reported_queries *reported, uint64_t query)
{
    for (uint32_t i = 0; i < REPORTED_QUERIES; i++) {
        const uint64_t item = atomic_load(&reported->items[i]);
        if ((item & ~REPORTED_SKIPS) == query)
            return item;
    }
    return 0;
}

void reported_queries_add(struct reported_queries *reported, uint64_t query)
{
    atomic_store(&reported->items[atomic_fetch_add(&reported->next, 1) % REPORTED_QUERIES], query);
}
