"""Pictures of a loaded scene, made by a thread of their own: drafts while requests come, finer ones when none does."""

from __future__ import annotations

import json
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import Camera, Error, Image, Loaded, Renderer, _drafts
from ._progress import maker_of
from ._types import Progress

# Seconds without a request after which things are at rest.
_REST_S = 0.15

# Points below which pictures have all of them.
_FEW_POINTS = 50_000

# Milliseconds of the first picture at rest; each one after it may take four times as long.
_FIRST_MS = 250.0

# Arguments by which the first frame finds an opacity, a method and its settings; each frame would do so anew.
_SEARCHES = ("see_through", "max_error", "budget_ms", "against")

# Seconds that Ctrl-C waits for the thread to end, which it may do later, too.
_PATIENCE_S = 0.1

_CLOSED = "the window is closed"


@dataclass(frozen=True)
class Request:
    """A requested picture."""

    camera: Camera
    size: tuple[int, int]
    method: str | None = None
    # Samples of the whole picture, if the method has some.
    samples: int | None = None
    opacity_factor: float = 1.0
    settings: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Begin:
    """The first picture, whole, and the request for it."""

    request: Request
    image: Image
    # Settings of the method that are in force.
    settings: dict[str, Any]
    # Results of the searches that were asked for: a factor on all opacities, and settings by their dotted keys.
    factor: float
    found: dict[str, Any]


@dataclass(frozen=True)
class Picture:
    """A finished picture."""

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
    """Raised to stop work because another picture is wanted, or none any more."""


