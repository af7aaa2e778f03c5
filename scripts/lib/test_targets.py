# SPDX-License-Identifier: Apache-2.0
"""Prints what Ninja has to build for the tests of a preset.

test_targets.py PRESET, in the root of the repository. The preset is configured. A program that no
test of the preset runs need not be built: the thread sanitizer's runs leave out most tests."""

import json
import pathlib
import re
import subprocess
import sys

ADD_TEST = re.compile(r"^add_test\(\[=\[(.*?)\]=\] (.*)\)$", re.MULTILINE)


def output_of(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def words_of_tests(build):
    """The commands, by the names of the tests. ctest itself lists only those that are built."""
    return {name: re.findall(r'"([^"]*)"', words)
            for file in build.glob("**/CTestTestfile.cmake")
            for name, words in ADD_TEST.findall(file.read_text(encoding="utf-8"))}


def main():
    build = pathlib.Path("build", sys.argv[1]).absolute()
    listed = json.loads(output_of("ctest", "--preset", sys.argv[1], "--show-only=json-v1"))
    known = {line.rpartition(": ")[0]
             for line in output_of("ninja", "-C", str(build), "-t", "targets", "all").splitlines()}
    words = words_of_tests(build)
    files = {word.removeprefix(f"{build}/") for test in listed["tests"] for word in words[test["name"]]
             if word.startswith(f"{build}/")}
    # Tests open these themselves.
    files |= {"layer/libVkLayer_assay.so", "tests/null_driver/libVkICD_null.so"}
    print("\n".join(sorted(files & known)))


if __name__ == "__main__":
    main()
