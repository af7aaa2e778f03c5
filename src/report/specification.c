/* SPDX-License-Identifier: Apache-2.0 */
/* Quotes the specification. */
#include "src/report/specification.h"

#include <string.h>

enum { SENTENCE_SHOWN = 160 };

#define SPECIFICATION "https://docs.vulkan.org/spec/latest/"

/* Returns the length of a sentence that is cut between words, to at most SENTENCE_SHOWN characters.
 */
static size_t short_length(const char *sentence)
{
    size_t length = 0, end_of_word = 0;
    for (uint32_t characters = 0; characters <= SENTENCE_SHOWN; characters++) {
        if (!sentence[length])
            return length;
        if (sentence[length] == ' ')
            end_of_word = length;
        do
            length++;
        while (((unsigned char)sentence[length] & 0xc0) == 0x80);
    }
    return end_of_word;
}

void specification_append_sentence(struct text_buffer *text, const struct vuid_text *vuid,
                                   enum spec_text spec_text)
{
    if (!vuid->sentence[0] || spec_text == SPEC_TEXT_NONE)
        return;
    size_t length = strlen(vuid->sentence), shown = length;
    if (spec_text == SPEC_TEXT_SHORT)
        shown = short_length(vuid->sentence);
    text_append(text, "%.*s%s", (int)shown, vuid->sentence, shown < length ? "..." : "");
}

void specification_append_url(struct text_buffer *text, const struct vuid_text *vuid)
{
    text_append(text, SPECIFICATION "%s#%s", vuid->page, vuid->id);
}

void specification_append(struct text_buffer *text, enum vuid vuid, const char *named,
                          enum spec_text spec_text)
{
    const struct vuid_text *current = &vuid_texts[vuid];
    if (current->sentence[0] && spec_text != SPEC_TEXT_NONE) {
        text_append(text, "\nThe Vulkan spec states: ");
        specification_append_sentence(text, current, spec_text);
        text_append(text, " (");
        specification_append_url(text, current);
        text_append(text, ")");
    }
    if (named != current->id) {
        text_append(text, " (today %s)", current->id);
        return;
    }
    const char *retired;
    for (unsigned n = 0; (retired = vuid_retired(vuid, n)); n++)
        text_append(text, "%s%s", n ? ", " : " (formerly ", retired);
    if (vuid_retired(vuid, 0))
        text_append(text, ")");
}
