"""Pictures of arrays, and what they hold."""

from __future__ import annotations

import copy
import json
import math
import pickle
import types
import warnings

import numpy as np
import pytest
from conftest import DATA, SIZE

import pellucid
from pellucid._progress import listening
from pellucid._renderer import Sharing
from pellucid._settings import with_bytes

# Three discs of opacity 0.25 before one another, over the whole image.
LAYERS = np.array([[0.0, 0.0, z] for z in range(3)])
ABOVE = pellucid.Camera.orthographic((0, 0, 8), (0, 0, 0), 2.0, up=(0, 1, 0))


def layers(**arguments):
    return pellucid.render(LAYERS, color=[1.0, 1.0, 1.0], radii=[2.0] * 3, opacity=0.25, camera=ABOVE, size=(16, 12), **arguments)


def test_three_layers_let_through_what_they_should(renderer):
    image = layers(fragments=True, depths=True, method="abuffer")
    assert image.shape == (12, 16, 4)
    assert image.size == (16, 12)
    np.testing.assert_allclose(image.rgba[..., 3], 1.0 - 0.75**3, atol=1e-6)
    np.testing.assert_allclose(image.rgba[..., :3], 1.0 - 0.75**3, atol=1e-6)
    np.testing.assert_array_equal(image.fragments, 3)
    np.testing.assert_allclose(image.depth, 6.0, rtol=1e-6)
    # 0.75 and 0.5625 of the light are left behind two discs, and 0.42 behind the third, at depth 8.
    np.testing.assert_allclose(image.median_depth, 8.0, rtol=1e-6)
    weights = 0.25 * 0.75 ** np.arange(3)
    np.testing.assert_allclose(image.mean_depth, weights @ [6.0, 7.0, 8.0] / weights.sum(), rtol=1e-6)


def test_channels_that_were_not_requested_are_none(renderer):
    image = layers()
    assert image.fragments is None
    assert image.median_depth is None
    assert image.mean_depth is None
    assert image.layers is None
    assert image.stderr is None
    assert image.pixel_stderr is None


def test_a_picture_is_an_array(renderer):
    image = layers()
    array = np.asarray(image)
    assert array.dtype == np.float32
    assert array.base is not None, "a view"
    assert not array.flags.writeable
    assert np.shares_memory(array, image.rgba)
    copy = np.array(image)
    copy[:] = 0.0
    assert image.rgba.max() > 0.5
    assert np.asarray(image, dtype=np.float64).dtype == np.float64
    np.testing.assert_array_equal(np.add(image, 1.0), array + 1.0)


def test_a_picture_calculates_as_its_array(renderer):
    image = layers()
    array = np.asarray(image)
    for found, expected in (
        (image * 2, array * 2),
        (1 - image, 1 - array),
        (image - image, np.zeros_like(array)),
        (-image, -array),
        (np.arange(4) * image, np.arange(4) * array),
        (image == array, np.ones_like(array, dtype=bool)),
        (np.clip(image, 0.1, 0.2), np.clip(array, 0.1, 0.2)),
        (np.add.reduce(image, axis=2), array.sum(axis=2)),
        (image[0], array[0]),
        (image[..., 3], array[..., 3]),
        (image[image > 0.5], array[array > 0.5]),
        (np.stack(list(image)), array),
    ):
        assert type(found) is np.ndarray
        np.testing.assert_array_equal(found, expected)
    assert np.mean(image) == array.mean()
    assert (len(image), image.shape, image.ndim, image.dtype) == (12, (12, 16, 4), 3, np.float32)
    assert not image[0].flags.writeable
    written = np.zeros_like(array)
    np.multiply(image, 2, out=written)
    np.testing.assert_array_equal(written, array * 2)
    message = (
        r"^out: expected an array to write to, found an Image \(add\): images are read-only, and numpy\.array\(image\) is a copy"
    )
    with pytest.raises(TypeError, match=message):
        image += 1
    with pytest.raises(IndexError):
        image[12]
    assert len({image, image}) == 1


