"""Devices, and scenes loaded on them."""

from __future__ import annotations

import json
import math
import operator
import os
import threading
from collections.abc import Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Any

from . import _pellucid
from ._camera import Camera
from ._cloud import Cloud
from ._errors import DeviceError
from ._progress import listening
from ._scene import Scene
from ._settings import COLUMNS, Asked, ask, asked, one_view
from ._types import Accuracy, Progress, Samples, Setting, Size

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ._image import Image
    from ._measures import Profile


class Renderer:
    """A device that renders scenes: upload once, render many frames.

    Parameters
    ----------
    device
        Index of the device in `devices`, or a part of its name. By default, the best device.

    Raises
    ------
    DeviceError
        No Vulkan loader, driver or device was found. The message says what to install.
    """

    __slots__ = ("_native",)

    _native: _pellucid.Device

    def __init__(self, device: str | int | None = None) -> None:
        asked = _device(device)
        self._native = _pellucid.Device(None if asked is None else str(asked))

    @property
    def name(self) -> str:
        """Name of the device."""
        return self._native.name()

    @property
    def driver(self) -> str:
        """Name and version of the driver."""
        return self._native.driver()

    @property
    def bytes_in_use(self) -> int:
        """Device memory that the scenes and frames of this renderer use now, in bytes."""
        return self._native.bytes_in_use()

    def load(self, points: Any, *, seed: int | None = None, progress: Progress = None, **settings: Any) -> Loaded:
        """Load points on the device: estimate missing radii, order the points and upload them.

        ``points`` and ``settings`` are those of `render`. Raises what `render` raises.
        """
        scene, found, camera = prepared(points, settings)
        return _load(self, scene, found, camera, seed=seed, progress=progress)

    def close(self) -> None:
        """Close the renderer. It ends once the scenes loaded on it are closed, too."""
        self._native.close()

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


