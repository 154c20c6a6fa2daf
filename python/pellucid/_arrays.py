"""Arguments that are arrays: their shapes and types are checked here, their values where they are copied."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import NDArray

# More points than an index tells apart would be refused later, after they were copied.
_MOST_POINTS = 2**32 - 1


def _array(name: str, given: Any) -> NDArray[Any]:
    import numpy as np

    try:
        array = np.asarray(given)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: expected an array of numbers, found {type(given).__name__} ({error})") from None
    if np.ma.isMaskedArray(given) and np.ma.is_masked(given):
        raise ValueError(f"{name}: expected an array without masked values; leave those out, or fill them")
    if array.dtype.kind not in "fiub":
        raise ValueError(f"{name}: expected real numbers, found an array of {array.dtype} of shape {array.shape}")
    return array


def rows(name: str, given: Any, count: int | None = None) -> NDArray[Any]:
    """Three floats for each point, flat: float32 stays as it is, everything else becomes float64."""
    import numpy as np

    array = _shaped(name, _array(name, given), count)
    kind = np.float32 if array.dtype == np.float32 else np.float64
    return np.ascontiguousarray(array, dtype=kind).reshape(-1)


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
    """Colors of points, flat: uint8, uint16, float32 or float64."""
    import numpy as np

    array = _shaped("colors", _array("colors", given), count)
    if array.dtype.kind in "iub" and array.dtype not in (np.uint8, np.uint16):
        raise ValueError(
            f"colors: expected uint8 or uint16 (sRGB) or floats from 0 to 1, found {array.dtype}; bytes are "
            "colors.astype(numpy.uint8)"
        )
    if array.dtype.kind == "f" and array.dtype not in (np.float32, np.float64):
        array = array.astype(np.float64)
    return np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("=")).reshape(-1)


def column(name: str, given: Any, count: int) -> NDArray[Any]:
    """A float32 for each point."""
    import numpy as np

    array = _array(name, given)
    if array.ndim == 2 and array.shape == (count, 1):
        array = array[:, 0]
    if array.shape != (count,):
        raise ValueError(f"{name}: expected an array of shape ({count},), one for each point, found {array.shape}")
    return np.ascontiguousarray(array, dtype=np.float32)


def codes(name: str, given: Any, count: int) -> NDArray[Any]:
    """A whole number from 0 to 255 for each point."""
    import numpy as np

    array = _array(name, given)
    if array.shape != (count,):
        raise ValueError(f"{name}: expected an array of shape ({count},), one for each point, found {array.shape}")
    if array.dtype == np.uint8:
        return np.ascontiguousarray(array)
    exact = array.astype(np.uint8, casting="unsafe")
    if not np.array_equal(exact, array):
        raise ValueError(f"{name}: expected whole numbers from 0 to 255, found {array.dtype} with other values")
    return np.ascontiguousarray(exact)


def vector(name: str, given: Any, length: int = 3) -> tuple[float, ...]:
    """Finite coordinates."""
    import numpy as np

    array = np.asarray(_array(name, given), dtype=np.float64)
    if array.shape != (length,):
        raise ValueError(f"{name}: expected {length} numbers, found an array of shape {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: expected finite numbers, found {array.tolist()}")
    return tuple(array.tolist())


def matrix(name: str, given: Any, shape: tuple[int, int]) -> NDArray[Any]:
    """A matrix of finite float64."""
    import numpy as np

    array = np.asarray(_array(name, given), dtype=np.float64)
    if array.shape != shape:
        raise ValueError(f"{name}: expected a matrix of shape {shape}, found {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: expected finite numbers, found {array.tolist()}")
    return array
