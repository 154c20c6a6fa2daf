"""Rendered pictures."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from . import _pellucid
from ._camera import Camera
from ._types import Path

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ._measures import Profile


class Image(NDArrayOperatorsMixin):
    """A rendered picture in linear light, with row 0 at the top.

    NumPy takes it as the array `rgba`: ``numpy.asarray(image)``, ``image * 2``, ``a - b``, ``a == b``, ``image[y, x]``,
    ``len(image)``. The results are plain arrays. The arrays of an image are read-only views that share its memory;
    ``numpy.array(image)`` returns a copy that you can write to. Only `size` differs from that of an array: it is width and height,
    also as ``numpy.size(image)``. In a notebook, an image displays itself.
    """

    __slots__ = ("_native", "_parts", "_profile", "_shape")

    _native: _pellucid.Picture
    _shape: tuple[int, int]
    _parts: dict[str, Any]
    _profile: Profile | None

    def __init__(self) -> None:
        raise TypeError("Image: expected no call; pellucid.render and Loaded.frame make images")

    @classmethod
    def _of(cls, native: _pellucid.Picture, parts: tuple[Any, ...], size: tuple[int, int]) -> Image:
        image = cls.__new__(cls)
        names = ("rgba", "depth", "median", "mean", "fragments", "layers", "stderr")
        for part in parts:
            if part is not None:
                part.flags.writeable = False
        image._native, image._parts, image._profile = native, dict(zip(names, parts, strict=True)), None
        image._shape = (size[1], size[0])
        return image

    def _plane(self, name: str, *channels: int) -> Any:
        part = self._parts[name]
        return None if part is None else part.reshape(*self._shape, *channels)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        rgba = self.rgba
        if dtype is not None and np.dtype(dtype) != rgba.dtype:
            if copy is False:
                raise ValueError(f"copy: expected True or None for {np.dtype(dtype)}, found False: pictures are float32")
            return rgba.astype(dtype)
        return rgba.copy() if copy else rgba

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **settings: Any) -> Any:
        if any(isinstance(out, Image) for out in settings.get("out", ())):
            raise TypeError(
                f"out: expected an array to write to, found an Image ({ufunc.__name__}): images are read-only, and "
                "numpy.array(image) is a copy to write to"
            )
        arrays = [one.rgba if isinstance(one, Image) else one for one in inputs]
        return getattr(ufunc, method)(*arrays, **settings)

    def __getitem__(self, place: Any) -> Any:
        return self.rgba[place]

    def __len__(self) -> int:
        return self._shape[0]

    # The mixin's == is that of arrays, and takes this away.
    __hash__ = object.__hash__

    def __copy__(self) -> Image:
        # Nothing of it can be changed.
        return self

    def __deepcopy__(self, known: Any) -> Image:
        return self

    def __reduce__(self) -> Any:
        raise TypeError(
            "an Image can't be pickled: it holds more than arrays; numpy.asarray(image) can be, and image.save writes a file"
        )

    @property
    def dtype(self) -> np.dtype[np.float32]:
        """Type of the values: float32."""
        return np.dtype(np.float32)

    @property
    def ndim(self) -> int:
        """Number of axes: 3."""
        return 3

    @property
    def shape(self) -> tuple[int, int, int]:
        """Rows, columns, 4."""
        return (*self._shape, 4)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels. The number of values, which an array calls its size, is ``image.rgba.size``."""
        return (self._shape[1], self._shape[0])

    @property
    def rgba(self) -> NDArray[np.float32]:
        """R, G, B multiplied by opacity, and opacity A, without the background, shape (h, w, 4).

        The values are in linear light, unless the scene says ``image.color = "encoded"``.
        """
        plane: NDArray[np.float32] = self._plane("rgba", 4)
        return plane

    @property
    def depth(self) -> NDArray[np.float32]:
        """Depth of the nearest fragment along the view, shape (h, w), world units; infinite where there is none."""
        plane: NDArray[np.float32] = self._plane("depth")
        return plane

    @property
    def median_depth(self) -> NDArray[np.float32] | None:
        """Depth at which half of the light or less is left, shape (h, w), world units; infinite where A is below 1/2.

        None unless you asked for ``depths=True`` and the method has this depth.
        """
        plane: NDArray[np.float32] | None = self._plane("median")
        return plane

    @property
    def mean_depth(self) -> NDArray[np.float32] | None:
        """Mean depth of the fragments, each weighted by what it adds to A, shape (h, w), world units.

        None under the conditions of `median_depth`.
        """
        plane: NDArray[np.float32] | None = self._plane("mean")
        return plane

    @property
    def fragments(self) -> NDArray[np.uint32] | NDArray[np.float32] | None:
        """Number of fragments of each pixel, shape (h, w): uint32, or with `samples` above 1 their means as float32.

        None unless you asked for ``fragments=True`` and the method has lists.
        """
        plane: NDArray[np.uint32] | NDArray[np.float32] | None = self._plane("fragments")
        return plane

    @property
    def layers(self) -> NDArray[np.uint32] | NDArray[np.float32] | None:
        """Number of blended layers of each pixel, shape (h, w), of methods that peel, with ``fragments=True``; else None.

        With `samples` above 1 it is the mean of the images, as float32.
        """
        plane: NDArray[np.uint32] | NDArray[np.float32] | None = self._plane("layers")
        return plane

    @property
    def stderr(self) -> float | None:
        """Standard error of the picture: root mean square over all pixels and R, G, B.

        Stochastic methods have it with ``fragments=True``; else it is None.
        """
        return self._native.stderr

    @property
    def pixel_stderr(self) -> NDArray[np.float32] | None:
        """Standard error of each pixel, shape (h, w, 3); None under the conditions of `stderr`."""
        plane: NDArray[np.float32] | None = self._plane("stderr", 3)
        return plane

    @property
    def samples(self) -> int:
        """Samples of each pixel's area: the number of images whose mean the picture is."""
        return self._native.samples

    @property
    def method(self) -> str:
        """Name of the method that drew the picture."""
        return self._native.method

    @property
    def reason(self) -> str:
        """Reason for the method."""
        return self._native.reason

    @property
    def metadata(self) -> dict[str, str]:
        """Metadata that saved files contain: scene, method, settings, device, version and seed."""
        return dict(self._native.metadata)

    @property
    def camera(self) -> Camera:
        """Camera of the picture, with every value that was found automatically."""
        return Camera._of(self._native.camera())

    @property
    def profile(self) -> Profile:
        """Cost of the frame: device time of each pass, and memory."""
        if self._profile is None:
            from ._measures import Profile

            self._profile = Profile._of(json.loads(self._native.profile()))
        return self._profile

    def over_background(self) -> NDArray[np.float32]:
        """Return linear R, G, B over the background of the scene, shape (h, w, 3)."""
        return self._native.linear(self._parts).reshape(*self._shape, 3)

    def to_srgb(self) -> NDArray[np.uint8]:
        """Return 8-bit sRGB over the background of the scene, shape (h, w, 3): the pixels of the PNG."""
        return self._native.srgb(self._parts).reshape(*self._shape, 3)

    def to_png(self, *, transparent: bool = False) -> bytes:
        """Return the bytes of the PNG that `save` writes."""
        return bytes(self._native.png(bool(transparent), self._parts))

    def save(self, path: Path, *, transparent: bool = False) -> None:
        """Save the picture as PNG (8-bit sRGB) or EXR (float32 R, G, B, A, Z and what else was asked for), by the extension.

        A PNG is over the background, or has straight alpha with ``transparent=True``. The file is written whole or not at all.

        An EXR has the same bytes as that of the command line. So has a PNG over the background, of a picture with
        ``accuracy="8-bit"``. A PNG with straight alpha differs in single values by 1 of 255: for such a file the command line
        continues blending longer, because colors are divided by A. It is most accurate with ``accuracy="exact"``.

        Raises OSError for another extension, a missing folder, and errors of the system.
        """
        self._native.save(os.fspath(path), bool(transparent), self._parts)

    def _repr_png_(self) -> bytes:
        return self.to_png()

    def __repr__(self) -> str:
        width, height = self.size
        return f"<pellucid.Image {width} × {height}, method {self.method}>"
