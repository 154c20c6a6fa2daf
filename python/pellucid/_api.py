"""The functions of the package."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from . import _pellucid
from ._camera import Camera
from ._progress import listening
from ._renderer import Loaded, Renderer, Sharing, _load, above_zero, positive, prepared, whole
from ._settings import _seed
from ._types import Accuracy, Path, Progress, Size

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._image import Image
    from ._measures import Check, Comparison, Device, Plan, Profile, Stress, Tradeoff


def render(
    points: Any,
    *,
    colors: ArrayLike | None = None,
    opacity: float | None = None,
    opacities: ArrayLike | None = None,
    radii: ArrayLike | None = None,
    normals: ArrayLike | None = None,
    scalars: Mapping[str, ArrayLike] | None = None,
    method: str = "auto",
    camera: Camera | Mapping[str, Any] | None = None,
    size: Size | None = None,
    fragments: bool = False,
    depths: bool = False,
    accuracy: Accuracy = "exact",
    device: str | int | None = None,
    seed: int | None = None,
    progress: Progress = None,
    **settings: Any,
) -> Image:
    """Renders points.

    Parameters
    ----------
    points
        An array of shape (n, 3); a `Cloud` or several; a `Scene`; a path of a cloud or of a scene file; or an object of laspy,
        open3d (legacy and tensor), pyvista, plyfile or pandas.
    colors, opacities, radii, normals, scalars
        Columns of an array of points, as of `Cloud`.
    opacity
        Opacity of all points, from 0 to 1; by default 1.
    method
        One of `methods`; "auto" is the cheapest one that is exact for the scene, unless the scene names one.
    camera
        A `Camera`, or a dict of keys of [camera]; by default one that sees the whole scene.
    size
        Columns and rows, each from 1 to 16384; by default the scene's, else 1024 x 1024.
    fragments
        Count the fragments of each pixel (`Image.fragments`), and find the standard error of stochastic methods.
    depths
        Find median and mean depths, each of which takes the time of another picture.
    accuracy
        "exact", or "8-bit" where blending may stop once no 8-bit value would move by more than a quarter of a step: faster, and
        what the command line does for a PNG.
    device
        Index or a part of the name; by default the best one.
    seed
        Of everything random; by default the scene's, else 0.
    progress
        True for a bar of tqdm, or what makes one.
    settings
        Keys of the scene file (docs/scene-file.md): ``samples=64`` of [method], ``radius=0.1`` of all clouds,
        ``background="white"``. A table before the key is for those that several tables have, as in ``shadows__samples=4``,
        ``cloud__0__color`` or ``method__size``; whole tables are dicts, as in ``shading={"model": "none"}``. Besides, as on the
        command line:
        ``view``, ``azimuth``, ``elevation``; ``class_opacity={"building": 0.1}``, ``classes``, ``without``;
        ``slices={"z": (2, 4)}``; ``see_through``, ``max_error``, ``budget_ms``; ``memory_budget`` and ``host_memory``, bytes or a
        text as "4GiB".

    Returns
    -------
    Image
        An array of linear float32 R, G, B, A, shape (h, w, 4).

    Raises
    ------
    ValueError, TypeError
        An argument is wrong; the message names it, what it is and what it should be. `SceneError`, which is a ValueError, of
        a setting.
    ReadError
        A file can't be read. It is an OSError.
    DeviceError
        No device is there, or it failed or has no room.
    KeyboardInterrupt
        Ctrl-C, within 0.2 s.
    """
    columns = {"colors": colors, "opacities": opacities, "radii": radii, "normals": normals, "scalars": scalars}
    arguments = _arguments(opacity, method, camera, size, {**columns, **settings})
    with Sharing(device) as renderer, _loaded(renderer, points, arguments, seed, progress) as loaded:
        return loaded.frame(fragments=fragments, depths=depths, accuracy=accuracy, progress=progress)


def profile(
    points: Any,
    *,
    frames: int = 5,
    opacity: float | None = None,
    method: str = "auto",
    camera: Camera | Mapping[str, Any] | None = None,
    size: Size | None = None,
    accuracy: Accuracy = "exact",
    device: str | int | None = None,
    seed: int | None = None,
    progress: Progress = None,
    **settings: Any,
) -> Profile:
    """Measures what frames of a scene cost, pass by pass, after a first one, which pays for pipelines and buffers.

    ``frames`` are those that count, from 1 to 100000; the others are as of `render`.
    """
    count = positive("frames", frames)
    arguments = _arguments(opacity, method, camera, size, settings)
    with Sharing(device) as renderer, _loaded(renderer, points, arguments, seed, progress) as loaded:
        return loaded.profile(frames=count, accuracy=accuracy, progress=progress)


def plan(
    points: Any,
    *,
    opacity: float | None = None,
    method: str = "auto",
    camera: Camera | Mapping[str, Any] | None = None,
    size: Size | None = None,
    device: str | int | None = None,
    seed: int | None = None,
    progress: Progress = None,
    **settings: Any,
) -> Plan:
    """The passes of a frame, each on or off, and the fact that decided it; renders nothing. The arguments are those of `render`."""
    from ._measures import Plan

    arguments = _arguments(opacity, method, camera, size, settings)
    with Sharing(device) as renderer, _loaded(renderer, points, arguments, seed, progress) as loaded:
        with listening(progress) as listener:
            text = loaded._native.plan(loaded._ask({}), listener)
        return Plan._of(*loaded._native.method(), json.loads(text))


def tradeoff(
    points: Any,
    *,
    quick: bool = False,
    only: Sequence[str] = (),
    seconds: float | None = None,
    folder: Path | None = None,
    opacity: float | None = None,
    method: str = "auto",
    camera: Camera | Mapping[str, Any] | None = None,
    size: Size | None = None,
    device: str | int | None = None,
    seed: int | None = None,
    progress: Progress = None,
    **settings: Any,
) -> Tradeoff:
    """Accuracy against time: every method and setting that draws the scene's image, against the exact one.

    Parameters
    ----------
    quick
        A part of it for a first look, in about a minute.
    only
        Names of methods; by default all that apply.
    seconds
        About how long frames may be rendered: by default 360, of a quick look 55.
    folder
        Where report.html, tables, figures and pictures go; by default they are thrown away. An interrupted run goes on there.

    The others are as of `render`; ``method`` says which image is compared.
    """
    import tempfile

    from ._measures import Tradeoff

    names = _names("only", only)
    known = methods()
    for name in names:
        if name not in known:
            raise ValueError(f"only: expected names of methods ({', '.join(known)}), found {name!r}")
    limit = None if seconds is None else above_zero("seconds", seconds)
    extent = {"quick": bool(quick), "only": names, "seconds": limit, "command": "pellucid.tradeoff()"}
    arguments = _arguments(opacity, method, camera, size, settings)
    with (
        Sharing(device) as renderer,
        _loaded(renderer, points, arguments, seed, progress, with_radii=True) as loaded,
        # Interrupted work may still write there.
        tempfile.TemporaryDirectory(prefix="pellucid-", ignore_cleanup_errors=True) as temporary,
        listening(progress) as listener,
    ):
        target = temporary if folder is None else os.fspath(folder)
        text = loaded._native.tradeoff(loaded._ask({}), extent, target, listener)
    return Tradeoff._of(json.loads(text))


def stress(
    *,
    quick: bool = False,
    methods: Sequence[str] | None = None,
    sides: Sequence[int] | None = None,
    layers: Sequence[int] | None = None,
    frames: int | None = None,
    max_fragments: int | None = None,
    max_seconds: float | None = None,
    seed: int = 0,
    device: str | int | None = None,
    progress: Progress = None,
) -> Stress:
    """Time, memory and error of the exact transparent methods over ever more layers.

    Parameters
    ----------
    quick
        1 to 1024 layers over 64² and 256² pixels instead of 1 to 4096 over 64², 256² and 1024².
    methods, sides, layers
        Other methods, sides of the square images and numbers of layers.
    frames
        Frames behind each median.
    max_fragments, max_seconds
        Cells with more fragments, or of which a longer frame is predicted, are skipped.
    """
    from ._measures import Stress

    names = None if methods is None else _names("methods", methods)
    if names == []:
        raise ValueError("methods: expected at least one name, found none; without it all that apply are measured")
    extent = {
        "quick": bool(quick),
        "methods": names,
        "sides": _integers("sides", sides),
        "layers": _integers("layers", layers),
        "frames": None if frames is None else positive("frames", frames),
        "max_fragments": None if max_fragments is None else whole("max_fragments", max_fragments, 2**63),
        "max_seconds": None if max_seconds is None else above_zero("max_seconds", max_seconds),
        "seed": _seed(seed) or 0,
        "command": "pellucid.stress()",
    }
    with Sharing(device) as renderer, listening(progress) as listener:
        text = _pellucid.stress(renderer._native, extent, listener)
    return Stress._of(json.loads(text))


def check(*names: str, device: str | int | None = None, progress: Progress = None) -> Check:
    """Runs the numerically hard cases on a device, each with a known answer.

    With ``names`` those whose names contain one of them, as in ``check("abuffer/")``.
    """
    from ._measures import Check

    for name in names:
        if not isinstance(name, str):
            hint = "; a list of names is check(*names)" if isinstance(name, (list, tuple, set)) else ""
            raise TypeError(f"names: expected texts, found {type(name).__name__}{hint}")
    with Sharing(device) as renderer, listening(progress) as listener:
        text = _pellucid.check(renderer._native, list(names), listener)
    return Check._of(json.loads(text))


def compare(a: Image | ArrayLike | Path, b: Image | ArrayLike | Path) -> Comparison:
    """Measures how far the picture ``b`` is off ``a``: RMSE, PSNR, SSIM, FLIP and the largest difference, in linear light.

    Pictures are of one size: an `Image`, which counts over its background; a PNG or EXR file; or an array of shape (h, w, 3), of
    linear floats, or of uint8 or uint16 as sRGB. Raises ValueError for other shapes and types, and for colors that are not finite.
    """
    from ._measures import Comparison

    text, difference, width, height = _pellucid.compare(_picture("a", a), _picture("b", b))
    return Comparison._of(json.loads(text), difference.reshape(height, width, 3))


def devices() -> list[Device]:
    """The Vulkan devices of this machine. Raises DeviceError where the loader is missing."""
    from ._measures import Device

    found = _pellucid.devices()
    return [
        Device(index, name, driver, tuple(lacks), tuple(without), taken) for index, name, driver, lacks, without, taken in found
    ]


def methods() -> list[str]:
    """The names of all methods; docs/methods.md describes them."""
    return [name for name, _ in _pellucid.methods()]


def view(
    points: Any,
    *,
    colors: ArrayLike | None = None,
    opacity: float | None = None,
    opacities: ArrayLike | None = None,
    radii: ArrayLike | None = None,
    normals: ArrayLike | None = None,
    scalars: Mapping[str, ArrayLike] | None = None,
    method: str = "auto",
    camera: Camera | Mapping[str, Any] | None = None,
    size: Size | None = None,
    fragments: bool = False,
    depths: bool = False,
    accuracy: Accuracy = "exact",
    device: str | int | None = None,
    seed: int | None = None,
    progress: Progress = None,
    frame_ms: float = 33.0,
    **settings: Any,
) -> Any:
    """Shows points in a notebook: drag to turn, wheel to come nearer, sliders for what the method has.

    Shift and drag moves the view, and so does another button than the left one. The wheel works once the picture was clicked.
    A double click brings the first view back.

    While something moves, pictures have as many samples, pixels and points as fit ``frame_ms``; at rest they get finer until
    nothing is left out. The window needs `jupyter_rfb` and `ipywidgets`, and a notebook (JupyterLab, Jupyter Notebook, VS
    Code). Elsewhere the result is the picture of `render`. Raises what `render` raises.

    Parameters
    ----------
    size
        Columns and rows of the window in pixels of the page, by default at most 720 × 540. It can be pulled at its corner.
    fragments, depths, accuracy
        Of the pictures that ``picture()`` gives.
    frame_ms
        Milliseconds that a picture may take while something moves, above 0.
    settings
        As of `render`. What ``see_through``, ``max_error`` and ``budget_ms`` find for the first picture stays in force for all.

    The others are as of `render`.

    Returns
    -------
    A widget with ``camera``, the present view; ``picture()``, which renders it whole; and ``close()``, which gives the
    device's memory back. Or an `Image`.
    """
    from ._view import shown

    columns = {"colors": colors, "opacities": opacities, "radii": radii, "normals": normals, "scalars": scalars}
    arguments = {**_arguments(opacity, method, camera, None, {**columns, **settings}), "seed": seed, "progress": progress}
    frame = {"fragments": fragments, "depths": depths, "accuracy": accuracy}
    return shown(points, size=size, device=device, frame_ms=above_zero("frame_ms", frame_ms), arguments=arguments, frame=frame)


def _arguments(
    opacity: float | None,
    method: str,
    camera: Camera | Mapping[str, Any] | None,
    size: Size | None,
    settings: Mapping[str, Any],
) -> dict[str, Any]:
    """Arguments of `render` as `Renderer.load` takes them."""
    # The default leaves the scene its own.
    asked = None if method == "auto" else method
    return {"method": asked, "opacity": opacity, "camera": camera, "size": size, **settings}


def _loaded(
    renderer: Renderer,
    points: Any,
    arguments: Mapping[str, Any],
    seed: int | None,
    progress: Progress,
    with_radii: bool = False,
) -> Loaded:
    """A scene on a renderer."""
    scene, found, camera = prepared(points, arguments)
    return _load(renderer, scene, found, camera, seed=seed, progress=progress, with_radii=with_radii)


def _names(name: str, given: Sequence[str]) -> list[str]:
    """A list of texts, of which one may come without the list."""
    if isinstance(given, str):
        return [given]
    if not hasattr(given, "__iter__") or isinstance(given, bytes):
        raise TypeError(f"{name}: expected a list of names, found {type(given).__name__}")
    return [str(one) for one in given]


def _integers(name: str, values: Sequence[int] | None) -> list[int] | None:
    if values is None:
        return None
    if isinstance(values, (str, bytes)) or not hasattr(values, "__iter__"):
        raise TypeError(f"{name}: expected a list of whole numbers, found {type(values).__name__}")
    return [positive(name, value) for value in values]


def _picture(name: str, given: Any) -> Any:
    """A picture for native code: a path, or linear R, G, B with columns and rows."""
    from ._image import Image

    if isinstance(given, (str, os.PathLike)):
        return os.fspath(given)
    pixels = given.over_background() if isinstance(given, Image) else _pixels(name, given)
    height, width = pixels.shape[:2]
    return (pixels.reshape(-1), width, height)


def _pixels(name: str, given: ArrayLike) -> NDArray[Any]:
    """An array of a picture, in the byte order and layout of native code."""
    import numpy as np

    array = np.asarray(given)
    if array.ndim != 3 or array.shape[2] != 3:
        hint = ""
        if array.ndim == 3 and array.shape[2] == 4:
            hint = "; of an Image give the image itself or image.over_background(), since four channels don't say the background"
        found = f"an array of shape {array.shape}{hint}"
        raise ValueError(f"{name}: expected an Image, a path or an array of shape (h, w, 3), found {found}")
    array = np.require(array, array.dtype.newbyteorder("="), ["C", "A"])
    if array.dtype not in (np.float32, np.float64, np.uint8, np.uint16):
        raise ValueError(f"{name}: expected linear floats, or uint8 or uint16 as sRGB, found an array of {array.dtype}")
    return array
