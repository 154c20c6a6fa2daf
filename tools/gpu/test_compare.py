"""Known answers for the comparison of measurements: `python3 -m unittest discover tools/gpu`."""

import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path

from compare import alone, compared, file_name, key, last_of, main, moved, moved_passes, read, rows, summary, verdict

CLOCK = [[1.0, 0.5], [1.0, 0.5]]


def row(method, ms, clock=CLOCK, used=True, **rest):
    """A row of the garden."""
    times = {"min_ms": ms, "median_ms": ms, "p95_ms": ms, "calibration_ms": clock, "calibrated": used, "passes": []}
    return {"kind": "row", "scene": "garden", "size": [64, 48], "method": method, **times, **rest}


def measurement(*lines, commit="abc", card="NVIDIA H200", driver="NVIDIA 580.1 (x)"):
    """Lines of a card."""
    machine = {"kind": "machine", "commit": commit, "date": "2026-12-01"}
    return [machine, {"kind": "device", "name": card, "driver": driver}, *lines]


class Verdicts(unittest.TestCase):
    def test_eight_percent_at_an_equal_clock_are_marked(self):
        self.assertEqual(verdict(row("sorted", 1.07), row("sorted", 1.0)), (1.07, ""))
        self.assertEqual(verdict(row("sorted", 1.5), row("sorted", 1.0)), (1.5, "SLOWER"))
        self.assertEqual(verdict(row("sorted", 0.5), row("sorted", 1.0)), (0.5, "faster"))
        # 1 / 1.07 is as near to 1 as 1.07.
        self.assertEqual(verdict(row("sorted", 1.0), row("sorted", 1.07))[1], "")

    def test_rows_of_other_clocks_are_not_compared(self):
        twice = [[2.0, 0.5], [2.0, 0.5]]
        self.assertEqual(verdict(row("sorted", 3.0, clock=twice), row("sorted", 1.0)), (3.0, "other clock"))
        # Planted: the calibration moved while one of them was measured.
        during = row("sorted", 3.0, clock=[[1.0, 0.5], [1.2, 0.5]], used=False)
        self.assertEqual(verdict(during, row("sorted", 1.0))[1], "clock moved")
        self.assertEqual(verdict(row("sorted", 3.0), row("sorted", 1.0, used=False))[1], "clock moved")

    def test_the_larger_of_both_ratios(self):
        self.assertAlmostEqual(moved([1.0, 0.5], [1.1, 0.4]), 0.25)
        self.assertEqual(moved([1.0, 0.5], [1.0, 0.5]), 0)
        self.assertEqual(moved([0.0, 0.5], [1.0, 0.5]), 1)


class Tables(unittest.TestCase):
    def test_what_moved_has_its_passes(self):
        before = [["sorted/blend", 0.6, 10, None], ["bin/keys", 0.3, 10, None], ["gone", 0.1, 1, 1]]
        old = row("sorted", 1.0, passes=before)
        new = row("sorted", 2.0, passes=[["sorted/blend", 1.7, 10, None], ["bin/keys", 0.31, 10, None]])
        self.assertEqual(moved_passes(new, old), [("sorted/blend", 0.6, 1.7), ("gone", 0.1, 0.0)])
        text, slower = compared(measurement(new, row("peel", 3.0)), measurement(old, row("abuffer", 1.0)))
        self.assertTrue(slower)
        self.assertEqual(text[1].split(), ["garden", "sorted", "64x48", "1.000", "2.000", "2.00", "SLOWER"])
        self.assertEqual(text[2].split(), ["garden", "peel", "64x48", "-", "3.000", "-", "new"])
        self.assertEqual(text[3], "garden sorted 64x48: sorted/blend 0.600 -> 1.700, gone 0.100 -> 0.000")
        self.assertEqual(text[4], "gone: garden abuffer 64x48")

    def test_rows_without_times_are_counted_apart(self):
        refused = {"kind": "row", "scene": "garden", "size": [64, 48], "method": "spbr", "refused": "memory"}
        check = {"kind": "check", "cases": 3, "passed": 2, "failed": 1}
        case = {"kind": "case", "name": "points/rim", "verdict": "fail"}
        pictures = {"kind": "pictures", "compared": 9, "equal": 8}
        late = {"kind": "step", "name": "rates", "left_out": "the time was over"}
        lines = measurement(row("sorted", 1.0), row("peel", 1.0, used=False), refused, case, check, pictures, late)
        self.assertEqual(list(rows(lines)), [key(row("sorted", 1.0)), key(row("peel", 1.0))])
        self.assertEqual(
            summary(lines)[1:],
            [
                "check: 2 of 3 passed, 1 failed",
                "  FAIL points/rim",
                "pictures: 8 of 9 equal to the last bit",
                "rows: 3, 1 not used since the clock moved, 1 without times",
                "  step rates failed",
            ],
        )
        self.assertEqual(len(alone(lines)), 3)
        self.assertIn("clock moved", alone(lines)[2])


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, name, lines):
        path = self.folder / name
        path.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
        return str(path)

    def test_a_file_is_named_after_card_driver_and_commit(self):
        self.assertEqual(file_name(measurement()), "nvidia-h200-580.1-abc.json")
        lavapipe = measurement(card="llvmpipe (LLVM 15.0.6, 256 bits)", driver="llvmpipe Mesa 22.3.6 (LLVM 15.0.6)")
        self.assertEqual(file_name(lavapipe), "llvmpipe-mesa-22.3.6-abc.json")

    def test_a_line_that_is_cut_counts_as_absent(self):
        path = self.write("a.json", measurement(row("sorted", 1.0)))
        with open(path, "a", encoding="utf-8") as file:
            file.write('{"kind":"row","scene":"gar')
        self.assertEqual(read(path), measurement(row("sorted", 1.0)))

    def test_the_last_of_the_card_is_compared_with(self):
        self.write("a.json", measurement(commit="old"))
        self.write("b.json", measurement(commit="own"))
        self.write("c.json", measurement(commit="x", card="NVIDIA H100"))
        self.write("d.json", measurement(commit="y", driver="NVIDIA 570.2"))
        card, driver = "NVIDIA H200", "NVIDIA 580.1 (x)"
        self.assertEqual(last_of(card, driver, "own", self.folder).name, "a.json")
        self.assertEqual(last_of(card, "NVIDIA 570.2", "own", self.folder).name, "d.json")
        self.assertIsNone(last_of("Radeon", driver, "own", self.folder))

    def test_the_status_says_if_something_is_slower(self):
        old = self.write("old.json", measurement(row("sorted", 1.0)))
        new = self.write("new.json", measurement(row("sorted", 2.0)))
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            statuses = [main([new, old]), main([old, new]), main([old, old]), main([])]
        self.assertEqual(statuses, [1, 0, 0, 2])


if __name__ == "__main__":
    unittest.main()
