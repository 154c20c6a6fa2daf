"""The window of `pellucid.view`: a canvas that Python draws, and controls below it."""

from __future__ import annotations

import asyncio
import base64
import math
import weakref
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import ipywidgets
import jupyter_rfb
import numpy as np
from numpy.typing import NDArray

from . import Camera, Image
from ._painter import Painter, Picture
from ._settings import tables

# Rows and columns of a picture at most, whatever the screen's density asks for.
_MOST_PIXELS = 4096

# The factor on the distance for a hundred pixels of the wheel, which is one notch of most mice.
_NOTCH = 1.15

# Methods whose pictures don't depend on opacity.
_OPAQUE = ("points", "squares", "circles", "paraboloid", "cone", "sphere", "hqs", "splats", "image-space")

_SAMPLES = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024)


class Canvas(jupyter_rfb.RemoteFrameBuffer):  # type: ignore[misc]
    """Canvas that shows the latest picture and passes on pointer events."""

    def __init__(self, window: Window, size: tuple[int, int]) -> None:
        self._window = weakref.proxy(window)
        self.pixels: NDArray[np.uint8] | None = None
        super().__init__(css_width=f"{size[0]}px", css_height=f"{size[1]}px", resizable=True, cursor="grab")

    def get_frame(self) -> NDArray[np.uint8] | None:
        """Return the latest picture, at most one for each frame that the page has taken."""
        return self.pixels

    def handle_event(self, event: dict[str, Any]) -> None:
        """Turn, move or resize the view."""
        self._window._handle(event)


class Window(ipywidgets.VBox):  # type: ignore[misc]
    """A scene in a notebook. `pellucid.view` makes it and explains its arguments.

    ``arguments`` are those of `Renderer.load`; ``frame`` has those of `Loaded.frame` for whole pictures.
    """

    def __init__(
        self,
        points: Any,
        *,
        size: tuple[int, int] | None,
        device: str | int | None,
        frame_ms: float,
        arguments: Mapping[str, Any],
        frame: Mapping[str, Any],
    ) -> None:
        # Events and pictures meet in the loop of the cell that makes the window.
        deliver = _deliver_to(weakref.ref(self), asyncio.get_running_loop())
        self._painter = Painter(points, arguments, device=device, frame=frame, size=size, frame_ms=frame_ms, deliver=deliver)
        try:
            self._begin()
        except BaseException:
            self._painter.close()
            raise

    def _begin(self) -> None:
        """Make the canvas and the controls around the first picture."""
        begin = self._painter.begin
        self._home = begin.request.camera
        self._still = begin.image.to_png()
        # Where the pointer was last while a button is pressed, and true if it moves the camera instead of turning it.
        self._pointer: tuple[float, float] | None = None
        self._moves = False
        width, height = begin.image.size
        self._css_size = (float(width), float(height))
        self._canvas = Canvas(self, (width, height))
        self._canvas.pixels = begin.image.to_srgb()
        self._status = ipywidgets.Label()
        self._controls = _controls(begin.image.method, begin.settings, self._control)
        self._request = replace(begin.request, **_values(self._controls))
        super().__init__([self._canvas, ipywidgets.HBox(list(self._controls.values())), self._status])
        self._finalizer = weakref.finalize(self, self._painter.close)
        self._ask()

    @property
    def camera(self) -> Camera:
        """Current view. Assign a `Camera` to change it; eye, target and up stay where the new camera has none."""
        return self._request.camera

    @camera.setter
    def camera(self, camera: Camera) -> None:
        if not isinstance(camera, Camera):
            raise TypeError(f"camera: expected a Camera, found {type(camera).__name__}")
        self._want(camera=_placed(camera, self.camera))

    def picture(self, size: tuple[int, int] | None = None) -> Image:
        """Render the current view with nothing left out. `size` is width and height, by default those of the window."""
        return self._painter.whole(self._request if size is None else replace(self._request, size=size))

    def close(self) -> None:
        """Close the window and free the device memory."""
        # ipywidgets closes windows that were never finished, too.
        if hasattr(self, "_finalizer"):
            self._finalizer()
            self._canvas.close()
        super().close()

    def _repr_mimebundle_(self, **given: Any) -> Any:
        """Return the widget, and a picture of it for pages without a kernel."""
        bundle = super()._repr_mimebundle_(**given)
        if bundle:
            (bundle[0] if isinstance(bundle, tuple) else bundle)["image/png"] = base64.b64encode(self._still).decode()
        return bundle

    def _want(self, **changes: Any) -> None:
        self._request = replace(self._request, **changes)
        self._ask()

    def _ask(self) -> None:
        self._painter.ask(self._request)

    def _control(self, _: Any) -> None:
        """Take over the value of a slider that was moved."""
        self._want(**_values(self._controls))

    def _show(self, made: Picture | Exception) -> None:
        """Show a picture, or the reason why there is none."""
        if isinstance(made, Exception):
            self._status.value = f"{type(made).__name__}: {made}"
            return
        self._canvas.pixels = made.pixels
        self._canvas.request_draw()
        self._status.value = _caption(made)

    def _handle(self, event: dict[str, Any]) -> None:
        kind = event["type"]
        if kind == "resize":
            self._resize(event)
        elif kind == "pointer_down":
            self._pointer = (event["x"], event["y"])
            self._moves = "Shift" in event.get("modifiers", ()) or event.get("button") != 1
        elif kind in ("pointer_move", "pointer_up") and self._pointer is not None:
            # The last movement comes with the release: one that the page held back comes after it.
            self._drag(event["x"], event["y"])
            if kind == "pointer_up":
                self._pointer = None
        elif kind == "wheel":
            # Lines and pages come as pixels already.
            self._want(camera=self.camera.zoom(_NOTCH ** (event["dy"] / 100)))
        elif kind == "double_click":
            # Back to the first view.
            self._want(camera=self._home)
        elif kind == "close":
            self._finalizer()

    def _drag(self, x: float, y: float) -> None:
        """Turn by half a turn over the window's height; move the view with Shift or a button other than the left one."""
        assert self._pointer is not None
        right, down = (x - self._pointer[0]) / self._css_size[1], (y - self._pointer[1]) / self._css_size[1]
        self._pointer = (x, y)
        if right == 0 == down:
            return
        if self._moves:
            self._want(camera=self.camera.pan(-right, down))
        else:
            self._want(camera=self.camera.orbit(-180 * right, 180 * down))

    def _resize(self, event: dict[str, Any]) -> None:
        ratio = event["ratio"]
        self._css_size = (max(event["width"], 1.0), max(event["height"], 1.0))
        width, height = (min(max(round(side * ratio), 1), _MOST_PIXELS) for side in self._css_size)
        if (width, height) != self._request.size:
            self._want(size=(width, height))