class Loaded:
    """A scene on a device, ready to render any number of frames. Threads that share it take turns."""

    __slots__ = ("_limits", "_native", "_scene", "_seed")

    _native: _pellucid.Loaded
    _scene: Scene
    _limits: dict[str, Any]
    _seed: int | None

    def __init__(self) -> None:
        raise TypeError("Loaded: expected no call; Renderer.load makes one")

    def frame(
        self,
        *,
        camera: Camera | Mapping[str, Any] | None = None,
        size: Size | None = None,
        samples: Samples | None = None,
        method: str | None = None,
        fragments: bool = False,
        depths: bool = False,
        accuracy: Accuracy = "exact",
        opacity_factor: float = 1.0,
        radius_factor: float = 1.0,
        seed: int | None = None,
        progress: Progress = None,
        **settings: Setting,
    ) -> Image:
        """Render a frame. Whatever is not given is as in the scene.

        Settings of the method, image, shading, camera and detail change without a new upload. Settings that change points (those of
        clouds and clips, and methods that need other points) arrange and upload the points again. ``opacity_factor`` and
        ``radius_factor``, at least 0, multiply the opacities and radii of all points at no cost; with ``see_through``, the opacity
        that it finds is multiplied. ``seed`` is the seed of stochastic methods. The other arguments are those of `render`.

        ``clip``, ``slices``, ``classes`` and ``without`` leave out further points. They can't bring back points that the scene
        leaves out. ``eye`` and ``target`` replace the ``view`` of the scene.
        """
        from ._image import Image

        request = self._ask(
            settings,
            camera=camera,
            size=size,
            samples=samples,
            method=method,
            fragments=fragments,
            depths=depths,
            accuracy=accuracy,
            opacity_factor=opacity_factor,
            radius_factor=radius_factor,
            seed=seed,
        )
        with listening(progress) as listener:
            picture, parts = self._native.frame(request, listener)
        return Image._of(picture, parts, picture.size)

    def profile(
        self,
        *,
        frames: int = 5,
        steady: bool = False,
        camera: Camera | Mapping[str, Any] | None = None,
        size: Size | None = None,
        samples: Samples | None = None,
        method: str | None = None,
        accuracy: Accuracy = "exact",
        seed: int | None = None,
        progress: Progress = None,
        **settings: Setting,
    ) -> Profile:
        """Measure frames, after a first one that isn't counted and pays for pipelines and buffers.

        ``frames`` is the number of frames that count, from 1 to 100000. With ``steady`` their counts are foreseen, as in a window
        or a film, and a frame waits for the device once; without, each frame waits for its own counts. The other arguments are
        those of `frame`.
        """
        from ._measures import Profile

        request = self._ask(settings, camera=camera, size=size, samples=samples, method=method, accuracy=accuracy, seed=seed)
        with listening(progress) as listener:
            text = self._native.profile(request, positive("frames", frames), bool(steady), listener)
        return Profile._of(json.loads(text))

    def _ask(
        self,
        settings: Mapping[str, Any],
        *,
        camera: Camera | Mapping[str, Any] | None = None,
        size: Size | None = None,
        samples: Samples | None = None,
        method: str | None = None,
        seed: int | None = None,
        **others: Any,
    ) -> dict[str, Any]:
        for name in settings:
            if name in COLUMNS:
                raise TypeError(f"{name}: expected at Renderer.load, which takes columns of points; a frame draws what was loaded")
        camera, table = _camera(camera)
        found = asked({"method": method, **settings, "camera": table, "size": size, "samples": samples})
        if found.direction:
            names = ", ".join(found.direction)
            raise TypeError(f"{names}: expected at Renderer.load, which frames the scene; here camera= looks from elsewhere")
        limits = {**self._limits, **found.limits}
        found = found._replace(limits=limits)
        seed = self._seed if seed is None else seed
        return ask(found, camera_changes=camera_changes(camera), seed=seed, **others)

    @property
    def camera(self) -> Camera:
        """Camera of the last frame, or of the scene before the first frame, with every value that was found automatically."""
        return Camera._of(self._native.camera())

    @property
    def size(self) -> Size:
        """Width and height in pixels of the last frame, or of the scene before the first frame."""
        width, height = self._native.size()
        return (width, height)

    @property
    def method(self) -> str:
        """Name of the method of the last frame."""
        return self._native.method()[0]

    @property
    def reason(self) -> str:
        """Reason for the method; empty before the first frame."""
        return self._native.method()[1]

    @property
    def colorings(self) -> list[str]:
        """The color source of each cloud, and the reason for it."""
        return self._native.colorings()

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Smallest and largest corner of the points, shape (2, 3), world units; NaN without points."""
        import numpy as np

        flat = self._native.bounds()
        return np.full((2, 3), np.nan) if flat is None else flat.reshape(2, 3)

    @property
    def scene(self) -> Scene:
        """Copy of the scene, with the seed it was loaded with."""
        return self._scene.copy()

    def __len__(self) -> int:
        return self._native.count()

    def close(self) -> None:
        """Free the device memory."""
        self._native.close()

    def __enter__(self) -> Loaded:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


def _load(
    renderer: Renderer,
    scene: Scene,
    found: Asked,
    camera: Camera | None,
    *,
    seed: int | None = None,
    progress: Progress = None,
    with_radii: bool = False,
) -> Loaded:
    """Load a scene on a device. Limits that were given in addition to its keys also hold for its frames."""
    loaded = Loaded.__new__(Loaded)
    loaded._scene, loaded._limits, loaded._seed = scene, found.limits, scene.seed if seed is None else seed
    if found.direction:
        scene._direct(found.direction)
    request = ask(Asked([], {}, found.limits), camera_changes=None, seed=loaded._seed)
    scene.seed = scene._native.seed = request["seed"]
    if camera is not None:
        scene._look(camera)
    with listening(progress) as listener:
        loaded._native = _pellucid.Loaded(renderer._native, scene._native, request, with_radii, listener)
    return loaded


def prepared(points: Any, arguments: Mapping[str, Any]) -> tuple[Scene, Asked, Camera | None]:
    """Return the scene that arguments of `render` describe, the arguments that are not keys, and the camera."""
    settings = {name: value for name, value in arguments.items() if name not in COLUMNS}
    columns = {name: value for name, value in arguments.items() if value is not None and name in COLUMNS}
    camera, table = _camera(settings.get("camera"))
    found = asked({**settings, "camera": table})
    if camera is not None:
        one_view(found.direction)
    scene = scene_of(points, columns)
    scene._change(found.changes)
    return scene, found, camera


def scene_of(points: Any, columns: Mapping[str, Any]) -> Scene:
    """Return a scene of whatever `render` takes."""
    if isinstance(points, (str, os.PathLike)):
        _without(columns, "a path")
        return Scene.read(points)
    if isinstance(points, Scene):
        _without(columns, "a Scene")
        return points.copy()
    if isinstance(points, (list, tuple)) and points:
        if all(isinstance(item, Cloud) for item in points):
            _without(columns, "clouds")
            return Scene(points)
        if all(isinstance(item, (str, os.PathLike)) for item in points):
            _without(columns, "paths")
            return Scene.read(*points)
    return Scene(Cloud.from_any(points, **columns))


def _without(columns: Mapping[str, Any], what: str) -> None:
    for name in columns:
        raise TypeError(f"{name}: expected with an array of points; {what} brings its own")


def camera_changes(camera: Camera | None) -> list[Any] | None:
    return None if camera is None else camera._changes()


def _camera(given: Any) -> tuple[Camera | None, Mapping[str, Any] | None]:
    """Return a camera, or keys of [camera]; both None if nothing is given."""
    if isinstance(given, Mapping):
        return None, given
    if given is not None and not isinstance(given, Camera):
        raise TypeError(f"camera: expected a Camera or a dict of keys of [camera], found {type(given).__name__}")
    return given, None


def positive(name: str, number: Any) -> int:
    """Return a whole number from 1 to 100000. Raises ValueError for anything else."""
    return whole(name, number, 100_000)


def whole(name: str, number: Any, most: int) -> int:
    """Return a whole number from 1 to ``most``. Raises ValueError for anything else."""
    if isinstance(number, bool) or not hasattr(number, "__index__") or not 1 <= number.__index__() <= most:
        shown = "2**63" if most == 2**63 else most
        raise ValueError(f"{name}: expected a whole number from 1 to {shown}, found {number!r}")
    return int(number)


def above_zero(name: str, number: Any) -> float:
    """Return a finite number above 0. Raises ValueError for anything else."""
    try:
        found = math.nan if isinstance(number, (str, bytes, bool)) else float(number)
    except (TypeError, ValueError):
        found = math.nan
    if not 0.0 < found < math.inf:
        raise ValueError(f"{name}: expected a number above 0, found {number!r}")
    return found


def _device(device: Any) -> str | int | None:
    """Return the device that was asked for. Raises TypeError for anything but an index or a text."""
    if device is None or isinstance(device, str):
        return device
    if isinstance(device, bool) or not hasattr(device, "__index__"):
        raise TypeError(f"device: expected an index or a part of a name, found {type(device).__name__}")
    return operator.index(device)


_open: dict[str | int | None, Renderer] = {}
_opening = threading.Lock()


class Sharing:
    """The renderer that `render` and other functions share, held for the length of a call.

    It is opened once, since that takes longer than a small frame. A device that failed may be lost, so the next call opens a new
    one.
    """

    __slots__ = ("_device", "_renderer")

    _renderer: Renderer

    def __init__(self, device: str | int | None) -> None:
        self._device = _device(device)

    def __enter__(self) -> Renderer:
        with _opening:
            if self._device not in _open:
                _open[self._device] = Renderer(self._device)
            self._renderer = _open[self._device]
        return self._renderer

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if isinstance(error, DeviceError):
            with _opening:
                if _open.get(self._device) is self._renderer:
                    del _open[self._device]
