"""Scenes on disk: the cloud and scene file that pellucid reads, which the other tools read too, and the exact images.

Everything of a scene lies in DIR/NAME and is made once.
"""

import json
import os

import numpy as np

from camera import FAR, NEAR, project, world_per_pixel
from exact import exact_image
from scenes import SCENES, Scene, make, radius_px

VERTEX = np.dtype(
    [(name, "<f4") for name in ("x", "y", "z")]
    + [(name, "u1") for name in ("red", "green", "blue", "alpha")]
    + [("radius", "<f4")]
)
HEADER_END = b"end_header\n"

SCENE_FILE = """\
[image]
size = [{width}, {height}]
color = "encoded"

[camera]
eye = {eye}
target = {target}
up = {up}
{extent}
near = {near}
far = {far}

[[cloud]]
path = "cloud.ply"

[shading]
model = "none"

[method]
name = "{method}"
"""


def write_scene(folder, name):
    """Makes a scene's files unless they are there."""
    path = os.path.join(folder, name)
    if os.path.exists(os.path.join(path, "scene.toml")):
        return
    os.makedirs(path, exist_ok=True)
    scene = make(name)
    write_cloud(scene, os.path.join(path, "cloud.ply"))
    # Last, since it stands for the whole.
    with open(os.path.join(path, "scene.toml"), "w", encoding="utf-8") as file:
        file.write(scene_file(scene))


def write_cloud(scene, path):
    """A binary PLY whose radii give every disc the same size on the image in frame 0."""
    vertices = np.empty(len(scene.positions), VERTEX)
    for i, name in enumerate(("x", "y", "z")):
        vertices[name] = scene.positions[:, i]
    for i, name in enumerate(("red", "green", "blue", "alpha")):
        vertices[name] = scene.colors[:, i]
    _, _, depth = project(scene.positions, scene.view, 0)
    # Radius 0 is the pixel that contains the center.
    vertices["radius"] = 0 if scene.opaque else radius_px(scene.size_px) * world_per_pixel(scene.view, depth)
    kinds = {"<f4": "float", "|u1": "uchar"}
    lines = [f"property {kinds[VERTEX[name].str]} {name}" for name in VERTEX.names]
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}", *lines]
    with open(path, "wb") as file:
        file.write("\n".join(header).encode() + b"\n" + HEADER_END)
        vertices.tofile(file)


def scene_file(scene):
    """The text of scene.toml: blending on the stored values and no shading, as the other tools do it."""
    view = scene.view
    return SCENE_FILE.format(
        width=view.width,
        height=view.height_px,
        eye=[float(v) for v in view.eye],
        target=[float(v) for v in view.target],
        up=[float(v) for v in view.up],
        extent=f"height = {view.height}" if view.height else f"fov_y = {view.fov_y}",
        near=NEAR,
        far=FAR,
        method="points" if scene.opaque else "abuffer",
    )


def read_scene(folder, name):
    """A scene that `write_scene` made."""
    path = os.path.join(folder, name, "cloud.ply")
    with open(path, "rb") as file:
        start = file.read(4096).index(HEADER_END) + len(HEADER_END)
    vertices = np.fromfile(path, VERTEX, offset=start)
    positions = np.stack([vertices[name] for name in ("x", "y", "z")], 1)
    colors = np.stack([vertices[name] for name in ("red", "green", "blue", "alpha")], 1)
    _, view, size_px = SCENES[name]
    return Scene(name, positions, colors, view, size_px)


def read_exact(folder, name, shape):
    """The exact image of frame 0 and facts about its fragments, computed on the first call."""
    # A point of one pixel has no shape.
    shape = "square" if SCENES[name][2] == 1 else shape
    stem = os.path.join(folder, name, f"exact-{shape}")
    if not os.path.exists(stem + ".json"):
        image, counts = exact_image(read_scene(folder, name), shape)
        covered = counts[counts > 0]
        facts = {
            "fragments": int(covered.sum()),
            "mean_layers": float(covered.mean()),
            "max_layers": int(covered.max()),
        }
        np.save(stem + ".npy", image.astype(np.float32))
        with open(stem + ".json", "w", encoding="utf-8") as file:
            json.dump(facts, file)
    with open(stem + ".json", encoding="utf-8") as file:
        return np.load(stem + ".npy").astype(np.float64), json.load(file)
