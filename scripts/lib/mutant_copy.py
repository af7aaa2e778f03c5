# SPDX-License-Identifier: Apache-2.0
"""A mutated copy of the repository, with its builds. Each worker of scripts/mutants has one."""
import os
import subprocess
import time

from mutant_build import SHORTEST_TIMEOUT, Build, make, tests_of

# Tests whose processes end without writing counts, or that preset coverage leaves out: reach.find does not name
# them.
UNCOUNTED = ("report_json_", "report_log", "corpus_")
SLOWER = 5  # times that a test takes under the sanitizers


def repository_files(root):
    """Of the working tree, as git sees it."""
    run = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                         cwd=root, check=True, stdout=subprocess.PIPE, text=True)
    return sorted(name for name in set(run.stdout.split("\0")) if name and (root / name).is_file())


class Copy:
    def __init__(self, root, number, seed, has_others=False):
        self.root, self.seed = root, seed
        self.tree = root / "build" / "mutants" / str(number)
        self.plain = Build(self.tree, "quick", seed, has_others)
        self.sanitized = Build(self.tree, "asan", seed)

    # ---- before the first mutant

    def prepare(self):
        """The first time only."""
        if not self.plain.tests:
            self.copy_files()
            self.plain.prepare()
            self.plain.measure()

    def prepare_sanitized(self):
        """Before the first mutant that needs it."""
        if not self.sanitized.tests:
            self.sanitized.prepare()
            seconds = {test.name: test.seconds for test in self.plain.tests}
            for test in self.sanitized.tests:
                test.seconds = SLOWER * seconds.get(test.name, SHORTEST_TIMEOUT)

    def count_lines(self, reach):
        """Builds another time, and notes which lines each test executes."""
        self.copy_files()
        has_others = self.plain.has_others
        make(self.tree, "coverage", "all" if has_others else "quick_tests", "-DCMAKE_C_FLAGS_DEBUG=-O1")
        build = self.tree / "build" / "coverage"
        for path in build.rglob("*.gcda"):
            path.unlink()
        tests = tests_of(self.tree, "coverage", self.seed)
        if has_others:
            tests += tests_of(self.tree, "coverage", self.seed, is_quick=False)
        for test in tests:
            begin = time.monotonic()
            test.passes()
            reach.seconds[test.name] = time.monotonic() - begin
            reach.add(self.tree, build, test.name)

    def copy_files(self):
        """Files that are the same keep their time, so that a second run builds little."""
        names = repository_files(self.root)
        for name in names:
            source, target = self.root / name, self.tree / name
            data = source.read_bytes()
            if not target.is_file() or target.read_bytes() != data:
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(data)
                target.chmod(source.stat().st_mode)
        kept = set(names)
        for folder, folders, files in os.walk(self.tree):
            if folder == str(self.tree):
                folders[:] = [name for name in folders if name != "build"]
            for name in files:
                path = os.path.join(folder, name)
                if os.path.relpath(path, self.tree) not in kept:
                    os.remove(path)
        deps = self.tree / "build" / "deps"
        deps.parent.mkdir(exist_ok=True)
        if not deps.is_symlink():
            deps.symlink_to(self.root / "build" / "deps")

    # ---- a mutant

    def try_mutation(self, mutation, results, reach):
        """As Build.try_mutation() says. What survives is tried again under the sanitizers."""
        def order(tests, names):
            """Those that execute the mutation: those first that are likely to kill it, and short."""
            def worth(test):
                before, same, others = results.kills_of(test.name, mutation)
                return before, (1 + 10 * same + others) / (0.2 + test.seconds)
            return sorted((test for test in tests
                           if test.name in names or test.name.startswith(UNCOUNTED)),
                          key=worth, reverse=True)

        for test in self.plain.others:
            test.seconds = reach.seconds.get(test.name, SHORTEST_TIMEOUT)
        outcome = self.plain.try_mutation(mutation, reach, order)
        if outcome["outcome"] == "survived":
            self.prepare_sanitized()
            again = self.sanitized.try_mutation(mutation, reach, order)
            if again["outcome"] == "killed":
                return again
        return outcome
