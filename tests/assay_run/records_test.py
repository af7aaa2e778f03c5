# SPDX-License-Identifier: Apache-2.0
"""Records: read, damaged, merged."""

import json

from page_test import build, compacted_size
from runs import NASTY, SCHEMA, TIME, Runs, finding, header, jsonschema, main, needs_jsonschema
from assay_run.records import read_records


class Merging(Runs):
    def record(self, script, folder):
        return self.run_script(script, "--record", folder).status

    def test_one_verdict(self):
        self.record("load(); end()", "records")
        self.record("load(); find(); end()", "records")
        self.expect(self.run_words("--merge", "records"), 99, "1 finding in 2 processes")

    def test_a_record_named_twice_counts_once(self):
        self.record("load(); find()", "a")
        self.assertIn("1 finding in 1 process", self.run_words("--merge", "a", ".", "a").err)

    def test_status_of_an_application(self):
        self.record("load(); end(); sys.exit(3)", "records")
        self.record("load(); end()", "records")
        self.assertEqual(self.run_words("--merge", "records").status, 3)

    def test_signal_of_an_application(self):
        self.record("load(); os.kill(os.getpid(), 9)", "records")
        self.expect(self.run_words("--merge", "records"), 137, "SIGKILL")

    def test_one_run_without_the_layer(self):
        self.record("load(); end()", "records")
        self.record("pass", "records")
        self.expect(self.run_words("--merge", "records"), 98, "the layer was not loaded")

    def test_a_run_that_was_cut_off(self):
        self.record("load(); end()", "records")
        self.record("load(); end(); os.kill(os.getppid(), 9)", "records")
        self.expect(self.run_words("--merge", "records"), 97, "the run was cut off")

    def test_full_disk_without_half_lines(self):
        self.write_record(header(), name="a/7.jsonl")
        (self.folder / "a/run.json").write_text(
            json.dumps({"command": ["app"], "status": 0, "full": True}))
        self.assertEqual(self.run_words("--merge", "a").status, 97)

    def test_files_without_runs(self):
        self.write_record(header(), finding(), name="a.txt")
        self.assertEqual(self.run_words("--merge", "a.txt").status, 99)

    def test_pids_of_two_hosts(self):
        self.write_record(header(), name="a/7.jsonl")
        self.write_record(header(), name="b/7.jsonl")
        self.assertIn("2 processes", self.run_words("--merge", "a", "b").err)

    def test_nothing_there(self):
        (self.folder / "empty").mkdir()
        self.assertEqual(self.run_words("--merge", "empty").status, 98)
        self.assertEqual(self.run_words("--merge", "none").status, 2)


class Reading(Runs):
    def test_empty(self):
        self.assertEqual(read_records([self.write_record()]).headers, [])

    def test_broken_lines(self):
        lines = ["", "{", "[]", "1", "{}", '{"Type": 1}', '{"Type": "Finding"}', "\xff",
                 json.dumps({**finding(), "VUID": None})]
        path = self.folder / "1.jsonl"
        path.write_text("\n".join([json.dumps(header()), *lines, json.dumps(finding())]),
                        encoding="latin-1")
        record = read_records([path])
        self.assertEqual((len(record.findings), len(record.damaged)), (1, 8))

    def test_half_characters(self):
        path = self.write_record(header(), finding(MainMessage="\ud83d half"))
        self.assertEqual(read_records([path]).findings[0]["MainMessage"], "? half")

    def test_unknown_lines_are_kept_apart(self):
        """A newer layer may write more."""
        record = read_records([self.write_record(header(), {"Type": "New", "pid": 1})])
        self.assertEqual((len(record.lines), record.findings, record.damaged), (2, [], []))

    def test_foreign_run_file(self):
        (self.folder / "run.json").write_text("[]")
        self.assertEqual(self.run_words("--merge", ".").status, 2)

    def test_messages_cannot_control_the_terminal(self):
        self.write_record(header(), finding(MainMessage=NASTY))
        result = self.run_words("--merge", ".")
        self.assertNotIn("\x1b", result.err)
        self.assertNotIn("\x00", result.err)
        self.assertIn("🦆", result.err)

    def test_terminal_without_utf_8(self):
        self.write_record(header(), finding(MainMessage=NASTY))
        result = self.run_words("--merge", ".", "--github", PYTHONIOENCODING="ascii")
        self.assertEqual(result.status, 99)

    @needs_jsonschema
    def test_records_of_these_tests_are_as_the_layer_writes_them(self):
        schema = self.load(SCHEMA)
        for line in (header(), finding(), finding(MainMessage=NASTY), build(1), compacted_size(1)):
            jsonschema.validate(line, schema)


def built(name, **members):
    return {"Type": "Build", "pid": 7, "time": TIME, "device": "0x1", "dst": f"0x{ord(name):x}000",
            "dst_name": name, "type": "bottom level", "mode": "build", "flags": "0x2", "size": 1 << 20, **members}


class LastState(Runs):
    """A process that ends without vkDestroyInstance leaves no list of advice."""

    LINES = [{"Type": "Submission", "pid": 7, "time": TIME, "device": "0x1"}, built("a"), built("b"),
             built("b"), built("c", flags="0x0"), built("d"), built("e"),
             {**built("f"), "Type": "Copy", "mode": "compact", "src": "0x61000", "flags": "0x0"},
             {"Type": "Destroyed", "pid": 7, "time": TIME, "device": "0x1", "dst": "0x64000"}]

    def merge(self, *lines, **settings):
        self.write_record(header(Settings={"advice": "true", **settings}), *lines)
        return self.run_words("--merge", "7.jsonl")

    def test_structures_are_alive(self):
        self.expect(self.merge(*self.LINES), 0,
                    "process 7 ended without vkDestroyInstance, so the list of advice is missing: after 1 "
                    "submission 5 acceleration structures (5.0 MiB) were alive; the largest: a, b, c; 2 "
                    "acceleration structures (2.0 MiB) were built with ALLOW_COMPACTION and never compacted")

    def test_nothing_is_said(self):
        for result in (self.merge(*self.LINES, {"Type": "Summary", "pid": 7, "time": TIME}), self.merge(*self.LINES, advice="false"),
                       self.merge(self.LINES[0])):
            self.assertNotIn("ended without", result.err)


if __name__ == "__main__":
    main()
