/* SPDX-License-Identifier: Apache-2.0 */
#include "src/hazards/ranges.h"

#include <stdlib.h>
#include <string.h>

#include "src/platform/aligned.h"

/* A search that takes more steps from leaf to leaf adds what it finds to the index. */
enum { LONG_WALK = 4 };

/* ---- leaves */

/* Adds an empty leaf behind another one, or at the front. Returns NULL if memory runs out. */
static struct leaf *leaf_insert(struct ranges *ranges, struct leaf *prev)
{
    struct leaf *leaf = aligned_allocate(_Alignof(struct leaf), sizeof(*leaf));
    if (!leaf)
        return NULL;
    leaf->count = 0;
    leaf->prev = prev;
    leaf->next = prev ? prev->next : ranges->first;
    *(leaf->prev ? &leaf->prev->next : &ranges->first) = leaf;
    *(leaf->next ? &leaf->next->prev : &ranges->last) = leaf;
    ranges->leaf_count++;
    ranges->debt++;
    return leaf;
}

/* Takes an empty leaf out. The index and fingers may still have it until index_renew(). */
static void leaf_remove(struct ranges *ranges, struct leaf *leaf)
{
    *(leaf->prev ? &leaf->prev->next : &ranges->first) = leaf->next;
    *(leaf->next ? &leaf->next->prev : &ranges->last) = leaf->prev;
    leaf->next = ranges->removed;
    ranges->removed = leaf;
    ranges->leaf_count--;
    ranges->debt++;
}

/* Moves the second half of a full leaf to a new leaf behind. Returns false if memory runs out. */
static bool leaf_split(struct ranges *ranges, struct leaf *leaf)
{
    const uint32_t half = LEAF_PIECES / 2;
    struct leaf *behind = leaf_insert(ranges, leaf);
    if (!behind)
        return false;
    memcpy(behind->pieces, &leaf->pieces[half], half * sizeof(leaf->pieces[0]));
    behind->count = leaf->count = half;
    return true;
}

/* ---- the index */

static void free_removed(struct ranges *ranges)
{
    for (struct leaf *leaf = ranges->removed; leaf;) {
        struct leaf *next = leaf->next;
        aligned_free(leaf);
        leaf = next;
    }
    ranges->removed = NULL;
}

/* Makes room in the index for all leaves. Returns false if memory runs out. */
static bool index_grow(struct ranges *ranges)
{
    if (ranges->leaf_count <= ranges->index_capacity)
        return true;
    const size_t capacity = ranges->leaf_count + ranges->leaf_count / 2;
    struct range_index *index = malloc(capacity * sizeof(*index));
    if (!index)
        return false;
    free(ranges->index);
    ranges->index = index;
    ranges->index_count = 0;
    ranges->index_capacity = capacity;
    return true;
}

/* Lets the index have all leaves. Without memory, it lacks only those that were removed. */
static void index_renew(struct ranges *ranges)
{
    size_t count = 0;
    if (index_grow(ranges)) {
        for (struct leaf *leaf = ranges->first; leaf; leaf = leaf->next)
            ranges->index[count++] = (struct range_index){leaf->pieces[0].begin, leaf};
    } else {
        for (size_t i = 0; i < ranges->index_count; i++)
            if (ranges->index[i].leaf->count)
                ranges->index[count++] = ranges->index[i];
    }
    ranges->index_count = count;
    for (uint32_t i = 0; i < RANGE_FINGERS; i++)
        if (ranges->fingers[i].leaf && !ranges->fingers[i].leaf->count)
            ranges->fingers[i].leaf = NULL;
    free_removed(ranges);
    ranges->debt = 0;
}

/* Adds a leaf behind an element of the index, if there is room. */
static void index_insert(struct ranges *ranges, size_t at, struct leaf *leaf)
{
    if (ranges->index_count == ranges->index_capacity || at >= ranges->index_count)
        return;
    struct range_index *before = &ranges->index[at];
    memmove(before + 2, before + 1, (ranges->index_count - at - 1) * sizeof(*before));
    before[1] = (struct range_index){leaf->pieces[0].begin, leaf};
    if (before[1].first < before->first) /* it has changed since */
        before[1].first = before->first;
    ranges->index_count++;
}

/* Returns the last leaf that begins at or before `at`, or the first leaf. The index may lack some
 * leaves and have removed ones: the rest of the way goes from leaf to leaf. */
