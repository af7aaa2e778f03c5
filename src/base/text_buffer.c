/* SPDX-License-Identifier: Apache-2.0 */
/* Text in a bounded buffer. */
#include "src/base/text_buffer.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { CHARACTER_MAX = 4 }; /* bytes of a character in UTF-8 */

static const char dots[] = "...";

static bool is_continuation(unsigned char byte)
{
    return (byte & 0xc0) == 0x80;
}

void text_begin(struct text_buffer *buffer, char *text, size_t size)
{
    *buffer = (struct text_buffer){.text = text, .size = size};
    text[0] = '\0';
}

size_t text_cut_length(const char *text, size_t length)
{
    size_t cut = length;
    for (int steps = 0; cut > 0 && is_continuation((unsigned char)text[cut]); steps++, cut--)
        if (steps == CHARACTER_MAX - 1)
            return length;
    return cut;
}

/* Ends a text of which only a part fitted. */
static void cut(struct text_buffer *buffer)
{
    buffer->cut = true;
    buffer->length = text_cut_length(buffer->text, buffer->size - sizeof(dots));
    memcpy(buffer->text + buffer->length, dots, sizeof(dots));
    buffer->length += sizeof(dots) - 1;
}

void text_append_part(struct text_buffer *buffer, const char *bytes, size_t length)
{
    if (buffer->cut)
        return;
    size_t room = buffer->size - buffer->length - 1;
    size_t fitting = length < room ? length : room;
    memcpy(buffer->text + buffer->length, bytes, fitting);
    buffer->text[buffer->length + fitting] = '\0';
    if (fitting == length)
        buffer->length += length;
    else
        cut(buffer);
}

void text_append(struct text_buffer *buffer, const char *text)
{
    text_append_part(buffer, text, strlen(text));
}

static void append_digits(struct text_buffer *buffer, uint64_t number, unsigned base,
                          unsigned least)
{
    char digits[20];
    size_t at = sizeof(digits);
    do {
        digits[--at] = "0123456789abcdef"[number % base];
        number /= base;
    } while (number || sizeof(digits) - at < least);
    text_append_part(buffer, digits + at, sizeof(digits) - at);
}

void text_append_decimal(struct text_buffer *buffer, uint64_t number)
{
    append_digits(buffer, number, 10, 1);
}

void text_append_padded(struct text_buffer *buffer, uint64_t number, unsigned digits)
{
    append_digits(buffer, number, 10, digits);
}

void text_append_hex(struct text_buffer *buffer, uint64_t number)
{
    text_append(buffer, "0x");
    append_digits(buffer, number, 16, 1);
}

/* ---- real numbers, exactly: printf may allocate */

enum {
    LIMB = 1000000000, /* a limb has nine decimal digits */
    LIMBS = 90,        /* of the longest double: 767 digits */
    DIGITS_MAX = LIMBS * 9,
    FIVES = 13,
    TWOS = 29, /* powers of 5 and 2 that 32 bits hold */
};

struct decimal {
    uint32_t limbs[LIMBS], count; /* the least limb first */
};

static void multiply(struct decimal *decimal, uint32_t factor)
{
    uint64_t carry = 0;
    for (uint32_t i = 0; i < decimal->count; i++) {
        carry += (uint64_t)decimal->limbs[i] * factor;
        decimal->limbs[i] = (uint32_t)(carry % LIMB);
        carry /= LIMB;
    }
    for (; carry; carry /= LIMB)
        decimal->limbs[decimal->count++] = (uint32_t)(carry % LIMB);
}

static void multiply_by_power(struct decimal *decimal, uint32_t base, unsigned exponent,
                              unsigned step)
{
    for (; exponent; exponent -= exponent < step ? exponent : step) {
        uint32_t factor = 1;
        for (unsigned i = 0; i < exponent && i < step; i++)
            factor *= base;
        multiply(decimal, factor);
    }
}

/* Writes the digits of a positive number, without zeros in front. Returns the exponent of ten of
 * the first digit. */
static int digits_of(double number, char digits[DIGITS_MAX + 1], size_t *count)
{
    int exponent;
    uint64_t mantissa = (uint64_t)ldexp(frexp(number, &exponent), 53);
    struct decimal decimal = {.limbs = {(uint32_t)(mantissa % LIMB), (uint32_t)(mantissa / LIMB)},
                              .count = 2};
    struct text_buffer text;
    exponent -= 53;
    const unsigned fractional = exponent < 0 ? (unsigned)-exponent : 0;
    if (exponent < 0)
        multiply_by_power(&decimal, 5, fractional, FIVES);
    else
        multiply_by_power(&decimal, 2, (unsigned)exponent, TWOS);
    while (!decimal.limbs[decimal.count - 1])
        decimal.count--;
    text_begin(&text, digits, DIGITS_MAX + 1);
    text_append_decimal(&text, decimal.limbs[decimal.count - 1]);
    for (uint32_t i = decimal.count - 1; i-- > 0;)
        text_append_padded(&text, decimal.limbs[i], 9);
    *count = text.length;
    return (int)text.length - 1 - (int)fractional;
}

