# SPDX-License-Identifier: Apache-2.0
"""The target `uninstall`, in a project of two files."""

import os
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
MODULE = ROOT / "scripts" / "lib" / "uninstall.cmake"
PROJECT = f"""cmake_minimum_required(VERSION 3.25)
project(two VERSION 1 LANGUAGES NONE)
install(FILES one DESTINATION share)
add_subdirectory(inner)
include({MODULE})
set(CPACK_GENERATOR TGZ)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
include(CPack)
"""


class Uninstall(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="assay-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "inner").mkdir()
        (self.folder / "CMakeLists.txt").write_text(PROJECT, encoding="utf-8")
        (self.folder / "one").touch()
        (self.folder / "inner/two").touch()
        (self.folder / "inner/CMakeLists.txt").write_text("install(FILES two DESTINATION share/doc/assay/docs)\n"
                                                          "install(FILES two DESTINATION share/assay/inner)\n",
                                                          encoding="utf-8")
        self.build, self.prefix = self.folder / "build", self.folder / "a prefix"
        self.run_ok("cmake", "-G", "Ninja", "-S", self.folder, "-B", self.build)

    def status(self, *words, **variables):
        return subprocess.run(words, cwd=self.folder, env={**os.environ, **variables}, check=False,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode

    def run_ok(self, *words, **variables):
        self.assertEqual(self.status(*words, **variables), 0)

    def install(self, **variables):
        self.run_ok("cmake", "--install", self.build, "--prefix", self.prefix, **variables)

    def uninstall(self):
        return self.status("cmake", "--build", self.build, "--target", "uninstall")

    def files(self):
        return sorted(path.name for path in self.folder.glob("**/share/**/*")
                      if path.is_file() and "_CPack_Packages" not in path.parts)

    def test_uninstalls(self):
        self.install()
        self.assertEqual(self.files(), ["one", "two", "two"])
        self.assertEqual(self.uninstall(), 0)
        self.assertEqual(self.files(), [])
        self.assertEqual(os.listdir(self.prefix / "share"), ["doc"])
        self.assertEqual(os.listdir(self.prefix / "share/doc"), [])

    def test_keeps_files_of_others(self):
        self.install()
        (self.prefix / "share/doc/assay/three").touch()
        self.assertEqual(self.uninstall(), 0)
        self.assertEqual(self.files(), ["three"])

    def test_packages_in_between(self):
        self.install()
        self.run_ok("cpack", "--config", self.build / "CPackConfig.cmake")
        self.run_ok("cpack", "--config", self.build / "CPackConfig.cmake", "-B", self.folder / "there")
        self.assertEqual(self.uninstall(), 0)
        self.assertEqual(self.files(), [])

    def test_staged(self):
        self.install(DESTDIR=str(self.folder / "stage"))
        self.assertEqual(self.files(), ["one", "two", "two"])
        self.assertEqual(self.uninstall(), 0)
        self.assertEqual(self.files(), [])

    def test_nothing_is_installed(self):
        self.assertNotEqual(self.uninstall(), 0)
        self.install()
        (self.prefix / "share/one").unlink()
        self.assertEqual(self.uninstall(), 0)
        self.assertEqual(self.files(), [])
        self.assertNotEqual(self.uninstall(), 0)


if __name__ == "__main__":
    unittest.main()
