/* SPDX-License-Identifier: Apache-2.0 */
/* Tests that text from outside the layer, such as a debug name, can't break a message over lines.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "hearing.h"
#include "src/base/text_buffer.h"
#include "src/report/finding_message.h"

static const char *quote(const char *quoted, size_t size)
{
    static char line[4096];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_append_quoted(&text, quoted, size);
    return line;
}

TEST(test_escape_sequences)
{
    static const struct {
        const char *text, *expected;
    } cases[] = {
        {"", "\"\""},
        {"mesh 3", "\"mesh 3\""},
        {"\xc3\xa9t\xc3\xa9 \xe2\x82\xac \xf0\x9f\x90\xb0", /* été, the euro sign, a rabbit */
         "\"\xc3\xa9t\xc3\xa9 \xe2\x82\xac \xf0\x9f\x90\xb0\""},
        {"a\"b\\c", "\"a\\\"b\\\\c\""},
        {"a\nb\rc\td", "\"a\\nb\\rc\\td\""},
        {"\x1b[31m\x01\x7f", "\"\\x1b[31m\\x01\\x7f\""},
        {"\xc2\x85\xe2\x80\xa8\xe2\x80\xae", "\"\\u0085\\u2028\\u202e\""},
        {"\xff\x80", "\"\\xff\\x80\""},                   /* no first byte of a character */
        {"\xc3", "\"\\xc3\""},                            /* cut */
        {"\xe2\x82x", "\"\\xe2\\x82x\""},                 /* cut, too */
        {"\xc0\x8a", "\"\\xc0\\x8a\""},                   /* a line feed in two bytes */
        {"\xe0\x80\x8a", "\"\\xe0\\x80\\x8a\""},          /* in three */
        {"\xed\xa0\x80", "\"\\xed\\xa0\\x80\""},          /* half of a surrogate pair */
        {"\xf4\x90\x80\x80", "\"\\xf4\\x90\\x80\\x80\""}, /* beyond U+10FFFF */
    };
    for (size_t i = 0; i < LENGTH(cases); i++)
        assert_string_equal(quote(cases[i].text, 100), cases[i].expected);
}

/* The first and the last character of each range, and their neighbours. */
TEST(test_ranges_of_characters)
{
    static const struct {
        uint32_t character;
        bool is_escaped;
    } cases[] = {
        {0x1f, true},    {0x20, false},   {0x7e, false},    {0x7f, true},      {0x80, true},
        {0x9f, true},    {0xa0, false},   {0x61b, false},   {0x61c, true},     {0x61d, false},
        {0x7ff, false},  {0x800, false},  {0x200d, false},  {0x200e, true},    {0x200f, true},
        {0x2010, false}, {0x2027, false}, {0x2028, true},   {0x202e, true},    {0x202f, false},
        {0x2065, false}, {0x2066, true},  {0x2069, true},   {0x206a, false},   {0xd7ff, false},
        {0xe000, false}, {0xffff, false}, {0x10000, false}, {0x10ffff, false},
    };
    for (size_t i = 0; i < LENGTH(cases); i++) {
        const uint32_t c = cases[i].character;
        const int length = c < 0x80 ? 1 : c < 0x800 ? 2 : c < 0x10000 ? 3 : 4;
        char bytes[5] = {(char)c}, quoted[16], escaped[16];
        for (int j = length - 1, shift = 0; length > 1 && j >= 0; j--, shift += 6)
            bytes[j] =
                (char)(j ? 0x80 | (c >> shift & 0x3f) : (0xf00 >> length & 0xff) | c >> shift);
        snprintf(quoted, sizeof(quoted), "\"%s\"", bytes);
        snprintf(escaped, sizeof(escaped), c < 0x80 ? "\"\\x%02x\"" : "\"\\u%04x\"", (unsigned)c);
        assert_string_equal(quote(bytes, 100), cases[i].is_escaped ? escaped : quoted);
    }
}

/* What a signal handler may use. */
TEST(test_numbers_and_plain_text)
{
    char line[32];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_append(&text, "a");
    text_append_decimal(&text, UINT64_MAX);
    assert_string_equal(line, "a18446744073709551615");
    text_begin(&text, line, sizeof(line));
    text_append_hex(&text, 0);
    text_append_hex(&text, 0x123456789abcdef0);
    text_append_padded(&text, 7, 3);
    text_append_padded(&text, 1234, 3);
    assert_string_equal(line, "0x00x123456789abcdef00071234");
    text_append(&text, "12");
    text_append(&text, "3\xc3\xa9");
    assert_string_equal(line, "0x00x123456789abcdef00071234...");
    text_append(&text, "no more");
    text_append_count(&text, 1, "byte");
    assert_int_equal(strlen(line), text.length);
}

/* As printf words them, which must not be called in a signal handler. */
static void check_real(double number)
{
    char line[64], expected[64];
    struct text_buffer text;
    for (int digits = 1; digits <= 17; digits++) {
        text_begin(&text, line, sizeof(line));
        text_append_real(&text, number, (unsigned)digits);
        snprintf(expected, sizeof(expected), "%.*g", digits, number);
        if (isnan(number)) /* MinGW-w64 leaves out the sign */
            strcpy(expected, signbit(number) ? "-nan" : "nan");
        assert_string_equal(line, expected);
    }
}