def test_a_picture_is_copied_and_not_pickled(renderer):
    image = layers()
    assert copy.copy(image) is image
    assert copy.deepcopy([image])[0] is image, "nothing of it can be changed"
    with pytest.raises(
        TypeError, match=r"^an Image can't be pickled: it holds more than arrays; numpy\.asarray\(image\) can be, and"
    ):
        pickle.dumps(image)


def test_a_frame_takes_keys_of_the_camera_and_no_columns(renderer, points):
    with renderer.load(points, opacity=0.3, size=SIZE) as loaded:
        keys = {"eye": [0.0, 0.0, 9.0], "target": [0.0, 0.0, 0.0], "up": [0.0, 1.0, 0.0]}
        image = loaded.frame(camera=keys)
        assert image.camera.eye == (0.0, 0.0, 9.0)
        np.testing.assert_array_equal(image.rgba, pellucid.render(points, opacity=0.3, size=SIZE, camera=keys).rgba)
        assert loaded.profile(camera=keys, frames=1).points == 500
        message = "^colors: expected at Renderer.load, which takes columns of points; a frame draws what was loaded$"
        with pytest.raises(TypeError, match=message):
            loaded.frame(colors=points)
        with pytest.raises(TypeError, match=r"^camera: expected a Camera or a dict of keys of \[camera\], found tuple$"):
            loaded.frame(camera=(0, 0, 9))


def test_a_camera_stands_for_all_of_the_view(points):
    camera = pellucid.Camera.look_at((0, 0, 9), (0, 0, 0), up=(0, 1, 0))
    for given in (camera, {"eye": [0, 0, 9], "target": [0, 0, 0]}):
        with pytest.raises(TypeError, match=r"^view: expected no camera beside it: both say from where"):
            pellucid.render(points, camera=given, view="top")


def test_bytes_of_memory_may_be_texts(renderer, points):
    expected = pellucid.render(points, opacity=0.3, size=SIZE).rgba
    for budget in ("1GiB", "512 MB", "1.5g", np.int64(2**30), 2**30):
        image = pellucid.render(points, opacity=0.3, size=SIZE, memory_budget=budget, host_memory=budget)
        np.testing.assert_array_equal(image.rgba, expected)
    with renderer.load(points, size=SIZE) as loaded:
        loaded.frame(memory_budget="1GiB")
    message = "^memory_budget: expected a number of bytes, or a text as '4GiB' or '500MB', found 'much'$"
    with pytest.raises(ValueError, match=message):
        pellucid.render(points, memory_budget="much")
    with pytest.raises(ValueError, match=r"^host_memory: expected at least \d+ bytes, found 1024$"):
        pellucid.render(DATA / "lidar/sample_c_2k.las", host_memory="1KiB")


@pytest.mark.parametrize(
    ("text", "bytes"), [("7", 7), ("7B", 7), ("2kB", 2000), ("2 KiB", 2048), ("0.5Mi", 2**19), ("1tib", 2**40)]
)
def test_texts_of_bytes_are_those_of_the_command_line(text, bytes):
    assert with_bytes({"memory_budget": text, "samples": 3}) == {"memory_budget": bytes, "samples": 3}


def test_a_device_is_an_index_or_a_text(renderer, points):
    index = next(device.index for device in pellucid.devices() if device.taken)
    for device in (index, np.int64(index), renderer.name):
        assert pellucid.render(points, size=SIZE, device=device).rgba.max() > 0.0
    for device, kind in (([0], "list"), (False, "bool"), (0.0, "float")):
        for call in (pellucid.Renderer, lambda device: pellucid.render(points, device=device)):
            with pytest.raises(TypeError, match=f"^device: expected an index or a part of a name, found {kind}$"):
                call(device)


