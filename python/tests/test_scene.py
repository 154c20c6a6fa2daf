"""Scenes: keys as attributes, TOML, completion."""

from __future__ import annotations

import copy
import inspect

import numpy as np
import pytest
from conftest import DATA, SIZE

import pellucid

LIGHT = [1.0, 1.0, -2.0]


@pytest.fixture
def scene(points):
    return pellucid.Scene(pellucid.Cloud(points, name="ball"), opacity=0.25, method="stochastic")


def test_keys_are_attributes_with_the_values_in_force(scene):
    assert scene.method.name == "stochastic"
    assert scene.method.samples == 64
    assert scene.image.size == [1024, 1024]
    assert scene.image.background == "auto"
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
    assert pellucid.Scene.from_toml(text).given() == scene.given()
    assert scene.given()["cloud"] == [{"path": "ball", "opacity": 0.25, "class": [{"id": 6, "opacity": 0.5}]}]
    assert scene.given()["clip"] == [{"slab": {"axis": "z", "min": -1.0}}]
    assert scene.given()["image"] == {"background": [0.1, 0.2, 0.3], "size": list(SIZE)}
    path = tmp_path / "scene.toml"
    file = DATA / "models/turbine_blade_6k.ply"
    path.write_text(f'[image]\nsize = [64, 48]\n[[cloud]]\npath = "{file}"\nopacity = 0.5\n')
    read = pellucid.Scene.read(path)
    again = pellucid.Scene.from_toml(read.to_toml(tmp_path), folder=tmp_path)
    assert again.given() == read.given()
    np.testing.assert_array_equal(pellucid.render(read).rgba, pellucid.render(again).rgba)
    assert len(read.clouds) == 1
    assert len(read.clouds[0]) > 1000


def test_a_scene_of_arrays_comes_back_with_its_clouds(renderer, points, tmp_path):
    file = DATA / "models/turbine_blade_6k.ply"
    clouds = [pellucid.Cloud(points, name="ball"), pellucid.Cloud.read(file), pellucid.Cloud(points + 4.0, opacity=0.5)]
    clips = [{"slab": {"axis": "z", "min": -1.0}}, {"plane": {"point": [0, 0, 0], "normal": [1, 0, 0]}, "invert": True}]
    scene = pellucid.Scene(clouds, size=SIZE, clip=clips, class_opacity={6: 0.5}, method="circles", shadows={}, color="red")
    scene.shading.light = LIGHT
    text = scene.to_toml(DATA)
    for path in ("ball", "models/turbine_blade_6k.ply", "cloud"):
        assert f'path = "{path}"' in text
    assert 'path = "ball"' in scene.to_toml(tmp_path)
    assert 'path = "ball"' in scene.copy().to_toml(tmp_path)
    again = pellucid.Scene.from_toml(text, folder=DATA, clouds=scene.clouds)
    # A text without a background has a black one.
    assert again.given() == {**scene.given(), "image": {**scene.given()["image"], "background": "auto"}}
    assert again.to_toml(tmp_path) == scene.to_toml(tmp_path)
    np.testing.assert_array_equal(pellucid.render(again).rgba, pellucid.render(scene).rgba)
    single = pellucid.Scene.from_toml("[[cloud]]\npath = 'a'\nradius = 0.5", clouds=clouds[0])
    assert single.given() == {"cloud": [{"path": "a", "radius": 0.5}]}


def test_the_same_file_twice_keeps_its_path():
    cloud = pellucid.Cloud.read(DATA / "models/turbine_blade_6k.ply")
    scene = pellucid.Scene([cloud, cloud])
    assert {table.path for table in scene.cloud} == {str(DATA / "models/turbine_blade_6k.ply")}


def test_clips_are_a_tuple(scene):
    assert scene.clip == ()
    scene.clip = [{"slab": {"axis": "z", "min": 0.0}}, {"plane": {"point": [0, 0, 0], "normal": [1, 0, 0]}, "invert": True}]
    assert len(scene.clip) == 2
    assert scene.get("clip.0.slab.min") == 0.0
    scene.clip = [*scene.clip, {"slab": {"axis": "x", "max": 3}}]
    assert [*scene.clip[2]] == ["slab"]
    scene.clip = []
    assert scene.clip == ()
    with pytest.raises(AttributeError, match="append"):
        scene.clip.append({})


