#!/usr/bin/env python3
"""Draws the same small scenes with pellucid and with other programs, and compares pixels: tools/witnesses/witnesses.py [NAME…].

    python3 -m venv target/witnesses && target/witnesses/bin/pip install -r tools/witnesses/requirements.txt
    target/witnesses/bin/python tools/witnesses/witnesses.py

Prints the table of docs/measuring.md. The exit status is 1 if a witness disagrees. PELLUCID names the program; by default it is
target/release/pellucid.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import flip_evaluator
import numpy as np
import OpenImageIO as oiio

import by_mitsuba
import by_vtk
from compare import Agreement, compare, table
from scene import (
    DISTANCE,
    FOV,
    HEIGHT,
    SIZE,
    Disc,
    Gaussian,
    Scene,
    WitnessError,
    disc_cloud,
    gaussian_cloud,
    point_cloud,
    run,
    sphere_cloud,
    write,
)

OIIO = f"OpenImageIO {oiio.VERSION_STRING}"
BACKGROUND = (0.0, 0.0, 1.0)
# Samples of a pixel by a path tracer.
SAMPLES = 2000
# Standard errors within which the means of 12 288 values lie: one beyond them is expected in 2000 pictures.
ERRORS = 5.5

LAYERS = [
    Disc((0.0, 0.0, 1.5 - 0.5 * k), color=[(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 1.0, 1.0)][k % 3], opacity=0.15 + 0.1 * k)
    for k in range(6)
]
CROSSING = [
    Disc((0.1, 0.0, 0.0), (0.6, 0.1, 1.0), color=(1.0, 0.0, 0.0), opacity=0.5),
    Disc((0.0, -0.1, 0.1), (-0.7, 0.2, 1.0), color=(0.0, 1.0, 0.0), opacity=0.4),
    Disc((0.0, 0.0, -0.1), (0.1, -0.8, 1.0), color=(1.0, 1.0, 1.0), opacity=0.6),
]
SPLATS = [
    Gaussian((-0.3, 0.2, 1.0), (0.3, 0.1, 0.2), (0.8, 0.0, 0.6, 0.0), (0.9, 0.2, 0.1), 0.6),
    Gaussian((0.2, 0.0, -0.5), (0.2, 0.4, 0.1), (0.5, -0.5, 0.1, 0.7), (0.1, 0.8, 0.3), 0.9),
    Gaussian((0.0, -0.3, -2.0), (0.5, 0.2, 0.1), (0.7, 0.1, 0.1, -0.7), (0.2, 0.3, 0.9), 0.7),
]


def ours(scene: Scene, folder: Path, *arguments: str) -> np.ndarray:
    """R, G, B, A and Z of pellucid's picture, linear, over the background: (SIZE, SIZE, 5)."""
    write(scene, folder)
    run("render", "scene.toml", "-o", "ours.exr", *arguments, folder=folder)
    return read(folder / "ours.exr", ["R", "G", "B", "A", "Z"])


def read(path: Path, names: list[str]) -> np.ndarray:
    """Channels of a file, in this order."""
    image = oiio.ImageBuf(str(path))
    if image.has_error:
        raise WitnessError(f"{path}: {image.geterror()}")
    pixels = image.get_pixels(oiio.FLOAT).astype(np.float64)
    return pixels[..., [image.spec().channelnames.index(name) for name in names]]


def discs(planes: list[Disc]) -> Scene:
    """Discs in the exact order of each pixel."""
    return Scene("abuffer", {"shape": "'oriented'", "max_pixel_radius": 1e9}, tuple(map(disc_cloud, planes)), BACKGROUND)


def _vtk(what: str, planes: list[Disc], folder: Path) -> Agreement:
    theirs = by_vtk.planes(planes, BACKGROUND)
    # A target of 8 bits rounds once for each layer and the background.
    allowed = 0.5 * (len(planes) + 1) / 255.0 + 1e-4
    mine = ours(discs(planes), folder)[..., :3]
    return compare((what, f"{by_vtk.VERSION}, dual depth peeling"), mine, theirs, allowed, f"{allowed:.4f}, 8 bits")


def vtk_layers(folder: Path) -> Agreement:
    """Parallel translucent planes."""
    return _vtk("six translucent planes, `abuffer`", LAYERS, folder)


