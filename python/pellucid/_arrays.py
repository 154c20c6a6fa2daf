"""Array arguments. Their shapes and types are checked here, their values where they are copied."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import NDArray

# More points than an index tells apart would be refused later, after they were copied.
_MOST_POINTS = 2**32 - 1
# Hint for callers who mean one color.
_ONE_COLOR = "one color for all points is a setting of render and Scene: color"


def numbers(name: str, given: Any) -> NDArray[Any]:
    """Return an array of real numbers, of any shape, in the byte order of this machine."""
    import numpy as np

    try:
        array = np.asarray(given)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: expected an array of numbers, found {type(given).__name__} ({error})") from None
    if np.ma.isMaskedArray(given) and np.ma.is_masked(given):
        raise ValueError(f"{name}: expected an array without masked values; leave those out, or fill them")
    if array.dtype.kind not in "fiub":
        help = f"; if all of them are numbers: numpy.asarray({name}).astype(float)" if array.dtype.kind == "O" else ""
        raise ValueError(f"{name}: expected real numbers, found an array of {array.dtype} of shape {array.shape}{help}")
    return array.astype(array.dtype.newbyteorder("="), copy=False)


def _flat(array: NDArray[Any], dtype: Any) -> NDArray[Any]:
    """Return an aligned, contiguous array of one dimension, as native code needs it."""
    import numpy as np

    return np.require(array, dtype, ["C", "A"]).reshape(-1)


def rows(name: str, given: Any, count: int | None = None) -> NDArray[Any]:
    """Return three floats for each point, flat: float32 stays as it is, everything else becomes float64."""
    import numpy as np

    array = _shaped(name, numbers(name, given), count)
    kind = np.float32 if array.dtype == np.float32 else np.float64
    return _flat(array, kind)


def _shaped(name: str, array: NDArray[Any], count: int | None) -> NDArray[Any]:
    wanted = "(n, 3)" if count is None else f"({count}, 3)"
    if array.ndim != 2 or array.shape[1] != 3 or (count is not None and array.shape[0] != count):
        help = ""
        if array.ndim == 2 and array.shape[0] == 3 and array.shape[1] != 3:
            help = f"; its transpose has it: {name}.T"
        elif array.ndim == 2 and array.shape[1] > 3:
            help = f"; {name}[:, :3] are the first three columns"
            if name == "colors":
                help += ", and the fourth may be opacities="
        elif array.ndim == 2 and array.shape[1] == 2 and name == "points":
            help = "; points in a plane need a third coordinate"
        raise ValueError(f"{name}: expected an array of shape {wanted}, found {array.shape}{help}")
    if count is None and array.shape[0] == 0:
        raise ValueError(f"{name}: expected at least one point, found an array of shape {array.shape}")
    if array.shape[0] > _MOST_POINTS:
        raise ValueError(f"{name}: expected at most {_MOST_POINTS} points, found {array.shape[0]}")
    return array


def colors(given: Any, count: int) -> NDArray[Any]:
    """Return the colors of points, flat: uint8, uint16, float32 or float64."""
    import numpy as np

    if isinstance(given, str):
        raise ValueError(f"colors: expected a color for each point, found {given!r}; {_ONE_COLOR}={given!r}")
    array = numbers("colors", given)
    if array.shape == (3,):
        example = "[1, 0, 0]" if array.dtype.kind == "f" else "'#ff0000'"
        raise ValueError(f"colors: expected an array of shape ({count}, 3), found (3,); {_ONE_COLOR}={example}")
    array = _shaped("colors", array, count)
    if array.dtype.kind in "iub" and array.dtype not in (np.uint8, np.uint16):
        help = "colors.astype(numpy.uint8)" if hasattr(given, "astype") else "numpy.array(colors, dtype=numpy.uint8)"
        raise ValueError(f"colors: expected uint8 or uint16 (sRGB) or floats from 0 to 1, found {array.dtype}; bytes are {help}")
    if array.dtype.kind == "f" and array.dtype not in (np.float32, np.float64):
        array = array.astype(np.float64)
    return _flat(array, array.dtype)


def column(name: str, given: Any, count: int) -> NDArray[Any]:
    """Return a float32 for each point."""
    import numpy as np

    array = _single(name, numbers(name, given), count)
    with np.errstate(over="ignore"):
        values = _flat(array, np.float32)
    if array.dtype.itemsize > 4 and array.dtype.kind == "f":
        lost = np.isinf(values) & np.isfinite(array)
        if lost.any():
            at = int(lost.argmax())
            raise ValueError(f"{name}: expected numbers that a float32 holds, up to 3.4e38, found {array[at]:g} in row {at}")
    return values


def codes(name: str, given: Any, count: int) -> NDArray[Any]:
    """Return a whole number from 0 to 255 for each point."""
    import numpy as np

    array = _single(name, numbers(name, given), count)
    if array.dtype != np.uint8:
        wrong = ~((array >= 0) & (array <= 255))
        if array.dtype.kind == "f":
            wrong |= array != np.floor(array)
        if wrong.any():
            at = int(wrong.argmax())
            raise ValueError(f"{name}: expected whole numbers from 0 to 255, found {array[at]:g} in row {at}")
    return _flat(array, np.uint8)


def _single(name: str, array: NDArray[Any], count: int) -> NDArray[Any]:
    """Return one number for each point, from an array of shape (n,) or (n, 1)."""
    if array.shape == (count, 1):
        array = array[:, 0]
    if array.shape != (count,):
        raise ValueError(f"{name}: expected an array of shape ({count},), one for each point, found {array.shape}")
    return array


def vector(name: str, given: Any, length: int = 3) -> tuple[float, ...]:
    """Return finite coordinates."""
    import numpy as np

    array = np.asarray(numbers(name, given), dtype=np.float64)
    if array.shape in ((length, 1), (1, length)):
        array = array.reshape(length)
    if array.shape != (length,):
        raise ValueError(f"{name}: expected {length} numbers, found an array of shape {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: expected finite numbers, found {array.tolist()}")
    return tuple(array.tolist())


def matrix(name: str, given: Any, *shapes: tuple[int, int]) -> NDArray[Any]:
    """Return a matrix of finite float64 in one of the given shapes."""
    import numpy as np

    array = np.asarray(numbers(name, given), dtype=np.float64)
    if array.shape not in shapes:
        wanted = " or ".join(map(str, shapes))
        raise ValueError(f"{name}: expected a matrix of shape {wanted}, found {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: expected finite numbers, found {array.tolist()}")
    return array
