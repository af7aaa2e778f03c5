# SPDX-License-Identifier: Apache-2.0
"""A mutated copy of the repository, built and tested. Each worker of scripts/mutants has one."""
import json
import os
import re
import signal
import subprocess
import threading
import time

from mutant_links import Links

GIB = 1 << 30
# A mutant may allocate or write without end. A limit of memory does not help alone, because a test
# allocates more than 16 GiB that it never touches: choom makes the system end the mutant first.
LIMITS = ["choom", "-n", "1000", "--", "prlimit", "--core=0", f"--fsize={GIB}", f"--as={64 * GIB}"]
# A test that hangs is ended by its processor time, which does not depend on how busy the machine is.
# One that waits for ever, which is rare, by the clock.
SHORTEST_TIMEOUT = 30  # seconds
# Tests whose processes end without writing counts: reach.find does not name them.
UNCOUNTED = ("report_json_", "report_log_files", "report_log_json")
LAYERS_DISABLED = {"VK_LOADER_LAYERS_DISABLE": "~implicit~"}


ORIGINAL = ".unmutated"  # the name of an output while a mutant has its place


class Failed(Exception):
    """Nothing can be said of any mutant; the text says why."""


def repository_files(root):
    """Of the working tree, as git sees it."""
    run = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                         cwd=root, check=True, stdout=subprocess.PIPE, text=True)
    return sorted(name for name in set(run.stdout.split("\0")) if name and (root / name).is_file())


# ---- processes

running = set()
running_lock = threading.Lock()


def kill_group(process):
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


def stop_processes():
    """Ends what the workers have started."""
    with running_lock:
        for process in running:
            kill_group(process)


def run_process(command, folder, environment=None, timeout=None, processor_seconds=None):
    """The exit status, None after a timeout, and the output."""
    limits = [*LIMITS, f"--cpu={processor_seconds}"] if processor_seconds else LIMITS
    process = subprocess.Popen([*limits, *command], cwd=folder, env=environment,
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, start_new_session=True)
    with running_lock:
        running.add(process)
    try:
        output, _ = process.communicate(timeout=timeout)
        status = process.returncode
    except subprocess.TimeoutExpired:
        kill_group(process)
        output, _ = process.communicate()
        status = None
    finally:
        with running_lock:
            running.discard(process)
    return status, output.decode(errors="replace")


# ---- tests

class Test:
    def __init__(self, description, seed):
        properties = {item["name"]: item["value"] for item in description.get("properties", [])}
        self.name, self.command = description["name"], description["command"]
        self.folder = properties["WORKING_DIRECTORY"]
        self.skipped = properties.get("SKIP_RETURN_CODE")
        self.failures = [re.compile(text)
                         for text in properties.get("FAIL_REGULAR_EXPRESSION", [])]
        self.environment = {name: value for name, value in os.environ.items()
                            if not name.startswith(("VK_", "ASSAY_"))}
        self.environment.update(LAYERS_DISABLED, ASSAY_TEST_SEED=str(seed))
        for setting in properties.get("ENVIRONMENT", []):
            name, _, value = setting.partition("=")
            self.environment[name] = value
        self.seconds = 0

    def passes(self, limited=False):
        limits = ()
        if limited:
            limits = max(SHORTEST_TIMEOUT, 20 * self.seconds), 3 + int(10 * self.seconds)
        status, self.output = run_process(self.command, self.folder, self.environment, *limits)
        if any(failure.search(self.output) for failure in self.failures):
            return False
        return status == 0 or (status is not None and status == self.skipped)


def tests_of(tree, preset, seed):
    listed = subprocess.run(["ctest", "--preset", preset, "-L", "^quick$", "--show-only=json-v1"],
                            check=True, cwd=tree, stdout=subprocess.PIPE, text=True)
    tests = [Test(test, seed) for test in json.loads(listed.stdout)["tests"]]
    if not tests:
        raise Failed(f"{tree}: no test is labelled quick")
    return tests