@pytest.mark.parametrize("name", ["render", "profile", "plan", "tradeoff", "check", "stress"])
def test_a_device_that_failed_is_opened_anew(renderer, points, monkeypatch, name):
    def lost(*_):
        raise pellucid.DeviceError("lost")

    class Lost:
        """Stand-in for the native scene."""

        frame = profile = plan = tradeoff = lost
        method = lambda self: ("abuffer", "")  # noqa: E731
        close = lambda self: None  # noqa: E731

    monkeypatch.setattr("pellucid._renderer._pellucid.Loaded", lambda *_: Lost())
    monkeypatch.setattr("pellucid._renderer._open", {})
    monkeypatch.setattr("pellucid._api._pellucid.check", lost)
    monkeypatch.setattr("pellucid._api._pellucid.stress", lost)
    with Sharing(None) as first:
        pass
    with pytest.raises(pellucid.DeviceError, match="lost"):
        getattr(pellucid, name)(*([] if name in ("check", "stress") else [points]))
    with Sharing(None) as second:
        assert second is not first
    with Sharing(None) as third:
        assert third is second


def test_stochastic_pictures_know_their_error_and_their_seed(renderer, points):
    def image(**arguments):
        return pellucid.render(points, opacity=0.3, size=SIZE, method="stochastic", method__samples=16, **arguments)

    counted = image(fragments=True)
    assert 0.0 < counted.stderr < 1.0
    assert counted.pixel_stderr.shape == (48, 64, 3)
    rms = math.sqrt(float((counted.pixel_stderr.astype(np.float64) ** 2).mean()))
    assert counted.stderr == pytest.approx(rms, rel=1e-5)
    np.testing.assert_array_equal(image().rgba, image(seed=0).rgba)
    assert np.abs(image(seed=1).rgba - image(seed=2).rgba).max() > 0.01


def test_the_order_of_points_does_not_show(renderer, points):
    colors = np.random.default_rng(1).random((500, 3))
    order = np.random.default_rng(2).permutation(500)
    a = pellucid.render(points, colors=colors, opacity=0.3, size=SIZE)
    b = pellucid.render(points[order], colors=colors[order], opacity=0.3, size=SIZE)
    np.testing.assert_array_equal(a.rgba, b.rgba)


@pytest.mark.parametrize(
    "make",
    [
        lambda p: p.astype(np.float32),
        lambda p: np.asfortranarray(p),
        lambda p: np.repeat(p, 2, axis=0)[::2],
        lambda p: np.flip(np.flip(p, 0), 0),
        lambda p: np.concatenate([p, p], axis=1)[:, :3],
        lambda p: p.astype(p.dtype.newbyteorder(">")),
        lambda p: p.tolist(),
    ],
    ids=["float32", "fortran", "strided", "negative strides", "columns", "big-endian", "lists"],
)
def test_every_layout_is_the_same_cloud(renderer, points, make):
    points = points.astype(np.float32).astype(np.float64)
    plain = pellucid.render(points, opacity=0.3, size=SIZE)
    np.testing.assert_array_equal(pellucid.render(make(points), opacity=0.3, size=SIZE).rgba, plain.rgba)


def test_integers_are_coordinates_too(renderer):
    grid = np.stack(np.meshgrid(*[np.arange(4)] * 3), axis=-1).reshape(-1, 3)
    a = pellucid.render(grid, size=SIZE)
    np.testing.assert_array_equal(a.rgba, pellucid.render(grid.astype(float), size=SIZE).rgba)


def test_a_cloud_is_a_copy(points):
    given = points.copy()
    cloud = pellucid.Cloud(given, scalars={"h": given[:, 2]}, radii=np.full(500, 0.1))
    given[:] = 0.0
    np.testing.assert_array_equal(cloud.points, points)
    np.testing.assert_array_equal(cloud.scalars["h"], points[:, 2].astype(np.float32))
    cloud.points[:] = 0.0
    np.testing.assert_array_equal(cloud.bounds, [points.min(0), points.max(0)])
    assert len(cloud) == 500


def test_colors_are_srgb_where_they_are_integers(points):
    bytes = np.random.default_rng(1).integers(0, 256, (500, 3), dtype=np.uint8)
    encoded = bytes / 255.0
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(pellucid.Cloud(points, colors=bytes).colors, linear, atol=1e-6)
    shorts = bytes.astype(np.uint16) * 257
    np.testing.assert_allclose(pellucid.Cloud(points, colors=shorts).colors, linear, atol=1e-6)
    srgb = pellucid.Cloud(points, colors=encoded, color_space="srgb")
    np.testing.assert_array_equal(srgb.colors, pellucid.Cloud(points, colors=bytes).colors)
    np.testing.assert_allclose(pellucid.Cloud(points, colors=linear).colors, linear, atol=1e-7)