/* Rounds to `kept` digits, halves to even. Returns 1 if that makes a first digit more, which is 1.
 */
static int round_digits(char *digits, size_t count, size_t kept)
{
    size_t at = kept;
    if (count <= kept)
        return 0;
    const bool is_half = digits[kept] == '5' && strspn(digits + kept + 1, "0") == count - kept - 1;
    if (digits[kept] < '5' || (is_half && (digits[kept - 1] - '0') % 2 == 0))
        return 0;
    while (at > 0 && digits[at - 1] == '9')
        digits[--at] = '0';
    if (at > 0) {
        digits[at - 1]++;
        return 0;
    }
    digits[0] = '1';
    return 1;
}

static void append_exponent(struct text_buffer *buffer, int exponent)
{
    text_append(buffer, exponent < 0 ? "e-" : "e+");
    text_append_padded(buffer, (uint64_t)abs(exponent), 2);
}

/* Appends digits, of which the first has this exponent of ten. */
static void append_fixed(struct text_buffer *buffer, const char *digits, size_t count, int exponent)
{
    if (exponent < 0)
        text_append(buffer, "0.");
    for (int zeros = -1; zeros > exponent; zeros--)
        text_append(buffer, "0");
    const size_t whole = exponent < 0 ? 0 : (size_t)exponent + 1;
    text_append_part(buffer, digits, whole < count || !whole ? whole : count);
    for (size_t zeros = count; zeros < whole; zeros++)
        text_append(buffer, "0");
    if (whole && whole < count)
        text_append(buffer, ".");
    if (whole < count)
        text_append_part(buffer, digits + whole, count - whole);
}

void text_append_real(struct text_buffer *buffer, double number, unsigned digits_kept)
{
    char digits[DIGITS_MAX + 1];
    size_t count;
    if (signbit(number))
        text_append(buffer, "-");
    number = fabs(number);
    if (!isfinite(number) || number == 0) {
        text_append(buffer, isnan(number) ? "nan" : number == 0 ? "0" : "inf");
        return;
    }
    int exponent = digits_of(number, digits, &count);
    exponent += round_digits(digits, count, digits_kept);
    count = count < digits_kept ? count : digits_kept;
    while (count > 1 && digits[count - 1] == '0')
        count--;
    const bool is_scientific = exponent < -4 || exponent >= (int)digits_kept;
    append_fixed(buffer, digits, count, is_scientific ? 0 : exponent);
    if (is_scientific)
        append_exponent(buffer, exponent);
}

/* ---- templates */

static bool starts_with(const char *text, const char *start)
{
    return strncmp(text, start, strlen(start)) == 0;
}

/* Goes back to a length at which the text was not cut. */
static void shorten(struct text_buffer *buffer, size_t length)
{
    buffer->length = length;
    buffer->text[length] = '\0';
    buffer->cut = false;
}

void text_append_template(struct text_buffer *buffer, const char *says, text_fill *fill,
                          void *about)
{
    size_t part = 0; /* where it began */
    bool has_empty_gap = false;
    while (*says && !buffer->cut) {
        if (starts_with(says, "[[")) {
            part = buffer->length;
            has_empty_gap = false;
            says += 2;
        } else if (starts_with(says, "]]")) {
            if (has_empty_gap)
                shorten(buffer, part);
            says += 2;
        } else if (*says == '{') {
            const size_t before = buffer->length, length = strcspn(says, "}");
            fill(buffer, about, says + 1, length - 1);
            has_empty_gap |= buffer->length == before;
            says += length + 1;
        } else {
            const size_t length = 1 + strcspn(says + 1, "{[]");
            text_append_part(buffer, says, length);
            says += length;
        }
    }
}

/* ---- times and counts */

/* Appends the date of a day since 1970-01-01: years begin in March here, so that a leap day is the
 * last day of its year. */
static void append_date(struct text_buffer *buffer, uint64_t days)
{
    days += 719468; /* since 0000-03-01 */
    uint64_t era = days / 146097, day = days % 146097;
    uint64_t year = (day - day / 1460 + day / 36524 - day / 146096) / 365;
    day -= 365 * year + year / 4 - year / 100;
    uint64_t month = (5 * day + 2) / 153;
    day -= (153 * month + 2) / 5;
    text_append_padded(buffer, era * 400 + year + (month >= 10), 4);
    text_append(buffer, "-");
    text_append_padded(buffer, month < 10 ? month + 3 : month - 9, 2);
    text_append(buffer, "-");
    text_append_padded(buffer, day + 1, 2);
}

