"""Objects of other packages mean what the readers of their files make of the same columns."""

import re
import warnings
from collections.abc import Collection
from pathlib import Path

import laspy
import numpy as np
import open3d as o3d
import pandas as pd
import plyfile
import pytest
import pyvista as pv

import pellucid
from pellucid import Cloud

DATA = Path(__file__).parents[2] / "tests" / "data"
SIZE = (96, 72)

LAS = [
    "formats/1.2-with-color.las",
    "formats/las14_test1_4.las",
    "formats/las_extrabytes.las",
    "formats/laz_pointwise_nochunk.laz",
    "lidar/sample_c_2k.las",
    "nasty/100-points.las",
    "nasty/crop_duplicate.laz",
    "nasty/pdalfail_0643_6319.laz",
    "nasty/single_point.laz",
    "nasty/spurious.las",
    "nasty/unregistered_extra_bytes.las",
]
PLY = [
    "formats/simple_binary_le.ply",
    "indoor/livingroom_fragment_2k.ply",
    "models/turbine_blade_6k.ply",
    "nasty/example_with_invalid_comments_little_endian.ply",
    "nasty/issue_2421.ply",
    "splats/soup.ply",
    "splats/soup.compressed.ply",
]


def assert_same(found: Cloud, expected: Cloud, *, but: Collection[str] = ()) -> None:
    """Every column that the file's reader has is there, to the bit; `found` may have more scalars, and lack some."""
    np.testing.assert_array_equal(found.points, expected.points)
    for name in ("colors", "classification", "intensity"):
        own, read = getattr(found, name), getattr(expected, name)
        assert (own is None) == (read is None), name
        if read is not None:
            np.testing.assert_array_equal(own, read, err_msg=name)
    for name, values in ((name, values) for name, values in expected.scalars.items() if name not in but):
        np.testing.assert_array_equal(found.scalars[name], values, err_msg=name)


def assert_same_picture(found: object, path: Path, **settings: object) -> None:
    """The bytes of the picture of the file."""
    own = pellucid.render(found, size=SIZE, **settings)
    read = pellucid.render(path, size=SIZE, **settings)
    np.testing.assert_array_equal(own.rgba, read.rgba)
    np.testing.assert_array_equal(own.depth, read.depth)
    np.testing.assert_array_equal(own.to_srgb(), read.to_srgb())
    assert own.rgba[..., 3].any(), "an empty picture says nothing"


@pytest.mark.parametrize("name", LAS)
def test_laspy_columns(name: str) -> None:
    las = laspy.read(DATA / name)
    found, expected = Cloud.from_any(las), Cloud.read(DATA / name)
    # laspy takes the extra bytes that the first record describes.
    records = sum(type(record).__name__ == "ExtraBytesVlr" for record in las.vlrs)
    assert_same(found, expected, but=expected.scalars.keys() - found.scalars.keys() if records > 1 else ())


def test_laspy_leaves_out_what_files_leave_out(tmp_path: Path) -> None:
    las = laspy.create(point_format=6, file_version="1.4")
    las.add_extra_dim(
        laspy.ExtraBytesParams("hag", "int16", scales=np.array([0.01]), offsets=np.array([0.0]), no_data=np.array([-9999]))
    )
    las.x, las.y, las.z = np.arange(12.0).reshape(3, 4)
    las.withheld = [0, 1, 0, 0]
    las.points.array["hag"] = [150, 7, -9999, 250]
    las.write(tmp_path / "a.las")
    with pytest.warns(pellucid.PellucidWarning, match="withheld"):
        read = Cloud.read(tmp_path / "a.las")
    for cloud in (Cloud.from_any(laspy.read(tmp_path / "a.las")), read):
        np.testing.assert_array_equal(cloud.points[:, 0], [0, 2, 3])
        np.testing.assert_array_equal(cloud.scalars["hag"], np.array([1.5, np.nan, 2.5], np.float32))


@pytest.mark.parametrize(
    "settings", [{}, {"opacity": 0.3, "color_by": "intensity"}, {"color_by": "gps-time"}, {"color_by": "return"}]
)
def test_laspy_picture(settings: dict[str, object]) -> None:
    path = DATA / "formats/1.2-with-color.las"
    assert_same_picture(laspy.read(path), path, **settings)


def test_laspy_picture_by_class() -> None:
    path = DATA / "lidar/sample_c_2k.las"
    classes = {"cloud.0.class": [{"id": "ground", "opacity": 0.2}, {"id": 6, "visible": False}]}
    assert_same_picture(laspy.read(path), path, color_by="classification", **classes)


def test_laspy_selection_is_a_cloud() -> None:
    las = laspy.read(DATA / "lidar/sample_c_2k.las")
    ground = las[np.asarray(las.classification) == 2]
    assert len(Cloud.from_any(ground)) == len(ground.points) < len(las.points)
    assert len(Cloud.from_any(ground.points)) == len(ground.points)