def test_columns_come_back_as_they_were_given(points):
    normals = np.random.default_rng(4).normal(size=(500, 3))
    classes = np.arange(500) % 20
    cloud = pellucid.Cloud(
        points,
        opacities=np.full(500, 51, dtype=np.uint8),
        radii=np.linspace(0, 1, 500),
        normals=normals,
        classification=classes,
        intensity=np.arange(500),
        z_up=True,
        name="ball",
    )
    np.testing.assert_allclose(cloud.opacities, 0.2, rtol=1e-6)
    np.testing.assert_array_equal(cloud.radii, np.linspace(0, 1, 500).astype(np.float32))
    unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(cloud.normals, unit, atol=1e-6)
    np.testing.assert_array_equal(cloud.classification, classes)
    np.testing.assert_array_equal(cloud.intensity, np.arange(500))
    assert cloud.z_up
    assert "ball" in repr(cloud)
    assert "500 points" in repr(cloud)
    assert pellucid.Cloud(points).colors is None
    assert pellucid.Cloud(points, normals=np.zeros((500, 3))).normals is None


def test_classes_can_be_seen_through_and_left_out(renderer):
    points = np.array([[x, 0.0, 0.0] for x in (-1.0, 0.0, 1.0)])
    camera = pellucid.Camera.orthographic((0, 0, 8), (0, 0, 0), 2.0, up=(0, 1, 0))
    classes = [2, 5, 6]

    def alphas(**arguments):
        image = pellucid.render(
            points, classification=classes, radii=[0.2] * 3, camera=camera, size=(40, 20), method="abuffer", **arguments
        )
        return [round(float(image.rgba[10, column, 3]), 5) for column in (10, 20, 30)]

    assert alphas() == [1.0, 1.0, 1.0]
    assert alphas(class_opacity={"high-vegetation": 0.25}) == [1.0, 0.25, 1.0]
    assert alphas(class_opacity={2: 0.5, "6": 0.75}) == [0.5, 1.0, 0.75]
    assert alphas(without=["ground"]) == [0.0, 1.0, 1.0]
    assert alphas(classes=[2, "building"]) == [1.0, 0.0, 1.0]
    assert alphas(slices={"x": (-0.5, None)}) == [0.0, 1.0, 1.0]
    assert alphas(clip=[{"box": {"min": [-2, -1, -1], "max": [0.5, 1, 1]}}]) == [1.0, 1.0, 0.0]
    assert alphas(cloud={"opacity": 0.5}) == [0.5, 0.5, 0.5]
    assert alphas(**{"cloud.0.opacity": 0.5}) == [0.5, 0.5, 0.5]
    assert alphas(cloud__0__opacity=0.5) == [0.5, 0.5, 0.5]


def test_several_clouds_have_settings_of_their_own(renderer):
    a = pellucid.Cloud([[-1.0, 0.0, 0.0]], radii=[0.2], opacity=0.5, name="a")
    b = pellucid.Cloud([[1.0, 0.0, 0.0]], radii=[0.2], name="b")
    camera = pellucid.Camera.orthographic((0, 0, 8), (0, 0, 0), 2.0, up=(0, 1, 0))
    image = pellucid.render([a, b], camera=camera, size=(40, 20), method="abuffer")
    assert [float(image.rgba[10, column, 3]) for column in (10, 30)] == [0.5, 1.0]


def test_see_through_finds_an_opacity(renderer, points):
    image = pellucid.render(points, radius=0.4, see_through=0.5, size=SIZE)
    alpha = image.rgba[..., 3]
    assert np.median(1.0 - alpha[alpha > 0.0]) == pytest.approx(0.5, abs=0.01)
    assert "pellucid:see-through" in image.metadata


