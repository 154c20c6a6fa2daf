"""Known answers for the arithmetic behind the tables: `python3 -m unittest discover tools/peers`."""

import unittest

from report import frame_ms, number, per_fragment_growth, ratio, ratios_table, reasons, times_table


def line(scene, tool, repeat, *ms, **rest):
    """A measurement."""
    return {"scene": scene, "tool": tool, "repeat": repeat, "ms": list(ms), "cal_ms": 100 + repeat, **rest}


FACTS = {
    "S2_32": {"fragments": 1_000_000, "mean_layers": 33.2, "max_layers": 115},
    "S2_512": {"fragments": 10_000_000, "mean_layers": 484.0, "max_layers": 1420},
}
# The machine is half as fast in the second repeat, and disturbed in the third.
DRIFT = [
    line("S2_32", "pellucid sorted", 0, 44, 40, 50, error={"rmse": 1.25e-7, "above_1_255": 0.0125}),
    line("S2_32", "painter sorted", 0, 88),
    line("S2_32", "pellucid sorted", 1, 88),
    line("S2_32", "painter sorted", 1, 176, 1000, 100),
    line("S2_32", "pellucid sorted", 2, 300),
    line("S2_32", "painter sorted", 2, 200),
]
LISTS = [
    line("S2_32", "pellucid abuffer", 0, 10),
    line("S2_512", "pellucid abuffer", 0, 250),
    line("S2_32", "vtk peel100", 0, 800),
    line("S2_32", "pellucid abuffer", 1, 30),
]


class Ratios(unittest.TestCase):
    def test_drift_cancels_within_a_repeat(self):
        # 0.5, 0.5, 1.5: the medians over everything would give 50 / 176.
        self.assertEqual(ratio(DRIFT, "S2_32", "pellucid sorted", "painter sorted"), 0.5)
        self.assertEqual(ratio(DRIFT[2:], "S2_32", "pellucid sorted", "painter sorted"), 1.0)

    def test_only_repeats_with_both_count(self):
        self.assertEqual(ratio(LISTS, "S2_32", "vtk peel100", "pellucid abuffer"), 80)

    def test_the_native_limit_is_a_constant(self):
        # Median of 40, 44, 50, 88 and 300 is 50; the limit is 11.
        self.assertEqual(frame_ms(DRIFT, "S2_32", "pellucid sorted"), 50)
        self.assertAlmostEqual(ratio(DRIFT, "S2_32", "pellucid sorted", "native"), 50 / 11)

    def test_rows_without_a_measurement_have_no_ratio(self):
        self.assertIsNone(ratio(DRIFT, "S2_512", "pellucid sorted", "painter sorted"))
        self.assertIsNone(ratio(DRIFT, "S2_512", "pellucid sorted", "native"))
        self.assertIsNone(ratio(DRIFT, "S2_32", "pellucid points", "native"))

    def test_time_per_fragment(self):
        # 20 ms over a million fragments are 20 ns, 250 ms over ten million 25 ns.
        self.assertEqual(per_fragment_growth(LISTS, FACTS, "S2_512"), 1.25)
        self.assertEqual(per_fragment_growth(LISTS, FACTS, "S2_32"), 1)
        self.assertIsNone(per_fragment_growth(DRIFT, FACTS, "S2_512"))


class Tables(unittest.TestCase):
    def test_numbers_keep_their_digits(self):
        shown = [number(value) for value in (None, 0.6, 1.2345, 99.96, 123456.7)]
        self.assertEqual(shown, ["–", "0.6", "1.23", "100", "123457"])

    def test_a_row_says_it_all(self):
        row = times_table(DRIFT, FACTS).splitlines()[2]
        self.assertEqual(row, "| S2_32 | pellucid sorted | 50 | 40–300 | 5 | 50 | 1.2e-07 | 1.2500% | 100–102 |")

    def test_missing_rows_are_listed(self):
        absent = {"scene": "S2_32", "tool": "vtk sorted", "repeat": 0, "cal_ms": 1, "missing": "no module"}
        row = times_table([*DRIFT, absent], FACTS).splitlines()[-1]
        self.assertEqual(row, "| S2_32 | vtk sorted | missing |" + " – |" * 6)
        self.assertEqual(reasons([*DRIFT, absent, absent]), "- vtk sorted is missing: no module")
        self.assertEqual(reasons(DRIFT), "Nothing is missing.")

    def test_targets_stand_over_the_ratios(self):
        rows = ratios_table(LISTS, FACTS).splitlines()
        self.assertEqual([len(row.split("|")) for row in rows], [14] * 5)
        self.assertIn("| ≤ 0.6 |  | ≤ 4 |  | ≥ 40 | ≤ 10 |", rows[2])
        # 20 over 38 and 250 over 400.
        self.assertEqual(rows[3], "| S2_32 | 33.2 | – | – | – | – | 80 | 0.526 | – | – | – | 1 |")
        self.assertEqual(rows[4], "| S2_512 | 484 | – | – | – | – | – | 0.625 | – | – | – | 1.25 |")


if __name__ == "__main__":
    unittest.main()
