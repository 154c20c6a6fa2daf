"""Measure what Python adds: frames against `pellucid profile`, uploads against a copy and the ordering, and the import.

Run it on an idle machine, with the package installed and the command line built in release:

    target/python/bin/python python/benches/speed.py [--points 1000000] [--upload 10000000] [--binary target/release/pellucid]
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import pellucid

ROOT = Path(__file__).resolve().parents[2]


def median_ms(work: Callable[[], object], repeats: int) -> float:
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return 1e3 * statistics.median(times)


def beyond(loaded: pellucid.Loaded) -> float:
    """Return the milliseconds that a frame takes in Python beyond what its own profile says."""
    begin = time.perf_counter()
    image = loaded.frame()
    return 1e3 * (time.perf_counter() - begin) - image.profile.wall_ms


def ply(path: Path, points: np.ndarray) -> None:
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    path.write_bytes(header.encode() + points.astype("<f4").tobytes())


def frames(count: int, binary: Path, repeats: int) -> None:
    """Measure the steady state: the wall time of `Loaded.frame`, and of the same frame as the command line measures it."""
    points = np.random.default_rng(0).normal(size=(count, 3)).astype(np.float32)
    settings = {"opacity": 0.1, "radius": 0.01, "size": (1024, 1024)}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "points.ply"
        ply(path, points)
        command = [binary, "profile", path, "--opacity", "0.1", "--radius", "0.01", "--size", "1024x1024", "--json"]
        ratios = []
        for turn in range(3):
            # In turns, so that a machine that slows down slows both.
            with pellucid.Renderer() as renderer, renderer.load(points, **settings) as loaded:
                loaded.frame()
                ours = median_ms(loaded.frame, repeats)
                added = statistics.median(beyond(loaded) for _ in range(repeats))
            done = subprocess.run([*command, "--frames", str(repeats)], capture_output=True, text=True, check=True)
            theirs = statistics.median(frame["wall_ms"] for frame in json.loads(done.stdout)["frames"])
            ratios.append(ours / theirs)
            print(f"frame of {count} points, turn {turn}: Python {ours:.1f} ms, profile {theirs:.1f} ms, ratio {ours / theirs:.3f}")
            print(f"    beyond the frame's own wall time: {added:.1f} ms")
        print(f"frame: ratio {statistics.median(ratios):.3f} (at most 1.1)")


def upload(count: int) -> None:
    """Measure the upload of a float32 array, against a copy of it and the ordering, which the command line does, too."""
    points = np.random.default_rng(0).normal(size=(count, 3)).astype(np.float32)
    copy = median_ms(points.copy, 5)
    with pellucid.Renderer() as renderer, tempfile.TemporaryDirectory() as folder:
        begin = time.perf_counter()
        cloud = pellucid.Cloud(points, z_up=True)
        into_cloud = 1e3 * (time.perf_counter() - begin)
        begin = time.perf_counter()
        renderer.load(cloud, radius=0.01, opacity=0.1).close()
        loaded = 1e3 * (time.perf_counter() - begin)
        path = Path(folder) / "points.ply"
        ply(path, points)
        begin = time.perf_counter()
        renderer.load(path, radius=0.01, opacity=0.1).close()
        from_file = 1e3 * (time.perf_counter() - begin)
    total, floor = into_cloud + loaded, copy + loaded
    print(f"upload of {count} points: memcpy {copy:.0f} ms, Cloud {into_cloud:.0f} ms, order and upload {loaded:.0f} ms")
    print(f"upload: {total:.0f} ms, of memcpy and ordering {total / floor:.2f} (at most 1.5); from a PLY file {from_file:.0f} ms")


def importing() -> None:
    script = "import time; t = time.perf_counter(); import pellucid; print(time.perf_counter() - t)"
    numpy_first = "import numpy\n" + script
    for name, text in (("with nothing loaded", script), ("after numpy", numpy_first)):
        times = [1e3 * float(subprocess.check_output([sys.executable, "-c", text])) for _ in range(9)]
        print(f"import {name}: {statistics.median(times):.1f} ms, least {min(times):.1f} ms (at most 50)")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--upload", type=int, default=10_000_000)
    parser.add_argument("--frames", type=int, default=10)
    parser.add_argument("--binary", type=Path, default=ROOT / "target" / "release" / "pellucid")
    given = parser.parse_args()
    importing()
    frames(given.points, given.binary, given.frames)
    upload(given.upload)


if __name__ == "__main__":
    main()
