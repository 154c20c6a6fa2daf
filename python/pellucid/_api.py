"""Functions of the package."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from . import _pellucid
from ._camera import Camera
from ._progress import listening
from ._renderer import Loaded, Renderer, Sharing, _load, above_zero, positive, prepared, whole
from ._settings import _seed, picture_against
from ._types import Accuracy, Path, Progress, Samples, Size

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
    samples: Samples | None = None,
    fragments: bool = False,
    depths: bool = False,
    accuracy: Accuracy = "exact",
    device: str | int | None = None,
    seed: int | None = None,
    progress: Progress = None,
    **settings: Any,
) -> Image:
    """Render points to a picture.

    Parameters
    ----------
    points
        An array of shape (n, 3); a `Cloud` or several of them; a `Scene`; the path of a point cloud or of a scene file; or an
        object of laspy, Open3D (legacy or tensor), PyVista, plyfile or pandas.
    colors, opacities, radii, normals, scalars
        Columns that belong to an array of points, as for `Cloud`.
    opacity
        Opacity of all points, from 0 to 1; 1 by default.
    method
        One of the names that `methods` returns. "auto" is a method that is exact for the scene, unless the scene names a
        method.
    camera
        A `Camera`, or a dict of keys of [camera]. By default, a camera that sees the whole scene.
    size
        Width and height in pixels, each from 1 to 16384. By default, the size that the scene gives, else 1024 × 1024.
    samples
        Samples of each pixel's area: 1, 2, 4, 8, 16, 32, 64, or "auto". The picture is the mean of so many images, each moved by a
        fraction of a pixel, and takes up to as many times as long; "auto" doubles them until the picture changes by less than
        ``sampling_error``. By default, the number that the scene gives, else 1, which shows the center of each pixel. The samples
        that a stochastic method draws in each image are ``method__samples``.
    fragments
        If True, count the fragments of each pixel (`Image.fragments`) and find the standard error of stochastic methods.
    depths
        If True, find median and mean depths, each of which takes the time of another picture.
    accuracy
        "exact", or "8-bit" to stop blending once no 8-bit value would change by more than a quarter of a step. "8-bit" is faster,
        and is what the command line uses for a PNG.
    device
        Index of a device, or a part of its name. By default, the best device.
    seed
        Seed of everything random, from 0 to 2**64 - 1. By default, the seed of the scene, else 0.
    progress
        True for a tqdm bar, or a callable that makes a bar, such as ``tqdm.tqdm``.
    settings
        Keys of the scene file (docs/scene-file.md): ``ensembles=64`` of [method], ``radius=0.1`` of all clouds,
        ``background="white"``. If several tables have a key, put the table before it, as in ``shadows__samples=4``,
        ``cloud__0__color`` or ``method__size``. A whole table is a dict, as in ``shading={"model": "none"}``. These options of the
        command line are also accepted: ``view``, ``azimuth``, ``elevation``; ``class_opacity={"building": 0.1}``, ``classes``,
        ``without``; ``slices={"z": (2, 4)}``; ``see_through``, ``max_error``, ``budget_ms``, ``against="area"``;
        ``memory_budget`` and ``host_memory``, in bytes or as a text such as "4GiB".

    Returns
    -------
    Image
        An array of linear float32 R, G, B, A, shape (h, w, 4).

    Raises
    ------
    ValueError, TypeError
        An argument is wrong. The message names the argument, what was found and what was expected. For a setting, the error is a
        `SceneError`, which is a ValueError.
    ReadError
        A file can't be read. ReadError is an OSError.
    DeviceError
        No device was found, or the device failed or has too little memory.
    KeyboardInterrupt
        Ctrl-C was pressed. It ends the call within 0.2 s.
    """
    columns = {"colors": colors, "opacities": opacities, "radii": radii, "normals": normals, "scalars": scalars}
    arguments = _arguments(opacity, method, camera, size, samples, {**columns, **settings})
    with Sharing(device) as renderer, _loaded(renderer, points, arguments, seed, progress) as loaded:
        return loaded.frame(fragments=fragments, depths=depths, accuracy=accuracy, progress=progress)


def profile(
    points: Any,
    *,
    frames: int = 5,
    steady: bool = False,
    opacity: float | None = None,
    method: str = "auto",
    camera: Camera | Mapping[str, Any] | None = None,
    size: Size | None = None,
    samples: Samples | None = None,
    accuracy: Accuracy = "exact",
    device: str | int | None = None,
    seed: int | None = None,
    progress: Progress = None,
    **settings: Any,
) -> Profile:
    """Measure what the frames of a scene cost, pass by pass.

    A first frame, which isn't counted, pays for pipelines and buffers. ``frames`` is the number of frames that count, from 1 to
    100000. With ``steady`` their counts are foreseen, as in a window or a film, and a frame waits for the device once; without,
    each frame waits for its own counts. The other arguments are those of `render`.
    """
    count = positive("frames", frames)
    arguments = _arguments(opacity, method, camera, size, samples, settings)
    with Sharing(device) as renderer, _loaded(renderer, points, arguments, seed, progress) as loaded:
        return loaded.profile(frames=count, steady=steady, accuracy=accuracy, progress=progress)


def plan(
    points: Any,
    *,
    opacity: float | None = None,
    method: str = "auto",
    camera: Camera | Mapping[str, Any] | None = None,
    size: Size | None = None,
    samples: Samples | None = None,
    device: str | int | None = None,
    seed: int | None = None,
    progress: Progress = None,
    **settings: Any,
) -> Plan:
    """Return the passes of a frame, each on or off, with the fact that decides it, without rendering.

    The arguments are those of `render`.
    """
    from ._measures import Plan

    arguments = _arguments(opacity, method, camera, size, samples, settings)
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
    against: str = "center",
    folder: Path | None = None,
    opacity: float | None = None,
    method: str = "auto",
    camera: Camera | Mapping[str, Any] | None = None,
    size: Size | None = None,
    samples: Samples | None = None,
    device: str | int | None = None,
    seed: int | None = None,
    progress: Progress = None,
    **settings: Any,
) -> Tradeoff:
    """Measure error against time: every method and setting that draws the scene's image, compared with the exact one.

    Parameters
    ----------
    quick
        If True, measure only a part of them, for a first look in about a minute.
    only
        Names of methods. By default, all methods that apply.
    seconds
        Approximate rendering time in seconds, above 0. By default 360, or 55 with ``quick``.
    against
        "center" for errors against the exact image with the scene's samples; "area" for errors against the exact image with 64
        samples in a pixel, of each setting with 1, 4 and 16 samples.
    folder
        Folder for report.html, tables, figures and pictures. By default, they are thrown away. An interrupted run continues from
        what the folder holds.

    The other arguments are those of `render`; ``method`` selects the image that is compared.
    """
    import tempfile

    from ._measures import Tradeoff

    names = _names("only", only)
    known = methods()
    for name in names:
        if name not in known:
            raise ValueError(f"only: expected names of methods ({', '.join(known)}), found {name!r}")
    limit = None if seconds is None else above_zero("seconds", seconds)
    picture = picture_against(against)
    extent = {"quick": bool(quick), "only": names, "seconds": limit, "against": picture, "command": "pellucid.tradeoff()"}
    arguments = _arguments(opacity, method, camera, size, samples, settings)
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
    """Measure time, memory and error of the methods that blend discs or soft spheres as the number of layers grows.

    Parameters
    ----------
    quick
        If True, 1 to 1024 layers over 64² and 256² pixels; else 1 to 4096 layers over 64², 256² and 1024² pixels.
    methods, sides, layers
        Names of methods, side lengths of the square images in pixels, and numbers of layers, in place of the default ones.
    frames
        Number of frames per median.
    max_fragments, max_seconds
        Limits beyond which a cell is skipped: its number of fragments, and the time predicted for one of its frames in seconds.
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
    """Run the numerically hard cases on a device, each with a known answer.

    With ``names``, only cases run whose names contain one of them, as in ``check("abuffer/")``.
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
    """Measure how far picture ``b`` is from picture ``a``: RMSE, PSNR, SSIM, FLIP and the largest difference, in linear light.

    Both pictures must have the same size. Each is an `Image`, which is compared over its background; a PNG or EXR file; or an array
    of shape (h, w, 3) that holds linear floats, or uint8 or uint16 in sRGB. Raises ValueError for other shapes and types, and for
    colors that are not finite.
    """
    from ._measures import Comparison

    text, difference, width, height = _pellucid.compare(_picture("a", a), _picture("b", b))
    return Comparison._of(json.loads(text), difference.reshape(height, width, 3))


def devices() -> list[Device]:
    """Return the Vulkan devices of this machine. Raises DeviceError if the Vulkan loader is missing."""
    from ._measures import Device

    found = _pellucid.devices()
    return [
        Device(index, name, driver, tuple(lacks), tuple(without), taken) for index, name, driver, lacks, without, taken in found
    ]


def methods() -> list[str]:
    """Return the names of all methods. docs/methods.md describes them."""
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
    samples: Samples | None = None,
    fragments: bool = False,
    depths: bool = False,
    accuracy: Accuracy = "exact",
    device: str | int | None = None,
    seed: int | None = None,
    progress: Progress = None,
    frame_ms: float = 33.0,
    **settings: Any,
) -> Any:
    """Show points in a notebook: drag to turn, scroll to zoom, and move sliders for the settings of the method.

    Drag with Shift, or with a button other than the left one, to move the view. The wheel works once you have clicked the picture.
    A double click brings back the first view.

    While something moves, pictures have one of the ``samples`` of each pixel's area, and as many random samples, pixels and points
    as fit in ``frame_ms``. At rest, they become finer until nothing is left out. The window needs `jupyter_rfb` and `ipywidgets`,
    and a notebook (JupyterLab, Jupyter Notebook, VS Code).
    Elsewhere, the result is the picture of `render`. Raises what `render` raises.

    Parameters
    ----------
    size
        Width and height of the window in pixels of the page, by default at most 720 × 540. Drag its corner to resize it.
    fragments, depths, accuracy
        Arguments for the pictures that ``picture()`` returns.
    frame_ms
        Time that a picture may take while something moves, in milliseconds, above 0.
    settings
        Settings as for `render`. What ``see_through``, ``max_error`` and ``budget_ms`` find for the first picture stays in force
        for the later ones.

    The other arguments are those of `render`.

    Returns
    -------
    A widget with ``camera``, the current view; ``picture()``, which renders it with nothing left out; and ``close()``, which frees
    device memory. Without a window, an `Image`.
    """
    from ._view import shown

    columns = {"colors": colors, "opacities": opacities, "radii": radii, "normals": normals, "scalars": scalars}
    arguments = {**_arguments(opacity, method, camera, None, samples, {**columns, **settings}), "seed": seed, "progress": progress}
    frame = {"fragments": fragments, "depths": depths, "accuracy": accuracy}
    return shown(points, size=size, device=device, frame_ms=above_zero("frame_ms", frame_ms), arguments=arguments, frame=frame)


def _arguments(
    opacity: float | None,
    method: str,
    camera: Camera | Mapping[str, Any] | None,
    size: Size | None,
    samples: Samples | None,
    settings: Mapping[str, Any],
) -> dict[str, Any]:
    """Turn arguments of `render` into those of `Renderer.load`."""
    # The default leaves the scene its own.
    asked = None if method == "auto" else method
    return {"method": asked, "opacity": opacity, "camera": camera, "size": size, "samples": samples, **settings}


def _loaded(
    renderer: Renderer,
    points: Any,
    arguments: Mapping[str, Any],
    seed: int | None,
    progress: Progress,
    with_radii: bool = False,
) -> Loaded:
    """Load a scene on a renderer."""
    scene, found, camera = prepared(points, arguments)
    return _load(renderer, scene, found, camera, seed=seed, progress=progress, with_radii=with_radii)


def _names(name: str, given: Sequence[str]) -> list[str]:
    """Return a list of texts; a single text counts as a list of one."""
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
    """Return a picture for native code: a path, or R, G, B of all pixels with width and height."""
    from ._image import Image

    if isinstance(given, (str, os.PathLike)):
        return os.fspath(given)
    pixels = given.over_background() if isinstance(given, Image) else _pixels(name, given)
    height, width = pixels.shape[:2]
    return (pixels.reshape(-1), width, height)


def _pixels(name: str, given: ArrayLike) -> NDArray[Any]:
    """Return the array of a picture in the byte order and layout that native code needs."""
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
