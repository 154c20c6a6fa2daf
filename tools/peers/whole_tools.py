"""The whole commands that are compared: which tool makes which picture from which file, and how one of them is run."""

import glob
import importlib.metadata
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass

from above import BOTTOM, CENTER, EYE_M, FAR_M, HEIGHT, NEAR_M, OPACITY, PIXEL_M, TOP, WIDTH

HERE = os.path.dirname(os.path.abspath(__file__))
# When a command is stopped.
LIMIT_S = 300
# Mesa's EGL needs no display; without these VTK looks for one first.
ENVIRONMENT = {"EGL_PLATFORM": "surfaceless", "VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}
# Words by which a tool complains though it ends well.
COMPLAINTS = ("error", "not supported", "can't", "cannot", "failed")


@dataclass(frozen=True)
class Row:
    """A picture that a tool makes: of a job ("nearest", "see-through", "mean", "density") and a kind of file."""

    job: str
    kind: str
    tool: str
    mode: str
    # Arguments of pellucid and CloudCompare; the others have scripts that take the mode.
    options: tuple = ()
    # True if one run takes minutes.
    slow: bool = False
    # True if the picture should be the job's exact one.
    claims: bool = True

    @property
    def label(self):
        """The tool's name in the tables."""
        return f"{self.tool} {self.mode}"


WHITE = ("--set", "image.background=white")
PLAIN = ("--set", "shading.model=none")
# Points of one pixel.
SMALL = (*PLAIN, "--radius", "0")
NEAREST = ("--method", "points", *PLAIN, *WHITE)
RASTER = ("-RASTERIZE", "-GRID_STEP", str(PIXEL_M), "-PROJ", "MAX", "-OUTPUT_RASTER_RGB")
THROUGH = ("--opacity", str(OPACITY), *WHITE)
# Of each point of a picture of density: few enough that dense walls stay below white.
FAINT = ("--opacity", "0.05", "--color-by", "uniform", "--set", "image.background=black")
ROWS = [
    Row("nearest", "ply", "pellucid", "points", NEAREST),
    Row("nearest", "ply", "PyVista", "nearest"),
    Row("nearest", "ply", "Open3D", "nearest"),
    Row("nearest", "ply", "CloudCompare", "rasterize", RASTER),
    Row("nearest", "laz", "pellucid", "points", NEAREST),
    Row("nearest", "laz", "PyVista", "nearest"),
    Row("nearest", "laz", "Open3D", "nearest"),
    Row("nearest", "laz", "datashader", "nearest"),
    Row("nearest", "laz", "CloudCompare", "rasterize", RASTER),
    Row("see-through", "ply", "pellucid", "pixels", (*SMALL, *THROUGH)),
    Row("see-through", "ply", "PyVista", "unsorted"),
    Row("see-through", "ply", "PyVista", "peel4"),
    Row("see-through", "ply", "PyVista", "peel100", slow=True),
    Row("see-through", "ply", "Open3D", "unlit"),
    Row("see-through", "ply", "Open3D", "lit"),
    Row("see-through", "ply", "pellucid", "default discs", THROUGH, claims=False),
    Row("mean", "laz", "pellucid", "average", ("--method", "average", *SMALL, *WHITE)),
    Row("mean", "laz", "datashader", "mean"),
    Row("density", "laz", "pellucid", "faint", (*SMALL, *FAINT)),
    Row("density", "laz", "datashader", "density"),
]
# The packages behind a tool, of which versions are told.
PACKAGES = {
    "PyVista": ("pyvista", "vtk"),
    "Open3D": ("open3d-cpu",),
    "datashader": ("datashader",),
}
READER = ("laspy", "lazrs")
SCRIPTS = {"PyVista": "whole_pyvista.py", "Open3D": "whole_open3d.py", "datashader": "whole_datashader.py"}


def camera():
    """The options of pellucid for the camera of `above`."""
    x, y = (round(value, 9) for value in CENTER)
    keys = {
        "camera.eye": [x, y, EYE_M],
        "camera.target": [x, y, 0.0],
        "camera.up": [0, 1, 0],
        "camera.height": round(TOP - BOTTOM, 9),
        "camera.near": NEAR_M,
        "camera.far": FAR_M,
        "image.color": "encoded",
    }
    sets = [word for key, value in keys.items() for word in ("--set", f"{key}={value}".replace(" ", ""))]
    return ["--size", f"{WIDTH}x{HEIGHT}", *sets]


def command(row, binaries):
    """The command of a row, in a folder with the cloud. `binaries` are the paths of pellucid and CloudCompare."""
    cloud = f"house.{row.kind}"
    if row.tool == "pellucid":
        return [binaries["pellucid"], "render", cloud, *camera(), *row.options, "-o", "picture.png"]
    if row.tool == "CloudCompare":
        return [binaries["CloudCompare"], "-SILENT", "-O", cloud, *row.options]
    return [sys.executable, os.path.join(HERE, SCRIPTS[row.tool]), cloud, "picture.png", row.mode]


def version(row, binaries):
    """The version of a row's tool and of what reads its file, "" if it doesn't tell."""
    if row.tool == "CloudCompare":
        return binaries["CloudCompare version"]
    if row.tool == "pellucid":
        asked = [binaries["pellucid"], "--version"]
        return subprocess.run(asked, capture_output=True, text=True, check=True).stdout.strip()
    found = []
    for package in (*PACKAGES[row.tool], *(READER if row.kind == "laz" else ())):
        try:
            found.append(f"{package} {importlib.metadata.version(package)}")
        except importlib.metadata.PackageNotFoundError:
            found.append(f"{package} not installed")
    return ", ".join(found)


def failure(result, text, pictures):
    """Why a command made no picture, or None if it made one. `text` is what it printed."""
    if "missing" in result:
        return result["missing"]
    status = result["status"]
    if status == 0 and pictures:
        return None
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    told = [line for line in lines if any(word in line.lower() for word in COMPLAINTS)] or lines or ["nothing"]
    if status < 0:
        stopped = f" after {LIMIT_S} s" if result["wall_s"] >= LIMIT_S else ""
        return f"ended by {signal.Signals(-status).name}{stopped}"
    return f"exit status {status}, no picture: {told[-1]}" if status == 0 else f"exit status {status}: {told[-1]}"


def run(row, binaries, folder, kept):
    """Runs a row in a process of its own on the clouds of `folder`; its picture goes to the path `kept`.

    Returns what `whole_run` measured and the picture's size, or why it failed.
    """
    with tempfile.TemporaryDirectory() as temporary:
        cloud = f"house.{row.kind}"
        os.symlink(os.path.abspath(os.path.join(folder, cloud)), os.path.join(temporary, cloud))
        warm(os.path.join(temporary, cloud))
        # Outside of the folder: each picture in it is the command's.
        with tempfile.NamedTemporaryFile("r", errors="replace") as printed:
            watcher = [sys.executable, os.path.join(HERE, "whole_run.py"), str(LIMIT_S), printed.name]
            done = subprocess.run(
                [*watcher, *command(row, binaries)],
                cwd=temporary,
                env={**os.environ, **ENVIRONMENT},
                stdout=subprocess.PIPE,
                text=True,
                check=True,
            )
            result, text = json.loads(done.stdout), printed.read()
        pictures = sorted(path for end in ("png", "tif") for path in glob.glob(os.path.join(temporary, f"*.{end}")))
        reason = failure(result, text, pictures)
        if reason:
            return {"failed": reason}
        shutil.copyfile(pictures[0], kept)
        return {**result, "picture_bytes": os.path.getsize(kept)}


def warm(path):
    """Reads a file, so that it lies in memory."""
    with open(path, "rb") as file:
        while file.read(1 << 24):
            pass
