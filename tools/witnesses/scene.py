"""Scenes of a few discs, spheres or Gaussians, as every program gets them, and pellucid's picture of one."""

import os
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
# The camera stands at (0, 0, DISTANCE), looks along −z with +y up, and sees HEIGHT at the origin.
SIZE = 64
DISTANCE = 4.0
HEIGHT = 2.0
NEAR, FAR = 0.5, 20.0
# The vertical angle of view in degrees.
FOV = float(np.degrees(2.0 * np.arctan(0.5 * HEIGHT / DISTANCE)))


class WitnessError(Exception):
    """A program is missing or has failed."""


@dataclass(frozen=True)
class Disc:
    """A disc of one color: center, normal, radius in world units, linear color and opacity in [0, 1]."""

    center: tuple[float, float, float]
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)
    radius: float = 8.0
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    opacity: float = 1.0


@dataclass(frozen=True)
class Gaussian:
    """A splat: center, standard deviations along its axes, rotation as a quaternion (w, x, y, z), linear color, peak opacity."""

    center: tuple[float, float, float]
    scale: tuple[float, float, float]
    rotation: tuple[float, float, float, float]
    color: tuple[float, float, float]
    opacity: float


@dataclass(frozen=True)
class Scene:
    """What pellucid draws: keys of the scene file, and a file of points for each cloud with keys of its own."""

    method: str
    keys: dict[str, object] = field(default_factory=dict)
    # Lines of a table [[cloud]] and the PLY that it names.
    clouds: tuple[tuple[str, bytes], ...] = ()
    background: tuple[float, float, float] = (0.0, 0.0, 0.0)
    # The values that are blended: linear light, or encoded ones as trainings of splats blend them.
    color: str = "linear"


def _ply(columns: dict[str, np.ndarray]) -> bytes:
    """A binary PLY of float32 columns."""
    count = len(next(iter(columns.values())))
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {count}"]
    head += [f"property float {name}" for name in columns] + ["end_header", ""]
    return "\n".join(head).encode() + np.stack(list(columns.values()), axis=1).astype("<f4").tobytes()


def disc_cloud(disc: Disc) -> tuple[str, bytes]:
    """A cloud of one disc."""
    names = ("x", "y", "z", "nx", "ny", "nz", "radius")
    values = (*disc.center, *disc.normal, disc.radius)
    keys = f"color = {list(disc.color)}\nopacity = {disc.opacity}\n"
    return keys, _ply({name: np.array([value]) for name, value in zip(names, values, strict=True)})


def sphere_cloud(center: tuple[float, float, float], radius: float) -> tuple[str, bytes]:
    """A cloud of one white sphere that is soft: its field is 1."""
    columns = dict(zip("xyz", center, strict=True)) | {"radius": radius, "soft": 1.0}
    return 'color = [1.0, 1.0, 1.0]\nfield = "soft"\n', _ply({name: np.array([value]) for name, value in columns.items()})


def point_cloud(points: np.ndarray, color: tuple[float, float, float]) -> tuple[str, bytes]:
    """A cloud of points of one color."""
    return f"color = {list(color)}\nradius = 0.001\n", _ply(dict(zip("xyz", points.T, strict=True)))


def gaussian_cloud(splats: list[Gaussian]) -> tuple[str, bytes]:
    """A file of Gaussian splats, as trainings write it: logarithms of extents, logits of opacities, harmonics of degree 0."""
    c0 = 0.28209479177387814
    rows = np.array([(*s.center, *s.scale, *s.rotation, *s.color, s.opacity) for s in splats])
    columns = dict(zip(("x", "y", "z"), rows[:, :3].T, strict=True))
    columns |= {f"f_dc_{k}": (rows[:, 10 + k] - 0.5) / c0 for k in range(3)}
    columns["opacity"] = np.log(rows[:, 13] / (1.0 - rows[:, 13]))
    columns |= {f"scale_{k}": np.log(rows[:, 3 + k]) for k in range(3)}
    columns |= {f"rot_{k}": rows[:, 6 + k] for k in range(4)}
    return "", _ply(columns)


def program() -> Path:
    """The program that is witnessed."""
    path = Path(os.environ.get("PELLUCID", ROOT / "target" / "release" / "pellucid")).resolve()
    if not os.access(path, os.X_OK):
        raise WitnessError(f"{path} is missing (cargo build --release makes it, or PELLUCID names another)")
    return path


def run(*arguments: str, folder: Path) -> str:
    """Runs pellucid in a folder and returns what it prints."""
    done = subprocess.run([program(), *arguments], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise WitnessError(f"pellucid {' '.join(arguments)}: status {done.returncode}\n{done.stderr}")
    return done.stdout


def write(scene: Scene, folder: Path) -> Path:
    """Writes a scene file and its points."""
    lines = [f"[image]\nsize = [{SIZE}, {SIZE}]\nbackground = {list(scene.background)}\ncolor = '{scene.color}'"]
    lines.append(f"[camera]\neye = [0.0, 0.0, {DISTANCE}]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]")
    lines.append(f"fov_y = {FOV!r}\nnear = {NEAR}\nfar = {FAR}")
    lines.append("[shading]\nmodel = 'none'")
    lines.append("\n".join([f"[method]\nname = '{scene.method}'", *(f"{key} = {value}" for key, value in scene.keys.items())]))
    for index, (keys, points) in enumerate(scene.clouds):
        (folder / f"{index}.ply").write_bytes(points)
        lines.append(f"[[cloud]]\npath = '{index}.ply'\n{keys}")
    path = folder / "scene.toml"
    path.write_text("\n\n".join(lines))
    return path


def rays() -> tuple[np.ndarray, np.ndarray]:
    """Origin and unit directions of the rays through the pixels' centers, rows from the top: (3), (SIZE, SIZE, 3)."""
    steps = (np.arange(SIZE) + 0.5) / SIZE - 0.5
    x, y = np.meshgrid(steps * HEIGHT, -steps * HEIGHT)
    directions = np.stack([x, y, np.full_like(x, -DISTANCE)], axis=-1)
    return np.array([0.0, 0.0, DISTANCE]), directions / np.linalg.norm(directions, axis=-1, keepdims=True)
