"""Columns of other packages as arguments of `Cloud`, by the names, types and ranges that readers know (docs/formats.md)."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ._errors import ReadError, tell

_POSITION = (("x", "y", "z"),)
_NORMAL = (("nx", "ny", "nz"), ("normal_x", "normal_y", "normal_z"), ("normalx", "normaly", "normalz"))
_LINEAR_COLOR = (("linear_red", "linear_green", "linear_blue"),)
_COLOR = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"), ("r", "g", "b"))
_ALPHA = ("alpha", "diffuse_alpha")
_RADIUS = ("radius",)
_CLASSIFICATION = ("classification", "scalar_classification", "class", "scalar_class", "label", "scalar_label")
_INTENSITY = ("intensity", "scalar_intensity")

# Columns that make a table one of Gaussian splats, as in the reader of PLY files.
_SPLAT = ("f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "rot_0", "rot_1", "rot_2", "rot_3")

_PLY_TYPES = {"i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint", "f4": "float", "f8": "double"}

# Colors up to this are meant to be at most 1: bytes of at most 2 would be black.
_UNIT = np.float32(2.0)

# Numbers of full intensity in integers of 8, 10, 12 and 16 bits, each with the largest value that means it.
_FULL = ((256, 255), (1023, 1023), (4095, 4095))


@dataclass
class Parts:
    """Columns with a row for each point, as they are stored."""

    points: NDArray[Any]
    colors: NDArray[Any] | None = None
    # True of colors that are linear and not sRGB-encoded.
    linear: bool = False
    # True if the largest color, and the largest alpha, tells the number of full intensity, and not the type.
    measured: bool = False
    alpha: NDArray[Any] | None = None
    radii: NDArray[Any] | None = None
    normals: NDArray[Any] | None = None
    classification: NDArray[Any] | None = None
    intensity: NDArray[Any] | None = None
    scalars: dict[str, NDArray[Any]] = field(default_factory=dict)


def assign(table: Mapping[str, NDArray[Any]], parts: Parts | None, *, measured: bool) -> Parts:
    """Find the columns of a table, each of shape (n,), by their names; a column of another name is a scalar.

    `parts` is what is known already, points above all; None if points are columns, too. With `measured`, the values decide which
    number is full intensity, unless they are bytes; else their type does.
    """
    rest = dict(table)
    if parts is None:
        parts = Parts(points=_take_three(rest, _POSITION))
    if parts.normals is None:
        parts.normals = _take_three(rest, _NORMAL)
    if parts.colors is None:
        parts.colors = _take_three(rest, _LINEAR_COLOR)
        parts.linear = parts.colors is not None
    if parts.colors is None:
        parts.colors = _take_three(rest, _COLOR)
    if parts.alpha is None:
        parts.alpha = _take(rest, _ALPHA)
    parts.measured = measured
    parts.radii = _take(rest, _RADIUS)
    name = _find(rest, _CLASSIFICATION)
    if name is not None and _are_codes(rest[name]):
        parts.classification = rest.pop(name)
    parts.intensity = _take(rest, _INTENSITY)
    parts.scalars = rest
    return parts


def finish(parts: Parts, *, what: str, z_up: bool | None = None) -> dict[str, Any]:
    """Return arguments of `Cloud`. Points that are not finite are left out, with a warning."""
    if parts.points.ndim != 2 or parts.points.shape[1] != 3:
        raise ValueError(f"points: {what} has points of shape {parts.points.shape}, expected (n, 3)")
    finite = np.isfinite(parts.points).all(axis=1)
    if not finite.all():
        _keep(parts, finite)
        tell([f"{(~finite).sum()} points of the {what} are left out: a coordinate is not finite"], [])
    given: dict[str, Any] = {"points": parts.points, "z_up": z_up, "name": what}
    # Numbers that a float32 doesn't hold are infinite, as those of files are.
    with np.errstate(over="ignore"):
        return given | _columns(parts)


def _columns(parts: Parts) -> dict[str, Any]:
    """Return arguments of `Cloud` other than the points."""
    given: dict[str, Any] = {}
    if parts.colors is not None:
        given |= _colors(parts)
    if parts.alpha is not None:
        given["opacities"] = _alphas(parts.alpha, measured=parts.measured)
    if parts.normals is not None:
        given["normals"] = _normals(parts.normals)
    if parts.radii is not None:
        radii = parts.radii.astype(np.float32)
        given["radii"] = np.where(np.isfinite(radii), np.maximum(radii, 0), 0)
    if parts.classification is not None:
        given["classification"] = parts.classification.astype(np.uint8)
    if parts.intensity is not None:
        given["intensity"] = parts.intensity.astype(np.float32)
    if parts.scalars:
        given["scalars"] = {name: values.astype(np.float32) for name, values in parts.scalars.items()}
    return {name: value for name, value in given.items() if value is not None}


def _keep(parts: Parts, rows: NDArray[np.bool_]) -> None:
    for column in fields(parts):
        values = getattr(parts, column.name)
        if isinstance(values, np.ndarray):
            setattr(parts, column.name, values[rows])
    parts.scalars = {name: values[rows] for name, values in parts.scalars.items()}


def _find(table: Mapping[str, Any], names: tuple[str, ...]) -> str | None:
    """Return the name in the table of the first of some names that it has, in any case."""
    lower = {name.lower(): name for name in reversed(list(table))}
    return next((lower[name] for name in names if name in lower), None)


def _take(table: dict[str, NDArray[Any]], names: tuple[str, ...]) -> NDArray[Any] | None:
    name = _find(table, names)
    return None if name is None else table.pop(name)


def _take_three(table: dict[str, NDArray[Any]], threes: tuple[tuple[str, str, str], ...]) -> Any:
    """Take three columns as the columns of one array; return None unless all three are there."""
    for three in threes:
        found = [_find(table, (name,)) for name in three]
        if None not in found:
            return np.stack([table.pop(name) for name in found if name is not None], axis=1)
    return None


def _are_codes(values: NDArray[Any]) -> bool:
    return bool(((values >= 0) & (values <= 255) & (values == np.floor(values))).all())


def _full_scale(values: NDArray[np.float32]) -> float | None:
    """Return the number of full intensity where the type doesn't decide it; None if no value is above 0."""
    finite = values[np.isfinite(values)]
    largest = finite.max(initial=0)
    if largest <= 0:
        return None
    if largest <= _UNIT:
        return 1.0
    return float(full_integer(largest))