def test_shadows_are_switched_on(renderer, scene):
    """An empty table in a file switches them on, too."""
    for on in ({}, True):
        assert pellucid.Scene(scene.clouds, shadows=on).given()["shadows"] == {}
        other = scene.copy()
        other.update(shadows=on)
        assert other.given()["shadows"] == {}
    scene.shadows = True
    assert scene.given()["shadows"] == {}
    scene.shadows = {"samples": 4}
    assert scene.given()["shadows"] == {"samples": 4}
    scene.shadows = None
    assert "shadows" not in scene.given()
    x, y = np.mgrid[-2:2:40j, -2:2:40j].reshape(2, -1)
    floor, roof = np.stack([x, y, 0 * x], axis=1), np.stack([0.3 * x, 0.3 * y, 0 * x + 1.0], axis=1)
    hall = pellucid.Cloud(np.concatenate([floor, roof]), normals=[(0, 0, 1)] * 2 * len(floor))
    view = {"size": SIZE, "view": "iso", "up": [0, 1, 0]}
    lit = view | {"method": "circles", "radius": 0.1, "shading": {"model": "lambert", "light": LIGHT}}
    shadowed = pellucid.render(hall, shadows={}, **lit).rgba
    assert np.abs(pellucid.render(hall, **lit).rgba - shadowed).max() > 0.1
    np.testing.assert_array_equal(pellucid.render(hall, shadows=True, **lit).rgba, shadowed)


def test_a_table_takes_a_dict(scene):
    scene.image = {"background": "red"}
    scene.image = {"size": (4.0, 5)}
    assert scene.given()["image"] == {"size": [4, 5]}
    scene.method = {"name": "stochastic", "samples": 4.0}
    assert scene.given()["method"] == {"name": "stochastic", "samples": 4}
    scene.camera = {"fov_y": 20}
    assert scene.given()["camera"] == {"fov_y": 20}
    before = scene.given()
    with pytest.raises(pellucid.SceneError, match=r"^shading\.modl='none': unknown key `shading\.modl`; did you mean `model`\?$"):
        scene.shading = {"model": "none", "modl": "none"}
    assert scene.given() == before


def test_a_plain_name_of_several_tables_is_the_method_s_unless_a_keyword_has_it(scene):
    scene.update(method__samples=8, min_layer_distance=0.5, color="red")
    assert scene.given()["method"] == {"name": "stochastic", "samples": 8, "min_layer_distance": 0.5}
    assert scene.given()["cloud"][0]["color"] == "red"
    assert "shadows" not in scene.given()
    # A keyword of every call: the samples of the picture.
    scene.update(samples=4)
    assert (scene.get("image.samples"), scene.get("method.samples")) == (4, 8)
    scene.update(shadows__resolution=256, shadows__samples=2)
    assert scene.given()["shadows"] == {"resolution": 256, "samples": 2}
    assert scene.shadows.fill == 1
    scene.update(shadows__resolution="auto", shadows__fill=2, shadows__occlusion="auto")
    assert scene.given()["shadows"] == {"resolution": "auto", "samples": 2, "fill": 2, "occlusion": "auto"}
    scene.set("method.samples", 16.0)
    assert scene.get("method.samples") == scene.method.samples == 16


def test_keys_that_are_not_there_are_key_errors(scene):
    for key in ("cloud.7.opacity", "cloud.-1.opacity", "clip.0.slab", "nope", "resolution", "image.nope"):
        with pytest.raises(KeyError):
            scene.get(key)
    assert scene.get("clip") is None
    assert scene.get("cloud.*.opacity") == 0.25
    keys = "size, background, samples, sampling_error, color"
    with pytest.raises(AttributeError, match=rf"^\[image\] has no key 'nokey'; it has {keys}$"):
        del scene.image.nokey
    for key in ("shadows", "cloud.0.class", "cloud.*.radius", "clip"):
        scene.set(key, None)


