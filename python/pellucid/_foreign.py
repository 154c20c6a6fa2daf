"""Point clouds of other packages, recognized by the module of their class; none of these packages is imported here.

An array means what the file readers take the same column for (docs/formats.md), so that the picture of an object has the bytes of
the picture of its file.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _table

# Names of an array that holds colors as rows.
_COLORS = ("rgba", "rgb", "colors", "color")
_NORMALS = ("normals", "normal")
_ALPHAS = ("alpha", "diffuse_alpha")

# The parts of a file of Gaussian splats: `chunk` and `sh` are those of a packed one.
_PLY_ELEMENTS = ("vertex", "chunk", "sh")

# Gaussian splats as Open3D holds them, and the properties of the PLY file that it read.
_SPLATS = {"f_dc": "f_dc_", "scale": "scale_", "rot": "rot_"}


def columns(object: Any) -> Any:
    """Return the points of an object of laspy, Open3D, PyVista, plyfile or pandas.

    The result is a dict of arguments of `Cloud`; or a `Cloud`, for objects that a file reader takes as they are (PLY, Gaussian
    splats); or None for an object of none of these packages. Raises ValueError if the object has no points, or lacks a coordinate.
    """
    for kind in type(object).__mro__:
        package = kind.__module__.partition(".")[0]
        if package == "laspy" and hasattr(object, "point_format"):
            return _of_las(object)
        if package == "open3d" and kind.__name__ == "PointCloud":
            return _of_open3d_tensor(object) if hasattr(object, "point") else _of_open3d(object)
        if package == "pyvista" and hasattr(object, "point_data") and hasattr(object, "points"):
            return _of_pyvista(object)
        if package == "plyfile" and kind.__name__ == "PlyData":
            return _of_plyfile(object)
        if package == "pandas" and kind.__name__ == "DataFrame":
            return _of_pandas(object)
    return None


def _of_las(las: Any) -> dict[str, Any]:
    """Convert a `laspy.LasData`, or points of one: coordinates, colors, classes, intensity, returns, extra dimensions.

    Points that are marked as withheld are left out, as of files.
    """
    names = set(las.point_format.dimension_names)
    extra = list(las.point_format.extra_dimension_names)
    kept = np.asarray(las["withheld"]) == 0
    no_data = _no_data(las)

    def column(name: str, kind: Any) -> NDArray[Any]:
        values: NDArray[Any] = np.asarray(las[name])[kept].astype(kind)
        return values

    def extra_column(name: str) -> NDArray[np.float32]:
        values = column(name, np.float32)
        if name in no_data:
            values[np.asarray(las.points.array[name])[kept] == no_data[name]] = np.nan
        return values

    points = np.stack([np.asarray(axis, dtype=np.float64)[kept] for axis in (las.x, las.y, las.z)], axis=1)
    scalars = {
        name: column(name, np.float32) for name in ("return_number", "number_of_returns", "point_source_id") if name in names
    }
    if "gps_time" in names:
        scalars["gps_time"] = _since_first(column("gps_time", np.float64))
    # Arrays of several numbers are left out, as of files.
    scalars |= {name: extra_column(name) for name in extra if np.ndim(las[name]) == 1}
    colors = None
    if {"red", "green", "blue"} <= names:
        colors = _of_their_bits(np.stack([column(name, np.uint16) for name in ("red", "green", "blue")], axis=1))
    return _table.finish(
        _table.Parts(
            points=points,
            colors=colors,
            classification=column("classification", np.uint8),
            intensity=column("intensity", np.float32),
            scalars=scalars,
        ),
        what="laspy.LasData",
        z_up=True,
    )


def _no_data(las: Any) -> dict[str, Any]:
    """Return the stored numbers that mean "no value", by extra dimension. Points without their file have none."""
    records = [*getattr(las, "vlrs", ()), *(getattr(las, "evlrs", None) or ())]
    described = [one for record in records for one in getattr(record, "extra_bytes_structs", ())]
    with_numbers = [one for one in described if one.data_type != 0 and one.no_data is not None]
    return {one.format_name(): one.no_data[0] for one in with_numbers}


def _of_their_bits(rgb: NDArray[np.uint16]) -> NDArray[Any] | None:
    """Return the colors of LAS, which many writers store with fewer bits than 16; None if all are zero."""
    largest = rgb.max(initial=0)
    if largest == 0:
        return None
    full = _table.full_integer(largest)
    if full == 255:
        return np.minimum(rgb, 255).astype(np.uint8)
    return rgb if full == 65535 else rgb.astype(np.float32) / np.float32(full)


def _since_first(times: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return seconds since the first time, because a GPS time in float32 is off by seconds."""
    finite = times[np.isfinite(times)]
    return (times - finite.min() if finite.size else times).astype(np.float32)


