# SPDX-License-Identifier: Apache-2.0
"""assay-run end to end: a real application, the loader, the layer, and the null driver."""

import json
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import unittest

from runs import ASSAY_RUN, ROOT, SCHEMA, VUID, Runs, jsonschema, main, needs_jsonschema

KHRONOS = pathlib.Path("/usr/share/vulkan/explicit_layer.d")
APPLICATION, LAYERS, DRIVER = (pathlib.Path(word).resolve() for word in sys.argv[1:4])


class Layer(Runs):
    def setUp(self):
        super().setUp()
        self.environment.update(VK_LAYER_PATH=str(LAYERS), VK_DRIVER_FILES=str(DRIVER),
                                VK_LOADER_LAYERS_DISABLE="~implicit~",
                                # The application asks for none; this is the default.
                                VK_ASSAY_VALIDATION_DUPLICATE_MESSAGE_LIMIT="10")

    def run_steps(self, steps, *options, **environment):
        return self.run_words(*options, "--", APPLICATION, *steps.split(), **environment)

    def records(self, folder="records"):
        files = sorted((self.folder / folder).glob("*/*.jsonl"))
        return [[json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]
                for file in files]

    def test_scratch_mistake(self):
        self.expect(self.run_steps("clean scratch", "--error-exitcode", "7"), 7, "scratchData.deviceAddress")

    def test_clean(self):
        self.expect(self.run_steps("clean"), 0, "0 findings in 1 process")

    def test_clean_with_own_status(self):
        self.assertEqual(self.run_steps("clean exit=42").status, 42)

    def test_only_the_layer_is_absent(self):
        """An installation without the layer, and a VK_LAYER_PATH that leads nowhere."""
        (self.folder / "copy").mkdir()
        copy = self.folder / "copy/assay-run"
        copy.write_text(ASSAY_RUN.read_text(encoding="utf-8"), encoding="utf-8")
        (self.folder / "copy/assay_run").symlink_to(ROOT / "scripts/assay_run")
        (self.folder / "copy/run.py").write_text(
            "import sys; sys.path.insert(0, '.')\n"
            "import assay_run.environment as environment\n"
            "environment.find_manifest_folder = lambda scripts: None\n"
            "exec(compile(open('assay-run').read(), 'assay-run', 'exec'))\n")
        run = subprocess.run([sys.executable, "-B", "run.py", "--", APPLICATION, "mistake"],
                             cwd=self.folder / "copy", capture_output=True, encoding="utf-8",
                             env={**self.environment, "VK_LAYER_PATH": "/nowhere"}, check=False)
        self.assertEqual(run.returncode, 98, run.stderr)

    def test_wrong_layer_path(self):
        """The layer that assay-run comes with is found all the same, if there is one."""
        result = self.run_steps("mistake", VK_LAYER_PATH="/nowhere")
        self.assertIn(result.status, (98, 99))

    def test_enabled_twice(self):
        result = self.run_steps("mistake", VK_INSTANCE_LAYERS="VK_LAYER_ASSAY_validation")
        self.assertIn("1 finding in 1 process", result.err)

    def run_region(self, status, *steps, label=f"assay:expect {VUID}"):
        return self.expect(self.run_words("--record", "records", "--", APPLICATION, f"label={label}",
                                          *steps), status)

    def test_expected_finding(self):
        self.assertIn("0 findings in 1 process; 1 expected finding",
                      self.run_region(0, "mistake", "unlabel", "clean").err)
        self.run_region(99, "mistake", "unlabel", "mistake")
        self.run_region(99, "mistake", label="assay:expect VUID-other")
        # The labels of findings are cut, too.
        self.run_region(0, "mistake", label=f"assay:expect {VUID} # {'x' * 300}")

    def test_expected_finding_is_absent(self):
        for label in (f"assay:expect {VUID}", f"assay:expect {VUID} # {'x' * 300}"):
            self.assertIn("but not reported", self.run_region(99, "clean", label=label).err)
            self.assertIn("but not reported", self.run_region(99, "unlabel", "mistake", label=label).err)

    @needs_jsonschema
    def test_expectations_match_the_schema(self):
        self.run_region(99, "clean")
        schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
        [lines] = self.records()
        for line in lines:
            jsonschema.validate(line, schema)
        self.assertIn("Expectation", [line["Type"] for line in lines])

    def test_everything(self):
        self.expect(self.run_steps("clean", "--everything", "--html", "a.html"), 0, "0 findings")
        result = self.run_steps("clean mistake", "--everything", "--json", "a.json")
        self.assertNotIn("warning", result.err)
        settings = self.load("a.json")["headers"][0]["Settings"]
        for key, value in (("preset", "everything"), ("level", "content"), ("hazards", "true"),
                           ("guard", "references"), ("call_sites", "full"), ("record_builds", "true"),
                           ("advice", "true"), ("limits", "driver")):
            self.assertEqual(settings[key], value, key)

    def test_messenger_and_log_action(self):
        for action in ("default", "callback", "log", "ignore", "fail"):
            self.expect(self.run_steps("mistake", "--set", f"debug_action={action}"), 99)

    def test_signals(self):
        for number in (signal.SIGSEGV, signal.SIGKILL, signal.SIGABRT):
            self.expect(self.run_steps(f"clean mistake signal={int(number)}"), -number, VUID)

    def test_application_that_leaves_its_instance(self):
        self.assertEqual(self.run_steps("mistake leave").status, 99)
        self.assertEqual(self.run_steps("clean leave").status, 0)

    def test_device_is_left_behind(self):
        """Advice comes when the instance is destroyed, and what was alive is said if it is not."""
        options = ("--everything", "--set", "advice_limits=submissions=0")
        result = self.run_steps("clean submit abandon", *options)
        self.expect(result, 0, "advice: VkAccelerationStructureKHR", "with ALLOW_UPDATE and never updated")
        self.assertNotIn("is alive at", result.err)
        self.expect(self.run_steps("clean submit leave", *options), 0,
                    "ended without vkDestroyInstance, so the list of advice is missing: after 1 submission")

    def test_sixteen_processes(self):
        processes = f"for i in $(seq 16); do {APPLICATION} name=process-$i many=3 & done; wait"
        self.expect(self.run_words("--json", "all.json", "--", "sh", "-c", processes), 99,
                    "1 finding (reported 48 times) in 16 processes")
        found = self.load("all.json")["new"]
        names = [item["name"] for one in found for item in one["Objects"] if "name" in item]
        self.assertEqual(sorted(set(names)), sorted(f"process-{i}" for i in range(1, 17)))

    def test_sixteen_runs_at_once(self):
        runs = [subprocess.Popen(
            [sys.executable, "-B", ASSAY_RUN, "--quiet", "--record", "records", "--", APPLICATION,
             "mistake" if i % 2 else "clean"], cwd=self.folder, env=self.environment,
            stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) for i in range(16)]
        self.assertEqual([run.wait() for run in runs], [0, 99] * 8)
        self.expect(self.run_words("--merge", "records"), 99, "1 finding (reported 8 times) in 16 processes")

    def test_baseline(self):
        self.assertEqual(self.run_steps("name=mesh-1 mistake", "--write-baseline",
                                        "known.txt").status, 0)
        self.assertIn(f"{VUID}@mesh-1", self.read("known.txt"))
        baseline = ("--baseline", "known.txt")
        self.assertEqual(self.run_steps("name=mesh-1 many=99", *baseline).status, 0)
        # The limit for each id may not hide the last.
        self.assertEqual(self.run_steps("name=mesh-1 many=200 name=mesh-2 mistake",
                                        *baseline).status, 99)
        self.expect(self.run_steps("clean", *baseline), 0, "known.txt:2: matches no finding any more")
        self.assertEqual(self.run_steps("clean", *baseline, "--strict-baseline").status, 99)

    def test_message_id_filter_takes_lines_of_a_baseline(self):
        line = f"message_id_filter={VUID}@mesh-*"
        self.assertEqual(self.run_steps("name=mesh-1 mistake", "--set", line).status, 0)
        self.assertEqual(self.run_steps("name=box mistake", "--set", line).status, 99)

    def test_held_back(self):
        self.expect(self.run_steps("many=50"), 99,
                    "1 finding (reported 10 times, 40 duplicates not reported)")

    @unittest.skipUnless((KHRONOS / "VkLayer_khronos_validation.json").exists(),
                         "the Khronos validation layer is not installed")
    def test_with_khronos(self):
        """Both find the mistake, and Assay's finding counts. Loaders order the layers by VK_INSTANCE_LAYERS
        or by the folders; both orders are good. VK_LAYER_PATH need not have the Khronos layer."""
        (self.folder / "vk_layer_settings.txt").write_text(
            "khronos_validation.debug_action = VK_DBG_LAYER_ACTION_LOG_MSG\n"
            "khronos_validation.log_filename = khronos.txt\n"
            "khronos_validation.report_flags = error\n")
        result = self.run_steps("clean scratch", "--with-khronos", VK_LOADER_DEBUG="layer")
        self.expect(result, 99, "1 finding in 1 process", "-pInfos-03710")
        self.assertIn("-pInfos-03710", self.read("khronos.txt"))
        stack = result.err.partition("vkCreateInstance layer callstack setup to:")[2]
        stack = stack.partition("<Drivers>")[0]
        self.assertEqual(sorted(re.findall(r"VK_LAYER_(\w+)_validation", stack)), ["ASSAY", "KHRONOS"])

    @unittest.skipUnless((KHRONOS / "VkLayer_khronos_validation.json").exists(),
                         "the Khronos validation layer is not installed")
    def test_count_khronos(self):
        """What both layers find counts once. Khronos layers of 2023 have false alarms of their own."""
        result = self.run_steps("clean scratch", "--count-khronos", "--json", "a.json")
        self.expect(result, 99, "-pInfos-03710 (both layers)")
        found = self.load("a.json")["new"]
        self.assertEqual([one.get("Layer") for one in found if one["VUID"].endswith("-pInfos-03710")], [None])
        (self.folder / "known.txt").write_text("".join({
            f"{one['VUID']}\n" for one in found if one.get("Layer")}))
        self.expect(self.run_steps("clean scratch", "--count-khronos", "--baseline", "known.txt"), 99,
                    "1 finding in 1 process")
        self.expect(self.run_steps("clean", "--count-khronos", "--baseline", "known.txt"), 0)

    def run_recorded(self, record, *command, **environment):
        """Returns the status, and the number of lines of each Type in the record."""
        status = self.run_words("--set", "record_builds=true", "--record", record, "--", *command,
                                VK_LAYER_PATH=f"{LAYERS}:{KHRONOS}", **environment).status
        [lines] = self.records(record)
        types = [line["Type"] for line in lines]
        return status, {name: types.count(name) for name in types}

    @unittest.skipUnless(shutil.which("gfxrecon-replay") and (KHRONOS / "VkLayer_gfxreconstruct.json").exists(),
                         "gfxreconstruct is not installed")
    def test_replay_by_gfxreconstruct(self):
        """It finds what the application did: the null driver's addresses are the same in the replay as in the
        capture, as on drivers that can replay addresses."""
        steps = ("clean", "scratch", "clean", "submit")
        captured = self.run_recorded("capture", APPLICATION, *steps, VK_INSTANCE_LAYERS="VK_LAYER_LUNARG_gfxreconstruct",
                                     GFXRECON_CAPTURE_FILE=str(self.folder / "a.gfxr"))
        self.assertEqual(captured[0], 99)
        self.assertGreater(captured[1]["Build"], steps.index("submit"))
        [capture] = self.folder.glob("a*.gfxr")
        self.assertEqual(self.run_recorded("replay", "gfxrecon-replay", capture), captured)

    def test_lines_of_readme(self):
        section = (ROOT / "README.md").read_text(encoding="utf-8").partition("\n## In CI\n")[2]
        lines = section.partition("```sh\n")[2].partition("```")[0]
        if self.run_words("--lavapipe", "--", "true").status == 2:
            self.skipTest("lavapipe is not installed")
        (self.folder / "bin").mkdir()
        (self.folder / "bin/assay-run").symlink_to(ASSAY_RUN)
        path = f"{self.folder}/bin:{self.environment['PATH']}"
        for step, expected in (("clean", 0), ("mistake", 99), ("exit=5", 98)):
            (self.folder / "app").write_text(f"#!/bin/sh\nexec {APPLICATION} {step}\n")
            (self.folder / "app").chmod(0o755)
            run = subprocess.run(["bash", "-c", lines], cwd=self.folder, check=False,
                                 env={**self.environment, "PATH": path}, capture_output=True)
            self.assertEqual(run.returncode, expected, run.stderr)
            for name in ("assay.xml", "assay.sarif", "assay.html"):
                self.assertTrue((self.folder / name).exists())
                (self.folder / name).unlink()

    def test_reports(self):
        result = self.run_steps("clean name=a mistake submit", "--junit", "a.xml", "--sarif", "a.sarif",
                                "--json", "a.json", "--html", "a.html", "--github")
        self.expect(result, 99)
        for name in ("a.xml", "a.sarif", "a.json", "a.html"):
            self.assertIn(VUID, self.read(name))
        self.assertIn(f"title={VUID}", result.out)
        data = json.loads(self.read("a.html").partition('id="data">')[2].partition("</script>")[0])
        self.assertLessEqual({"Submission", "Build", "Destroyed", "a"}, set(data["builds"]["words"]))


if __name__ == "__main__":
    main()
