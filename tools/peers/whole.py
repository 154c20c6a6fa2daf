#!/usr/bin/env python3
"""Times whole commands, from a cold start over a file to a picture on disk, in pellucid and in other tools.

    python3 tools/peers/whole.py --pellucid target/release/pellucid -o target/peers

Makes the clouds in the output folder on the first run, then runs every tool on every job in turn, several times over,
and writes whole.json, whole.md and the pictures there. docs/performance.md says what is compared.
"""

import argparse
import json
import os
import sys
import time

import numpy as np
from PIL import Image

import house
import plan_view
import whole_report
from above import HEIGHT, OPACITY, WIDTH
from machine import calibrate, processor
from whole_tools import ROWS, command, run, version


def arguments():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3, help="how often everything is run in turn (3)")
    parser.add_argument("--skip-slow", action="store_true", help="leave out what takes minutes")
    parser.add_argument("--pellucid", default="target/release/pellucid", metavar="BINARY")
    parser.add_argument("--cloudcompare", default="CloudCompare", metavar="BINARY")
    parser.add_argument("--cloudcompare-version", default="", metavar="TEXT", help="it doesn't tell by itself")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="for clouds, pictures and results")
    options = parser.parse_args()
    if not os.path.exists(options.pellucid):
        parser.error(f"{options.pellucid} does not exist; build it with `cargo build --release`")
    return options


def exact_pictures(steps, colors):
    """The exact picture of each job that has one, and the pixels in which it is the only right one."""
    grid = plan_view.Grid(house.PIXEL_STEPS, WIDTH, HEIGHT)
    ordered, everywhere = plan_view.untied(steps, grid), np.ones((HEIGHT, WIDTH), bool)
    return {
        "nearest": (plan_view.nearest(steps, colors, grid), ordered),
        "see-through": (plan_view.blended(steps, colors, OPACITY, grid), ordered),
        "mean": (plan_view.mean(steps, colors, grid), everywhere),
    }


def error(path, exact):
    """How far a picture is from the exact one and its mask. Opaque colors are bytes; others may be rounded."""
    picture, mask = exact
    image = np.asarray(Image.open(path).convert("RGB"))
    tolerance = 0 if picture.dtype == np.uint8 else 1
    return {
        "differ": plan_view.differ(image, picture, tolerance, mask),
        "rmse": plan_view.rmse(image, picture, mask),
    }


def measure(options, row, exact, repeat):
    """A measurement, in the form that `whole_report` takes."""
    binaries = {
        "pellucid": os.path.abspath(options.pellucid),
        "CloudCompare": options.cloudcompare,
        "CloudCompare version": options.cloudcompare_version,
    }
    line = {
        "job": row.job,
        "kind": row.kind,
        "tool": row.label,
        "version": version(row, binaries),
        "command": [os.path.basename(word) for word in command(row, binaries)],
        "repeat": repeat,
        "cal_ms": calibrate(),
    }
    name = f"{row.job}-{row.kind}-{row.label}.png".replace(" ", "-").lower()
    kept = os.path.join(options.output, "pictures", name)
    line.update(run(row, binaries, options.output, kept))
    if "failed" not in line and repeat == 0 and row.claims and row.job in exact:
        line["error"] = error(kept, exact[row.job])
    return line


def write(options, measurements, machine):
    """Writes both results, whole or not at all."""
    text = whole_report.report(measurements, machine)
    content = json.dumps({"machine": machine, "measurements": measurements}, indent=1)
    for name, written in (("whole.json", content), ("whole.md", text)):
        path = os.path.join(options.output, name)
        with open(path + ".part", "w", encoding="utf-8") as file:
            file.write(written)
        os.replace(path + ".part", path)
    return text


def main():
    """Runs everything in turn."""
    options = arguments()
    os.makedirs(os.path.join(options.output, "pictures"), exist_ok=True)
    exact = exact_pictures(*house.write(options.output))
    machine = {
        "processor": processor(),
        "cores": os.cpu_count(),
        "load at start": f"{os.getloadavg()[0]:.1f}",
        "date": time.strftime("%Y-%m-%d", time.gmtime()),
        "pixels without an order": f"{1 - exact['nearest'][1].mean():.2%}",
    }
    measurements, text = [], ""
    for repeat in range(options.repeats):
        for row in ROWS:
            if row.slow and (repeat or options.skip_slow):
                continue
            line = measure(options, row, exact, repeat)
            print(json.dumps(line), file=sys.stderr)
            measurements.append(line)
            # A run that is stopped leaves what it has.
            text = write(options, measurements, machine)
    print(text)


if __name__ == "__main__":
    main()
