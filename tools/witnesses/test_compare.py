"""The comparer finds what is wrong: `python3 -m unittest discover tools/witnesses`. Skipped where numpy is not installed."""

import unittest

try:
    import numpy as np
except ImportError as missing:
    raise unittest.SkipTest(str(missing)) from missing

from compare import compare, table


class Compare(unittest.TestCase):
    """Known answers."""

    def agreement(self, ours, theirs, allowed=0.1):
        return compare(("a", "b"), np.array(ours), np.array(theirs), allowed, "0.1")

    def test_values_within_what_is_allowed_agree(self):
        row = self.agreement([0.5, np.inf], [0.59, np.inf])
        self.assertTrue(row.agrees)
        self.assertAlmostEqual(row.share, 0.9)
        self.assertIn("| 2 | 9.0e-02 | 0.1 | agrees |", table([row]))

    def test_one_value_beyond_differs(self):
        row = self.agreement([0.5, 0.5, 0.5], [0.5, 0.61, 0.5])
        self.assertFalse(row.agrees)
        self.assertIn("**differs**", table([row]))

    def test_a_bound_of_each_value_counts(self):
        self.assertTrue(self.agreement([0.0, 1.0], [0.0, 1.4], np.array([0.1, 0.5])).agrees)
        self.assertFalse(self.agreement([0.4, 1.0], [0.0, 1.0], np.array([0.1, 0.5])).agrees)

    def test_nothing_where_something_is_differs(self):
        for ours, theirs in ((np.inf, 1.0), (1.0, np.inf), (np.nan, 1.0), (1.0, np.nan), (np.inf, -np.inf)):
            self.assertFalse(self.agreement([ours], [theirs]).agrees, (ours, theirs))

    def test_nothing_compared_is_no_agreement(self):
        self.assertFalse(self.agreement([], []).agrees)

    def test_other_sizes_are_an_error(self):
        with self.assertRaisesRegex(ValueError, "a:"):
            self.agreement([1.0], [1.0, 1.0])


if __name__ == "__main__":
    unittest.main()
