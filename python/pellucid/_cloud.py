"""Point clouds."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

from . import _arrays, _pellucid
from ._progress import listening
from ._types import Path, Progress

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray


class Cloud:
    """Points with their attributes. The arrays are copied, and a cloud never changes.

    Parameters
    ----------
    points
        Positions in world units, shape (n, 3), real numbers, all finite. They are kept in float64.
    colors
        Shape (n, 3). uint8 and uint16 are sRGB, as in files. Floats are from 0 to 1; see ``color_space``.
    opacity
        One opacity for all points, from 0 to 1, which multiplies ``opacities``.
    opacities
        Shape (n,), from 0 to 1; uint8 values are divided by 255.
    radii
        Shape (n,), world units, at least 0. Without them, the radius of each point is estimated from its neighbors.
    normals
        Shape (n, 3), of any length. A zero vector means that the point has no normal.
    classification
        Shape (n,), whole numbers from 0 to 255: the classes of LAS.
    intensity
        Shape (n,).
    scalars
        Further values by name, each of shape (n,). ``color_by`` and ``field`` accept these names.
    z_up
        True if +Z points up, as in surveys; False if +Y does, as in models. None decides by the shape of the cloud.
    color_space
        Color space of floats in ``colors``: "linear", or "srgb", as Open3D and PLY files have them.
    name
        Name that metadata and scene files use in place of a file, not empty; "cloud" by default.

    Raises
    ------
    ValueError
        A wrong shape, type or value. The message names the argument, what was found and what was expected.
    """

    __slots__ = ("_file", "_native", "name", "opacity")

    _native: _pellucid.Cloud
    # True if the name is the path of the file that it was read from.
    _file: bool
    name: str
    """Name that metadata and scene files use in place of a file."""
    opacity: float | None
    """One opacity for all points, from 0 to 1; None if none was given."""

    def __init__(
        self,
        points: ArrayLike,
        *,
        colors: ArrayLike | None = None,
        opacity: float | None = None,
        opacities: ArrayLike | None = None,
        radii: ArrayLike | None = None,
        normals: ArrayLike | None = None,
        classification: ArrayLike | None = None,
        intensity: ArrayLike | None = None,
        scalars: Mapping[str, ArrayLike] | None = None,
        z_up: bool | None = None,
        color_space: Literal["linear", "srgb"] = "linear",
        name: str | None = None,
    ) -> None:
        if color_space not in ("linear", "srgb"):
            raise ValueError(f"color_space: expected 'linear' or 'srgb', found {color_space!r}")
        if name is not None and not str(name):
            raise ValueError("name: expected a text, found an empty one; without name= it is 'cloud'")
        flat = _arrays.rows("points", points)
        count = flat.shape[0] // 3

        def column(name: str, given: ArrayLike | None) -> NDArray[Any] | None:
            return None if given is None else _arrays.column(name, given, count)

        given = {
            "colors": None if colors is None else _arrays.colors(colors, count),
            "srgb": color_space == "srgb",
            "opacities": None if opacities is None else _unit(opacities, count),
            "radii": column("radii", radii),
            "normals": None if normals is None else _arrays.rows("normals", normals, count),
            "classification": None if classification is None else _arrays.codes("classification", classification, count),
            "intensity": column("intensity", intensity),
            "scalars": _scalars(scalars, count),
            "z_up": None if z_up is None else bool(z_up),
        }
        self.opacity = _opacity(opacity)
        self.name = "cloud" if name is None else str(name)
        self._file = False
        self._native = _pellucid.Cloud.of_arrays(flat, given)

    @classmethod
    def read(cls, path: Path, *, progress: Progress = None) -> Cloud:
        """Read a file: PLY, LAS, LAZ, COPC, E57, PCD, PTS, PTX, a table of numbers, or Gaussian splats.

        Raises ReadError for a file that is missing, damaged or without points.
        """
        with listening(progress) as listener:
            return cls._of(_pellucid.Cloud.read(os.fspath(path), listener), os.fspath(path), file=True)

    @classmethod
    def from_any(cls, object: Any, **columns: Any) -> Cloud:
        """Make a cloud from an array or an object of laspy, Open3D, PyVista, plyfile or pandas.

        ``columns`` are arguments of `Cloud`, which take precedence over the columns of the object. Objects of plyfile and Gaussian
        splats are read as their files are, and take no columns. Raises TypeError if you pass columns with them, and for other types
        of objects.
        """
        if isinstance(object, Cloud):
            if columns:
                names = ", ".join(columns)
                raise TypeError(f"{names}: a Cloud has its columns already; make another one of its arrays")
            return object
        from ._foreign import columns as columns_of

        found = columns_of(object)
        if isinstance(found, Cloud):
            for name in columns:
                raise TypeError(
                    f"{name}: expected with an array of points; {found.name} is read as its file is, and takes no columns"
                )
            return found
        if found is not None:
            return cls(**{**found, **columns})
        if isinstance(object, (list, tuple)):
            _check_rows(object)
        if hasattr(object, "__array__") or isinstance(object, (list, tuple)):
            return cls(object, **columns)
        kind = f"{type(object).__module__}.{type(object).__qualname__}"
        raise TypeError(
            f"points: expected an array of shape (n, 3), a Cloud, a Scene, a path, or an object of laspy, open3d, pyvista, "
            f"plyfile or pandas, found {kind}"
        )

    @classmethod
    def _of(cls, native: _pellucid.Cloud, name: str, *, file: bool) -> Cloud:
        cloud = cls.__new__(cls)
        cloud._native, cloud.name, cloud.opacity, cloud._file = native, name, None, file
        return cloud

    def __copy__(self) -> Cloud:
        cloud = Cloud._of(self._native, self.name, file=self._file)
        cloud.opacity = self.opacity
        return cloud

    def __deepcopy__(self, memo: dict[int, Any]) -> Cloud:
        # Points never change.
        return self.__copy__()

    def __reduce__(self) -> str | tuple[Any, ...]:
        raise TypeError("a Cloud can't be pickled; send its numpy arrays (points, colors, …) or its file, and make it anew there")

    def __len__(self) -> int:
        return len(self._native)

    def __repr__(self) -> str:
        low, high = self.bounds.tolist()
        return f"<pellucid.Cloud {self.name!r}: {len(self)} points from {low} to {high}>"

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Smallest and largest corner, shape (2, 3), world units."""
        import numpy as np

        flat = self._native.bounds()
        return np.full((2, 3), np.nan) if flat is None else flat.reshape(2, 3)

    @property
    def points(self) -> NDArray[np.float64]:
        """Copy of the positions, shape (n, 3), world units."""
        return self._native.points().reshape(-1, 3)

    @property
    def colors(self) -> NDArray[np.float32] | None:
        """Copy of the colors, shape (n, 3), linear; None if there are none."""
        flat = self._native.colors()
        return None if flat is None else flat.reshape(-1, 3)

    @property
    def normals(self) -> NDArray[np.float32] | None:
        """Copy of the normals, shape (n, 3), of length 1 or 0; None if there are none."""
        flat = self._native.normals()
        return None if flat is None else flat.reshape(-1, 3)

    @property
    def opacities(self) -> NDArray[np.float32] | None:
        """Copy of the opacities of the points, shape (n,); None if there are none."""
        return self._native.opacities()

    @property
    def radii(self) -> NDArray[np.float32] | None:
        """Copy of the radii, shape (n,), world units; None if there are none."""
        return self._native.radii()

    @property
    def classification(self) -> NDArray[np.uint8] | None:
        """Copy of the classes, shape (n,); None if there are none."""
        return self._native.classification()

    @property
    def intensity(self) -> NDArray[np.float32] | None:
        """Copy of the intensities, shape (n,); None if there are none."""
        return self._native.intensity()

    @property
    def scalars(self) -> dict[str, NDArray[np.float32]]:
        """Copies of all other values by name, each of shape (n,)."""
        return dict(self._native.scalars())

    @property
    def z_up(self) -> bool:
        """True if +Z points up."""
        return self._native.z_up()


