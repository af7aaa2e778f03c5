/* SPDX-License-Identifier: Apache-2.0 */
/* Patterns of names, and comparisons that ignore case. */
#include "src/base/letter_case.h"
#include "src/report/ids/message_filter.h"
#include "tests/unit/unit_test.h"

TEST(test_globs)
{
    static const struct {
        const char *glob, *text;
        bool matches;
    } cases[] = {
        {"", "", true},           {"", "a", false},
        {"*", "", true},          {"a*c", "abbc", true},
        {"a*c", "abcb", false},   {"*a*b*", "xaxbx", true},
        {"*ab", "aab", true},     {"a?c", "abc", true},
        {"a?c", "ac", false},     {"?", "\xc3\xa9", true},
        {"?", "\xff", true},      {"[a-c]x", "bx", true},
        {"[ab]c", "bc", true},    {"[ab]c", "cc", false},
        {"[a-c]x", "dx", false},  {"[!a-c]x", "dx", true},
        {"[!a-c]x", "ax", false}, {"[]]", "]", true},
        {"[!]]", "]", false},     {"[a-]", "-", true},
        {"[ab", "[ab", true},     {"[ab", "a", false},
        {"a\\*", "a\\b", true},   {"mesh[0-9]", "mesh7", true},
        {"Mesh", "mesh", false},  {"[\xc3\xa9-\xc3\xab]", "\xc3\xaa", true},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++)
        if (glob_matches(cases[i].glob, cases[i].text) != cases[i].matches)
            fail_msg("%s and %s", cases[i].glob, cases[i].text);
}

TEST(test_letter_case)
{
    assert_true(text_equals_in_any_case("VUID-Abc", "vuid-aBC"));
    assert_false(text_equals_in_any_case("abc", "ab"));
    assert_false(text_equals_in_any_case("ab", "abc"));
    assert_false(text_equals_in_any_case("@", "`"));
    assert_true(text_starts_in_any_case("0X1", "0x"));
    assert_false(text_starts_in_any_case("0", "0x"));
}