void text_append_time(struct text_buffer *buffer, struct utc_time time)
{
    uint64_t seconds = time.seconds % 86400;
    append_date(buffer, time.seconds / 86400);
    text_append(buffer, "T");
    text_append_padded(buffer, seconds / 3600, 2);
    text_append(buffer, ":");
    text_append_padded(buffer, seconds / 60 % 60, 2);
    text_append(buffer, ":");
    text_append_padded(buffer, seconds % 60, 2);
    text_append(buffer, ".");
    text_append_padded(buffer, time.nanoseconds / 1000, 6);
    text_append(buffer, "Z");
}

/* The plurals that do not end in "s" alone. */
static const char *irregular_plural(const char *noun)
{
    static const struct {
        const char *one, *many;
    } nouns[] = {{"vertex", "vertices"}, {"index", "indices"}, {"geometry", "geometries"}};
    for (size_t i = 0; i < sizeof(nouns) / sizeof(nouns[0]); i++)
        if (strcmp(noun, nouns[i].one) == 0)
            return nouns[i].many;
    return NULL;
}

void text_append_count(struct text_buffer *buffer, uint64_t count, const char *noun)
{
    const char *irregular = irregular_plural(noun);
    text_append_decimal(buffer, count);
    text_append(buffer, " ");
    text_append(buffer, count != 1 && irregular ? irregular : noun);
    if (count != 1 && !irregular)
        text_append(buffer, "s");
}

/* ---- quoted text */

size_t text_decode(const unsigned char *bytes, size_t size, uint32_t *character)
{
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000}; /* by length */
    size_t length = bytes[0] < 0x80             ? 1
                    : (bytes[0] & 0xe0) == 0xc0 ? 2
                    : (bytes[0] & 0xf0) == 0xe0 ? 3
                    : (bytes[0] & 0xf8) == 0xf0 ? 4
                                                : 0;
    if (!length || length > size)
        return 0;
    uint32_t value = length == 1 ? bytes[0] : bytes[0] & (0x7fu >> length);
    for (size_t i = 1; i < length; i++) {
        if (!is_continuation(bytes[i]))
            return 0;
        value = value << 6 | (bytes[i] & 0x3f);
    }
    if (value < least[length] || value > 0x10ffff || (value >= 0xd800 && value <= 0xdfff))
        return 0;
    *character = value;
    return length;
}

/* The control characters of Unicode, its separators of lines and paragraphs, and the characters
 * that change the direction of writing. */
static bool is_control(uint32_t character)
{
    return character < 0x20 || (character >= 0x7f && character <= 0x9f) || character == 0x061c ||
           character == 0x200e || character == 0x200f ||
           (character >= 0x2028 && character <= 0x202e) ||
           (character >= 0x2066 && character <= 0x2069);
}

/* Appends an escape sequence such as \x1b. */
static void append_code(struct text_buffer *buffer, char letter, uint32_t code, unsigned digits)
{
    const char start[] = {'\\', letter, '\0'};
    text_append(buffer, start);
    append_digits(buffer, code, 16, digits);
}

static void append_character(struct text_buffer *buffer, const unsigned char *bytes, size_t length,
                             uint32_t character)
{
    if (!length)
        append_code(buffer, 'x', bytes[0], 2);
    else if (character == '"' || character == '\\')
        text_append(buffer, character == '"' ? "\\\"" : "\\\\");
    else if (character == '\n')
        text_append(buffer, "\\n");
    else if (character == '\r')
        text_append(buffer, "\\r");
    else if (character == '\t')
        text_append(buffer, "\\t");
    else if (is_control(character))
        append_code(buffer, character < 0x80 ? 'x' : 'u', character, character < 0x80 ? 2 : 4);
    else
        text_append_part(buffer, (const char *)bytes, length);
}

void text_append_escaped(struct text_buffer *buffer, const char *text, size_t size)
{
    const unsigned char *bytes = (const unsigned char *)text;
    size_t left = strnlen(text, size);
    if (left == size && left > 0)
        left = text_cut_length(text, size);
    while (left > 0) {
        uint32_t character = 0;
        size_t length = text_decode(bytes, left, &character);
        append_character(buffer, bytes, length, character);
        bytes += length ? length : 1;
        left -= length ? length : 1;
    }
}

void text_append_quoted(struct text_buffer *buffer, const char *quoted, size_t size)
{
    text_append(buffer, "\"");
    text_append_escaped(buffer, quoted, size);
    text_append(buffer, "\"");
}