def test_numbers_of_numpy_are_classes(scene):
    scene.update(classes=np.int64(2))
    other = pellucid.Scene(scene.clouds, opacity=0.25, method="stochastic", classes=[2.0])
    assert other.given() == scene.given()


def test_a_direction_is_kept(renderer, points):
    def picture(**settings):
        return pellucid.render(scene, size=SIZE, **settings).rgba

    scene = pellucid.Scene(pellucid.Cloud(points), method="circles")
    expected = picture(view="front", elevation=10.0)
    scene.update(view="front")
    scene.update(elevation=10.0)
    np.testing.assert_array_equal(picture(), expected)
    np.testing.assert_array_equal(pellucid.render(scene.copy(), size=SIZE).rgba, expected)
    np.testing.assert_array_equal(picture(elevation=10.0), expected)
    scene.update(view="front")
    assert np.abs(picture() - expected).max() > 0.0
    np.testing.assert_array_equal(picture(elevation=10.0), expected)
    # A place of the camera is newer than the view.
    scene.camera.eye = (0.0, -20.0, 3.0)
    placed = picture()
    fresh = pellucid.Scene(scene.clouds, method="circles", camera={"eye": (0.0, -20.0, 3.0)})
    np.testing.assert_array_equal(pellucid.render(fresh, size=SIZE).rgba, placed)


def test_a_place_wins_over_the_view_in_a_frame(renderer, points):
    scene = pellucid.Scene(pellucid.Cloud(points), size=SIZE, method="circles", view="top")
    places = ({"camera": {"eye": (0, -9, 1), "target": (0, 0, 0)}}, {"eye": (0.0, -20.0, 3.0)}, {"camera__target": (1, 1, 0)})
    with renderer.load(points, size=SIZE, method="circles", view="top") as loaded:
        for place in places:
            np.testing.assert_array_equal(loaded.frame(**place).rgba, pellucid.render(scene, **place).rgba)
        np.testing.assert_array_equal(loaded.frame(fov_y=30).rgba, pellucid.render(scene, fov_y=30).rgba)


def test_a_scene_that_was_loaded_has_its_seed(renderer, points):
    stochastic = {"size": SIZE, "opacity": 0.3, "method": "stochastic", "method__samples": 4}
    with renderer.load(points, seed=3, **stochastic) as loaded:
        assert loaded.scene.seed == 3
        np.testing.assert_array_equal(pellucid.render(loaded.scene).rgba, loaded.frame().rgba)


def test_a_text_has_neither_view_nor_seed(points):
    scene = pellucid.Scene(pellucid.Cloud(points), view="top")
    scene.seed = 3
    again = pellucid.Scene.from_toml(scene.to_toml(), clouds=scene.clouds)
    assert again.given() == {**scene.given(), "image": {"background": "auto"}}
    assert (again.seed, again._direction) == (0, {})


def test_exclusions_of_points_add_up(renderer, points):
    """The docstrings of `Scene.update` and `Loaded.frame` promise it."""
    cloud = pellucid.Cloud(points, classification=np.arange(500) % 2)
    scene = pellucid.Scene(cloud, size=SIZE, method="circles")
    whole = pellucid.render(scene).rgba
    scene.update(classes=[0], slices={"z": (0, None)})
    with renderer.load(scene) as loaded:
        assert loaded.frame(slices={"x": (0, None)}).rgba.any()
        for none in ({"classes": [1]}, {"without": [0]}, {"slices": {"z": (None, -0.1)}}):
            with pytest.raises(pellucid.SceneError, match="no point remains"):
                loaded.frame(**none)
    scene.update(classes=[1], slices={"x": (0, None)})
    assert len(scene.clip) == 2
    with pytest.raises(pellucid.SceneError, match="no point remains"):
        pellucid.render(scene)
    scene.clip = []
    scene.set("cloud.*.class", None)
    np.testing.assert_array_equal(pellucid.render(scene).rgba, whole)