def _deliver_to(window: weakref.ref[Window], loop: asyncio.AbstractEventLoop) -> Any:
    """Return a function that brings pictures from the painter's thread to the loop and keeps no reference to the window."""

    def show(made: Picture | Exception) -> None:
        if (there := window()) is not None:
            there._show(made)

    def deliver(made: Picture | Exception) -> None:
        if not loop.is_closed():
            loop.call_soon_threadsafe(show, made)

    return deliver


def _placed(camera: Camera, present: Camera) -> Camera:
    """Return a camera with eye, target and up, taken from the current one where missing: the pointer can move no other camera."""
    names = ("eye", "target", "up")
    return replace(camera, **{name: getattr(present, name) for name in names if getattr(camera, name) is None})


def _controls(method: str, settings: dict[str, Any], changed: Any) -> dict[str, Any]:
    """Return sliders by name: opacity for all but opaque methods, the threshold for soft ones, and samples."""
    layout = ipywidgets.Layout(width="320px")
    made: dict[str, Any] = {}
    if method not in _OPAQUE:
        made["opacity_factor"] = ipywidgets.FloatLogSlider(
            value=1.0, base=10, min=-2, max=1, step=0.02, readout_format=".2f", description="opacity ×", layout=layout
        )
    if method in _methods_with("threshold"):
        start = float(settings.get("threshold", 0.5))
        made["threshold"] = ipywidgets.FloatSlider(value=start, min=0, max=1, step=0.01, description="threshold", layout=layout)
    if method in _methods_with("samples"):
        start = int(settings.get("samples", 64))
        options = sorted({*_SAMPLES, start})
        made["samples"] = ipywidgets.SelectionSlider(value=start, options=options, description="samples", layout=layout)
    for control in made.values():
        control.observe(changed, names="value")
    return made


def _methods_with(key: str) -> list[str]:
    """Return the methods for which a scene file has a key."""
    found = tables()["method"].get(key)
    return [] if found is None else found["methods"]


def _values(controls: dict[str, Any]) -> dict[str, Any]:
    """Return the values of the controls as a request has them."""
    values = {name: control.value for name, control in controls.items()}
    settings = {"threshold": values.pop("threshold")} if "threshold" in values else {}
    return {**values, "settings": settings}


def _caption(made: Picture) -> str:
    """Return the caption below the canvas: the method, what is left out, and the time."""
    parts = [made.method]
    if made.draft.samples is not None:
        parts.append(f"{made.draft.samples} samples")
    if made.draft.coarse > 1:
        parts.append(f"{made.draft.coarse} × {made.draft.coarse} pixels as one")
    parts.append("whole" if made.whole else "draft")
    if made.standard_error is not None and math.isfinite(made.standard_error):
        parts.append(f"standard error {made.standard_error:.2g}")
    return " · ".join([*parts, f"{made.ms:.0f} ms"])