def test_laspy_eight_bits_in_sixteen() -> None:
    las = laspy.create(point_format=2, file_version="1.2")
    las.x, las.y, las.z = np.arange(9.0).reshape(3, 3)
    las.red, las.green, las.blue = [255, 0, 51], [0, 128, 0], [0, 0, 255]
    eight = Cloud.from_any(las)
    las.red = [5000, 0, 51]
    sixteen = Cloud.from_any(las)
    assert eight.colors is not None
    assert sixteen.colors is not None
    assert eight.colors[0, 0] == 1
    assert sixteen.colors[0, 0] < 0.01
    las.red[:] = las.green[:] = las.blue[:] = 0
    assert Cloud.from_any(las).colors is None


def test_open3d_legacy() -> None:
    path = DATA / "indoor/livingroom_fragment_2k.ply"
    cloud = o3d.io.read_point_cloud(str(path))
    assert_same(Cloud.from_any(cloud), Cloud.read(path))
    assert_same_picture(cloud, path, opacity=0.4)


def test_open3d_normals() -> None:
    path = DATA / "models/turbine_blade_6k.ply"
    assert_same_picture(o3d.io.read_point_cloud(str(path)), path, shading__model="lambert")


def test_open3d_has_the_color_of_every_byte() -> None:
    """float64 of Open3D and bytes of a file become the same linear float32."""
    bytes_ = np.stack([np.arange(256)] * 3, axis=1).astype(np.uint8)
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(np.arange(768.0).reshape(256, 3)))
    cloud.colors = o3d.utility.Vector3dVector(bytes_ / 255.0)
    np.testing.assert_array_equal(Cloud.from_any(cloud).colors, Cloud(np.asarray(cloud.points), colors=bytes_).colors)


def test_open3d_tensor() -> None:
    path = DATA / "indoor/livingroom_fragment_2k.ply"
    cloud = o3d.t.io.read_point_cloud(str(path))
    assert_same(Cloud.from_any(cloud), Cloud.read(path))
    assert_same_picture(cloud, path, opacity=0.4)


def test_open3d_tensor_of_a_pcd_file() -> None:
    path = DATA / "indoor/redwood_fragment_1k.pcd"
    assert_same(Cloud.from_any(o3d.t.io.read_point_cloud(str(path))), Cloud.read(path))


def test_open3d_tensor_attributes() -> None:
    points = np.random.default_rng(1).random((5, 3))
    cloud = o3d.t.geometry.PointCloud(o3d.core.Tensor(points))
    cloud.point["intensity"] = o3d.core.Tensor(np.arange(5.0)[:, None])
    cloud.point["label"] = o3d.core.Tensor(np.array([1, 2, 6, 6, 9], dtype=np.int32))
    cloud.point["flow"] = o3d.core.Tensor(np.arange(10.0).reshape(5, 2))
    found = Cloud.from_any(cloud)
    np.testing.assert_array_equal(found.intensity, np.arange(5.0))
    np.testing.assert_array_equal(found.classification, [1, 2, 6, 6, 9])
    np.testing.assert_array_equal(found.scalars["flow_1"], [1, 3, 5, 7, 9])


def test_open3d_tensor_of_splats() -> None:
    path = DATA / "splats/soup.ply"
    own = pellucid.render(o3d.t.io.read_point_cloud(str(path)), size=SIZE)
    read = pellucid.render(path, size=SIZE)
    assert read.rgba[..., 3].any()
    # Open3D holds extents as float32, and has their logarithms no more.
    np.testing.assert_allclose(own.rgba, read.rgba, atol=1e-5)


def test_pyvista_normals() -> None:
    path = DATA / "models/turbine_blade_6k.ply"
    mesh = pv.read(path)
    assert_same(Cloud.from_any(mesh), Cloud.read(path))
    assert_same_picture(mesh, path, opacity=0.5)


def test_pyvista_colors(tmp_path: Path) -> None:
    random = np.random.default_rng(2)
    kinds = [(axis, "f4") for axis in "xyz"] + [(channel, "u1") for channel in ("red", "green", "blue", "alpha")]
    rows = np.empty(500, dtype=kinds)
    for name, kind in kinds:
        rows[name] = random.random(500) if kind == "f4" else random.integers(0, 256, 500)
    path = tmp_path / "cloud.ply"
    plyfile.PlyData([plyfile.PlyElement.describe(rows, "vertex")]).write(path)
    mesh = pv.read(path)
    assert "RGBA" in mesh.point_data
    assert_same(Cloud.from_any(mesh), Cloud.read(path))
    assert_same_picture(mesh, path)