def test_a_size_is_the_picture_s(renderer, points):
    """`render` does so, too, though methods have a size as well: a factor on radii."""
    cloud = pellucid.Cloud(points)
    scene = pellucid.Scene(cloud, size=(48, 36), method="squares")
    assert scene.given()["image"] == {"size": [48, 36]}
    assert scene.given()["method"] == {"name": "squares"}
    assert "size = [48, 36]" in scene.to_toml()
    assert pellucid.render(scene).shape == (36, 48, 4)
    scene.update(size=np.array([40, 30]), method__size=2.0)
    assert scene.get("size") == scene.image.size == [40, 30]
    assert scene.method.size == 2.0
    large = pellucid.render(scene)
    assert large.size == np.size(large) == (40, 30)
    small = pellucid.render(scene, method={"size": 0.5})
    assert small.size == (40, 30)
    assert small.rgba[..., 3].mean() < 0.5 * large.rgba[..., 3].mean()
    with renderer.load(cloud, size=(48, 36), method="squares") as loaded:
        assert loaded.frame().size == (48, 36)
        np.testing.assert_array_equal(loaded.frame(size=(40, 30), method__size=2.0).rgba, large.rgba)
    for wrong in (64, (64, 48.5), (1, 2, 3), "64x48"):
        with pytest.raises(ValueError, match=r"^size: expected \(width, height\), whole numbers from 1 to 16384, found "):
            scene.update(size=wrong)
    with pytest.raises(pellucid.SceneError, match=r"^size=\(0, 30\): `image\.size` "):
        scene.update(size=(0, 30))
    assert scene.image.size == [40, 30]


def test_a_camera_may_be_a_scene_s(renderer, scene):
    camera = pellucid.Camera.look_at((0, -9, 1), (0, 0, 0), up=(0, 0, 1), fov_y=30)
    expected = pellucid.render(scene, size=SIZE, camera=camera).rgba
    scene.update(size=SIZE, view="top", near=0.5)
    scene.update(camera=camera)
    assert scene.given()["camera"] == {"eye": [0, -9, 1], "target": [0, 0, 0], "up": [0, 0, 1], "fov_y": 30}
    np.testing.assert_array_equal(pellucid.render(scene).rgba, expected)
    scene.update(camera={"fov_y": 40.0})
    assert scene.camera.eye == [0, -9, 1]
    assert scene.camera.fov_y == 40
    scene.camera = camera
    np.testing.assert_array_equal(pellucid.render(scene).rgba, expected)
    scene.camera = None
    assert "camera" not in scene.given()
    direct = pellucid.Scene(scene.clouds, camera=camera, opacity=0.25, method="stochastic", size=SIZE)
    np.testing.assert_array_equal(pellucid.render(direct).rgba, expected)
    with pytest.raises(TypeError, match=r"^camera: expected a Camera or a dict of keys of \[camera\], found tuple$"):
        scene.update(camera=(0, 0, 5))


def test_a_copy_changes_by_itself(scene):
    for other in (scene.copy(), copy.copy(scene), copy.deepcopy(scene), copy.deepcopy([scene])[0]):
        other.method.samples = 4
        assert scene.method.samples == 64
    cloud = pellucid.Cloud(np.eye(3), name="corner", opacity=0.5)
    for same in (copy.copy(cloud), copy.deepcopy(cloud)):
        same.opacity = 1.0
        assert (len(same), same.name, cloud.opacity) == (3, "corner", 0.5)


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
    with pytest.raises(pellucid.ReadError, match="a pipe or a device"):
        pellucid.Cloud.read("/dev/null")


def test_a_damaged_file_is_no_crash(renderer):
    for name in ("corrupt_crc.e57", "laszip_broken_coder.laz", "no-points.las", "no_vertex.ply"):
        with pytest.raises(pellucid.ReadError, match=name.replace(".", r"\.")):
            pellucid.Cloud.read(DATA / "nasty" / name)
