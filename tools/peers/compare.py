#!/usr/bin/env python3
"""Times pellucid and other tools on the same scenes in one run, and says how exact each image is.

    python3 tools/peers/compare.py --pellucid target/release/pellucid -o target/peers

Makes the scenes in the output folder on the first run, then measures every tool on every scene in turn, several times
over, and writes results.json and results.md there. docs/performance.md says what a frame includes.
"""

import argparse
import json
import os
import sys

import report
import store
from exact import error
from machine import calibrate, processor
from scenes import SCENES
from tools import Job, Missing, measure_peer, measure_pellucid, tools_of

# Names on the command line to those in the tables.
PEERS = {"cpu": "painter", "vtk": "vtk", "vispy": "vispy"}


def arguments():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES))
    parser.add_argument("--peers", nargs="*", choices=PEERS, default=list(PEERS))
    parser.add_argument("--repeats", type=int, default=5, help="how often everything is measured in turn (5)")
    parser.add_argument("--frames", type=int, default=3, help="frames per measurement (3)")
    parser.add_argument("--skip-slow", action="store_true", help="leave out depth peeling, which takes minutes")
    parser.add_argument("--pellucid", default="target/release/pellucid", metavar="BINARY")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="for scenes and results")
    options = parser.parse_args()
    if not os.path.exists(options.pellucid):
        parser.error(f"{options.pellucid} does not exist; build it with `cargo build --release`")
    return options


def measure(options, scene, tool, repeat):
    """A measurement, in the form that `report` takes."""
    line = {"scene": scene, "tool": tool.label, "repeat": repeat, "cal_ms": calibrate()}
    # Images do not depend on the repeat.
    job = Job(options.output, scene, options.frames, with_image=repeat == 0)
    try:
        if tool.name == "pellucid":
            result, image = measure_pellucid(options.pellucid, tool, job)
        else:
            result, image = measure_peer(tool, job)
    except Missing as reason:
        return {**line, "missing": str(reason)}
    if image is not None:
        exact, _ = store.read_exact(options.output, scene, tool.shape)
        line["error"] = error(image, exact)
    return {**line, **result}


def wanted(options, scene):
    """The tools that were asked for."""
    names = {"pellucid", *(PEERS[name] for name in options.peers)}
    return [tool for tool in tools_of(scene) if tool.name in names and not (tool.slow and options.skip_slow)]


def write(options, measurements, facts, machine):
    """Writes both results, whole or not at all."""
    text = report.report(measurements, facts, machine)
    whole = {"machine": machine, "native_ms": report.NATIVE_MS, "scenes": facts, "measurements": measurements}
    for name, content in (("results.json", json.dumps(whole, indent=1)), ("results.md", text)):
        path = os.path.join(options.output, name)
        with open(path + ".part", "w", encoding="utf-8") as file:
            file.write(content + "\n")
        os.replace(path + ".part", path)
    return text


def main():
    """Measures everything that was asked for."""
    options = arguments()
    facts = {}
    for scene in options.scenes:
        print(f"{scene}: scene and exact images", file=sys.stderr)
        store.write_scene(options.output, scene)
        _, facts[scene] = store.read_exact(options.output, scene, "disc")
        for shape in {tool.shape for tool in wanted(options, scene)}:
            store.read_exact(options.output, scene, shape)
    machine = {"processor": processor(), "cores": os.cpu_count(), "load at start": f"{os.getloadavg()[0]:.1f}"}
    measurements, missing = [], set()
    for repeat in range(options.repeats):
        for scene in options.scenes:
            for tool in wanted(options, scene):
                if (repeat and tool.slow) or (scene, tool) in missing:
                    continue
                line = measure(options, scene, tool, repeat)
                if "missing" in line:
                    missing.add((scene, tool))
                print(json.dumps(line), file=sys.stderr)
                measurements.append(line)
                # A run that is stopped leaves what it has.
                text = write(options, measurements, facts, machine)
    print(text)


if __name__ == "__main__":
    main()
