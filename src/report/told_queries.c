/* SPDX-License-Identifier: Apache-2.0 */
#include "src/report/told_queries.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

enum { WORDS_OF_PLACE = 8, WORDS_OF_VALUE = 3 };

/* Texts are literals: equal ones mostly have one address, and else count as different. */
uint64_t told_query(enum rule rule, const struct location *location, const struct finding *finding,
                    const struct call_site *site)
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
    return (XXH3_64bits(words, sizeof(words)) | 2) & ~TOLD_SKIPS;
}

uint64_t told_queries_find(struct told_queries *told, uint64_t query)
{
    for (uint32_t i = 0; i < TOLD_QUERIES; i++) {
        const uint64_t item = atomic_load(&told->items[i]);
        if ((item & ~TOLD_SKIPS) == query)
            return item;
    }
    return 0;
}

void told_queries_add(struct told_queries *told, uint64_t query)
{
    atomic_store(&told->items[atomic_fetch_add(&told->next, 1) % TOLD_QUERIES], query);
}
