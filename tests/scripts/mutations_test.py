# SPDX-License-Identifier: Apache-2.0
"""The mutations of scripts/mutants: each kind is found, and nothing else is touched."""

import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts" / "lib"))

from mutations import mutations_of  # noqa: E402


def mutants(body):
    """The kind and the body of each mutant of a function."""
    text = "void f(void)\n{" + body + "} int end;"
    found = []
    for path, kind, begin, end, new in mutations_of("a.c", text):
        assert path == "a.c"
        mutant = text[:begin] + new + text[end:]
        found.append((kind, mutant[len("void f(void)\n{"):-len("} int end;")]))
    return sorted(found)


class Kinds(unittest.TestCase):
    def test_comparison(self):
        self.assertEqual(mutants("return a == b;"), [("comparison turned", "return a != b;")])
        self.assertEqual(mutants("return a <= b;"),
                         [("bound off by one", "return a <= 1 + b;"),
                          ("comparison turned", "return a < b;")])

    def test_bound(self):
        self.assertEqual(mutants("return n - 1;"), [("bound off by one", "return n ;")])
        self.assertEqual(mutants("return -1;"), [])

    def test_flag(self):
        self.assertEqual(mutants("return A | B;"), [("flag not set", "return A ;")])
        self.assertEqual(mutants("x.y |= B;"), [("flag not set", "x.y |= 0 & B;"),
                                                ("statement dropped", ";")])

    def test_condition(self):
        self.assertEqual(mutants("if (a) return 0;"),
                         [("condition negated", "if (!(a)) return 0;")])
        self.assertEqual(mutants("if (!a) return 0;"),
                         [("condition negated", "if (!(!a)) return 0;")])
        self.assertEqual(mutants("return !a;"), [("condition negated", "return a;")])

    def test_statement(self):
        self.assertEqual(mutants("g(a, b); return 0;"), [("statement dropped", "; return 0;")])
        self.assertEqual(mutants("for (;;) g();"), [("statement dropped", "for (;;) ;")])
        self.assertEqual(mutants("int a = b; return a;"), [])


class LeftAlone(unittest.TestCase):
    def test_comments_strings_directives(self):
        self.assertEqual(mutants("/* a < b; f(); */ // a == b\n#if A == B\n#endif\n"), [])
        self.assertEqual(mutants('char *s = "a < b", c = \'<\';'), [])

    def test_shifts_and_arrows(self):
        self.assertEqual(mutants("return a->b << 2 >> c;"), [])

    def test_outside_of_functions(self):
        text = "_Static_assert(A == B); int a = B | C, b, c;"
        self.assertEqual(list(mutations_of("a.c", text)), [])


if __name__ == "__main__":
    unittest.main()
