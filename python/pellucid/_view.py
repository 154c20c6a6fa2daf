"""`pellucid.view`: a window in a notebook, or a picture where there can be none."""

from __future__ import annotations

import sys
import warnings
from typing import Any


def view(
    points: Any,
    *,
    size: tuple[int, int] | None = None,
    device: str | int | None = None,
    budget_ms: float = 33.0,
    **arguments: Any,
) -> Any:
    """Shows points in a notebook: drag to turn, wheel to come nearer, sliders for what the method has.

    While something moves, pictures have as many samples, pixels and points as fit `budget_ms`; at rest they get finer until
    nothing is left out. The window needs `jupyter_rfb` and `ipywidgets`, and a notebook (JupyterLab, Jupyter Notebook, VS
    Code). Elsewhere the result is the picture of `render`.

    Parameters
    ----------
    points
        What `render` takes: an array (n, 3), clouds, a scene, a path, or an object of laspy, open3d, pyvista, plyfile, pandas.
    size
        Columns and rows of the window in pixels of the page, by default at most 720 × 540. It can be pulled at its corner.
    device
        Name or number of the Vulkan device; by default the best one.
    budget_ms
        Milliseconds that a picture may take while something moves, above 0.
    arguments
        Anything else that `Renderer.load` takes: ``camera``, ``method``, ``seed``, columns of points, keys of the scene file.

    Returns
    -------
    A widget with ``camera``, the present view; ``picture()``, which renders it whole; and ``close()``, which gives the
    device's memory back. Or an `Image`.

    Raises
    ------
    ValueError
        An argument makes no sense; the message names it.
    Error
        Whatever `render` refuses.
    """
    if not budget_ms > 0:
        raise ValueError(f"budget_ms: found {budget_ms!r}, expected milliseconds above 0")
    if _is_notebook():
        try:
            from ._window import Window
        except ImportError as error:
            from ._errors import PellucidWarning

            warnings.warn(
                f"view shows a picture, since {error.name or error} is missing; for a window: pip install jupyter_rfb ipywidgets",
                PellucidWarning,
                stacklevel=2,
            )
        else:
            return Window(points, size=size, device=device, budget_ms=budget_ms, **arguments)
    from . import render

    return render(points, size=size, device=device, **arguments)


def _is_notebook() -> bool:
    """True if a kernel of Jupyter runs this, whose front end shows widgets."""
    shell = sys.modules.get("IPython")
    running = None if shell is None else shell.get_ipython()
    return getattr(running, "kernel", None) is not None
