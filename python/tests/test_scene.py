"""Scenes: keys as attributes, TOML, completion."""

from __future__ import annotations

import inspect

import numpy as np
import pytest
from conftest import DATA, SIZE

import pellucid


@pytest.fixture
def scene(points):
    return pellucid.Scene(pellucid.Cloud(points, name="ball"), opacity=0.25, method="stochastic")


def test_keys_are_attributes_with_the_values_in_force(scene):
    assert scene.method.name == "stochastic"
    assert scene.method.samples == 64
    assert scene.image.size == [1024, 1024]
    assert scene.image.background == [0.0, 0.0, 0.0]
    assert scene.camera.eye is None
    assert scene.cloud[0].opacity == 0.25
    assert scene.cloud[-1].path == "ball"
    assert len(scene.cloud) == 1
    scene.method.samples = 8
    scene.image.background = "white"
    scene.cloud[0].radius = 0.5
    assert scene.method.samples == 8
    assert scene.image.background == [1.0, 1.0, 1.0]
    assert scene.get("cloud.0.radius") == 0.5
    assert scene.given()["method"] == {"name": "stochastic", "samples": 8}
    scene.method.samples = None
    assert scene.method.samples == 64
    del scene.cloud[0].radius
    assert scene.cloud[0].radius is None
    scene.method = "abuffer"
    assert scene.method.name == "abuffer"


def test_all_clouds_at_once(points):
    scene = pellucid.Scene([pellucid.Cloud(points), pellucid.Cloud(points + 5.0)])
    scene.cloud.opacity = 0.125
    assert [cloud.opacity for cloud in (scene.cloud[0], scene.cloud[1])] == [0.125, 0.125]
    scene.cloud[1].opacity = 1.0
    assert scene.cloud[0].opacity == 0.125
    assert [cloud.name for cloud in scene.clouds] == ["cloud-0", "cloud-1"]
    with pytest.raises(IndexError, match="below 2"):
        scene.cloud[2]


def test_every_key_completes_and_is_described(scene):
    keys = dir(scene.method)
    assert {"name", "samples", "alpha_correction", "shape"} <= set(keys)
    for table in (scene.image, scene.camera, scene.shading, scene.shadows, scene.detail, scene.method, scene.cloud[0]):
        for key in table.keys():  # noqa: SIM118
            text = inspect.getdoc(getattr(type(table), key.replace(".", "__")))
            assert text
            assert text == inspect.cleandoc(table.doc(key))
    assert "samples" in scene.method.doc("samples").lower()
    assert "1 to" in scene.method.doc("samples")
    assert "number from 0 to 1; by default 1" in scene.cloud[0].doc("opacity")
    assert "name='stochastic'" in repr(scene.method)


def test_a_key_that_is_none_is_refused(scene):
    with pytest.raises(AttributeError, match="no key 'sample'"):
        scene.method.sample = 3
    with pytest.raises(AttributeError, match="no key 'sample'"):
        _ = scene.method.sample
    with pytest.raises(KeyError):
        scene.get("method.sample")
    with pytest.raises(AttributeError, match="has no key"):
        scene.cloud.opacty = 1.0


def test_toml_and_back(renderer, scene, points, tmp_path):
    scene.update(size=SIZE, background=[0.1, 0.2, 0.3], clip=[{"slab": {"axis": "z", "min": -1.0}}], class_opacity={6: 0.5})
    text = scene.to_toml()
    assert 'path = "' in text
    path = tmp_path / "scene.toml"
    file = DATA / "models/turbine_blade_6k.ply"
    path.write_text(f'[image]\nsize = [64, 48]\n[[cloud]]\npath = "{file}"\nopacity = 0.5\n')
    read = pellucid.Scene.read(path)
    again = pellucid.Scene.from_toml(read.to_toml(tmp_path), folder=tmp_path)
    assert again.given() == read.given()
    np.testing.assert_array_equal(pellucid.render(read).rgba, pellucid.render(again).rgba)
    assert len(read.clouds) == 1
    assert len(read.clouds[0]) > 1000


def test_clips_are_a_list(scene):
    assert scene.clip == []
    scene.clip = [{"slab": {"axis": "z", "min": 0.0}}, {"plane": {"point": [0, 0, 0], "normal": [1, 0, 0]}, "invert": True}]
    assert len(scene.clip) == 2
    assert scene.get("clip.0.slab.min") == 0.0
    scene.clip = []
    assert scene.clip == []


def test_a_copy_changes_by_itself(scene):
    other = scene.copy()
    other.method.samples = 4
    assert scene.method.samples == 64


def test_rendering_leaves_a_scene_as_it_is(renderer, scene):
    before = scene.given()
    image = pellucid.render(scene, size=SIZE, samples=4, camera=pellucid.Camera.look_at((0, 0, 9), (0, 0, 0), up=(0, 1, 0)))
    assert image.size == SIZE
    assert scene.given() == before


def test_the_built_in_scene_follows_its_seed(renderer):
    a, b = (pellucid.Scene.built_in(seed) for seed in (0, 1))
    assert np.abs(pellucid.render(a, size=SIZE).rgba - pellucid.render(b, size=SIZE).rgba).max() > 0.0
    assert len(a.clouds) >= 1


def test_a_file_that_is_broken_says_where(tmp_path):
    path = tmp_path / "broken.toml"
    path.write_text("[image]\nsize = [0, 5]\n[[cloud]]\npath = 'a.ply'\n")
    with pytest.raises(pellucid.SceneError, match=r"broken\.toml:2:\d+: `image\.size`"):
        pellucid.Scene.read(path)
    path.write_text("[imag]\nsize = [5, 5]\n[[cloud]]\npath = 'a.ply'\n")
    with pytest.raises(pellucid.SceneError, match=r"broken\.toml:1:\d+: unknown key `imag`"):
        pellucid.Scene.read(path)


def test_errors_are_of_the_usual_kinds():
    assert issubclass(pellucid.SceneError, ValueError)
    assert issubclass(pellucid.ReadError, OSError)
    for kind in (pellucid.SceneError, pellucid.ReadError, pellucid.DeviceError):
        assert issubclass(kind, pellucid.Error)
    with pytest.raises(pellucid.ReadError, match="empty"):
        pellucid.Cloud.read("/dev/null")


def test_a_damaged_file_is_no_crash(renderer):
    for name in ("corrupt_crc.e57", "laszip_broken_coder.laz", "no-points.las", "no_vertex.ply"):
        with pytest.raises(pellucid.ReadError, match=name.replace(".", r"\.")):
            pellucid.Cloud.read(DATA / "nasty" / name)
