"""What is compared: which tool draws which scene, and how each is run for a few frames in a process of its own."""

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass

import numpy as np
import OpenEXR

from exact import encode_srgb
from scenes import SCENES

HERE = os.path.dirname(os.path.abspath(__file__))


class Missing(Exception):
    """The tool cannot be run here; the message says why."""


@dataclass(frozen=True)
class Tool:
    """A row of a scene: a tool in one of its modes."""

    name: str
    mode: str
    # Shape of its splats, "disc" or "square".
    shape: str
    # True if one run of it takes minutes.
    slow: bool = False

    @property
    def label(self):
        """The tool's name in the tables."""
        return f"{self.name} {self.mode}"


@dataclass(frozen=True)
class Job:
    """The task of a tool: a scene in a folder of scenes, so many frames, and whether frame 0 is kept."""

    folder: str
    scene: str
    frames: int
    with_image: bool


OPAQUE = [
    Tool("pellucid", "points", "disc"),
    Tool("painter", "nearest", "disc"),
    Tool("vtk", "opaque", "square"),
    Tool("vispy", "opaque", "disc"),
]
TRANSPARENT = [
    Tool("pellucid", "sorted", "disc"),
    Tool("pellucid", "sorted for png", "disc"),
    Tool("pellucid", "abuffer", "disc"),
    Tool("painter", "sorted", "disc"),
    Tool("vtk", "sorted", "square"),
    Tool("vispy", "sorted", "disc"),
    Tool("vtk", "peel100", "square", slow=True),
]
SCRIPTS = {"painter": "painter.py", "vtk": "vtk_points.py", "vispy": "vispy_points.py"}


def tools_of(scene):
    """The tools that draw a scene."""
    return OPAQUE if SCENES[scene][2] == 1 else TRANSPARENT


def run(command, **kwargs):
    """Runs a command; its standard output, or `Missing` with the last line of what it complained about."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, **kwargs)
    except OSError as error:
        raise Missing(str(error)) from error
    if done.returncode:
        complaint = done.stderr.strip().splitlines()
        raise Missing(complaint[-1] if complaint else f"exit status {done.returncode}")
    return done.stdout


def measure_peer(tool, job):
    """Runs a peer's script: its JSON and, if it is kept, its image of frame 0."""
    # Mesa's EGL needs no display; without these VTK and vispy look for one first.
    environment = {"EGL_PLATFORM": "surfaceless", "VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow", **os.environ}
    with tempfile.TemporaryDirectory() as temporary:
        path = os.path.join(temporary, "image.npy")
        command = [sys.executable, os.path.join(HERE, SCRIPTS[tool.name]), job.folder, job.scene, tool.mode]
        command += ["--frames", str(job.frames)] + (["--image", path] if job.with_image else [])
        # Others' warnings share the output; the result is its last line.
        result = json.loads(run(command, env=environment).splitlines()[-1])
        return result, np.load(path) if job.with_image else None


def measure_pellucid(binary, tool, job):
    """Runs `pellucid profile` and, if the image is kept, `pellucid render`: the same two things.

    A mode is a method, and "for png" where frames need only be right to a quarter of an 8-bit step; their image is not
    kept, since a PNG has 8 bits itself.
    """
    method, *output = tool.mode.split(" for ")
    source = [os.path.join(job.folder, job.scene, "scene.toml"), "--method", method, "--quiet"]
    # `profile` draws one frame before those that it measures: these are the second and later ones.
    stop = [f"--for={name}" for name in output]
    profile = json.loads(run([binary, "profile", *source, *stop, "--frames", str(job.frames), "--json"]))
    result = {
        "ms": [frame["wall_ms"] for frame in profile["frames"]],
        "version": run([binary, "--version"]).strip(),
        "driver": profile["device"]["name"],
        "bands": profile["memory"]["bands"],
    }
    if not job.with_image or output:
        return result, None
    with tempfile.TemporaryDirectory() as temporary:
        path = os.path.join(temporary, "image.exr")
        run([binary, "render", *source, "-o", path])
        return result, read_exr(path)


def read_exr(path):
    """R, G, B (height, width, 3) of an EXR, which is linear, as the stored values that the tools blend."""
    with OpenEXR.File(path, separate_channels=True) as file:
        channels = file.channels()
        return encode_srgb(np.stack([channels[name].pixels for name in "RGB"], 2).astype(np.float64))
