"""What the peers' scripts have in common: each draws one scene in a process of its own and prints one line of JSON."""

import argparse
import json
import time

import numpy as np

from store import read_scene

# A first frame that takes longer is the measurement: what only a first frame pays for is little of it. Seconds.
VERY_SLOW_S = 60.0
# So is a second frame that takes longer than this.
SLOW_S = 5.0


def arguments(modes):
    """The command line of a peer's script: its scene and options."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", help="where the scenes are")
    parser.add_argument("scene")
    parser.add_argument("mode", choices=modes)
    parser.add_argument("--frames", type=int, default=3)
    parser.add_argument("--image", metavar="FILE.npy", help="write frame 0")
    options = parser.parse_args()
    return read_scene(options.folder, options.scene), options


def measure(draw, frames):
    """Frame 0 as an image, and the milliseconds of `frames` later ones.

    `draw(frame)` returns the image when it is on the host.
    """

    def timed(frame):
        start = time.perf_counter()
        image = draw(frame)
        return image, time.perf_counter() - start

    image, first = timed(0)
    image = np.array(image)
    if first > VERY_SLOW_S:
        return image, [first * 1e3]
    _, second = timed(1)
    if second > SLOW_S:
        return image, [second * 1e3]
    return image, [timed(2 + frame)[1] * 1e3 for frame in range(frames)]


def run(draw, options, version, driver):
    """Measures and prints. `driver` is asked after the first frame, when there is a context."""
    image, times = measure(draw, options.frames)
    if options.image:
        np.save(options.image, image)
    print(json.dumps({"ms": times, "version": version, "driver": driver()}))