def full_integer(largest: float) -> int:
    """Return the number of full intensity in integers of which this is the largest, as the readers of files find it."""
    return next((full for most, full in _FULL if largest <= most), 65535)


def _colors(parts: Parts) -> dict[str, Any]:
    """Return colors as `Cloud` takes them: 8 or 16 bits, or floats from 0 to 1 with their color space."""
    colors = parts.colors
    assert colors is not None
    if colors.dtype.kind == "u" and (colors.itemsize == 1 or (colors.itemsize == 2 and not parts.measured)):
        return {"colors": colors}
    if colors.dtype.kind in "iu" and not parts.measured and not parts.linear:
        return {"colors": _as_bytes(colors)}
    floats = colors.astype(np.float32)
    unknown = np.isnan(floats)
    full: float | None = 1.0
    if parts.measured and not parts.linear:
        full = _full_scale(floats)
        if full is None:
            return {}
        # A color without any number is white, as points without color are.
        floats[unknown.all(axis=1)] = full
        unknown = np.isnan(floats)
    floats = np.clip(np.where(unknown, np.float32(0), floats) / np.float32(full), 0, 1)
    return {"colors": floats, "color_space": "linear" if parts.linear else "srgb"}


def _as_bytes(values: NDArray[Any]) -> NDArray[np.uint8]:
    """Return integers of another type as bytes; signed bytes below 0 are taken for bytes that were declared wrongly."""
    return values.view(np.uint8) if values.dtype == np.int8 else np.clip(values, 0, 255).astype(np.uint8)


def _alphas(alpha: NDArray[Any], *, measured: bool) -> NDArray[np.float32]:
    """Return opacities from 0 to 1; NaN becomes 1."""
    full = 255.0
    if measured and alpha.dtype != np.uint8:
        full = _full_scale(alpha.astype(np.float32)) or 1.0
    elif alpha.dtype.kind == "f":
        full = 1.0
    elif alpha.dtype == np.uint16:
        full = 65535.0
    elif alpha.dtype != np.uint8:
        alpha = _as_bytes(alpha)
    values = alpha.astype(np.float32)
    unit: NDArray[np.float32] = np.clip(np.where(np.isnan(values), np.float32(full), values) / np.float32(full), 0, 1)
    return unit


def _normals(normals: NDArray[Any]) -> NDArray[np.float32] | None:
    """Return normals, zero where one is not finite; None if no normal is left."""
    values = normals.astype(np.float32)
    values[~np.isfinite(values).all(axis=1)] = 0
    return values if values.any() else None


def are_splats(table: Mapping[str, Any]) -> bool:
    """Return True if the columns are those of Gaussian splats in a PLY file."""
    names = {name.lower() for name in table}
    return all(name in names for name in _SPLAT)


def splats(table: Mapping[str, NDArray[Any]], *, what: str) -> Any:
    """Return a `Cloud` of Gaussian splats, from the columns of a PLY file, which the reader of such files reads."""

    def write(file: BinaryIO) -> None:
        # PLY has no integers of 8 bytes and no booleans.
        kinds = {name: column.dtype.str[1:] if column.dtype.str[1:] in _PLY_TYPES else "f8" for name, column in table.items()}
        rows = np.empty(len(next(iter(table.values()))), dtype=[(name, f"<{kind}") for name, kind in kinds.items()])
        for name, column in table.items():
            rows[name] = column
        properties = "".join(f"property {_PLY_TYPES[kind]} {'_'.join(name.split())}\n" for name, kind in kinds.items())
        head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n{properties}end_header\n"
        file.write(head.encode())
        file.write(rows.data)

    return read(write, what=what)


def read(write: Callable[[BinaryIO], object], *, what: str) -> Any:
    """Return the `Cloud` of a file that `write` writes."""
    from ._cloud import Cloud

    with _file(write) as path:
        try:
            cloud = Cloud.read(path)
            cloud.name, cloud._file = what, False
            return cloud
        except ReadError as error:
            raise ValueError(f"points: {what}: {str(error).replace(path, 'as PLY')}") from error


@contextmanager
def _file(write: Callable[[BinaryIO], object]) -> Iterator[str]:
    """Yield the path of a file in memory where the system has such files, else of a temporary one."""
    if hasattr(os, "memfd_create"):
        with open(os.memfd_create("pellucid.ply"), "wb") as file:
            write(file)
            file.flush()
            yield f"/proc/self/fd/{file.fileno()}"
        return
    with tempfile.TemporaryDirectory(prefix="pellucid-") as folder:
        path = os.path.join(folder, "cloud.ply")
        with open(path, "wb") as file:
            write(file)
        yield path
