# SPDX-License-Identifier: Apache-2.0
"""One build of a mutated copy of the repository, and the tests that run in it."""
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
LIMITS = ["choom", "-n", "1000", "--", "prlimit", "--core=0", f"--fsize={GIB}"]
ADDRESSES = f"--as={512 * GIB}"  # programs with `driver gaps` reserve 16 GiB behind each memory
# A test that hangs is ended by its processor time, which does not depend on how busy the machine is.
# One that waits for ever, which is rare, by the clock.
SHORTEST_TIMEOUT = 30  # seconds
LAYERS_DISABLED = {"VK_LOADER_LAYERS_DISABLE": "~implicit~"}
ORIGINAL = ".unmutated"  # the name of an output while a mutant has its place
OTHERS = "^(quick|bench|slow|no-coverage)$"  # labels that the other tests lack: they take up to a minute


class Failed(Exception):
    """Nothing can be said of any mutant; the text says why."""


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


def run_process(command, folder, environment=None, timeout=None, limits=()):
    """The exit status, None after a timeout, and the output."""
    process = subprocess.Popen([*LIMITS, *limits, *command], cwd=folder, env=environment,
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
    def __init__(self, description, seed, limits):
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
        self.limits = limits
        self.seconds = 0

    def passes(self, limited=False):
        timeout, limits = None, self.limits
        if limited:
            timeout = max(SHORTEST_TIMEOUT, 20 * self.seconds)
            limits = [*limits, f"--cpu={3 + int(10 * self.seconds)}"]
        status, self.output = run_process(self.command, self.folder, self.environment, timeout, limits)
        if any(failure.search(self.output) for failure in self.failures):
            return False
        return status == 0 or (status is not None and status == self.skipped)


def tests_of(tree, preset, seed, limits=(), is_quick=True):
    chosen = ("--preset", preset, "-L", "^quick$") if is_quick else \
        ("--test-dir", f"build/{preset}", "-LE", OTHERS)
    listed = subprocess.run(["ctest", *chosen, "--show-only=json-v1"],
                            check=True, cwd=tree, stdout=subprocess.PIPE, text=True)
    tests = [Test(test, seed, limits) for test in json.loads(listed.stdout)["tests"]]
    if not tests:
        raise Failed(f"{tree}: ctest {' '.join(chosen)} lists no test")
    return tests


def make(tree, preset, target, *options):
    """Configures a preset and builds a target of it."""
    for command, text in ((["cmake", "--preset", preset, *options], "does not configure"),
                          (["cmake", "--build", "--preset", preset, "--target", target],
                           "does not build")):
        status, output = run_process(command, tree)
        if status != 0:
            raise Failed(f"{tree} {text}:\n{output[-2000:]}")


# ---- a build

class Build:
    """Optimised, of preset quick; or sanitized, of preset asan, which finds what a run does not show."""

    def __init__(self, tree, preset, seed, has_others=False):
        self.tree, self.preset, self.seed, self.has_others = tree, preset, seed, has_others
        self.build = tree / "build" / preset
        self.is_sanitized = preset == "asan"
        self.tests, self.others, self.sound, self.links = [], [], set(), None

    def prepare(self):
        """Without debug information: else every mutation changes it."""
        for kept in self.build.rglob("*" + ORIGINAL):  # the last run was ended by force
            kept.replace(str(kept).removesuffix(ORIGINAL))
        target = "all" if self.has_others else "quick_tests"
        make(self.tree, self.preset, target, "-DCMAKE_C_FLAGS_DEBUG=-O1" if self.is_sanitized
             else "-DCMAKE_C_FLAGS_RELWITHDEBINFO=-O2 -DNDEBUG")
        (self.build / "mutant").mkdir(exist_ok=True)
        self.links = Links(self.build, target)
        limits = () if self.is_sanitized else [ADDRESSES]
        self.tests = tests_of(self.tree, self.preset, self.seed, limits)
        if self.has_others:
            self.others = tests_of(self.tree, self.preset, self.seed, limits, is_quick=False)

    def measure(self):
        """Fails if a test does."""
        for test in self.tests:
            begin = time.monotonic()
            self.require(test)
            test.seconds = time.monotonic() - begin

    def require(self, test):
        """That it passes without a mutation."""
        if test.name not in self.sound and not test.passes() and not test.passes():
            raise Failed(f"{test.name} fails without a mutation:\n{test.output[-2000:]}")
        self.sound.add(test.name)

    def try_mutation(self, mutation, reach, order):
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
            killer = self.find_killer(order(self.tests, names) + order(self.others, names),
                                      mutated, kept)
        finally:
            for path in kept:
                os.replace(path + ORIGINAL, path)
        if not killer:
            return {"outcome": "survived"}
        self.require(killer)
        return {"outcome": "killed", "killer": killer.name, "preset": self.preset,
                "is_quick": killer not in self.others}

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

    def find_killer(self, tests, mutated, kept):
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
                return test
        return None

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