TEST(test_real_numbers)
{
    static const double numbers[] = {
        0,        -0.0,   1,       -1.5,     0.5,     2.5,     0.1,      1e-4,   1e-5,
        99999999, 9.5,    99.5,    0.125,    1e22,    1e23,    123456.5, 1e300,  DBL_MAX,
        DBL_MIN,  5e-324, FLT_MAX, FLT_MIN,  1e-45f,  0.1f,    INFINITY, NAN,    -INFINITY,
        -NAN,     1e9,    1e17,    16777217, 0.99999, 9999.95, 1.0 / 3,  2.0 / 3};
    uint64_t seed = 1;
    for (size_t i = 0; i < sizeof(numbers) / sizeof(numbers[0]); i++)
        check_real(numbers[i]);
    for (int i = 0; i < 3000; i++) {
        double number;
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        memcpy(&number, &seed, sizeof(number));
        check_real(number);
        check_real((double)(int64_t)(seed >> 40) / 256); /* often halves of the last digit */
    }
}

static void fill_gap(struct text_buffer *text, void *about, const char *name, size_t length)
{
    (void)about;
    if (strncmp(name, "empty", length) != 0)
        text_append_part(text, name, length);
}

static const char *fill(const char *says)
{
    static char line[64];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_append_template(&text, says, fill_gap, NULL);
    return line;
}

TEST(test_templates)
{
    assert_string_equal(fill(""), "");
    assert_string_equal(fill("plain [0] ] }"), "plain [0] ] }");
    assert_string_equal(fill("a {b} {empty}c"), "a b c");
    assert_string_equal(fill("a[[, b {b}]][[, c {empty}]]."), "a, b b.");
    assert_string_equal(fill("[[{empty} and {a}]][[{a} or {empty}]]x"), "x");
    assert_string_equal(fill("[{a}] [{empty}]"), "[a] []");
}

TEST(test_cuts)
{
    assert_string_equal(quote("abc", 3), "\"abc\"");
    assert_string_equal(quote("abc", 2), "\"ab\"");
    assert_string_equal(quote("a\xc3\xa9", 2), "\"a\"");
    assert_string_equal(quote("a\xc3\xa9", 3), "\"a\xc3\xa9\"");
    assert_string_equal(quote("abc", 0), "\"\"");
    assert_int_equal(text_cut_length("\x80\x80\x80\x80\x80\x80", 5), 5);
    assert_int_equal(text_cut_length("\xf0\x9f\x90\xb0", 3), 0);
    assert_int_equal(text_cut_length("\xf0\x80\x80\x80\x80", 4), 4); /* longer than a character */
}

#define NASTY "a\"]\nValidation Error: [ VUID-fake ]\x1b[2J\xff"
#define NASTY_QUOTED "\"a\\\"]\\nValidation Error: [ VUID-fake ]\\x1b[2J\\xff\""

TEST(test_names_and_labels_stay_on_one_line)
{
    static struct message message;
    struct label_stack labels = {0};
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_CALL};
    struct finding finding;
    struct object_names *names = names_create();
    object_names_set(names, VK_OBJECT_TYPE_COMMAND_BUFFER, 0xc0, NASTY);
    object_names_set(names, VK_OBJECT_TYPE_BUFFER, 0xb, NASTY);
    label_push(&labels, NASTY);
    const struct call_origin origin = {
        .command_buffer = (VkCommandBuffer)(uintptr_t)0xc0, .names = names, .labels = &labels};
    finding_says(&finding, "a", "is {}", object(VK_OBJECT_TYPE_BUFFER, 0xb));
    message_of_finding(&message, SENT_VUID, &location, &origin, &finding,
                       &(struct message_style){0});

    assert_int_equal(count_lines(message.text), 1); /* before the specification's sentence */
    assert_has(message.text, "VkBuffer 0xb[" NASTY_QUOTED "].");
    assert_has(message.text, "VkCommandBuffer 0xc0[" NASTY_QUOTED "]");
    assert_has(message.text, "labels " NASTY_QUOTED ".");
    /* The application gets its own names as they are. */
    assert_string_equal(message.named.objects[1].pObjectName, NASTY);
    assert_string_equal(message.labels[0].pLabelName, NASTY);

    const char *log = capture_message(&message);
    assert_int_equal(count_lines(log), 6);
    assert_has(log, "        [1] VkBuffer 0xb[" NASTY_QUOTED "]\n");
    label_stack_clear(&labels);
    object_names_destroy(names);
}

/* Warnings about settings quote what the user wrote. */
TEST_OPENED(test_settings_stay_on_one_line, surrounding_set_up)
{
#ifdef _WIN32
    skip(); /* the environment is no UTF-8 there, and 0xff is a letter */
#endif
    setenv("VK_ASSAY_VALIDATION_LEVEL", "state\"\n\x1b[2J\xff", 1);
    setenv("VK_ASSAY_VALIDATION_LOG_FILENAME", "/nonexistent/" NASTY, 1);
    setenv("VK_ASSAY_VALIDATION_MESSAGE_ID_FILTER", "0\n1", 1);
    capture_begin(STDERR_FILENO);
    struct reporter *reporter = reporter_of(NULL);
    const char *log = capture_end();
    assert_int_equal(count_lines(log), 6); /* three headings, three lines */
    assert_has(log, "assay_validation.level: \"state\\\"\\n\\x1b[2J\\xff\" ");
    assert_has(log, "\"/nonexistent/a\\\"]\\nValidation Error: ");
    assert_has(log, "message_id_filter: \"0\\n1\" ");
    reporter_destroy(reporter);
}
