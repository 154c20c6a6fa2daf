"""The scenes of the comparison. They are made from a fixed seed, so that every machine gets the same points."""

import math
from dataclasses import dataclass

import numpy as np

from camera import View

SEED = 20240607


@dataclass(frozen=True)
class Scene:
    """Points and how to look at them.

    `positions` (n, 3) float32; `colors` (n, 4) uint8, straight alpha; a splat is a square of `size_px` pixels or a disc
    of the same area.
    """

    name: str
    positions: np.ndarray
    colors: np.ndarray
    view: View
    size_px: float

    @property
    def opaque(self):
        """True if only the nearest point of each pixel shows."""
        return self.size_px == 1


def radius_px(size_px):
    """Radius of the disc with the area of the square."""
    return size_px / math.sqrt(math.pi)


def tori():
    """Three nested tori, 1,000,002 points of opacity 1.0, 0.5 and 0.3 from the inside out."""
    random = np.random.default_rng(SEED)
    n = 333_334
    positions, colors = [], []
    for tube, color, alpha in (
        (0.15, (255, 60, 40), 255),
        (0.30, (60, 220, 60), 128),
        (0.45, (70, 110, 255), 77),
    ):
        u, v = random.random(n) * 2 * np.pi, random.random(n) * 2 * np.pi
        ring = 1 + tube * np.cos(v)
        positions.append(np.stack([ring * np.cos(u), ring * np.sin(u), tube * np.sin(v)], 1))
        shade = 0.6 + 0.4 * np.sin(v)
        colors.append(np.column_stack([np.array(color) * shade[:, None], np.full(n, alpha)]))
    return shuffled(random, np.concatenate(positions), np.concatenate(colors))


def cube():
    """A cube filled with 200,000 points of opacity 13/255."""
    random = np.random.default_rng(SEED)
    n = 200_000
    positions = random.random((n, 3)) - 0.5
    colors = np.column_stack([(positions + 0.5) * 255, np.full(n, 13)])
    return positions.astype(np.float32), colors.astype(np.uint8)


def sphere_and_plane():
    """Five million opaque points: a sphere over a checkered plane."""
    random = np.random.default_rng(SEED)
    n = 2_500_000
    sphere = random.normal(size=(n, 3))
    sphere /= np.linalg.norm(sphere, axis=1)[:, None]
    plane = np.stack([random.random(n) * 4 - 2, random.random(n) * 4 - 2, np.full(n, -1.0)], 1)
    checker = (np.floor(plane[:, 0] * 4) + np.floor(plane[:, 1] * 4)) % 2
    gray = np.repeat((80 + 150 * checker)[:, None], 3, axis=1)
    colors = np.concatenate([(sphere + 1) * 127, gray])
    colors = np.column_stack([colors, np.full(2 * n, 255)])
    return shuffled(random, np.concatenate([sphere, plane]), colors)


def shuffled(random, positions, colors):
    """The points in random order, in the types of a scene."""
    order = random.permutation(len(positions))
    return positions[order].astype(np.float32), colors[order].astype(np.uint8)


TORI_VIEW = View(1024, 1024, (0.0, -2.2, 2.2), (0, 0, 0), fov_y=45.0)
CUBE_VIEW = View(1024, 1024, (1.6, -1.3, 1.1), (0, 0, 0), height=1.9)
SPHERE_VIEW = View(1920, 1080, (0.0, -4.0, 1.5), (0, 0, -0.2), fov_y=45.0)

# Name to points, view, and side of a splat's square in pixels. The number in S2's names is about the mean number of
# layers over the covered pixels.
SCENES = {
    "S1": (tori, TORI_VIEW, 3),
    "S2_32": (cube, CUBE_VIEW, 9),
    "S2_128": (cube, CUBE_VIEW, 18),
    "S2_512": (cube, CUBE_VIEW, 36),
    "S3": (sphere_and_plane, SPHERE_VIEW, 1),
}


def make(name):
    """Makes a scene of `SCENES`."""
    points, view, size_px = SCENES[name]
    positions, colors = points()
    return Scene(name, positions, colors, view, size_px)