def test_pyvista_point_set_with_scalars() -> None:
    points = np.random.default_rng(3).random((20, 3))
    cloud = pv.PointSet(points)
    cloud["height above ground"] = points[:, 2]
    cloud["names"] = [str(at) for at in range(20)]
    found = Cloud.from_any(cloud)
    np.testing.assert_array_equal(found.scalars["height above ground"], points[:, 2].astype(np.float32))
    assert list(found.scalars) == ["height above ground"]
    image = pellucid.render(cloud, size=SIZE, color_by="height above ground")
    assert image.rgba[..., 3].any()


@pytest.mark.parametrize("name", PLY)
def test_plyfile(name: str) -> None:
    ply = plyfile.PlyData.read(DATA / name)
    assert_same(Cloud.from_any(ply), Cloud.read(DATA / name))
    assert_same_picture(ply, DATA / name)


@pytest.mark.parametrize("name", ["formats/5points_double_ascii.ply", "nasty/text_extradim.ply"])
def test_plyfile_of_text(name: str) -> None:
    """Plyfile makes float32 of what a file of text calls a float, and the reader of files float64."""
    found, read = Cloud.from_any(plyfile.PlyData.read(DATA / name)), Cloud.read(DATA / name)
    np.testing.assert_allclose(found.points, read.points, rtol=1e-6)
    assert list(found.scalars) == list(read.scalars)
    if read.colors is not None:
        np.testing.assert_array_equal(found.colors, read.colors)


def test_plyfile_of_the_other_byte_order(tmp_path: Path) -> None:
    ply = plyfile.PlyData.read(DATA / "models/turbine_blade_6k.ply")
    ply.byte_order = ">"
    ply.write(tmp_path / "big.ply")
    big = plyfile.PlyData.read(tmp_path / "big.ply")
    assert_same_picture(big, DATA / "models/turbine_blade_6k.ply")


TABLES = {
    "bytes": {"red": [0, 255, 7], "green": [1, 2, 3], "blue": [4, 5, 6]},
    "shorts": {"r": [0, 256, 7], "g": [1, 2, 3], "b": [4, 5, 65535]},
    "fractions": {"R": [0.0, 1.0, 0.3], "G": [0.1, 0.2, 0.7], "B": [0.4, 0.5, 0.6]},
    "linear": {"linear_red": [0.0, 1.0, 0.3], "linear_green": [0.1, 0.2, 0.7], "linear_blue": [0.4, 0.5, 0.6]},
    "black": {"red": [0, 0, 0], "green": [0, 0, 0], "blue": [0, 0, 0]},
    "alpha": {"a": [0.5, 1.0, 0.25]},
    "alpha of bytes": {"alpha": [0, 255, 100]},
    "classes": {"Class": [2, 6, 255], "i": [0.5, 100.0, -3.0], "radius": [0.5, 0.0, 0.25]},
    "no classes": {"label": [2.5, 6.0, 255.0], "weight": [1.0, 2.0, 4.0]},
    "normals": {"nx": [0.0, 2.0, 0.0], "ny": [0.0, 0.0, 3.0], "nz": [1.0, 0.0, 4.0]},
}


@pytest.mark.parametrize("table", TABLES.values(), ids=TABLES.keys())
def test_pandas(table: dict[str, list[float]], tmp_path: Path) -> None:
    frame = pd.DataFrame({"X": [0.0, 1.0, 0.5], "Y": [0.0, 1.0, 0.25], "Z": [0.0, 1.0, 2.0], **table})
    path = tmp_path / "cloud.csv"
    frame.to_csv(path, index=False)
    assert_same(Cloud.from_any(frame), Cloud.read(path))
    assert_same_picture(frame, path)


def test_pandas_with_missing_values_and_text() -> None:
    frame = pd.DataFrame(
        {
            "name": ["a", "b", "c"],
            "x": pd.array([1, 2, None], dtype="Int64"),
            "y": [1.0, 2.0, 3.0],
            "z": np.array([1, 2, 3], dtype=np.int16),
            "when": pd.to_datetime(["2020-01-01"] * 3),
        }
    )
    with pytest.warns(pellucid.PellucidWarning, match="1 points of the pandas.DataFrame are left out: a coordinate is not finite"):
        cloud = Cloud.from_any(frame)
    np.testing.assert_array_equal(cloud.points, [[1, 1, 1], [2, 2, 2]])
    assert not cloud.scalars


def test_pandas_splats() -> None:
    path = DATA / "splats/soup.ply"
    frame = pd.DataFrame(plyfile.PlyData.read(path)["vertex"].data)
    assert_same_picture(frame, path)


