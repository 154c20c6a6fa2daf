"""Render point clouds you can see through, exactly or nearly, on devices with Vulkan 1.3, and time every pass.

>>> import numpy, pellucid
>>> points = numpy.random.default_rng(0).normal(size=(10_000, 3))
>>> image = pellucid.render(points, opacity=0.2, size=(256, 256))
>>> image.save("cloud.png")

`render` takes arrays, files, and objects of laspy, Open3D, PyVista, plyfile and pandas. A `Renderer` uploads points once and
renders any number of frames. `profile`, `tradeoff`, `stress`, `check`, `compare` and `plan` measure. `view` opens a window in a
notebook.
"""

from __future__ import annotations

import atexit as _atexit
from contextlib import suppress as _suppress
from typing import TYPE_CHECKING as _TYPE_CHECKING

from . import _pellucid
from ._api import check, compare, devices, methods, plan, profile, render, stress, tradeoff, view
from ._camera import Camera
from ._cloud import Cloud
from ._errors import DeviceError, Error, PellucidWarning, ReadError, SceneError
from ._renderer import Loaded, Renderer
from ._scene import Scene

if _TYPE_CHECKING:
    from ._image import Image
    from ._measures import (
        Check,
        CheckCase,
        Comparison,
        Device,
        FrameCost,
        Pass,
        Plan,
        PlanPass,
        Profile,
        Stress,
        StressCell,
        Tradeoff,
        TradeoffRow,
    )

__version__: str = _pellucid.VERSION

__all__ = [
    "Camera",
    "Check",
    "CheckCase",
    "Cloud",
    "Comparison",
    "Device",
    "DeviceError",
    "Error",
    "FrameCost",
    "Image",
    "Loaded",
    "Pass",
    "PellucidWarning",
    "Plan",
    "PlanPass",
    "Profile",
    "ReadError",
    "Renderer",
    "Scene",
    "SceneError",
    "Stress",
    "StressCell",
    "Tradeoff",
    "TradeoffRow",
    "__version__",
    "check",
    "compare",
    "devices",
    "methods",
    "plan",
    "profile",
    "render",
    "stress",
    "tradeoff",
    "view",
]


def _end() -> None:
    """Wait for interrupted work, which may still use the device that the end of the process takes away. Ctrl-C ends the wait."""
    with _suppress(KeyboardInterrupt):
        _pellucid.wait(10.0)


_atexit.register(_end)


def __getattr__(name: str) -> object:
    """Import `Image`, which needs NumPy, and the measurement classes, a fifth of the import time, when they are first used."""
    if name == "Image":
        from ._image import Image

        return Image
    if name in __all__:
        from . import _measures

        return getattr(_measures, name)
    raise AttributeError(f"module 'pellucid' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
