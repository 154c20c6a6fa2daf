"""Devices, and scenes on them."""

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
from ._types import Accuracy, Progress, Setting, Size

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ._image import Image
    from ._measures import Profile


class Renderer:
    """A device that renders scenes: one upload, many frames.

    Parameters
    ----------
    device
        Its index in `devices`, or a part of its name; by default the best one.

    Raises
    ------
    DeviceError
        No Vulkan loader, driver or device is there; the message says what to install.
    """

    __slots__ = ("_native",)

    _native: _pellucid.Device

    def __init__(self, device: str | int | None = None) -> None:
        asked = _device(device)
        self._native = _pellucid.Device(None if asked is None else str(asked))

    @property
    def name(self) -> str:
        """The device's name."""
        return self._native.name()

    @property
    def driver(self) -> str:
        """The driver's name and version."""
        return self._native.driver()

    @property
    def bytes_in_use(self) -> int:
        """Bytes of the device's memory that its scenes and frames take now."""
        return self._native.bytes_in_use()

    def load(self, points: Any, *, seed: int | None = None, progress: Progress = None, **settings: Any) -> Loaded:
        """Brings points to the device: finds missing radii, orders and uploads them.

        ``points`` and ``settings`` are those of `render`. Raises what `render` raises.
        """
        scene, found, camera = prepared(points, settings)
        return _load(self, scene, found, camera, seed=seed, progress=progress)

    def close(self) -> None:
        """Ends it, once the scenes on it are closed, too."""
        self._native.close()

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


class Loaded:
    """A scene on a device, ready to render any number of frames. Threads that share one take turns."""

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
        """Renders a frame. What is not given is as the scene has it.

        Settings of the method, the image, the shading, the camera and the detail are live; those that change points (of
        clouds and clips, and methods that want other points) arrange and upload them again. The factors, at least 0, multiply
        the radii and opacities of all points at no cost; with ``see_through`` the opacity that it finds is multiplied.
        ``seed`` is that of stochastic methods. The others are those of `render`.

        ``clip``, ``slices``, ``classes`` and ``without`` leave out further points, and can't bring back those that the scene
        leaves out. ``eye`` and ``target`` take the place of the scene's ``view``.
        """
        from ._image import Image

        request = self._ask(
            settings,
            camera=camera,
            size=size,
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
        camera: Camera | Mapping[str, Any] | None = None,
        size: Size | None = None,
        method: str | None = None,
        accuracy: Accuracy = "exact",
        seed: int | None = None,
        progress: Progress = None,
        **settings: Setting,
    ) -> Profile:
        """Measures frames after a first one, which pays for pipelines and buffers."""
        from ._measures import Profile

        request = self._ask(settings, camera=camera, size=size, method=method, accuracy=accuracy, seed=seed)
        with listening(progress) as listener:
            text = self._native.profile(request, positive("frames", frames), listener)
        return Profile._of(json.loads(text))

    def _ask(
        self,
        settings: Mapping[str, Any],
        *,
        camera: Camera | Mapping[str, Any] | None = None,
        size: Size | None = None,
        method: str | None = None,
        seed: int | None = None,
        **others: Any,
    ) -> dict[str, Any]:
        for name in settings:
            if name in COLUMNS:
                raise TypeError(f"{name}: expected at Renderer.load, which takes columns of points; a frame draws what was loaded")
        camera, table = _camera(camera)
        found = asked({"method": method, **settings, "camera": table, "size": size})
        if found.direction:
            names = ", ".join(found.direction)
            raise TypeError(f"{names}: expected at Renderer.load, which frames the scene; here camera= looks from elsewhere")
        limits = {**self._limits, **found.limits}
        found = found._replace(limits=limits)
        seed = self._seed if seed is None else seed
        return ask(found, camera_changes=camera_changes(camera), seed=seed, **others)

    @property
    def camera(self) -> Camera:
        """The camera of the last frame, before it that of the scene, with all that was found where nothing was given."""
        return Camera._of(self._native.camera())

    @property
    def size(self) -> Size:
        """Columns and rows of the last frame, before it those of the scene."""
        width, height = self._native.size()
        return (width, height)

    @property
    def method(self) -> str:
        """The method of the last frame."""
        return self._native.method()[0]

    @property
    def reason(self) -> str:
        """Why this method; empty before the first frame."""
        return self._native.method()[1]

    @property
    def colorings(self) -> list[str]:
        """How clouds are colored, and why."""
        return self._native.colorings()

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Smallest and largest corner of the points, shape (2, 3), world units."""
        import numpy as np

        flat = self._native.bounds()
        return np.full((2, 3), np.nan) if flat is None else flat.reshape(2, 3)

    @property
    def scene(self) -> Scene:
        """A copy of the scene, with the seed that it was loaded with."""
        return self._scene.copy()

    def __len__(self) -> int:
        return self._native.count()

    def close(self) -> None:
        """Gives the device's memory back."""
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
    """Brings a scene to a device. What was found beside its keys is in force for its frames, too."""
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
    """The scene that arguments of `render` describe, those that are no keys, and the camera."""
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
    """A scene of whatever `render` takes."""
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
    """A camera, or keys of [camera]; neither where none is given."""
    if isinstance(given, Mapping):
        return None, given
    if given is not None and not isinstance(given, Camera):
        raise TypeError(f"camera: expected a Camera or a dict of keys of [camera], found {type(given).__name__}")
    return given, None


def positive(name: str, number: Any) -> int:
    """A whole number from 1 to 100000. Raises ValueError for anything else."""
    return whole(name, number, 100_000)


def whole(name: str, number: Any, most: int) -> int:
    """A whole number from 1 to the most. Raises ValueError for anything else."""
    if isinstance(number, bool) or not hasattr(number, "__index__") or not 1 <= number.__index__() <= most:
        shown = "2**63" if most == 2**63 else most
        raise ValueError(f"{name}: expected a whole number from 1 to {shown}, found {number!r}")
    return int(number)


def above_zero(name: str, number: Any) -> float:
    """A finite number above 0. Raises ValueError for anything else."""
    try:
        found = math.nan if isinstance(number, (str, bytes, bool)) else float(number)
    except (TypeError, ValueError):
        found = math.nan
    if not 0.0 < found < math.inf:
        raise ValueError(f"{name}: expected a number above 0, found {number!r}")
    return found


def _device(device: Any) -> str | int | None:
    """A device as it is asked for. Raises TypeError for what is neither an index nor a text."""
    if device is None or isinstance(device, str):
        return device
    if isinstance(device, bool) or not hasattr(device, "__index__"):
        raise TypeError(f"device: expected an index or a part of a name, found {type(device).__name__}")
    return operator.index(device)


_open: dict[str | int | None, Renderer] = {}
_opening = threading.Lock()


class Sharing:
    """The renderer that `render` and others share, for the length of a call.

    It is opened once, since that takes longer than a small frame. A device that failed may be lost: the next call opens it anew.
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
