"""Cases worked by hand for the pictures of a house from above. Skipped where numpy is not installed."""

import unittest

try:
    import numpy as np
except ImportError as missing:
    raise unittest.SkipTest(str(missing)) from missing

from plan_view import Grid, blended, differ, mean, nearest, rmse, untied

# Pixels of 5 steps, 3 across and 2 up, centered on multiples of 5.
GRID = Grid(5, 3, 2)
# Three points on the upper right pixel, whose edges are at 7.5 and 12.5 and at 2.5 and 7.5; one on the lower left one.
STEPS = np.array([(12, 7, 30), (8, 3, 10), (10, 5, 20), (-2, 2, 0)])
COLORS = np.array([(200, 0, 0), (0, 200, 0), (0, 0, 200), (100, 100, 100)], np.uint8)
ALL = np.ones((2, 3), bool)


def white_but(upper_right, lower_left):
    """The picture with these two pixels."""
    image = np.full((2, 3, 3), 255.0)
    image[0, 2], image[1, 0] = upper_right, lower_left
    return image


class Pictures(unittest.TestCase):
    def test_the_highest_point_of_a_pixel_is_nearest(self):
        np.testing.assert_array_equal(nearest(STEPS, COLORS, GRID), white_but((200, 0, 0), (100, 100, 100)))

    def test_points_are_blended_from_the_lowest_to_the_highest(self):
        # Half of red, a quarter of blue, an eighth of green, and an eighth of white.
        rest = 255 / 8
        expected = white_but((100 + rest, 25 + rest, 50 + rest), (177.5, 177.5, 177.5))
        np.testing.assert_allclose(blended(STEPS, COLORS, 0.5, GRID), expected)

    def test_the_order_of_points_in_the_file_does_not_count(self):
        for picture in (lambda s, c: nearest(s, c, GRID), lambda s, c: blended(s, c, 0.5, GRID)):
            np.testing.assert_array_equal(picture(STEPS[::-1], COLORS[::-1]), picture(STEPS, COLORS))

    def test_the_mean_is_of_all_points_of_a_pixel(self):
        third = 200 / 3
        np.testing.assert_allclose(mean(STEPS, COLORS, GRID), white_but((third, third, third), (100, 100, 100)))

    def test_two_points_at_one_height_have_no_order(self):
        self.assertTrue(untied(STEPS, GRID).all())
        tied = STEPS.copy()
        tied[1, 2] = 20
        np.testing.assert_array_equal(untied(tied, GRID), [(True, True, False), (True, True, True)])
        # The same height in another pixel is no tie.
        tied = STEPS.copy()
        tied[3, 2] = 30
        self.assertTrue(untied(tied, GRID).all())


class Differences(unittest.TestCase):
    def test_one_channel_of_one_pixel_is_a_sixth(self):
        exact = nearest(STEPS, COLORS, GRID)
        image = exact.copy()
        self.assertEqual((differ(image, exact, 0, ALL), rmse(image, exact, ALL)), (0, 0))
        image[0, 1, 2] -= 3
        self.assertEqual(differ(image, exact, 0, ALL), 1 / 6)
        self.assertEqual(differ(image, exact, 2.5, ALL), 1 / 6)
        self.assertEqual(differ(image, exact, 3, ALL), 0)
        # One of 18 values is off by 3/255.
        self.assertAlmostEqual(rmse(image, exact, ALL), 3 / 255 / 18**0.5)

    def test_pixels_outside_of_the_mask_do_not_count(self):
        exact = nearest(STEPS, COLORS, GRID)
        image, mask = exact.copy(), ALL.copy()
        image[0, 1, 2] -= 3
        mask[0, 1] = False
        self.assertEqual((differ(image, exact, 0, mask), rmse(image, exact, mask)), (0, 0))

    def test_a_darker_byte_does_not_wrap_around(self):
        exact, image = np.zeros((1, 1, 3), np.uint8), np.full((1, 1, 3), 255, np.uint8)
        self.assertEqual(rmse(image, exact, np.ones((1, 1), bool)), 1)
        self.assertEqual(rmse(exact, image, np.ones((1, 1), bool)), 1)

    def test_pictures_of_another_size_are_not_compared(self):
        exact = nearest(STEPS, COLORS, GRID)
        self.assertIsNone(differ(exact[:1], exact, 0, ALL))
        self.assertIsNone(rmse(exact[:1], exact, ALL))


if __name__ == "__main__":
    unittest.main()