class Copy:
    def __init__(self, root, number, seed):
        self.root, self.seed = root, seed
        self.tree = root / "build" / "mutants" / str(number)
        self.build = self.tree / "build" / "quick"
        self.tests, self.links = [], None

    # ---- before the first mutant

    def prepare(self):
        """The first time only."""
        if self.tests:
            return
        self.copy_files()
        for kept in self.build.rglob("*" + ORIGINAL):  # the last run was ended by force
            kept.replace(str(kept).removesuffix(ORIGINAL))
        self.run_or_fail(["cmake", "--preset", "quick",
                          "-DCMAKE_C_FLAGS_RELWITHDEBINFO=-O2 -DNDEBUG"], "does not configure")
        self.run_or_fail(["cmake", "--build", "--preset", "quick"], "does not build")
        (self.build / "mutant").mkdir(exist_ok=True)
        self.links = Links(self.build, "quick_tests")
        tests = tests_of(self.tree, "quick", self.seed)
        for test in tests:
            begin = time.monotonic()
            if not test.passes() and not test.passes():
                raise Failed(f"{test.name} fails without a mutation:\n{test.output[-2000:]}")
            test.seconds = time.monotonic() - begin
        self.tests = tests

    def count_lines(self, reach):
        """Builds a second time, and notes which lines each test executes."""
        self.copy_files()
        build = self.tree / "build" / "coverage"
        self.run_or_fail(["cmake", "--preset", "coverage", "-DCMAKE_C_FLAGS_DEBUG=-O1"],
                         "does not configure")
        self.run_or_fail(["cmake", "--build", "--preset", "coverage",
                          "--target", "quick_tests"], "does not build")
        for path in build.rglob("*.gcda"):
            path.unlink()
        for test in tests_of(self.tree, "coverage", self.seed):
            test.passes()
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

    def run_or_fail(self, command, text):
        status, output = run_process(command, self.tree)
        if status != 0:
            raise Failed(f"{self.tree} {text}:\n{output[-2000:]}")

    # ---- a mutant

    def try_mutation(self, mutation, results, reach):
        """{"outcome": ...}: killed with its killer, survived, unbuilt, equivalent or unused."""
        text = (self.tree / mutation.path).read_text(encoding="utf-8")
        names, having = reach.find(mutation.path, text.count("\n", 0, mutation.begin) + 1)
        objects = self.links.objects_of(self.tree / mutation.path)
        if mutation.path.endswith(".h"):
            objects &= having  # an unused inline function is part of no object
        if not objects:
            return {"outcome": "unused"}
        mutated = self.compile(mutation, text, sorted(objects))
        if mutated is None:
            return {"outcome": "unbuilt"}
        if not mutated:
            return {"outcome": "equivalent"}
        kept = []
        try:
            return self.test(self.order(mutation, results, names), mutated, kept)
        finally:
            for path in kept:
                os.replace(path + ORIGINAL, path)

    def compile(self, mutation, text, objects):
        """The objects that the mutation changes, each with its mutant; None if it is no C."""
        path, mutated = self.tree / mutation.path, {}
        times = path.stat()
        path.write_text(text[:mutation.begin] + mutation.text + text[mutation.end:])
        try:
            for number, made in enumerate(objects):
                mutant = f"mutant/{number}.o"
                status, _ = run_process(["sh", "-c", self.links.compilation(made, mutant)], self.build)
                if status != 0:
                    return None
                if (self.build / made).read_bytes() != (self.build / mutant).read_bytes():
                    mutated[made] = mutant
            return mutated
        finally:
            path.write_text(text)
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))

    def order(self, mutation, results, names):
        """The tests that execute the mutation: those first that are likely to kill it, and short."""
        def worth(test):
            before, same, others = results.kills_of(test.name, mutation)
            return before, (1 + 10 * same + others) / (0.2 + test.seconds)
        return sorted((test for test in self.tests
                       if test.name in names or test.name.startswith(UNCOUNTED)),
                      key=worth, reverse=True)

    def test(self, tests, mutated, kept):
        """Links a program when its test comes, because most mutants die early."""
        linked = set()
        for test in tests:
            affected = [name for name in self.links.outputs_of(test.command)
                        if self.is_affected(name, mutated)]
            for name in affected:
                if name not in linked:
                    self.link(name, mutated, kept)
                linked.add(name)
            if affected and not test.passes(limited=True):
                return {"outcome": "killed", "killer": test.name}
        return {"outcome": "survived"}

    def is_affected(self, name, mutated):
        return not self.links.objects_in(self.links.outputs[name]).isdisjoint(mutated)

    def link(self, name, mutated, kept):
        """In the place of the output, which `kept` is for: the programs find each other there."""
        output = self.links.outputs[name]
        used = self.links.objects_in(output)
        path = str(self.build / name)
        os.replace(path, path + ORIGINAL)
        kept.append(path)
        command = self.links.link(output, {made: mutant for made, mutant in mutated.items()
                                           if made in used})
        status, text = run_process(["sh", "-c", command], self.build)
        if status != 0:
            raise Failed(f"{path} does not link:\n{text[-2000:]}")
