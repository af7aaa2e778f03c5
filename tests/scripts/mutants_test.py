# SPDX-License-Identifier: Apache-2.0
"""What scripts/mutants does around a mutant: it counts, and keeps the results of earlier runs."""

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


if __name__ == "__main__":
    unittest.main()
