"""`pellucid.view`: a window in a notebook, or a picture where a window isn't possible."""

from __future__ import annotations

import sys
import warnings
from typing import Any

from ._settings import Asked, ask
from ._types import Size


def shown(
    points: Any, *, size: Size | None, device: str | int | None, frame_ms: float, arguments: dict[str, Any], frame: dict[str, Any]
) -> Any:
    """Return what `pellucid.view` returns. `arguments` are those of `Renderer.load`, `frame` those of `Loaded.frame`."""
    # Wrong arguments are reported here; a window would find them by its first `picture()`.
    ask(Asked([], {}, {}), **frame)
    if _is_notebook():
        try:
            from ._window import Window
        except ImportError as error:
            from ._errors import PellucidWarning, outside

            warnings.warn(
                f"view shows a picture, since {error.name or error} is missing; for a window: pip install jupyter_rfb ipywidgets",
                PellucidWarning,
                stacklevel=outside(),
            )
        else:
            return Window(points, size=size, device=device, frame_ms=frame_ms, arguments=arguments, frame=frame)
    from . import render

    return render(points, device=device, **{**arguments, "size": size}, **frame)


def _is_notebook() -> bool:
    """Return True if a Jupyter kernel runs this, whose front end shows widgets."""
    shell = sys.modules.get("IPython")
    running = None if shell is None else shell.get_ipython()
    return getattr(running, "kernel", None) is not None
