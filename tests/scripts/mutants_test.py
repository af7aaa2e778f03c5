# SPDX-License-Identifier: Apache-2.0
"""What scripts/mutants does: it finds each kind of mutation and nothing else, counts, and keeps the results of earlier
runs."""

import importlib.machinery
import importlib.util
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest
from types import SimpleNamespace

ROOT = pathlib.Path(__file__).resolve().parents[2]
loader = importlib.machinery.SourceFileLoader("mutants", str(ROOT / "scripts" / "mutants"))
mutants = importlib.util.module_from_spec(importlib.util.spec_from_loader("mutants", loader))
loader.exec_module(mutants)

SOURCE = "void f(void)\n{\n    g();\n    return a == b;\n}\nint end, of, file;\n"


@unittest.skipUnless(shutil.which("git"), "scripts/mutants copies what git lists, and git is not installed")
class Repository(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name).resolve()
        (self.root / "src").mkdir()
        (self.root / ".gitignore").write_text("/build/\n")
        self.write(SOURCE)
        subprocess.run(["git", "init", "-q"], cwd=self.root, check=True)

    def write(self, text):
        (self.root / "src" / "a.c").write_text(text)

    def mutations(self):
        return sorted(mutants.mutations_of("src/a.c", SOURCE))

    def test_results_stay_until_a_source_changes(self):
        turned, dropped = self.mutations()
        results = mutants.Results(self.root)
        results.add(turned, {"outcome": "killed", "killer": "t"})
        again = mutants.Results(self.root)
        self.assertEqual(again.find(turned)["outcome"], "killed")
        self.assertIsNone(again.find(dropped))
        self.assertIsNone(mutants.Results(self.root, "all").find(turned))
        self.write(SOURCE + "\n")
        for _ in range(2):
            changed = mutants.Results(self.root)
            self.assertIsNone(changed.find(turned))
            self.assertEqual(changed.kills_of("t", turned), (True, 1, 1))
            self.assertEqual(changed.kills_of("t", dropped), (False, 1, 1))
            self.assertEqual(changed.kills_of("t", dropped._replace(path="src/x/b.c")), (False, 0, 1))
            self.assertEqual(changed.kills_of("u", turned), (False, 0, 0))

    def test_explained(self):
        turned, dropped = self.mutations()
        path = self.root / "explained.tsv"
        path.write_text("# why\nsrc/a.c\treturn a == b;\treturn a != b;\tsame\tboth are\n")
        reasons = mutants.read_explained(path)
        changes = [(name.path, *mutants.change_of(self.root, name)) for name in (turned, dropped)]
        self.assertEqual(reasons, {changes[0]: ("same", "both are")})
        self.assertEqual(changes[1], ("src/a.c", "g();", ";"))

    def test_a_line_that_was_cut_is_left_out(self):
        turned, dropped = self.mutations()
        results = mutants.Results(self.root)
        results.add(turned, {"outcome": "survived"})
        results.add(dropped, {"outcome": "survived"})
        text = results.path.read_text()
        results.path.write_text(text[:-10])
        again = mutants.Results(self.root)
        self.assertIsNotNone(again.find(turned))
        self.assertIsNone(again.find(dropped))


class Explained(unittest.TestCase):
    def test_lines_are_there(self):
        """A line that changes is to be looked at again; one that counts for nothing occurs once."""
        for (name, before, _), (kind, reason) in mutants.read_explained(mutants.EXPLAINED).items():
            lines = [line.strip() for line in (ROOT / name).read_text().splitlines()]
            self.assertIn(kind, ("same", "kept"))
            self.assertTrue(reason)
            self.assertIn(before, lines, name)
            if kind == "same":
                self.assertEqual(lines.count(before), 1, name)


class Count(unittest.TestCase):
    """Mutations are numbers, of which every third one counts."""

    def counted(self, jobs):
        run = mutants.Run(SimpleNamespace(count=20), None, iter(range(100)))
        run.print_progress = lambda mutation, outcome: None

        def work():
            while (mutation := run.take()) is not None:
                run.finish(mutation, {"outcome": "killed" if mutation % 3 == 0 else "unbuilt"})
        workers = [threading.Thread(target=work) for _ in range(jobs)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        return sorted(mutation for mutation, _ in run.counted)

    def test_it_does_not_depend_on_the_workers(self):
        for jobs in (1, 2, 7):
            self.assertEqual(self.counted(jobs), list(range(0, 60, 3)))

    def test_fewer_than_wanted(self):
        run = mutants.Run(SimpleNamespace(count=2), None, iter(range(1)))
        self.assertEqual(run.take(), 0)
        run.finish(0, {"outcome": "unbuilt"})
        self.assertIsNone(run.take())


def mutants_of(body):
    """The kind and the body of each mutant of a function."""
    text = "void f(void)\n{" + body + "} int end;"
    found = []
    for path, kind, begin, end, new in mutants.mutations_of("a.c", text):
        assert path == "a.c"
        mutant = text[:begin] + new + text[end:]
        found.append((kind, mutant[len("void f(void)\n{"):-len("} int end;")]))
    return sorted(found)


class Kinds(unittest.TestCase):
    def test_comparison(self):
        self.assertEqual(mutants_of("return a == b;"), [("comparison turned", "return a != b;")])
        self.assertEqual(mutants_of("return a <= b;"),
                         [("bound off by one", "return a <= 1 + b;"),
                          ("comparison turned", "return a < b;")])

    def test_bound(self):
        self.assertEqual(mutants_of("return n - 1;"), [("bound off by one", "return n ;")])
        self.assertEqual(mutants_of("return -1;"), [])

    def test_flag(self):
        self.assertEqual(mutants_of("return A | B;"), [("flag not set", "return A ;")])
        self.assertEqual(mutants_of("x.y |= B;"), [("flag not set", "x.y |= 0 & B;"),
                                                ("statement dropped", ";")])

    def test_condition(self):
        self.assertEqual(mutants_of("if (a) return 0;"),
                         [("condition negated", "if (!(a)) return 0;")])
        self.assertEqual(mutants_of("if (!a) return 0;"),
                         [("condition negated", "if (!(!a)) return 0;")])
        self.assertEqual(mutants_of("return !a;"), [("condition negated", "return a;")])

    def test_statement(self):
        self.assertEqual(mutants_of("g(a, b); return 0;"), [("statement dropped", "; return 0;")])
        self.assertEqual(mutants_of("for (;;) g();"), [("statement dropped", "for (;;) ;")])
        self.assertEqual(mutants_of("int a = b; return a;"), [])


class LeftAlone(unittest.TestCase):
    def test_comments_strings_directives(self):
        self.assertEqual(mutants_of("/* a < b; f(); */ // a == b\n#if A == B\n#endif\n"), [])
        self.assertEqual(mutants_of('char *s = "a < b", c = \'<\';'), [])

    def test_shifts_and_arrows(self):
        self.assertEqual(mutants_of("return a->b << 2 >> c;"), [])

    def test_outside_of_functions(self):
        text = "_Static_assert(A == B); int a = B | C, b, c;"
        self.assertEqual(list(mutants.mutations_of("a.c", text)), [])


if __name__ == "__main__":
    unittest.main()