def _check_rows(given: Sequence[Any]) -> None:
    """Refuse a list of clouds, files or whole arrays; a list of rows is an array."""
    from ._scene import Scene

    for item in given:
        if isinstance(item, (Cloud, Scene, str, os.PathLike)) or getattr(item, "ndim", 1) > 1:
            kinds = ", ".join(sorted({type(item).__name__ for item in given}))
            raise TypeError(
                f"points: expected an array of shape (n, 3) or a list of clouds, found a list of {kinds}; "
                "of several make clouds, as in [Cloud(a), Cloud(b)]"
            )


def _opacity(given: float | None) -> float | None:
    if given is None:
        return None
    try:
        opacity = float(given)
    except (TypeError, ValueError):
        kind = type(given).__name__
        raise ValueError(
            f"opacity: expected one number from 0 to 1, found {kind}; an opacity for each point is opacities="
        ) from None
    if not 0.0 <= opacity <= 1.0:
        raise ValueError(f"opacity: expected a number from 0 to 1, found {opacity}")
    return opacity


def _unit(given: ArrayLike, count: int) -> NDArray[Any]:
    import numpy as np

    column = _arrays.column("opacities", given, count)
    bytes = np.asarray(given).dtype == np.uint8
    return column / np.float32(255.0) if bytes else column


def _scalars(given: Mapping[str, ArrayLike] | None, count: int) -> list[tuple[str, NDArray[Any]]]:
    if given is None:
        return []
    if not hasattr(given, "items"):
        raise TypeError(f"scalars: expected a dict of arrays by name, found {type(given).__name__}")
    return [(str(name), _arrays.column(f"scalars[{name!r}]", values, count)) for name, values in given.items()]