def vtk_crossing(folder: Path) -> Agreement:
    """Planes whose order changes from pixel to pixel."""
    return _vtk("three planes that cross, `abuffer`", CROSSING, folder)


def _points() -> list[tuple[np.ndarray, tuple[float, float, float]]]:
    """Random points of three colors whose places in the picture lie a twentieth of a pixel or more from the pixels' rims."""
    random = np.random.default_rng(5)
    points = np.column_stack([random.uniform(-1.2, 1.2, (4000, 2)), random.uniform(-2.0, 1.5, 4000)])
    steps = (points[:, :2] * (DISTANCE / (DISTANCE - points[:, 2:])) / HEIGHT + 0.5) * SIZE
    points = points[(np.abs(steps - np.rint(steps)) > 0.05).all(axis=1)]
    return [(points[k::3], tuple(float(k == channel) for channel in range(3))) for k in range(3)]


def _of_points(folder: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    clouds = _points()
    scene = Scene("points", {}, tuple(point_cloud(points, color) for points, color in clouds))
    return ours(scene, folder), *by_vtk.points(clouds)


def vtk_points(folder: Path) -> Agreement:
    """Which of many points each pixel shows."""
    mine, colors, _ = _of_points(folder)
    return compare(("4000 opaque points, `points`", by_vtk.VERSION), mine[..., :3], colors, 0.5 / 255.0, "0.002, 8 bits")


def vtk_depth(folder: Path) -> Agreement:
    """Depths of the same points."""
    mine, _, depth = _of_points(folder)
    # A step of 24 bits, and of the buffer's float32, at the farthest of these points.
    allowed = 2e-5
    return compare(("their depths, channel `Z`", f"{by_vtk.VERSION}, depth buffer"), mine[..., 4], depth, allowed, "2e-5, 24 bits")


def openimageio_flatten(folder: Path) -> Agreement:
    """A deep picture flattened by another program."""
    run("scene", "volume", "--set", "points=20000", "-o", ".", folder=folder)
    for name, deep in (("flat.exr", []), ("deep.exr", ["--deep"])):
        run("render", "scene.toml", "--method", "abuffer", "--size", "96x96", "--transparent", "-o", name, *deep, folder=folder)
    names = ["R", "G", "B", "A"]
    flattened = oiio.ImageBufAlgo.flatten(oiio.ImageBuf(str(folder / "deep.exr")))
    flattened.write(str(folder / "flattened.exr"))
    mine, theirs = read(folder / "flat.exr", names), read(folder / "flattened.exr", names)
    # Roundings of some dozen samples in float32.
    return compare(("a deep EXR of 20 000 discs, flattened", f"{OIIO}, `flatten`"), mine, theirs, 1e-5, "1e-5")


def _chances(what: str, other: str, mine: np.ndarray, mean: np.ndarray, off: float = 0.0) -> Agreement:
    """Compares with means of samples that are 0 or 1, whose spread follows from their chance."""
    spread = np.sqrt(np.clip(mine * (1.0 - mine), 0.0, None) / SAMPLES)
    # Where a chance is near 0 or 1, single samples count.
    allowed = ERRORS * spread + 5.0 / SAMPLES + off
    return compare(
        (what, f"{by_mitsuba.VERSION}, {other}, {SAMPLES} samples"),
        mine,
        mean,
        allowed,
        f"{allowed.max():.3f}, {ERRORS} standard errors",
    )


def mitsuba_layers(folder: Path) -> Agreement:
    """Layers that let a ray through by chance."""
    mine = ours(discs(LAYERS), folder)[..., :3]
    return _chances("the six planes, `abuffer`", "path tracing", mine, by_mitsuba.planes(LAYERS, BACKGROUND, SAMPLES))


def mitsuba_gaussians(folder: Path) -> Agreement:
    """Splats along rays."""
    keys = {"kernel": "'ray'", "order": "'pixel'", "dilation": 0.0, "alpha_min": 1e-6, "alpha_max": 0.9999, "stop": 0.0}
    mine = ours(Scene("abuffer", keys, (gaussian_cloud(SPLATS),), color="encoded"), folder)[..., :3]
    theirs = by_mitsuba.gaussians(SPLATS)
    # Positions and exponents in float32, and rims cut at 6 standard deviations.
    return compare(("three Gaussians, `kernel=ray`", f"{by_mitsuba.VERSION}, `volprim_rf_basic`"), mine, theirs, 2e-4, "2e-4")


def mitsuba_soft(folder: Path) -> Agreement:
    """Light through a sphere that grows denser toward its center, Eq. 1 to 7 of Seemann et al. (2018)."""
    center, radius, scale = (0.1, -0.1, 0.0), 0.8, 4.0
    scene = Scene("soft-base", {"lambda": scale, "threshold": 0.5}, (sphere_cloud(center, radius),))
    light = np.repeat(1.0 - ours(scene, folder)[..., 3:4], 3, axis=-1)
    # The grid of 160³ cells is linear between their centers.
    return _chances(
        "light through a soft sphere, `soft-base`",
        "an absorbing medium",
        light,
        by_mitsuba.soft_sphere(center, radius, scale, SAMPLES),
        2e-3,
    )


def splat_transform(folder: Path) -> Agreement:
    """Splats in the order of their centers, as a viewer's engine draws them."""
    scene = Scene("sorted", {"kernel": "'ewa'", "order": "'center'"}, (gaussian_cloud(SPLATS),), color="encoded")
    write(scene, folder)
    run("render", "scene.toml", "-o", "ours.png", folder=folder)
    # The engine's axes are those of the file turned by half a turn about z.
    camera = ["--camera-pos", f"0,0,{DISTANCE}", "--camera-target", "0,0,0", "--camera-up", "0,-1,0", "--camera-fov", repr(FOV)]
    command = [
        *os.environ.get("SPLAT_TRANSFORM", "splat-transform").split(),
        "0.ply",
        *camera,
        "--resolution",
        f"{SIZE}x{SIZE}",
        "theirs.webp",
    ]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise WitnessError(f"{' '.join(command)}: status {done.returncode}\n{done.stdout}{done.stderr}")
    version = re.search(r"splat-transform v(\S+)", done.stdout + done.stderr)
    names = ["R", "G", "B"]
    mine, theirs = read(folder / "ours.png", names), read(folder / "theirs.webp", names)
    # It subtracts e^-4.5 from each falloff, so that rims end at 0, and has 8 bits.
    allowed = np.exp(-4.5) * sum(s.opacity for s in SPLATS) + 1.0 / 255.0
    return compare(
        ("three Gaussians, `order=center`", f"splat-transform {version[1] if version else ''}"),
        mine,
        theirs,
        allowed,
        f"{allowed:.3f}, its rims",
    )


def flip(folder: Path) -> Agreement:
    """The measure of visible differences, of NVIDIA's own program."""
    write(discs(CROSSING), folder)
    for method in ("abuffer", "weighted"):
        run("render", "scene.toml", "--method", method, "-o", f"{method}.png", folder=folder)
    mine = json.loads(run("compare", "abuffer.png", "weighted.png", "--json", folder=folder))["flip"]
    images = [read(folder / f"{method}.png", ["R", "G", "B"]).astype(np.float32) for method in ("abuffer", "weighted")]
    _, theirs, _ = flip_evaluator.evaluate(*images, "LDR", inputsRGB=True)
    other = "flip-evaluator 1.7"
    return compare(("FLIP of two pictures, `compare`", other), np.array([mine]), np.array([theirs]), 1e-4, "1e-4")


WITNESSES: dict[str, Callable[[Path], Agreement]] = {
    "vtk-layers": vtk_layers,
    "vtk-crossing": vtk_crossing,
    "vtk-points": vtk_points,
    "vtk-depth": vtk_depth,
    "openimageio-flatten": openimageio_flatten,
    "mitsuba-layers": mitsuba_layers,
    "mitsuba-gaussians": mitsuba_gaussians,
    "mitsuba-soft": mitsuba_soft,
    "splat-transform": splat_transform,
    "flip": flip,
}


def main() -> int:
    """Reads the command line; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", nargs="*", choices=[[], *WITNESSES], help="witnesses; by default all")
    names = parser.parse_args().name or list(WITNESSES)
    rows = []
    try:
        for name in names:
            with tempfile.TemporaryDirectory() as folder:
                rows.append(WITNESSES[name](Path(folder)))
    except WitnessError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print(table(rows))
    return 0 if all(row.agrees for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