def test_a_budget_of_error_chooses_a_method(renderer, points):
    exact = pellucid.render(points, radius=0.4, opacity=0.3, size=SIZE, method="abuffer")
    chosen = pellucid.render(points, radius=0.4, opacity=0.3, size=SIZE, max_error=0.02)
    assert "pellucid:choice" in chosen.metadata
    assert pellucid.compare(exact, chosen).rmse <= 0.02


def test_against_the_area_the_samples_are_chosen_too(renderer, points):
    scene = {"radius": 0.4, "opacity": 0.3, "size": SIZE}
    area, four, one = (pellucid.render(points, method="abuffer", samples=n, **scene) for n in (64, 4, 1))
    least = pellucid.compare(area, four).rmse
    assert least < pellucid.compare(area, one).rmse
    chosen = pellucid.render(points, max_error=1.01 * least, against="area", **scene)
    choice = json.loads(chosen.metadata["pellucid:choice"])
    assert choice["against"] == "area"
    assert 1 < choice["samples"] <= 4
    assert pellucid.compare(area, chosen).rmse <= 1.01 * least
    with pytest.raises(ValueError, match="against: expected 'center' or 'area', found 'edge'"):
        pellucid.render(points, max_error=0.1, against="edge", **scene)


def test_settings_without_effect_are_warned_of(renderer, points):
    with pytest.warns(pellucid.PellucidWarning, match=r"samples|method\.samples") as caught:
        pellucid.render(points, method__samples=4, method="abuffer", size=SIZE)
    assert caught[0].filename == __file__, "the warning is about the line that called"
    away = pellucid.Camera.look_at((0, 0, 100), (0, 0, 200), up=(0, 1, 0))
    with pytest.warns(pellucid.PellucidWarning, match="sees nothing|empty"):
        pellucid.render(points, camera=away, size=SIZE)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pellucid.render(points, size=SIZE)


def test_a_bar_follows_the_work(renderer, points):
    class Bar:
        def __init__(self, total=None, desc=None):
            self.total, self.desc, self.done, self.closed = total, desc, 0, False
            bars.append(self)

        def update(self, steps):
            self.done += steps

        def close(self):
            self.closed = True

    bars: list[Bar] = []
    many = np.random.default_rng(0).normal(size=(200_000, 3))
    pellucid.render(many, opacity=0.1, size=(256, 256), method="abuffer", progress=Bar)
    assert any(bar.done > 0 for bar in bars)
    assert all(bar.total is None or bar.done <= bar.total for bar in bars)
    assert all(bar.closed for bar in bars)
    assert all(bar.desc for bar in bars)
    full = [bar.done == bar.total for bar in bars if bar.total is not None]
    assert full
    assert all(full), "of work that succeeded"
    import tqdm

    pellucid.render(points, size=SIZE, progress=tqdm.tqdm)
    pellucid.render(points, size=SIZE, progress=True)


def test_bars_are_full_where_work_succeeded():
    bars = []

    def make(total, desc):
        bars.append(types.SimpleNamespace(total=total, n=0, close=lambda: None))
        bars[-1].update = lambda steps, bar=bars[-1]: setattr(bar, "n", bar.n + steps)
        return bars[-1]

    with listening(make) as listener:
        listener("reading", 0, 7)
        listener("choosing", 0, None)
        listener("rendering", 3, 9)
    assert [(bar.n, bar.total) for bar in bars] == [(7, 7), (0, None), (9, 9)]

    def fail():
        with listening(make) as listener:
            listener("reading", 2, 7)
            raise RuntimeError("no")

    with pytest.raises(RuntimeError, match="no"):
        fail()
    assert bars[-1].n == 2


def test_a_bar_that_fails_ends_the_work(renderer):
    def broken(total=None, desc=None):
        raise RuntimeError("no bar today")

    many = np.random.default_rng(0).normal(size=(400_000, 3))
    with pytest.raises(RuntimeError, match="no bar today"):
        pellucid.render(many, opacity=0.1, size=(512, 512), method="abuffer", progress=broken)
    image = pellucid.render(many[:1000], opacity=0.1, size=SIZE)
    assert image.rgba.max() > 0.0, "the device goes on"


