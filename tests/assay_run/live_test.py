# SPDX-License-Identifier: Apache-2.0
"""While the application runs: findings are printed, and the first one may end it."""

import os
import pty
import subprocess
import sys
import textwrap

from runs import ASSAY_RUN, LAYER, VUID, Runs, main

LONG = 600  # seconds: a test that waits for the end of the application fails by its time limit


class Live(Runs):
    def test_findings_are_printed_while_the_application_runs(self):
        """The application goes on when it reads a line, which the test writes after the finding."""
        script = "load(); find(); input(); find(); end()"
        with subprocess.Popen(
                [sys.executable, "-B", ASSAY_RUN, "--live", "--", sys.executable, "-c",
                 LAYER + script], cwd=self.folder, env=self.environment, encoding="utf-8",
                stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            first = [process.stderr.readline() for _ in range(2)]
            process.stdin.write("\n")
            process.stdin.close()
            rest = process.stderr.read()
        self.assertIn(VUID, first[0])
        self.assertIn("infoCount is 0.", first[1])
        self.assertNotIn("infoCount is 0.", rest)  # printed once
        self.assertIn("2 times", rest)
        self.assertIn("1 finding (reported 2 times)", rest)

    def run_on_terminal(self, *options, waits):
        """Returns what stands on the terminal. `waits`: the application ends only after the finding was
        printed."""
        script = "load(); find(); input(); print('last words', file=sys.stderr); end()"
        try:
            outer, inner = pty.openpty()
        except OSError as error:  # a container without /dev/pts
            self.skipTest(str(error))
        with subprocess.Popen(
                [sys.executable, "-B", ASSAY_RUN, *options, "--", sys.executable, "-c", LAYER + script],
                cwd=self.folder, env=self.environment, stdin=subprocess.PIPE, stderr=inner) as process:
            os.close(inner)
            text = b""
            while True:
                if not process.stdin.closed and (not waits or VUID.encode() in text):
                    process.stdin.write(b"\n")
                    process.stdin.close()
                try:
                    text += os.read(outer, 4096)
                except OSError:  # the other end is closed
                    break
        os.close(outer)
        return text.decode()

    def test_default_on_a_terminal(self):
        text = self.run_on_terminal(waits=True)
        self.assertLess(text.index(VUID), text.index("last words"))

    def test_not_live_on_a_terminal(self):
        text = self.run_on_terminal("--no-live", waits=False)
        self.assertLess(text.index("last words"), text.index(VUID))

    def test_half_a_line(self):
        """A line is read when it is whole."""
        script = """
            load()
            text = json.dumps({"Type": "Finding", "pid": os.getpid(), "time": TIME, "Severity": "Error",
                               "VUID": VUID, "MessageID": "0x1", "Objects": [], "MainMessage": "Half."})
            write(text[:40]); time.sleep(0.3); write(text[40:] + "\\n"); time.sleep(0.3); end()"""
        self.expect(self.run_script(script, "--live"), 99, "Half.", "1 finding in 1 process")


class StopAtFirst(Runs):
    def test_first_finding_ends_the_run(self):
        script = f"load(); find(); time.sleep({LONG})"
        self.expect(self.run_script(script, "--stop-at-first"), 99, "1 finding in 1 process",
                    "the first finding has ended the run")

    def test_findings_while_the_application_ends(self):
        """The signal comes again while a busy machine is slow to handle it."""
        script = f"""
            import itertools
            turns = itertools.count()
            signal.signal(signal.SIGTERM, lambda *_: next(turns) or (find(), end(), sys.exit(0)))
            load(); find(); time.sleep({LONG})"""
        self.expect(self.run_script(script, "--stop-at-first"), 99,
                    "has ended the run (--stop-at-first); 1 more came before the application had ended")

    def test_signal_is_ignored(self):
        script = f"signal.signal(signal.SIGTERM, signal.SIG_IGN); load(); find(); time.sleep({LONG})"
        self.expect(self.run_script(script, "--stop-at-first"), 99, "has ended the run")

    def test_process_that_outlives_the_application(self):
        script = f"""
            ours, theirs = os.pipe()
            if os.fork() == 0:
                load(); os.write(theirs, b"."); time.sleep(0.5); find(); time.sleep({LONG})
            os.read(ours, 1)"""
        self.expect(self.run_script(script, "--stop-at-first"), 99, "has ended the run")

    def test_nothing_to_stop_for(self):
        result = self.expect(self.run_script("load(); end(); sys.exit(3)", "--stop-at-first"), 3)
        self.assertNotIn("has ended the run", result.err)

    def test_known_findings_do_not_count(self):
        (self.folder / "known.txt").write_text(VUID)
        script = textwrap.dedent("load(); find(); time.sleep(0.5); end(); sys.exit(4)")
        self.expect(self.run_script(script, "--stop-at-first", "--baseline", "known.txt"), 4)

    def test_warnings_do_not_count(self):
        script = "load(); find(Severity='Warning'); time.sleep(0.5); end(); sys.exit(4)"
        self.expect(self.run_script(script, "--stop-at-first"), 4)


if __name__ == "__main__":
    main()
