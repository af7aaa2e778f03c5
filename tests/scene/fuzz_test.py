# SPDX-License-Identifier: Apache-2.0
"""Damaged captures at random: tests/scene/fuzz.c.

usage: fuzz_test.py SCENE_FUZZ COUNT"""

import pathlib
import subprocess
import sys
import tempfile

from captures import scene


def main():
    with tempfile.TemporaryDirectory(prefix="assay-test-") as folder:
        seed, scratch = pathlib.Path(folder) / "seed", pathlib.Path(folder) / "scratch"
        capture = scene(seed)
        capture.finding(1, "pInfos[0].pGeometries[0]", "primitive 1")
        capture.finding(5, "pInfos[0].pGeometries[0]", "instance 1")
        capture.write()
        (scratch / "data").mkdir(parents=True)
        sys.exit(subprocess.run([sys.argv[1], seed, scratch, sys.argv[2]], check=False).returncode)


if __name__ == "__main__":
    main()
