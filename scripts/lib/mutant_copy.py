# SPDX-License-Identifier: Apache-2.0
"""A mutated copy of the repository, built and tested. Each worker of scripts/mutants has one."""
import hashlib
import json
import os
import signal
import subprocess
import threading
import time

GIB = 1 << 30
# A mutant may allocate or write without end. A limit of memory does not help alone, because a test
# allocates more than 16 GiB that it never touches: choom makes the system end the mutant first.
LIMITS = ["choom", "-n", "1000", "--", "prlimit", "--core=0", f"--fsize={GIB}", f"--as={64 * GIB}"]
SHORTEST_TIMEOUT = 30  # seconds; a busy machine must not kill a mutant
LAYERS_DISABLED = {"VK_LOADER_LAYERS_DISABLE": "~implicit~"}


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


def run_process(command, folder, environment=None, timeout=None):
    """The exit status, None after a timeout, and the output."""
    process = subprocess.Popen([*LIMITS, *command], cwd=folder, env=environment,
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
        self.environment = {name: value for name, value in os.environ.items()
                            if not name.startswith(("VK_", "ASSAY_"))}
        self.environment.update(LAYERS_DISABLED, ASSAY_TEST_SEED=str(seed))
        for setting in properties.get("ENVIRONMENT", []):
            name, _, value = setting.partition("=")
            self.environment[name] = value
        self.seconds = 0

    def passes(self, timeout=None):
        status, self.output = run_process(self.command, self.folder, self.environment, timeout)
        return status == 0 or (status is not None and status == self.skipped)


class Copy:
    def __init__(self, root, number, seed):
        self.root, self.seed = root, seed
        self.tree = root / "build" / "mutants" / str(number)
        self.build = self.tree / "build" / "quick"
        self.tests, self.objects = [], {}

    # ---- before the first mutant

    def prepare(self):
        """The first time only."""
        if self.tests:
            return
        self.copy_files()
        self.run_or_fail(["cmake", "--preset", "quick",
                          "-DCMAKE_C_FLAGS_RELWITHDEBINFO=-O2 -DNDEBUG"], "does not configure")
        self.run_or_fail(["cmake", "--build", "--preset", "quick", "-j", "1"], "does not build")
        self.find_objects()
        listed = subprocess.run(["ctest", "--preset", "quick", "--show-only=json-v1"], check=True,
                                cwd=self.tree, stdout=subprocess.PIPE, text=True)
        self.tests = [Test(test, self.seed) for test in json.loads(listed.stdout)["tests"]]
        if not self.tests:
            raise Failed(f"{self.build}: no test is labelled quick")
        for test in self.tests:
            begin = time.monotonic()
            if not test.passes() and not test.passes():
                raise Failed(f"{test.name} fails without a mutation:\n{test.output[-2000:]}")
            test.seconds = time.monotonic() - begin

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

    def find_objects(self):
        """The objects of each source that the quick tests need. The objects of all sources in src/
        are those of None: a header may be part of any."""
        commands = json.loads((self.build / "compile_commands.json").read_text())
        everywhere = []
        for command in commands:
            name = os.path.relpath(command["file"], self.tree)
            words = command["command"].split()
            output = words[words.index("-o") + 1]
            if name.startswith("src/") and (self.build / output).exists():
                self.objects.setdefault(name, []).append(output)
                everywhere.append(output)
        self.objects[None] = everywhere

    # ---- a mutant

    def try_mutation(self, mutation, results):
        """{"outcome": ...}: killed with its killer, survived, unbuilt, equivalent or unused."""
        path = self.tree / mutation.path
        objects = self.objects.get(None if mutation.path.endswith(".h") else mutation.path)
        if not objects:
            return {"outcome": "unused"}
        if self.make(objects) != 0:
            raise Failed(f"{self.tree}: does not build without a mutation")
        before = self.hashes(objects)
        data = path.read_bytes()
        text = data.decode()
        path.write_text(text[:mutation.begin] + mutation.text + text[mutation.end:])
        try:
            if self.make(objects) != 0:
                return {"outcome": "unbuilt"}
            if self.hashes(objects) == before:
                return {"outcome": "equivalent"}
            return self.test(mutation, results)
        finally:
            path.write_bytes(data)

    def make(self, targets):
        status, _ = run_process(["ninja", "-j", "1", *targets], self.build)
        return status

    def hashes(self, objects):
        return [hashlib.sha256((self.build / name).read_bytes()).digest() for name in objects]

    def test(self, mutation, results):
        """The programs are linked a few at a time, because most mutants die early."""
        def worth(test):
            same, others = results.kills_of(test.name, mutation.path)
            return (1 + 10 * same + others) / (0.1 + test.seconds)
        tests = sorted(self.tests, key=worth, reverse=True)
        step = 3
        while tests:
            batch, tests = tests[:step], tests[step:]
            step *= 2
            if self.make(sorted({self.target_of(test) for test in batch})) != 0:
                return {"outcome": "unbuilt"}
            for test in batch:
                if not test.passes(max(SHORTEST_TIMEOUT, 20 * test.seconds)):
                    return {"outcome": "killed", "killer": test.name}
        return {"outcome": "survived"}

    def target_of(self, test):
        """The program, whose dependencies are the layer and the null driver if it needs them."""
        name = os.path.relpath(test.command[0], self.build)
        return "quick_tests" if name.startswith("..") else name
