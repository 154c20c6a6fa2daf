"""Reads a deep EXR of pellucid by OpenEXR and holds it against the flat EXR of the same scene.

python3 read.py DEEP.exr FLAT.exr [--counts]

In float64 the samples of each pixel, over one another in their order, must be R, G, B and A of the flat file (whose background is black) within
what roundings of float32 leave. --counts: as many samples as `fragments.Y` says. Prints the number of samples, the largest share of the
allowed error, and the largest count; ends with status 1 and the first difference where there is one.
"""

import argparse
import pathlib
import sys
import tempfile

import numpy as np
import OpenEXR

ROUNDING = 2.0**-24


# Name, type and size of the attribute that says how orderly samples are, in files that were asked for it. OpenEXR's
# library knows the type, its Python module (3.5.3) refuses files that have it.
STATE = b"deepImageState\0deepImageState\0\1\0\0\0"


def channels(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        found = {name: channel.pixels for name, channel in file.channels().items()}
        return file.header()["type"], found


def deep_channels(path):
    """The channels of a deep file and its state. Where the header has one, a copy is read in which it has a type that the module doesn't know, and
    passes over."""
    content = pathlib.Path(path).read_bytes()
    state = 0
    if STATE in content:
        state = content[content.index(STATE) + len(STATE)]
        with tempfile.TemporaryDirectory() as folder:
            copy = pathlib.Path(folder, "copy.exr")
            copy.write_bytes(content.replace(STATE, STATE.replace(b"State\0\1", b"Stat_\0\1")))
            kind, found = channels(copy)
    else:
        kind, found = channels(path)
    if kind != OpenEXR.deepscanline:
        sys.exit(f"{path}: type {kind}")
    return found, {0: "none", 1: "sorted", 3: "tidy"}[state]


def samples(deep, x, y):
    """Rows of R, G, B, A, Z, ZBack; a pixel without samples has none."""
    names = ["R", "G", "B", "A", "Z", "ZBack" if "ZBack" in deep else "Z"]
    values = [deep[name][y, x] for name in names]
    if values[0] is None:
        return np.zeros((0, 6))
    return np.stack([np.asarray(value, dtype=np.float64) for value in values], axis=1)


def flattened(rows):
    front = np.zeros(4)
    for row in rows:
        front += (1.0 - front[3]) * row[:4]
    return front


def check(deep, flat, counts):
    total, longest, worst = 0, 0, 0.0
    height, width = flat["A"].shape
    for y in range(height):
        for x in range(width):
            rows = samples(deep, x, y)
            total, longest = total + len(rows), max(longest, len(rows))
            z, back = rows[:, 4], rows[:, 5]
            if np.any(z[1:] < z[:-1]) or np.any(back < z):
                raise ValueError(f"pixel ({x}, {y}): samples are not in the order of depths")
            if counts and len(rows) != flat["fragments.Y"][y, x]:
                raise ValueError(f"pixel ({x}, {y}): {len(rows)} samples, {flat['fragments.Y'][y, x]} fragments")
            wanted = np.array([flat[name][y, x] for name in "RGBA"], dtype=np.float64)
            # Three roundings for each fragment in A and in a color, where an error of A counts once more; and those of
            # the samples.
            allowed = 8.0 * (len(rows) + 2.0) * ROUNDING
            share = np.abs(flattened(rows) - wanted).max() / allowed
            if not share <= 1.0:
                raise ValueError(f"pixel ({x}, {y}): {flattened(rows)} of {len(rows)} samples, not {wanted}")
            worst = max(worst, share)
    return total, longest, worst


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("deep")
    arguments.add_argument("flat")
    arguments.add_argument("--counts", action="store_true")
    given = arguments.parse_args()
    deep, state = deep_channels(given.deep)
    _, flat = channels(given.flat)
    try:
        total, longest, worst = check(deep, flat, given.counts)
    except ValueError as error:
        sys.exit(f"{given.deep}: {error}")
    print(f"{total} samples, at most {longest}, {worst:.2f} of the allowed error, {sorted(deep)}, state {state}")


main()
