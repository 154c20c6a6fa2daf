"""Pictures of a loaded scene, made by a thread of their own: drafts while requests come, finer ones when none does."""

from __future__ import annotations

import functools
import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import Camera, Image, Loaded, Renderer, _drafts

if TYPE_CHECKING:
    from ._types import Accuracy

# Seconds without a request after which things are at rest.
_REST_S = 0.15

# Points below which pictures have all of them.
_FEW_POINTS = 50_000

# Milliseconds of the first picture at rest; each one after it may take four times as long.
_FIRST_MS = 250.0


@dataclass(frozen=True)
class Request:
    """A picture that is wanted."""

    camera: Camera
    size: tuple[int, int]
    method: str | None = None
    # Samples of the whole picture, if the method has some.
    samples: int | None = None
    opacity_factor: float = 1.0
    settings: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Begin:
    """The first picture, whole, and what was asked for it."""

    request: Request
    image: Image
    # Settings of the method that are in force.
    settings: dict[str, Any]


@dataclass(frozen=True)
class Picture:
    """A picture that was made."""

    # (h, w, 3), sRGB; of a draft fewer rows and columns than were asked for.
    pixels: NDArray[np.uint8]
    draft: _drafts.Draft
    # True if nothing is left out.
    whole: bool
    ms: float
    method: str
    # Root mean square over the picture, of methods that draw samples.
    standard_error: float | None


class OutdatedError(Exception):
    """A picture at rest was stopped, since another one is wanted."""


