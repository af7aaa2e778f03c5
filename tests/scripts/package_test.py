# SPDX-License-Identifier: Apache-2.0
"""The .deb: what it contains, needs and says.

usage: package_test.py BUILD_FOLDER

Exits with 77 (skipped) if a tool that makes packages is missing."""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(sys.argv[1]).resolve()
TOOLS = ("cpack", "dpkg-deb", "dpkg-shlibdeps", "file")
DOCUMENTS = "usr/share/doc/assay"
LINK = re.compile(r"\]\(([^)#:]+)(?:#[^)]*)?\)")
# Links to what documents say about sources.
NOT_INSTALLED = ("json", "layer", "src", "tests", "scripts", "vuid-tables")


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="assay-test-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)

    @classmethod
    def make_package(cls):
        """Makes the package and returns its path."""
        subprocess.run(["cpack", "-G", "DEB", "--config", BUILD / "CPackConfig.cmake", "-B", cls.folder],
                       check=True, stdout=subprocess.DEVNULL)
        [package] = cls.folder.glob("assay_*.deb")
        return package

    def test_package(self):
        package = self.make_package()
        tree = self.folder / "tree"
        subprocess.run(["dpkg-deb", "--extract", package, tree], check=True)
        self.check_fields(package)
        self.assertTrue((tree / "usr/share/man/man1/assay-run.1").is_file() or
                        (tree / "usr/share/man/man1/assay-run.1.gz").is_file())
        self.assertTrue((tree / "usr/share/vulkan/explicit_layer.d/VkLayer_assay.json").is_file())
        self.check_documents(tree / DOCUMENTS)

    def check_fields(self, package):
        run = subprocess.run(["dpkg-deb", "--field", package], check=True, stdout=subprocess.PIPE,
                             encoding="utf-8")
        fields = dict(line.split(": ", 1) for line in run.stdout.splitlines() if re.match(r"\S+: ", line))
        self.assertIn("libvulkan1", fields["Recommends"].split(", "))
        self.assertIn("python3", fields["Depends"])
        self.assertNotIn(".invalid", run.stdout)  # a place that does not exist
        self.assertIn(f"/{DOCUMENTS}", run.stdout)
        places = re.findall(r"ASSAY_BUG_REPORTS:STRING=(.*)", (BUILD / "CMakeCache.txt").read_text())
        for place in filter(None, places):
            self.assertIn(f"<{place}>", fields["Maintainer"])
            self.assertIn(f"Report bugs to {place}.", run.stdout)

    def check_documents(self, folder):
        documents = list(folder.glob("**/*.md"))
        for document in [ROOT / "README.md", *(ROOT / "docs").glob("**/*.md")]:
            self.assertIn(folder / document.relative_to(ROOT), documents)
        for document in documents:
            for link in LINK.findall(document.read_text(encoding="utf-8")):
                target = (document.parent / link).resolve()
                name = str(target.relative_to(folder.resolve()))
                if name.split("/")[0] not in NOT_INSTALLED:
                    self.assertTrue(target.exists(), f"{document.name}: {link}")


def main():
    missing = [tool for tool in TOOLS if not shutil.which(tool)]
    if missing:
        print(f"skipped: {', '.join(missing)} missing")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])


if __name__ == "__main__":
    main()