static struct leaf *leaf_search(struct ranges *ranges, uint64_t at)
{
    size_t low = 0, count = ranges->index_count;
    while (count > 1) {
        const size_t half = count / 2;
        low = ranges->index[low + half].first <= at ? low + half : low;
        count -= half;
    }
    while (low > 0 && !ranges->index[low].leaf->count)
        low--;
    struct leaf *leaf = ranges->index_count ? ranges->index[low].leaf : ranges->first;
    leaf = leaf->count ? leaf : ranges->first;
    uint32_t steps = 0;
    for (; leaf->prev && leaf->pieces[0].begin > at; leaf = leaf->prev)
        ranges->debt++;
    for (; leaf->next && leaf->next->pieces[0].begin <= at; leaf = leaf->next)
        steps++;
    ranges->debt += steps;
    if (steps > LONG_WALK)
        index_insert(ranges, low, leaf);
    return leaf;
}

/* ---- search */

/* Returns the first of the pieces [low, high) that ends behind `at`, or `high`. */
static uint32_t piece_search(const struct piece *pieces, uint32_t low, uint32_t high, uint64_t at)
{
    while (low < high) {
        const uint32_t middle = (low + high) / 2;
        if (pieces[middle].end <= at)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Returns the first piece of a leaf that ends behind `at`, or the count. Pieces often have the same
 * size, so the search begins at the place that `at` would have then. */
static uint32_t piece_guess(const struct leaf *leaf, uint64_t at)
{
    const struct piece *pieces = leaf->pieces;
    const uint64_t begin = pieces[0].begin, end = pieces[leaf->count - 1].end;
    if (at <= begin)
        return 0;
    if (at >= end)
        return leaf->count;
    const double part = (double)(at - begin) / (double)(end - begin);
    uint32_t low = (uint32_t)(part * leaf->count), step = 1;
    uint32_t high = low; /* rounded: the count at most */
    for (; low > 0 && pieces[low - 1].end > at; step *= 2)
        low = low > step ? low - step : 0;
    for (; high < leaf->count && pieces[high].end <= at; step *= 2)
        high = high + step < leaf->count ? high + step : leaf->count;
    return piece_search(pieces, low, high, at);
}

/* Searches at the finger's piece and at the one after it, where the next access of a stream mostly
 * is. Returns whether `found` is the first piece that ends behind `at`. */
static bool finger_finds(struct cursor *finger, uint64_t at, struct cursor *found)
{
    *found = *finger;
    if (!finger->leaf || finger->piece >= finger->leaf->count)
        return false;
    const struct piece *piece = cursor_piece(*found);
    if (at < piece->end)
        return at >= piece->begin;
    cursor_step(found);
    const struct piece *next = cursor_piece(*found);
    if (next && at >= next->end)
        return false;
    if (next && at >= next->begin)
        *finger = *found;
    return true;
}

static bool leaf_covers(const struct leaf *leaf, uint64_t at)
{
    return leaf && leaf->count && leaf->pieces[0].begin <= at &&
           (!leaf->next || at < leaf->next->pieces[0].begin);
}

/* Returns the leaf that covers `at`, and the finger to move there: one that is near, or the one
 * that has not been used for the longest time. */
static uint32_t search_fingers(struct ranges *ranges, uint64_t at, struct leaf **leaf)
{
    for (uint32_t i = 0; i < RANGE_FINGERS; i++) {
        *leaf = ranges->fingers[i].leaf;
        if (leaf_covers(*leaf, at))
            return i;
        *leaf = *leaf && (*leaf)->count ? (*leaf)->next : NULL;
        if (leaf_covers(*leaf, at))
            return i;
    }
    *leaf = leaf_search(ranges, at);
    uint32_t oldest = 0;
    for (uint32_t i = 1; i < RANGE_FINGERS; i++)
        if (ranges->used[i] < ranges->used[oldest])
            oldest = i;
    return oldest;
}

struct cursor ranges_find(struct ranges *ranges, uint64_t at)
{
    if (!ranges->first)
        return (struct cursor){NULL, 0};
    if (ranges->debt > ranges->leaf_count + 4 * LEAF_PIECES)
        index_renew(ranges);
    /* The streams of a build take turns. */
    for (uint32_t turn = 0; turn < RANGE_FINGERS; turn++) {
        const uint32_t each = (ranges->recent_finger + turn) % RANGE_FINGERS;
        struct cursor found;
        if (finger_finds(&ranges->fingers[each], at, &found)) {
            ranges->recent_finger = each;
            ranges->used[each] = ++ranges->find_count;
            return found;
        }
    }
    struct leaf *leaf;
    ranges->recent_finger = search_fingers(ranges, at, &leaf);
    ranges->used[ranges->recent_finger] = ++ranges->find_count;
    struct cursor *finger = &ranges->fingers[ranges->recent_finger];
    *finger = (struct cursor){leaf, piece_guess(leaf, at)};
    /* If `at` is behind the leaf's last piece, the next leaf has the piece. */
    return finger->piece < leaf->count ? *finger : (struct cursor){leaf->next, 0};
}

/* ---- changes */

/* Chooses the leaf for a new piece before the cursor, and makes room in it. Returns false if memory
 * runs out. */
static bool make_room_for_piece(struct ranges *ranges, struct cursor *at)
{
    struct leaf *prev = at->leaf ? at->leaf->prev : ranges->last;
    /* Between two leaves, the piece goes to the end of the first one, unless the second one has
     * much room. Ascending accesses leave full leaves behind. */
    if (prev && at->piece == 0 && (!at->leaf || at->leaf->count >= LEAF_PIECES / 2))
        *at = (struct cursor){prev, prev->count};
    if (!at->leaf || at->piece == LEAF_PIECES) {
        *at = (struct cursor){leaf_insert(ranges, at->leaf), 0};
        return at->leaf;
    }
    if (at->leaf->count < LEAF_PIECES)
        return true;
    if (!leaf_split(ranges, at->leaf))
        return false;
    if (at->piece > LEAF_PIECES / 2)
        *at = (struct cursor){at->leaf->next, at->piece - LEAF_PIECES / 2};
    return true;
}

struct piece *ranges_insert(struct ranges *ranges, struct cursor *cursor, uint64_t begin,
                            uint64_t end)
{
    struct cursor at = *cursor;
    if (!make_room_for_piece(ranges, &at))
        return NULL;
    struct piece *piece = &at.leaf->pieces[at.piece];
    memmove(piece + 1, piece, (at.leaf->count - at.piece) * sizeof(*piece));
    *piece = (struct piece){.begin = begin, .end = end};
    at.leaf->count++;
    ++*ranges->piece_count;
    *cursor = ranges->fingers[ranges->recent_finger] = at;
    return piece;
}

void ranges_remove(struct ranges *ranges, struct cursor *cursor, uint64_t end)
{
    uint32_t piece = cursor->piece;
    struct cursor behind = {NULL, 0};
    for (struct leaf *leaf = cursor->leaf, *next; leaf; leaf = next, piece = 0) {
        uint32_t stop = piece;
        next = leaf->next;
        while (stop < leaf->count && leaf->pieces[stop].begin < end)
            piece_clear_notes(&leaf->pieces[stop++]);
        *ranges->piece_count -= stop - piece;
        memmove(&leaf->pieces[piece], &leaf->pieces[stop],
                (leaf->count - stop) * sizeof(leaf->pieces[0]));
        leaf->count -= stop - piece;
        if (piece < leaf->count) {
            behind = (struct cursor){leaf, piece};
            break;
        }
        if (!leaf->count)
            leaf_remove(ranges, leaf);
    }
    *cursor = behind;
}

void ranges_sweep(struct ranges *ranges, bool (*is_wanted)(struct piece *piece, void *context),
                  void *context)
{
    /* Kept pieces move to the front, so that leaves are full again. They never overtake. */
    struct cursor to = {ranges->first, 0};
    for (struct leaf *leaf = ranges->first; leaf; leaf = leaf->next) {
        const uint32_t count = leaf->count;
        for (uint32_t i = 0; i < count; i++) {
            struct piece *from = &leaf->pieces[i];
            if (!is_wanted(from, context)) {
                piece_clear_notes(from);
                --*ranges->piece_count;
                continue;
            }
            if (to.piece == LEAF_PIECES) {
                to.leaf->count = LEAF_PIECES;
                to = (struct cursor){to.leaf->next, 0};
            }
            to.leaf->pieces[to.piece++] = *from;
        }
    }
    if (to.leaf)
        to.leaf->count = to.piece;
    for (struct leaf *leaf = ranges->last, *prev; leaf && (leaf != to.leaf || !to.piece);
         leaf = prev) {
        const bool is_last = leaf == to.leaf;
        prev = leaf->prev;
        leaf->count = 0;
        leaf_remove(ranges, leaf);
        if (is_last)
            break;
    }
    index_renew(ranges);
}

void ranges_release(struct ranges *ranges)
{
    for (struct leaf *leaf = ranges->first, *next; leaf; leaf = next) {
        next = leaf->next;
        for (uint32_t i = 0; i < leaf->count; i++)
            piece_clear_notes(&leaf->pieces[i]);
        *ranges->piece_count -= leaf->count;
        aligned_free(leaf);
    }
    free_removed(ranges);
    free(ranges->index);
    *ranges = (struct ranges){.piece_count = ranges->piece_count};
}