def _of_open3d(cloud: Any) -> dict[str, Any]:
    """Convert an `open3d.geometry.PointCloud`: float64 arrays, colors from 0 to 1 and sRGB-encoded."""
    parts = _table.Parts(points=np.asarray(cloud.points, dtype=np.float64))
    if cloud.has_colors():
        parts.colors = np.asarray(cloud.colors)
    if cloud.has_normals():
        parts.normals = np.asarray(cloud.normals)
    return _table.finish(parts, what="open3d.geometry.PointCloud")


def _of_open3d_tensor(cloud: Any) -> Any:
    """Convert an `open3d.t.geometry.PointCloud`, on any device: every attribute by its name."""
    what = "open3d.t.geometry.PointCloud"
    arrays = {str(name): cloud.point[name].cpu().numpy() for name in cloud.point}
    points = arrays.pop("positions", None)
    if points is None:
        raise ValueError(f"points: {what} has no attribute 'positions'")
    if {"f_dc", "opacity", "scale", "rot"} <= arrays.keys():
        return _table.splats(_splat_columns(points, arrays), what=what)
    return _named_arrays(points, arrays, what)


def _splat_columns(points: NDArray[Any], arrays: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return Open3D splats as the columns of the file they came from, where all harmonics of red come first."""
    table = dict(zip("xyz", points.T, strict=True))
    for name, stem in _SPLATS.items():
        table |= {f"{stem}{at}": column for at, column in enumerate(np.atleast_2d(arrays[name].T))}
    # Open3D takes extents from their logarithms, and leaves all else as it was.
    with np.errstate(divide="ignore"):
        table |= {name: np.log(column, dtype=np.float64) for name, column in table.items() if name.startswith("scale_")}
    table["opacity"] = arrays["opacity"].reshape(len(points))
    if (rest := arrays.get("f_rest")) is not None:
        by_channel = rest.transpose(0, 2, 1).reshape(len(points), -1)
        table |= {f"f_rest_{at}": column for at, column in enumerate(by_channel.T)}
    return table


def _of_pyvista(mesh: Any) -> dict[str, Any]:
    """Convert a `pyvista.PolyData`, `PointSet` or other data set with points: arrays of `point_data` by their names."""
    arrays = {str(name): np.asarray(mesh.point_data[name]) for name in mesh.point_data}
    found: dict[str, Any] = _named_arrays(np.asarray(mesh.points), arrays, f"pyvista.{type(mesh).__name__}")
    return found


def _named_arrays(points: NDArray[Any], arrays: dict[str, NDArray[Any]], what: str) -> dict[str, Any]:
    """Convert points, and arrays with a row for each point, by their names."""
    arrays = {name: _flat(array) for name, array in arrays.items() if array.dtype.kind in "buif"}
    parts = _table.Parts(points=points)
    parts.colors, parts.alpha = _take_colors(arrays)
    if (alpha := _take(arrays, _ALPHAS, width=1)) is not None:
        parts.alpha = alpha
    parts.normals = _take(arrays, _NORMALS, width=3)
    table = dict(_single(arrays))
    return _table.finish(_table.assign(table, parts, measured=False), what=what)


def _flat(array: NDArray[Any]) -> NDArray[Any]:
    """Return a column of shape (n,) from one number for each point."""
    return array[:, 0] if array.ndim == 2 and array.shape[1] == 1 else array


def _take_colors(arrays: dict[str, NDArray[Any]]) -> tuple[NDArray[Any] | None, NDArray[Any] | None]:
    """Take the colors, and alphas if there are four numbers: by name, else the first rows of three or four bytes."""
    colors = _take(arrays, _COLORS, width=3)
    colors = _take(arrays, _COLORS, width=4) if colors is None else colors
    if colors is None:
        rows_of_bytes = (name for name, array in arrays.items() if array.dtype == np.uint8 and _width(array) in (3, 4))
        name = next(rows_of_bytes, None)
        colors = None if name is None else arrays.pop(name)
    if colors is None:
        return None, None
    return colors[:, :3], colors[:, 3] if colors.shape[1] == 4 else None


def _take(arrays: dict[str, NDArray[Any]], names: Iterable[str], *, width: int) -> NDArray[Any] | None:
    """Take the first array with one of the names, in any case, and this many numbers per point."""
    for wanted in names:
        for name, array in arrays.items():
            if name.lower() == wanted and _width(array) == width:
                return arrays.pop(name)
    return None


def _width(array: NDArray[Any]) -> int:
    """Return the number of values per point; 0 for an array that is no table."""
    if array.ndim == 1:
        return 1
    return int(array.shape[1]) if array.ndim == 2 else 0


def _single(arrays: Mapping[str, NDArray[Any]]) -> Iterable[tuple[str, NDArray[Any]]]:
    """Yield arrays of one number per point; those of several as one array each, `NAME_0` and so on."""
    for name, array in arrays.items():
        if array.ndim == 1:
            yield name, array
        elif array.ndim == 2:
            yield from ((f"{name}_{at}", column) for at, column in enumerate(array.T))


def _of_plyfile(ply: Any) -> Any:
    """Convert a `plyfile.PlyData` as the PLY reader reads its bytes, so splats and prepared clouds work, too."""
    names = [element.name for element in ply.elements]
    if "vertex" not in names:
        raise ValueError(f"points: plyfile.PlyData has no element 'vertex', only {names}")
    kept = [element for element in ply.elements if element.name in _PLY_ELEMENTS]
    # As text it would be slow, and in the other byte order, too.
    copy = type(ply)(kept, text=False, byte_order="=", comments=list(ply.comments))
    return _table.read(copy.write, what="plyfile.PlyData")


def _of_pandas(frame: Any) -> Any:
    """Convert a `pandas.DataFrame`: columns by name, as in a text file with a header, without those that hold no numbers."""
    table: dict[str, NDArray[Any]] = {}
    for at, name in enumerate(frame.columns):
        column = frame.iloc[:, at]
        kind = getattr(column.dtype, "numpy_dtype", column.dtype)
        if getattr(kind, "kind", "O") in "buif":
            text = str(name)
            table[f"{text}_{at}" if text in table else text] = _numbers(column)
    what = "pandas.DataFrame"
    missing = [name for name in "xyz" if name not in {known.lower() for known in table}]
    if missing:
        found = ", ".join(map(str, frame.columns))[:200]
        texts = [str(name) for name in frame.columns if str(name).lower() in missing]
        if len(texts) == len(missing):
            names = ", ".join(map(repr, texts))
            raise ValueError(
                f"points: {what} has no numbers in {names}; if they are texts of numbers: frame.astype({{{texts[0]!r}: float, …}})"
            )
        raise ValueError(
            f"points: {what} has no column of numbers {missing[0]!r}, only [{found}]; "
            "rename some, as in frame.rename(columns={'X': 'x', 'Y': 'y', 'Z': 'z'})"
        )
    if _table.are_splats(table):
        return _table.splats(table, what=what)
    short = {"a": "alpha", "i": "intensity"}
    table = {short.get(name.lower(), name): column for name, column in table.items()}
    return _table.finish(_table.assign(table, None, measured=True), what=what, z_up=True)


def _numbers(column: Any) -> NDArray[Any]:
    """Return the numbers of a column; missing ones are NaN."""
    if isinstance(column.dtype, np.dtype):
        return np.asarray(column)
    if column.isna().any():
        return np.asarray(column.to_numpy(dtype=np.float64, na_value=np.nan))
    return np.asarray(column.to_numpy(dtype=column.dtype.numpy_dtype))