def test_a_picture_shows_itself_in_a_notebook(renderer):
    image = layers()
    png = image._repr_png_()
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    assert png == image.to_png()
    assert "16 × 12" in repr(image)
    assert image.method in repr(image)


def test_a_profile_comes_with_each_picture(renderer):
    profile = layers(method="abuffer").profile
    names = [of.name for of in profile.frames[0].passes]
    assert "abuffer/count" in names
    assert profile.gpu_ms > 0.0
    assert profile.wall_ms > 0.0
    assert profile.points == 3
    assert profile.pixels == 16 * 12


@pytest.mark.filterwarnings("ignore::pellucid.PellucidWarning")
def test_frames_do_not_follow_from_those_before(renderer, points):
    """Each frame after others is that of a scene that was loaded for it alone."""
    asked = [
        {},
        {"color_by": "height", "image__color": "encoded"},
        {"color_by": "height"},
        {"method": "spbr", "seed": 3},
        {"method": "spbr"},
        {"method": "splats"},
        {"see_through": 0.5},
        {"see_through": 0.5, "opacity_factor": 0.1},
        {"method": "abuffer", "background": "white"},
        {},
    ]
    with renderer.load(points, size=SIZE, opacity=0.3) as loaded:
        found = [np.array(loaded.frame(**one)) for one in asked]
    for one, image in zip(asked, found, strict=True):
        with renderer.load(points, size=SIZE, opacity=0.3) as fresh:
            np.testing.assert_array_equal(image, np.asarray(fresh.frame(**one)), err_msg=str(one))


def test_frames_of_a_store_that_stays_on_the_disk_are_shaded_as_they_ask(renderer, cli, tmp_path):
    points = np.random.default_rng(5).normal(size=(60_000, 3))
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    header += "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz")) + "end_header\n"
    rows = np.concatenate([points, normals], axis=1).astype("<f4")
    (tmp_path / "many.ply").write_bytes(header.encode() + rows.tobytes())
    cli("prepare", "many.ply", "-o", "store/")

    def load(**shading):
        return renderer.load(tmp_path / "store", size=SIZE, host_memory="1MiB", **shading)

    phong = {"shading__model": "phong", "specular": 1.0}
    with load(shading__model="lambert") as loaded, load(**phong) as fresh:
        first, then = np.array(loaded.frame()), np.array(loaded.frame(**phong))
        assert not np.array_equal(first, then)
        np.testing.assert_array_equal(then, np.asarray(fresh.frame()))


def test_splats_stay_splats_after_a_method_that_has_none(renderer):
    with renderer.load(pellucid.Scene.read(DATA / "splats" / "soup.ply"), size=SIZE) as loaded:
        first = np.array(loaded.frame())
        assert not np.array_equal(first, loaded.frame(method="hqs"))
        np.testing.assert_array_equal(first, np.asarray(loaded.frame()))


def test_see_through_takes_a_factor(renderer, points):
    with renderer.load(points, size=SIZE, radius=0.05) as loaded:
        metadata = dict(loaded.frame(see_through=0.5).metadata)
        factor = json.loads(metadata["pellucid:see-through"])["factor"]
        both = np.array(loaded.frame(see_through=0.5, opacity_factor=0.1))
        np.testing.assert_allclose(both, np.asarray(loaded.frame(opacity_factor=0.1 * factor)), rtol=1e-5, atol=1e-7)


def test_a_frame_after_an_interrupted_one_is_its_own(renderer, points):
    class StopError(Exception):
        pass

    def stop(**_):
        raise StopError

    away = pellucid.Camera.look_at((0, 0, 30), (0, 0, 0), up=(0, 1, 0))
    with renderer.load(points, size=SIZE, opacity=0.3) as loaded:
        first = np.array(loaded.frame())
        with pytest.raises(StopError):
            loaded.frame(camera=away, see_through=0.5, progress=stop)
        np.testing.assert_array_equal(first, np.asarray(loaded.frame()))
