"""What pictures of a house from above should be, in whole numbers and float64, and how far others are from it."""

from dataclasses import dataclass

import numpy as np

WHITE = 255


@dataclass(frozen=True)
class Grid:
    """Pixels that are `steps` of a point's coordinates wide and centered on whole multiples of them, from 0."""

    steps: int
    width: int
    height: int

    @property
    def size(self):
        """The number of pixels."""
        return self.width * self.height

    def image(self, pixels):
        """Pixels in rows, of any type and number of channels, as an image."""
        return pixels.reshape(self.height, self.width, *pixels.shape[1:])


def layers(steps, grid):
    """The pixel of each point (n,), row 0 at the top, and the order of points from the lowest to the highest."""
    column, up = ((steps[:, i] + grid.steps // 2) // grid.steps for i in (0, 1))
    return (grid.height - 1 - up) * grid.width + column, np.argsort(steps[:, 2], kind="stable")


def nearest(steps, colors, grid):
    """Opaque points over white: the highest of each pixel, 8 bits (height, width, 3)."""
    pixel, order = layers(steps, grid)
    image = np.full((grid.size, 3), WHITE, np.uint8)
    # Of equal indices, numpy keeps the last.
    image[pixel[order]] = colors[order]
    return grid.image(image)


def blended(steps, colors, opacity, grid):
    """Points of an opacity over white, from the lowest to the highest, 0 to 255 (height, width, 3)."""
    pixel, order = layers(steps, grid)
    by_pixel = order[np.argsort(pixel[order], kind="stable")]
    sorted_pixel = pixel[by_pixel]
    starts = np.flatnonzero(np.diff(sorted_pixel, prepend=-1))
    counts = np.diff(np.append(starts, len(sorted_pixel)))
    image = np.full((grid.size, 3), float(WHITE))
    # The k-th point of every pixel that has so many.
    for k in range(counts.max(initial=0)):
        rows = starts[counts > k] + k
        below = image[sorted_pixel[rows]]
        image[sorted_pixel[rows]] = below * (1 - opacity) + colors[by_pixel[rows]] * opacity
    return grid.image(image)


def mean(steps, colors, grid):
    """The mean color of all points of each pixel over white, 0 to 255 (height, width, 3)."""
    pixel, _ = layers(steps, grid)
    counts = np.bincount(pixel, minlength=grid.size)
    sums = [np.bincount(pixel, colors[:, i].astype(np.float64), grid.size) for i in range(3)]
    image = np.where(counts, np.array(sums) / np.maximum(counts, 1), WHITE)
    return grid.image(image.T)


def untied(steps, grid):
    """True for each pixel (height, width) that has no two points at one height, whose order no tool can know."""
    pixel, _ = layers(steps, grid)
    order = np.lexsort((steps[:, 2], pixel))
    where, up = pixel[order], steps[order, 2]
    again = (np.diff(where) == 0) & (np.diff(up) == 0)
    free = np.ones(grid.size, bool)
    free[where[1:][again]] = False
    return grid.image(free)


def differ(image, exact, tolerance, mask):
    """The share of the pixels of a mask in which a channel is further than `tolerance` (of 255) from the exact one.

    None if the picture has another size.
    """
    if image.shape != exact.shape:
        return None
    distance = np.abs(image.astype(np.float64) - exact)[mask]
    return float((distance > tolerance).any(axis=1).mean())


def rmse(image, exact, mask):
    """Root of the mean squared difference over all channels of the pixels of a mask, 0 to 1; None as in `differ`."""
    if image.shape != exact.shape:
        return None
    return float(np.sqrt(np.mean((image.astype(np.float64) - exact)[mask] ** 2)) / 255)
