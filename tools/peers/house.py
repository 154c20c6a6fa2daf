"""A house in a garden, scanned from all sides: the cloud of the comparison of whole commands, as PLY and as LAZ.

The camera looks straight down without perspective, since that is the one view that all tools offer. Coordinates are
whole millimeters and edges of pixels (`above.PIXEL_M`) are half ones, so that no rounding moves a point to another
pixel.
"""

import os

import laspy
import numpy as np

from above import HEIGHT, PIXEL_M, RIGHT, TOP, WIDTH

SEED = 20261130
POINTS = 3_000_000
# Heights differ by less than a point is wide, so that few are equal.
STEP_M, STEP_UP_M = 0.001, 0.00001
PIXEL_STEPS = round(PIXEL_M / STEP_M)
VERTEX = np.dtype([(name, "<f4") for name in "xyz"] + [(name, "u1") for name in ("red", "green", "blue")])

# Rooms: walls (x from, y from, x to, y to) of both floors, meters.
WALLS = [
    (6, 5, 18, 5),
    (18, 5, 18, 14),
    (6, 14, 18, 14),
    (6, 5, 6, 14),
    (11, 5, 11, 14),
    (11, 9, 18, 9),
    (6, 10, 11, 10),
]
TREES = [(3, 3, 1.6), (3, 16, 2.0), (21.5, 4, 2.2), (22, 15, 1.7), (12, 17, 1.1), (21, 10, 1.2)]
# Furniture: corners (x, y, z, x, y, z) and color.
BOXES = [
    ((7, 6, 0, 9.5, 7.2, 0.8), (150, 90, 40)),
    ((12, 6, 0, 14, 8, 0.5), (200, 60, 50)),
    ((15, 11, 0, 17, 13, 0.6), (60, 90, 180)),
    ((7, 11, 2.7, 9, 13, 3.3), (80, 160, 190)),
    ((13, 10, 2.7, 16, 11, 3.5), (120, 80, 50)),
]


def rectangle(random, n, corner, sides, color):
    """Points of a rectangle that is scanned with 4 mm of noise. `sides` are vectors from the corner."""
    right, up = sides
    u, v = random.random((n, 1)), random.random((n, 1))
    positions = np.array(corner) + u * np.array(right) + v * np.array(up) + random.normal(0, 0.004, (n, 3))
    return positions, tinted(random, n, color)


def tinted(random, n, color):
    """A color with the grain of a material."""
    return np.array(color) + random.normal(0, 10, (n, 1)) + random.normal(0, 4, (n, 3))


def tree(random, n, x, y, radius):
    """Points of a crown, denser to the outside."""
    direction = random.normal(size=(n, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    distance = radius * (1 - 0.5 * random.random((n, 1)) ** 2) * (0.8 + 0.2 * np.sin(9 * direction[:, :1]))
    positions = direction * distance * (1, 1, 1.3) + (x, y, 1.5 * radius + 0.5)
    return positions, tinted(random, n, (60, 130, 50)) + 40 * direction[:, 2:]


def box(random, n, corners, color):
    """Points of the top and of two sides."""
    x, y, z, right, back, top = corners
    across, deep, high = (right - x, 0, 0), (0, back - y, 0), (0, 0, top - z)
    return [
        rectangle(random, n // 2, (x, y, top), (across, deep), color),
        rectangle(random, n // 4, (x, y, z), (across, high), np.array(color) * 0.7),
        rectangle(random, n // 4, (x, y, z), (deep, high), np.array(color) * 0.6),
    ]


def parts(random, n):
    """The parts of the scene, each positions (k, 3) in meters and colors (k, 3)."""
    garden = rectangle(random, int(0.25 * n), (0, 0, 0), ((RIGHT, 0, 0), (0, TOP, 0)), (120, 150, 80))
    found = [garden]
    for z, color in ((0.02, (170, 150, 130)), (2.7, (190, 170, 140))):
        found.append(rectangle(random, int(0.09 * n), (6, 5, z), ((12, 0, 0), (0, 9, 0)), color))
        for x0, y0, x1, y1 in WALLS:
            sides = (x1 - x0, y1 - y0, 0), (0, 0, 2.6)
            found.append(rectangle(random, int(0.01 * n), (x0, y0, z), sides, [225] * 3))
    # Half as many points as the floors: one sees between them.
    for y, slope in ((4.6, 4.9), (14.4, -4.9)):
        found.append(rectangle(random, int(0.045 * n), (5.6, y, 5.4), ((12.8, 0, 0), (0, slope, 2.8)), (170, 70, 50)))
    for corners, color in BOXES:
        found += box(random, int(0.012 * n), corners, color)
    for x, y, radius in TREES:
        found.append(tree(random, int(0.025 * n), x, y, radius))
    return found


def make(n=POINTS):
    """Positions (n, 3) in whole steps (int64) and colors (n, 3) uint8, in random order.

    The first two points are corners of the ground, so that the cloud is as large as the picture to half a pixel.
    """
    random = np.random.default_rng(SEED)
    found = parts(random, n)
    positions, colors = (np.concatenate([part[i] for part in found]) for i in (0, 1))
    # The parts are fewer points than asked for; the ground gets the rest.
    missing = max(n - len(positions), 0)
    ground = rectangle(random, missing, (0, 0, 0), ((RIGHT, 0, 0), (0, TOP, 0)), (110, 140, 75))
    positions, colors = np.concatenate([positions, ground[0]])[:n], np.concatenate([colors, ground[1]])[:n]
    order = random.permutation(n)
    positions, colors = positions[order], colors[order]
    far = (WIDTH - 1) * PIXEL_M, (HEIGHT - 1) * PIXEL_M
    positions[:, :2] = np.clip(positions[:, :2], 0, far)
    positions[:2] = (0, 0, 0), (*far, 0)
    steps = np.rint(positions / (STEP_M, STEP_M, STEP_UP_M)).astype(np.int64)
    return steps, np.clip(np.rint(colors), 1, 250).astype(np.uint8)


def in_meters(steps):
    """Positions in meters, float64."""
    return steps * (STEP_M, STEP_M, STEP_UP_M)


def write(folder):
    """Writes house.ply and house.laz unless they are there, and returns positions (steps) and colors."""
    steps, colors = make()
    ply, laz = (os.path.join(folder, "house." + kind) for kind in ("ply", "laz"))
    if not (os.path.exists(ply) and os.path.exists(laz)):
        write_ply(ply, steps, colors)
        write_laz(laz, steps, colors)
    return steps, colors


def write_ply(path, steps, colors):
    """A binary PLY of float32 positions and 8-bit colors."""
    vertices = np.empty(len(steps), VERTEX)
    for i, name in enumerate(VERTEX.names):
        vertices[name] = in_meters(steps)[:, i] if i < 3 else colors[:, i - 3]
    kinds = ["float"] * 3 + ["uchar"] * 3
    lines = [f"property {kind} {name}" for kind, name in zip(kinds, VERTEX.names, strict=True)]
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}", *lines, "end_header"]
    with open(path, "wb") as file:
        file.write("\n".join(header).encode() + b"\n")
        vertices.tofile(file)


def write_laz(path, steps, colors):
    """A LAZ of format 2, whose 16-bit colors are the 8-bit ones times 257."""
    header = laspy.LasHeader(point_format=2, version="1.2")
    header.scales, header.offsets = (STEP_M, STEP_M, STEP_UP_M), (0, 0, 0)
    cloud = laspy.LasData(header)
    cloud.X, cloud.Y, cloud.Z = steps.T
    cloud.red, cloud.green, cloud.blue = colors.T.astype(np.uint16) * 257
    cloud.write(path)
