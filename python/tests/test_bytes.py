"""What Python renders and writes are the bytes that the command line writes, metadata included."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import DATA
from matplotlib.image import imread

import pellucid

FILES = [
    "formats/1.2-with-color.las",
    "lidar/sample_c_2k.las",
    "models/turbine_blade_6k.ply",
    "indoor/redwood_fragment_1k.pcd",
    "formats/points_cloudcompare.xyz",
    "formats/1.2-with-color.ptx",
    "splats/soup.ply",
]

# Arguments of Python, and of the command line.
CASES = {
    "plain": ({}, []),
    "transparent": ({"opacity": 0.2}, ["--opacity", "0.2"]),
    "stochastic": (
        {"opacity": 0.2, "method": "stochastic", "method__samples": 8, "seed": 3},
        ["--opacity", "0.2", "--method", "stochastic", "--set", "method.samples=8", "--seed", "3"],
    ),
    "samples": (
        {"opacity": 0.3, "method": "abuffer", "samples": 4, "fragments": True, "depths": True},
        ["--opacity", "0.3", "--method", "abuffer", "--samples", "4", "--aov"],
    ),
    "samples as many as it takes": (
        {"samples": "auto", "sampling_error": 0.05},
        ["--samples", "auto", "--set", "image.sampling_error=0.05"],
    ),
    "seen from aside": (
        {"view": "left", "elevation": 20, "background": "white", "color_by": "height", "colormap": "magma"},
        ["--view", "left", "--elevation", "20", "--background", "white", "--color-by", "height", "--colormap", "magma"],
    ),
    "aov": (
        {"opacity": 0.3, "method": "abuffer", "fragments": True, "depths": True},
        ["--opacity", "0.3", "--method", "abuffer", "--aov"],
    ),
}


def of_cli(cli, tmp_path, inputs, arguments, suffix):
    out = tmp_path / f"cli{suffix}"
    cli("render", *map(str, inputs), "--size", "96x64", "-o", str(out), *arguments)
    return out.read_bytes()


def of_python(tmp_path, points, arguments, suffix):
    out = tmp_path / f"python{suffix}"
    accuracy = "8-bit" if suffix == ".png" else "exact"
    pellucid.render(points, size=(96, 64), accuracy=accuracy, **arguments).save(out)
    return out.read_bytes()


@pytest.mark.filterwarnings("ignore::pellucid.PellucidWarning")
@pytest.mark.parametrize("suffix", [".png", ".exr"])
@pytest.mark.parametrize("file", FILES)
def test_of_files(renderer, cli, tmp_path, file, suffix):
    for name, (python, arguments) in CASES.items():
        if name in ("aov", "samples") and suffix == ".png":
            continue
        if file == "splats/soup.ply" and name == "seen from aside":
            # Splats have colors alone.
            python = {key: value for key, value in python.items() if not key.startswith("color")}
            arguments = arguments[:6]
        ours = of_python(tmp_path, DATA / file, python, suffix)
        assert ours == of_cli(cli, tmp_path, [DATA / file], arguments, suffix), name


@pytest.mark.parametrize("suffix", [".png", ".exr"])
def test_of_the_built_in_scene(renderer, cli, tmp_path, suffix):
    ours = of_python(tmp_path, pellucid.Scene.built_in(), {}, suffix)
    assert ours == of_cli(cli, tmp_path, [], [], suffix)


@pytest.mark.parametrize("name", ["volume", "stack", "tori"])
def test_of_other_built_in_scenes(renderer, cli, tmp_path, monkeypatch, name):
    cli("scene", name, "-o", str(tmp_path / name))
    scene = tmp_path / name / "scene.toml"
    ours = of_python(tmp_path, scene, {}, ".exr")
    assert ours == of_cli(cli, tmp_path, [scene], [], ".exr")
    monkeypatch.chdir(tmp_path)
    again = pellucid.Scene.from_toml(pellucid.Scene.read(scene).to_toml(tmp_path / name), folder=tmp_path / name)
    ours = of_python(tmp_path, again, {}, ".exr")
    assert ours == of_cli(cli, tmp_path, [scene], [], ".exr")


@pytest.mark.filterwarnings("ignore::pellucid.PellucidWarning")
def test_of_several_files(renderer, cli, tmp_path):
    files = [DATA / "models/turbine_blade_6k.ply", DATA / "indoor/livingroom_fragment_2k.ply"]
    ours = of_python(tmp_path, files, {"opacity": 0.5}, ".png")
    assert ours == of_cli(cli, tmp_path, files, ["--opacity", "0.5"], ".png")


def test_of_arrays_in_place_of_a_file(renderer, cli, tmp_path):
    """A cloud that bears the name of a file is that file, to the last byte of metadata."""
    rng = np.random.default_rng(11)
    points, colors = rng.normal(size=(3000, 3)).astype(np.float32), rng.integers(0, 256, (3000, 3), dtype=np.uint8)
    header = "ply\nformat binary_little_endian 1.0\nelement vertex 3000\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz")
    header += "".join(f"property uchar {channel}\n" for channel in ("red", "green", "blue")) + "end_header\n"
    rows = np.concatenate([points.view(np.uint8).reshape(3000, 12), colors], axis=1)
    (tmp_path / "ball.ply").write_bytes(header.encode() + rows.tobytes())
    cloud = pellucid.Cloud(points, colors=colors, name="ball.ply")
    for suffix in (".png", ".exr"):
        ours = of_python(tmp_path, cloud, {"opacity": 0.1}, suffix)
        assert ours == of_cli(cli, tmp_path, ["ball.ply"], ["--opacity", "0.1"], suffix)


@pytest.mark.filterwarnings("ignore::pellucid.PellucidWarning")
def test_of_frames_of_a_loaded_scene(renderer, cli, tmp_path):
    """Frames with live settings are those of a scene that had the settings from the start."""
    path = DATA / "lidar/sample_c_2k.las"
    with renderer.load(path, size=(96, 64), opacity=0.3) as loaded:
        steps = [
            ({}, []),
            ({"background": [0.1, 0.2, 0.3]}, ["--background", "0.1,0.2,0.3"]),
            ({"method": "stochastic", "method__samples": 4}, ["--method", "stochastic", "--set", "method.samples=4"]),
            ({"method": "spbr", "ensembles": 4}, ["--method", "spbr", "--set", "method.ensembles=4"]),
            ({"method": "points"}, ["--method", "points"]),
            ({"radius": 0.5}, ["--radius", "0.5"]),
            ({"color_by": "height"}, ["--color-by", "height"]),
            ({"max_points": 500}, ["--max-points", "500"]),
            ({"shading__model": "none"}, ["--set", "shading.model=none"]),
            ({}, []),
        ]
        for settings, arguments in steps:
            out = tmp_path / "python.exr"
            loaded.frame(**settings).save(out)
            ours = out.read_bytes()
            assert ours == of_cli(cli, tmp_path, [path], ["--opacity", "0.3", *arguments], ".exr"), settings


def test_a_transparent_png(renderer, cli, tmp_path):
    path = DATA / "models/turbine_blade_6k.ply"
    out = tmp_path / "python.png"
    image = pellucid.render(path, size=(96, 64), opacity=0.5)
    image.save(out, transparent=True)
    assert out.read_bytes() == image.to_png(transparent=True)
    cli("render", str(path), "--size", "96x64", "--opacity", "0.5", "--transparent", "-o", "cli.png")
    ours, theirs = imread(out), imread(tmp_path / "cli.png")
    assert ours.shape == (64, 96, 4)
    assert 0.0 < ours[..., 3].mean() < 1.0
    # The command line stops blending where no byte of such a file would change by much.
    difference = np.abs(ours - theirs)
    assert difference.max() < 1.5 / 255.0
    assert (difference > 0.0).mean() < 0.01


def test_srgb_is_what_a_png_holds(renderer, tmp_path, points):
    image = pellucid.render(points, size=(32, 24), opacity=0.4, background=[0.2, 0.4, 0.6])
    image.save(tmp_path / "a.png")
    found = pellucid.compare(tmp_path / "a.png", image.to_srgb())
    assert found.max_value == 0.0
    over = image.rgba[..., :3] + (1.0 - image.rgba[..., 3:]) * np.float32([0.2, 0.4, 0.6])
    np.testing.assert_allclose(image.over_background(), over, atol=1e-6)


@pytest.mark.filterwarnings("ignore::pellucid.PellucidWarning")
def test_of_a_store_that_stays_on_the_disk(renderer, cli, tmp_path):
    """Memory for a tenth of the points: they are read as the picture needs them."""
    points = np.random.default_rng(5).normal(size=(60_000, 3)).astype(np.float32)
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    (tmp_path / "many.ply").write_bytes(header.encode() + points.tobytes())
    cli("prepare", "many.ply", "-o", "store/")
    for settings, arguments in [
        ({}, []),
        ({"detail": {"spacing_px": 4}}, ["--detail", "4"]),
        ({"max_points": 20000}, ["--max-points", "20000"]),
    ]:
        python = {"opacity": 0.2, "host_memory": 1 << 20, **settings}
        ours = of_python(tmp_path, tmp_path / "store", python, ".exr")
        arguments = ["--opacity", "0.2", "--host-memory", "1MiB", *arguments]
        assert ours == of_cli(cli, tmp_path, [tmp_path / "store"], arguments, ".exr"), settings