class Painter:
    """A renderer of requests, the latest first, in a thread that alone uses the device.

    Parameters
    ----------
    points
        Points as for `pellucid.render`.
    arguments
        Arguments of `Renderer.load`.
    frame
        Arguments of `Loaded.frame` for whole pictures.
    device
        Device as for `Renderer`.
    size
        Width and height of the first picture in pixels; None for those of the scene, made smaller until they fit `most`.
    frame_ms
        Time that a picture may take while requests come, in milliseconds.
    deliver
        Callable that takes each picture, or the error in place of one. The painter's thread calls it.

    Raises
    ------
    Error
        Whatever `Renderer` and `Renderer.load` refuse.
    KeyboardInterrupt
        Ctrl-C was pressed while points are loaded. It ends the thread.
    """

    begin: Begin

    def __init__(
        self,
        points: Any,
        arguments: Mapping[str, Any],
        *,
        device: str | int | None,
        frame: Mapping[str, Any] | None = None,
        size: tuple[int, int] | None = None,
        most: tuple[int, int] = (720, 540),
        frame_ms: float,
        deliver: Callable[[Picture | Exception], None],
    ) -> None:
        self._frame_ms = frame_ms
        self._whole_as = {"accuracy": "exact", **(frame or {})}
        self._deliver = deliver
        self._changed = threading.Condition()
        self._wanted: Request | None = None
        # Whole pictures that somebody waits for.
        self._tasks: deque[tuple[Request, Future[Image]]] = deque()
        self._closed = False
        self._why_closed = _CLOSED
        self._costs = _drafts.Costs()
        self._costs_of: tuple[str | None, int | None, tuple[int, int]] | None = None
        self._thins = False
        self._whole_ms = math.inf
        begun: Future[None] = Future()
        self._thread = threading.Thread(
            target=self._run, args=(points, dict(arguments), device, size, most, begun), name="pellucid view", daemon=True
        )
        try:
            self._thread.start()
            begun.result()
        except BaseException:
            self.close(_PATIENCE_S)
            raise

    def ask(self, request: Request) -> None:
        """Request a picture in place of the one requested before, if that isn't made yet."""
        with self._changed:
            self._wanted = request
            self._changed.notify()

    def whole(self, request: Request) -> Image:
        """Return the picture that leaves nothing out. Raises Error if the painter is closed, or the frame fails."""
        made: Future[Image] = Future()
        with self._changed:
            if self._closed:
                raise Error(self._why_closed)
            self._tasks.append((request, made))
            self._changed.notify()
        try:
            return made.result()
        except KeyboardInterrupt:
            # Not begun, it need not be made any more.
            made.cancel()
            raise

    def close(self, patience_s: float | None = None) -> None:
        """End the thread, which frees the device memory, and wait for it, at most ``patience_s`` seconds."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        if self._thread.is_alive() and self._thread is not threading.current_thread():
            self._thread.join(patience_s)

    def _run(
        self,
        points: Any,
        arguments: dict[str, Any],
        device: str | int | None,
        size: tuple[int, int] | None,
        most: tuple[int, int],
        begun: Future[None],
    ) -> None:
        try:
            searches = {name: arguments.pop(name) for name in _SEARCHES if name in arguments}
            progress = self._stopper(lambda: self._closed, arguments.pop("progress", None))
            with Renderer(device) as renderer, renderer.load(points, **arguments, progress=progress) as scene:
                self._thins = _may_thin(scene)
                size = size or _fitting(scene.size, most)
                image = scene.frame(size=size, accuracy="8-bit", progress=progress, **searches)
                self.begin = _begin(scene, image, arguments.get("camera"))
                begun.set_result(None)
                self._paint(scene)
        except BaseException as error:
            self._why_closed = f"the window was closed by an error: {error}"
            if not begun.done():
                begun.set_exception(error)
            elif isinstance(error, Exception):
                self._deliver(error)
        finally:
            self._fail_tasks()

    def _fail_tasks(self) -> None:
        """Fail requests for whole pictures that nobody will make, so that nobody waits for them."""
        with self._changed:
            self._closed = True
            tasks, self._tasks = self._tasks, deque()
        for _, made in tasks:
            if made.set_running_or_notify_cancel():
                made.set_exception(Error(self._why_closed))

    def _paint(self, scene: Loaded) -> None:
        """Make pictures until the painter is closed."""
        while True:
            with self._changed:
                self._changed.wait_for(self._is_outdated)
                if self._closed:
                    return
                task = self._tasks.popleft() if self._tasks else None
                request, self._wanted = self._wanted, None
            if task is not None:
                self._fulfill(scene, *task)
            if request is not None:
                try:
                    self._follow(scene, request)
                except OutdatedError:
                    pass
                except Exception as error:
                    self._deliver(error)

    def _fulfill(self, scene: Loaded, request: Request, made: Future[Image]) -> None:
        """Make the whole picture that somebody waits for, unless the window is closed meanwhile."""
        if not made.set_running_or_notify_cancel():
            return
        try:
            draft = _drafts.whole(request.samples)
            progress = self._stopper(lambda: self._closed)
            made.set_result(self._frame(scene, request, draft, progress=progress, **self._whole_as))
        except OutdatedError:
            made.set_exception(Error(_CLOSED))
        except BaseException as error:
            made.set_exception(error)

    def _follow(self, scene: Loaded, request: Request) -> None:
        """Make a draft of a request, then, while no other request comes, finer pictures until nothing is left out."""
        kind = (request.method, request.samples, request.size)
        if kind != self._costs_of:
            self._costs, self._costs_of = _drafts.Costs(), kind
        draft = _drafts.moving(self._costs, self._frame_ms, request.samples, thins=self._thins)
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
        return self._wanted is not None or bool(self._tasks) or self._closed

    def _make(self, scene: Loaded, request: Request, draft: _drafts.Draft, *, stoppable: bool = False) -> None:
        # Waits until a frame that was stopped has ended, which counts for no other.
        count = len(scene)
        start = time.perf_counter()
        thins = self._thins and not (request.method or "").startswith("spbr")
        points = draft.points(count) if thins else None
        progress = self._stopper(self._is_outdated) if stoppable else None
        image = self._frame(scene, request, draft, points=points, progress=progress)
        pixels = image.to_srgb()
        ms = 1e3 * (time.perf_counter() - start)
        whole = draft == _drafts.whole(request.samples)
        if whole:
            self._whole_ms = ms
        elif points is not None and ms > self._whole_ms:
            # Points that can't be left out without being ordered anew, as Gaussian splats.
            self._thins, self._costs = False, _drafts.Costs()
        self._costs.add(ms, draft.work(request.samples))
        self._deliver(Picture(pixels, draft, whole, ms, image.method, image.stderr))

    def _frame(
        self,
        scene: Loaded,
        request: Request,
        draft: _drafts.Draft,
        *,
        points: int | None = None,
        **others: Any,
    ) -> Image:
        """Render a frame with what was found for the first one."""
        settings = {**self.begin.found, **request.settings}
        if points is not None:
            settings["detail"] = {"max_points": points}
        if draft.samples is not None:
            settings["method__samples"] = draft.samples
        if draft != _drafts.whole(request.samples):
            # The area of a pixel is for pictures that leave nothing out.
            settings["samples"] = 1
        # Standard errors come with the count of fragments.
        as_asked = {"accuracy": "8-bit", **others, "fragments": draft.samples is not None or others.get("fragments", False)}
        return scene.frame(
            camera=request.camera,
            size=draft.size(request.size),
            method=request.method,
            opacity_factor=self.begin.factor * request.opacity_factor,
            **as_asked,
            **settings,
        )

    def _stopper(self, is_outdated: Callable[[], bool], progress: Progress = None) -> Callable[..., _Stopper]:
        make = maker_of(progress)
        return lambda **given: _Stopper(is_outdated, None if make is None else make(**given))


class _Stopper:
    """A progress bar that stops outdated work, and passes progress on to another bar if there is one."""

    def __init__(self, is_outdated: Callable[[], bool], bar: Any = None) -> None:
        self._is_outdated = is_outdated
        self._bar = bar
        self.total: int | None = None

    def update(self, count: float = 1) -> None:
        if self._is_outdated():
            raise OutdatedError
        if self._bar is not None:
            self._bar.total = self.total
            self._bar.update(count)

    def close(self) -> None:
        """End the bar."""
        if self._bar is not None:
            self._bar.close()


def _begin(scene: Loaded, image: Image, camera: Any) -> Begin:
    """Return what the first picture of a scene decides, the method included; `camera` is the one that was asked for."""
    if not isinstance(camera, Camera) or None in (camera.eye, camera.target, camera.up):
        given = scene.scene
        vertical = given.get("camera.up") or _nearest_axis(image.camera)
        # Near and far that were found for one view, not given, would cut others.
        camera = replace(image.camera, up=vertical, near=given.get("camera.near"), far=given.get("camera.far"))
    found = _chosen(image)
    settings = {name: found.get(f"method.{name}", scene.scene.get(f"method.{name}")) for name in ("samples", "threshold")}
    settings = {name: value for name, value in settings.items() if value is not None}
    factor = json.loads(image.metadata.get("pellucid:see-through", "{}")).get("factor", 1.0)
    return Begin(Request(camera=camera, size=image.size, method=image.method), image, settings, factor, found)


def _chosen(image: Image) -> dict[str, Any]:
    """Return settings by their dotted keys that `max_error` or `budget_ms` chose for a picture."""
    choice = json.loads(image.metadata.get("pellucid:choice", "{}"))
    pairs = (pair.partition("=") for pair in choice.get("setting", "").split())
    return {key: _value(text) for key, _, text in pairs}


def _value(text: str) -> Any:
    """Return a value as an option of the command line has it: a number or a bool, else a text."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def _may_thin(scene: Loaded) -> bool:
    """Return True if drafts may leave points out: not with shadows, nor where the scene leaves points out by itself."""
    settings = scene.scene
    detail = (settings.get("detail.max_points"), settings.get("detail.spacing_px"))
    return len(scene) > _FEW_POINTS and not any(detail) and "shadows" not in settings.given()


def _fitting(size: tuple[int, int], most: tuple[int, int]) -> tuple[int, int]:
    """Return the size, made smaller until it fits."""
    factor = min(1.0, most[0] / size[0], most[1] / size[1])
    return max(round(size[0] * factor), 1), max(round(size[1] * factor), 1)


def _nearest_axis(camera: Camera) -> tuple[float, float, float]:
    """Return the axis of the world that is nearest to the top of the image; the camera turns around it."""
    up = np.asarray(camera.up)
    axis = np.zeros(3)
    axis[np.abs(up).argmax()] = np.sign(up[np.abs(up).argmax()])
    x, y, z = axis.tolist()
    return x, y, z
