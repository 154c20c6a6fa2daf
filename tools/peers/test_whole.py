"""Known answers for the comparison of whole commands: its tables, and how a command is watched. Needs no tool."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

from whole_report import HEADER, commands, failures, report, table
from whole_tools import ROWS, command, failure

HERE = os.path.dirname(os.path.abspath(__file__))
BINARIES = {"pellucid": "/bin/pellucid", "CloudCompare": "/bin/cc", "CloudCompare version": "2"}


def line(tool, repeat, wall_s=None, **rest):
    """A measurement."""
    measured = {} if wall_s is None else {"wall_s": wall_s, "cpu_s": wall_s * 2, "threads": 3 + repeat}
    sizes = {"peak_bytes": 500_000_000, "picture_bytes": 2_133_400}
    names = {"job": "nearest", "kind": "ply", "tool": tool, "version": f"{tool} 1.0", "command": ["see", "a b"]}
    return {**names, "repeat": repeat, "cal_ms": 300 + repeat, **measured, **sizes, **rest}


RUNS = [
    line("pellucid points", 0, 2.0, error={"differ": 0.00025, "rmse": 0.00123}),
    line("PyVista nearest", 0, 9.0, error={"differ": None, "rmse": None}),
    line("Open3D unlit", 0, failed="ended by SIGSEGV"),
    line("pellucid points", 1, 1.25),
    line("PyVista nearest", 1, 5.0),
    line("Open3D unlit", 1, failed="ended by SIGSEGV"),
    line("pellucid points", 2, 4.0),
    line("PyVista nearest", 2, failed="exit status 1: no memory"),
]
ROW = "| nearest, PLY | pellucid points | 1.25 | 2 | 1 | 3 | 2.5 | 5 | 500 | 2133 | 0.025% | 1.2e-03 |"


class Tables(unittest.TestCase):
    def test_a_row_says_it_all(self):
        # The least and the median of 2, 1.25 and 4 seconds.
        self.assertEqual(table(RUNS).splitlines()[2], ROW)

    def test_a_slower_run_changes_the_row(self):
        slower = [dict(m, wall_s=m["wall_s"] + 1) if m["tool"] == "pellucid points" else m for m in RUNS]
        row = table(slower).splitlines()[2]
        self.assertNotEqual(row, ROW)
        self.assertIn("| 2.25 | 3 | 1 |", row)

    def test_no_error_is_not_an_unknown_one(self):
        right = line("pellucid points", 0, 2.0, error={"differ": 0.0, "rmse": 0.0})
        self.assertTrue(table([right]).endswith("| 0.000% | 0 |"))
        self.assertTrue(table([line("pellucid points", 0, 2.0)]).endswith("| – | – |"))

    def test_a_run_that_failed_is_told_and_the_others_count(self):
        # 5 over 1.25; the median of 9 and 5.
        row = table(RUNS).splitlines()[3]
        self.assertEqual(row, "| nearest, PLY | PyVista nearest | 5 | 7 | 4 | 2 of 3 | 10 | 4 | 500 | 2133 | – | – |")

    def test_a_tool_that_always_failed_keeps_its_row(self):
        row = table(RUNS).splitlines()[4]
        self.assertEqual(row, "| nearest, PLY | Open3D unlit | failed |" + " – |" * (len(HEADER) - 3))
        self.assertEqual(
            failures(RUNS).splitlines(),
            [
                "- Open3D unlit, nearest, PLY: ended by SIGSEGV",
                "- PyVista nearest, nearest, PLY: exit status 1: no memory",
            ],
        )
        self.assertEqual(failures(RUNS[:2]), "Nothing failed.")

    def test_a_job_of_another_file_is_another_row(self):
        other = line("PyVista nearest", 0, 7.0, kind="laz")
        row = table([*RUNS, other]).splitlines()[-1]
        # Without pellucid on that file there is no ratio.
        self.assertTrue(row.startswith("| nearest, LAZ | PyVista nearest | 7 | 7 | – | 1 |"), row)

    def test_every_row_has_its_version_and_its_command(self):
        self.assertEqual(len(commands(RUNS).splitlines()), 3)
        self.assertEqual(commands(RUNS[2:3]), "- Open3D unlit, nearest, PLY (Open3D unlit 1.0): `see 'a b'`")
        self.assertTrue(report(RUNS, {"cores": 2}).startswith("Machine: cores 2; calibration 300 to 302 ms.\n"))


class Rows(unittest.TestCase):
    def test_each_row_is_named_once_and_has_a_command_on_its_file(self):
        self.assertEqual(len({(row.job, row.kind, row.label) for row in ROWS}), len(ROWS))
        for row in ROWS:
            self.assertIn(f"house.{row.kind}", command(row, BINARIES))

    def test_pellucid_looks_straight_down_on_768_pixels_of_25_mm(self):
        words = command(ROWS[0], BINARIES)
        self.assertEqual(words[:3], ["/bin/pellucid", "render", "house.ply"])
        self.assertIn("camera.height=19.2", words)
        # The middle of pixels 0 to 1023 and 0 to 767, of which 0 is centered on 0.
        self.assertIn("camera.eye=[12.7875,9.5875,30.0]", words)
        self.assertIn("camera.target=[12.7875,9.5875,0.0]", words)


class Failures(unittest.TestCase):
    def test_a_picture_and_status_0_are_no_failure(self):
        self.assertIsNone(failure({"status": 0}, "error: none", ["picture.png"]))

    def test_a_command_without_a_picture_failed_and_its_complaint_is_told(self):
        text = "Raster not supported here\n\nFinished in 2 s\n"
        self.assertEqual(failure({"status": 0}, text, []), "exit status 0, no picture: Raster not supported here")
        self.assertEqual(failure({"status": 0}, "", []), "exit status 0, no picture: nothing")

    def test_a_picture_does_not_hide_a_status_or_a_signal(self):
        self.assertEqual(failure({"status": 2}, "a\nb", ["picture.png"]), "exit status 2: b")
        self.assertEqual(failure({"status": -11, "wall_s": 1}, "a", ["picture.png"]), "ended by SIGSEGV")
        self.assertEqual(failure({"status": -9, "wall_s": 300.1}, "", []), "ended by SIGKILL after 300 s")

    def test_a_program_that_is_not_there_is_told(self):
        self.assertEqual(failure({"missing": "No such file"}, "", []), "No such file")


@unittest.skipUnless(os.path.isdir("/proc/self/task"), "threads are counted in /proc")
class Watching(unittest.TestCase):
    def watch(self, *words, limit_s=60):
        """What `whole_run` measures of a command, and what that printed."""
        with tempfile.NamedTemporaryFile("r") as printed:
            watcher = [sys.executable, os.path.join(HERE, "whole_run.py"), str(limit_s), printed.name]
            done = subprocess.run([*watcher, *words], stdout=subprocess.PIPE, check=True)
            return json.loads(done.stdout), printed.read()

    def python(self, text, **options):
        """The same of a program in Python."""
        return self.watch(sys.executable, "-c", text, **options)

    def test_the_peak_is_that_of_the_command_and_not_of_its_parent(self):
        held = b"x" * 300_000_000
        small, _ = self.python("pass")
        large, _ = self.python("x = b'x' * 150_000_000")
        self.assertEqual(len(held), 300_000_000)
        self.assertLess(small["peak_bytes"], 150_000_000)
        self.assertGreater(large["peak_bytes"], 150_000_000)
        self.assertLess(large["peak_bytes"], 300_000_000)

    def test_status_and_output_are_those_of_the_command(self):
        result, text = self.python("import sys; print('out'); print('err', file=sys.stderr, flush=True); sys.exit(3)")
        self.assertEqual((result["status"], sorted(text.split())), (3, ["err", "out"]))

    def test_a_signal_is_a_negative_status(self):
        self.assertEqual(self.python("import os; os.kill(os.getpid(), 11)")[0]["status"], -11)

    def test_a_command_that_takes_too_long_is_stopped(self):
        result, _ = self.python("import time; time.sleep(60)", limit_s=0.1)
        self.assertEqual(result["status"], -9)
        self.assertGreaterEqual(result["wall_s"], 0.1)

    def test_threads_are_counted_at_their_most(self):
        text = "import threading, time; [threading.Thread(target=time.sleep, args=(1,)).start() for _ in range(4)]"
        self.assertEqual(self.python(text)[0]["threads"], 5)

    def test_a_program_that_is_not_there_is_missing(self):
        self.assertIn("nowhere", self.watch("/nowhere")[0]["missing"])


if __name__ == "__main__":
    unittest.main()