def test_objects_read_as_files_take_no_columns() -> None:
    path = DATA / "splats/soup.ply"
    ply = plyfile.PlyData.read(path)
    objects = {
        "plyfile.PlyData": ply,
        "pandas.DataFrame": pd.DataFrame(ply["vertex"].data),
        "open3d.t.geometry.PointCloud": o3d.t.io.read_point_cloud(str(path)),
    }
    for name, splats in objects.items():
        message = f"expected with an array of points; {name} is read as its file is, and takes no columns"
        with pytest.raises(TypeError, match=f"^z_up: {message}$"):
            Cloud.from_any(splats, z_up=True)
        with pytest.raises(TypeError, match=f"^opacities: {message}$"):
            pellucid.render(splats, opacities=np.ones(3), size=SIZE)


def test_lists_of_objects_are_one_scene() -> None:
    las, mesh = laspy.read(DATA / "lidar/sample_c_2k.las"), pv.read(DATA / "models/turbine_blade_6k.ply")
    both = pellucid.render([Cloud.from_any(las), Cloud.from_any(mesh)], size=SIZE)
    read = pellucid.render(
        [Cloud.read(DATA / "lidar/sample_c_2k.las"), Cloud.read(DATA / "models/turbine_blade_6k.ply")], size=SIZE
    )
    np.testing.assert_array_equal(both.rgba, read.rgba)


def test_points_that_are_not_finite_are_left_out() -> None:
    points = np.random.default_rng(4).random((10, 3))
    points[3, 1] = np.nan
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud.colors = o3d.utility.Vector3dVector(np.full((10, 3), 0.5))
    with pytest.warns(pellucid.PellucidWarning, match="1 points of the open3d.geometry.PointCloud are left out") as warned:
        found = Cloud.from_any(cloud)
    assert warned[0].filename == __file__
    assert len(found) == 9
    assert found.colors is not None
    assert len(found.colors) == 9


def test_numbers_that_overflow_are_infinite_as_those_of_files(tmp_path: Path) -> None:
    frame = pd.DataFrame({"x": [0.0, 1.0], "y": [0.0, 1.0], "z": [0.0, 1.0], "weight": [1.0, 1e300]})
    path = tmp_path / "cloud.csv"
    frame.to_csv(path, index=False)
    assert_same(Cloud.from_any(frame), Cloud.read(path))


def test_objects_have_the_name_of_their_kind() -> None:
    assert Cloud.from_any(plyfile.PlyData.read(DATA / "models/turbine_blade_6k.ply")).name == "plyfile.PlyData"
    assert Cloud.from_any(pd.DataFrame({"x": [0.0], "y": [0.0], "z": [0.0]})).name == "pandas.DataFrame"


def test_whole_objects_give_no_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Cloud.from_any(laspy.read(DATA / "formats/las14_test1_4.las"))


BAD = {
    "data frame without z": (
        lambda: pd.DataFrame({"x": [1.0], "y": [2.0], "height": [3.0]}),
        "points: pandas.DataFrame has no column of numbers 'z', only [x, y, height]; rename some",
    ),
    "data frame of text": (
        lambda: pd.DataFrame({"x": ["1"], "y": [2.0], "z": [3.0]}),
        "points: pandas.DataFrame has no numbers in 'x'; if they are texts of numbers: frame.astype({'x': float, …})",
    ),
    "tensor without positions": (
        lambda: o3d.t.geometry.PointCloud(),
        "points: open3d.t.geometry.PointCloud has no attribute 'positions'",
    ),
    "PLY without vertices": (
        lambda: plyfile.PlyData([plyfile.PlyElement.describe(np.zeros(1, dtype=[("x", "f4")]), "face")]),
        "points: plyfile.PlyData has no element 'vertex', only ['face']",
    ),
    "PLY without z": (
        lambda: plyfile.PlyData([plyfile.PlyElement.describe(np.zeros(1, dtype=[("x", "f4"), ("y", "f4")]), "vertex")]),
        "points: plyfile.PlyData: as PLY: element `vertex` has no property `z`, only [x, y]",
    ),
}


@pytest.mark.parametrize(("make", "message"), BAD.values(), ids=BAD.keys())
def test_objects_without_points_are_refused(make: object, message: str) -> None:
    with pytest.raises(ValueError, match="^" + re.escape(message)):
        Cloud.from_any(make())  # type: ignore[operator]


@pytest.mark.parametrize(
    "empty",
    [o3d.geometry.PointCloud(), pv.PolyData(), pd.DataFrame({"x": [], "y": [], "z": []}, dtype=float)],
    ids=["open3d", "pyvista", "pandas"],
)
def test_empty_objects_are_refused(empty: object) -> None:
    with pytest.raises(ValueError, match=r"^points: expected at least one point, found an array of shape \(0, 3\)$"):
        pellucid.render(empty, size=SIZE)
