"""Cases worked by hand for the exact image and its comparer. Skipped where numpy is not installed."""

import unittest

try:
    import numpy as np
except ImportError as missing:
    raise unittest.SkipTest(str(missing)) from missing

from camera import View, project
from exact import encode_srgb, error, exact_image
from scenes import Scene

# Four pixels of one world unit on a side, seen along +Y; x goes right and z up.
VIEW = View(4, 4, (0, -5, 0), (0, 0, 0), height=4.0)
# Behind, red of opacity 0.2; in front, green of opacity 0.4; both over the center of column 2, row 1.
POSITIONS = np.array([(0.5, 0, 0.5), (0.5, -1, 0.5)], np.float32)
COLORS = np.array([(255, 0, 0, 51), (0, 255, 0, 102)], np.uint8)
BOTH = (0.2 * 0.6, 0.4, 0)


def scene(size_px):
    """The two points as splats of a size."""
    return Scene("two", POSITIONS, COLORS, VIEW, size_px)


class Exact(unittest.TestCase):
    def test_projection(self):
        x, y, depth = project(POSITIONS, VIEW, 0)
        np.testing.assert_allclose([x, y, depth], [[2.5, 2.5], [1.5, 1.5], [5, 4]])

    def test_disc(self):
        # The disc's radius is 2/√π = 1.13: the pixel of the center and its four neighbors.
        image, counts = exact_image(scene(2), "disc")
        covered = np.array([(0, 0, 1, 0), (0, 1, 1, 1), (0, 0, 1, 0), (0, 0, 0, 0)])
        np.testing.assert_array_equal(counts, 2 * covered)
        np.testing.assert_allclose(image, covered[..., None] * BOTH)

    def test_square(self):
        # From 1.5 to 3.5 across and 0.5 to 2.5 down: of the centers on its rim, those at the lower ends are in.
        image, counts = exact_image(scene(2), "square")
        np.testing.assert_array_equal(counts[:3, 1:3], [(2, 2), (2, 2), (0, 0)])
        self.assertEqual(counts.sum(), 8)
        np.testing.assert_allclose(image[0, 1], BOTH)

    def test_order_is_by_depth_and_not_by_place(self):
        turned = Scene("two", POSITIONS[::-1], COLORS[::-1], VIEW, 2)
        np.testing.assert_array_equal(exact_image(turned, "disc")[0], exact_image(scene(2), "disc")[0])

    def test_opaque_points_hide_each_other(self):
        image, counts = exact_image(scene(1), "disc")
        np.testing.assert_array_equal(image[1, 2], (0, 1, 0))
        self.assertEqual((counts[1, 2], counts.sum(), image.sum()), (2, 2, 1))


class Error(unittest.TestCase):
    def test_only_covered_pixels_count(self):
        # Two of 16 pixels are covered, one of them in one channel wrong by 0.3: √(0.09 / 6).
        exact = np.zeros((4, 4, 3))
        exact[0, :2] = 0.5
        image = exact.copy()
        image[0, 0, 1] = 0.8
        found = error(image, exact)
        self.assertAlmostEqual(found["rmse"], (0.09 / 6) ** 0.5)
        self.assertEqual(found["above_1_255"], 0.5)

    def test_bytes_are_fractions_of_255(self):
        exact = np.full((1, 1, 3), 100 / 255)
        self.assertEqual(error(np.full((1, 1, 4), 100, np.uint8), exact), {"rmse": 0, "above_1_255": 0})
        self.assertEqual(error(np.full((1, 1, 4), 102, np.uint8), exact)["above_1_255"], 1)

    def test_srgb(self):
        # IEC 61966-2-1: linear 0.5 is 0.7354, and the curve begins as a line of slope 12.92.
        np.testing.assert_allclose(encode_srgb(np.array([0, 0.001, 0.5, 1])), [0, 0.01292, 0.7354, 1], atol=5e-5)


if __name__ == "__main__":
    unittest.main()