class Painter:
    """Renders requests, the latest first, in a thread that alone touches the device.

    Parameters
    ----------
    points
        What `pellucid.render` takes.
    arguments
        Arguments of `Renderer.load`.
    device
        As of `Renderer`.
    size
        Columns and rows of the first picture; `None` for the scene's, made smaller until it fits `most`.
    budget_ms
        Milliseconds that a picture may take while requests come.
    deliver
        Is called with each picture, or with the error that came in place of one, in the painter's thread.

    Raises
    ------
    Error
        Whatever `Renderer` and `Renderer.load` refuse.
    """

    def __init__(
        self,
        points: Any,
        arguments: dict[str, Any],
        *,
        device: str | int | None,
        size: tuple[int, int] | None = None,
        most: tuple[int, int] = (720, 540),
        budget_ms: float,
        deliver: Callable[[Picture | Exception], None],
    ) -> None:
        self._budget_ms = budget_ms
        self._deliver = deliver
        self._changed = threading.Condition()
        self._wanted: Request | None = None
        self._task: Callable[[Loaded], None] | None = None
        self._closed = False
        self._costs = _drafts.Costs()
        self._costs_of: tuple[str | None, int | None, tuple[int, int]] | None = None
        self._thins = False
        self._whole_ms = math.inf
        begun: list[Begin | BaseException] = []
        ready = threading.Event()
        begin = functools.partial(_begin, arguments=arguments, size=size, most=most)
        self._thread = threading.Thread(
            target=self._run, args=(points, arguments, device, begin, begun, ready), name="pellucid view", daemon=True
        )
        self._thread.start()
        ready.wait()
        if isinstance(begun[0], BaseException):
            raise begun[0]
        self.begin = begun[0]

    def ask(self, request: Request) -> None:
        """Wants a picture; one that was wanted before and isn't made yet will not be."""
        with self._changed:
            self._wanted = request
            self._changed.notify()

    def whole(self, request: Request) -> Image:
        """The picture that leaves nothing out. Raises Error if the painter is closed, or the frame fails."""
        from . import Error

        found: list[Any] = []
        done = threading.Event()

        def task(loaded: Loaded) -> None:
            try:
                found.append(_frame(loaded, request, _drafts.whole(request.samples), accuracy="exact"))
            except Exception as error:
                found.append(error)
            done.set()

        with self._changed:
            if self._closed:
                raise Error("the window is closed")
            self._task = task
            self._changed.notify()
        done.wait()
        if isinstance(found[0], BaseException):
            raise found[0]
        image: Image = found[0]
        return image

    def close(self) -> None:
        """Ends the thread and gives the device's memory back."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _run(
        self,
        points: Any,
        arguments: dict[str, Any],
        device: str | int | None,
        begin: Callable[[Loaded], Begin],
        begun: list[Begin | BaseException],
        ready: threading.Event,
    ) -> None:
        try:
            with Renderer(device) as renderer, renderer.load(points, **arguments) as scene:
                self._thins = _may_thin(scene)
                begun.append(begin(scene))
                ready.set()
                self._paint(scene)
        except BaseException as error:
            if ready.is_set():
                self._deliver(error if isinstance(error, Exception) else RuntimeError(str(error)))
            else:
                begun.append(error)
                ready.set()

    def _paint(self, scene: Loaded) -> None:
        """Makes pictures until the end."""
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._wanted is not None or self._task is not None or self._closed)
                if self._closed:
                    return
                request, self._wanted = self._wanted, None
                task, self._task = self._task, None
            if task is not None:
                task(scene)
            if request is not None:
                try:
                    self._follow(scene, request)
                except OutdatedError:
                    pass
                except Exception as error:
                    self._deliver(error)

    def _follow(self, scene: Loaded, request: Request) -> None:
        """A draft of a request, then, while no other one comes, finer pictures until nothing is left out."""
        kind = (request.method, request.samples, request.size)
        if kind != self._costs_of:
            self._costs, self._costs_of = _drafts.Costs(), kind
        draft = _drafts.moving(self._costs, self._budget_ms, request.samples, thins=self._thins)
        whole = _drafts.whole(request.samples)
        self._make(scene, request, draft)
        budget_ms = _FIRST_MS
        with self._changed:
            self._changed.wait_for(self._is_outdated, timeout=_REST_S)
        while draft != whole and not self._is_outdated():
            next_draft = _drafts.resting(self._costs, budget_ms, request.samples, thins=self._thins)
            budget_ms *= 4
            if next_draft.work(request.samples) > draft.work(request.samples):
                draft = next_draft
                self._make(scene, request, draft, stoppable=True)

    def _is_outdated(self) -> bool:
        return self._wanted is not None or self._task is not None or self._closed

    def _make(self, scene: Loaded, request: Request, draft: _drafts.Draft, *, stoppable: bool = False) -> None:
        # Waits until a frame that was stopped has ended, which counts for no other.
        count = len(scene)
        start = time.perf_counter()
        thins = self._thins and not (request.method or "").startswith("spbr")
        points = draft.points(count) if thins else None
        image = _frame(scene, request, draft, points=points, progress=self._stopper if stoppable else None)
        pixels = image.to_srgb()
        ms = 1e3 * (time.perf_counter() - start)
        whole = draft == _drafts.whole(request.samples)
        if whole:
            self._whole_ms = ms
        elif points is not None and ms > self._whole_ms:
            # Points that can't be left out without being arranged anew, as Gaussian splats.
            self._thins, self._costs = False, _drafts.Costs()
        self._costs.add(ms, draft.work(request.samples))
        self._deliver(Picture(pixels, draft, whole, ms, image.method, image.stderr))

    def _stopper(self, *_: Any, **__: Any) -> _Stopper:
        return _Stopper(self._is_outdated)


class _Stopper:
    """Takes the place of a bar of progress, and stops the frame once another picture is wanted."""

    def __init__(self, is_outdated: Callable[[], bool]) -> None:
        self._is_outdated = is_outdated
        self.n = 0
        self.total: int | None = None

    def update(self, count: float = 1) -> None:
        if self._is_outdated():
            raise OutdatedError

    refresh = set_description = set_postfix = lambda self, *_, **__: None

    def close(self) -> None:
        """Nothing is held."""


def _begin(scene: Loaded, *, arguments: dict[str, Any], size: tuple[int, int] | None, most: tuple[int, int]) -> Begin:
    """Renders the scene as it is, which decides the method."""
    image = scene.frame(size=size or _fitting(scene.size, most), accuracy="8-bit")
    camera = arguments.get("camera")
    if not isinstance(camera, Camera) or None in (camera.eye, camera.target, camera.up):
        # Near and far that were found for one view would cut others.
        vertical = scene.scene.get("camera.up") or _nearest_axis(image.camera)
        camera = replace(image.camera, up=vertical, near=None, far=None)
    settings = {name: scene.scene.get(f"method.{name}") for name in ("samples", "threshold")}
    request = Request(camera=camera, size=image.size, method=image.method)
    return Begin(request, image, {name: value for name, value in settings.items() if value is not None})


def _may_thin(scene: Loaded) -> bool:
    """True if drafts may leave points out: with shadows each has its own share of light, and a scene may do so by itself."""
    settings = scene.scene
    detail = (settings.get("detail.max_points"), settings.get("detail.spacing_px"))
    return len(scene) > _FEW_POINTS and not any(detail) and "shadows" not in settings.given()


def _fitting(size: tuple[int, int], most: tuple[int, int]) -> tuple[int, int]:
    """The size, made smaller until it fits."""
    factor = min(1.0, most[0] / size[0], most[1] / size[1])
    return max(round(size[0] * factor), 1), max(round(size[1] * factor), 1)


def _nearest_axis(camera: Camera) -> tuple[float, float, float]:
    """The axis of the world that points to the top of the image, nearly: the camera turns around it."""
    up = np.asarray(camera.up)
    axis = np.zeros(3)
    axis[np.abs(up).argmax()] = np.sign(up[np.abs(up).argmax()])
    x, y, z = axis.tolist()
    return x, y, z


def _frame(
    scene: Loaded,
    request: Request,
    draft: _drafts.Draft,
    *,
    points: int | None = None,
    accuracy: Accuracy = "8-bit",
    progress: Any = None,
) -> Image:
    settings = dict(request.settings)
    if points is not None:
        settings["detail"] = {"max_points": points}
    if draft.samples is not None:
        settings["samples"] = draft.samples
    return scene.frame(
        camera=request.camera,
        size=draft.size(request.size),
        method=request.method,
        opacity_factor=request.opacity_factor,
        # Which is what standard errors come with.
        fragments=draft.samples is not None,
        accuracy=accuracy,
        progress=progress,
        **settings,
    )
