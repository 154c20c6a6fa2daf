# The public surface, for those who write against it. Replaced by annotated modules as they appear.
from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

Size: TypeAlias = tuple[int, int]
Accuracy: TypeAlias = Literal["exact", "8-bit"]
Setting: TypeAlias = bool | int | float | str | Sequence[bool | int | float | str] | Mapping[str, Any] | None
# True: a bar of tqdm. A callable: `tqdm.tqdm` or what takes total=, desc= and has update() and close().
Progress: TypeAlias = bool | Callable[..., Any] | None

class Error(RuntimeError): ...
class DeviceError(Error): ...
class SceneError(Error, ValueError): ...
class ReadError(Error, OSError): ...
class PellucidWarning(UserWarning): ...

class Cloud:
    # points (n, 3) any real dtype. colors (n, 3): uint8/uint16 are sRGB as files have them, floats are linear 0..1.
    # opacities (n,), radii (n,), normals (n, 3), scalars {name: (n,)}, classification (n,) uint8, intensity (n,).
    # scalars' names that files of LAS give: return_number, number_of_returns, point_source_id, gps_time.
    # z_up: True as readers of surveys (LAS, E57, PCD, text), False as models; None tells it from the shape as for PLY.
    # name: in place of a file's name in metadata and TOML.
    def __init__(
        self,
        points: ArrayLike,
        *,
        colors: ArrayLike | None = None,
        opacity: float | None = None,
        opacities: ArrayLike | None = None,
        radii: ArrayLike | None = None,
        normals: ArrayLike | None = None,
        classification: ArrayLike | None = None,
        intensity: ArrayLike | None = None,
        scalars: Mapping[str, ArrayLike] | None = None,
        z_up: bool | None = None,
        # Of colors that are floats; integers are sRGB in any case. "srgb": as open3d and PLY files have them.
        color_space: Literal["linear", "srgb"] = "linear",
        name: str | None = None,
    ) -> None: ...
    @classmethod
    def read(cls, path: str | os.PathLike[str], *, progress: Progress = None) -> Cloud: ...
    @classmethod
    def from_any(cls, object: Any, **columns: Any) -> Cloud: ...  # calls _foreign.columns(object)
    def __len__(self) -> int: ...
    @property
    def bounds(self) -> NDArray[np.float64]: ...  # (2, 3): smallest and largest corner
    @property
    def points(self) -> NDArray[np.float64]: ...
    @property
    def colors(self) -> NDArray[np.float32] | None: ...
    @property
    def classification(self) -> NDArray[np.uint8] | None: ...
    @property
    def intensity(self) -> NDArray[np.float32] | None: ...
    @property
    def scalars(self) -> dict[str, NDArray[np.float32]]: ...
    name: str

class Scene:
    def __init__(self, clouds: Cloud | Iterable[Cloud] = ..., **settings: Setting) -> None: ...
    @classmethod
    def read(cls, path: str | os.PathLike[str], *, progress: Progress = None) -> Scene: ...
    @classmethod
    def from_toml(cls, text: str, *, folder: str | os.PathLike[str] = ".", progress: Progress = None) -> Scene: ...
    def to_toml(self, folder: str | os.PathLike[str] = ".") -> str: ...
    # scene.set("method.samples", 64); scene.method.samples = 64; scene.cloud[0].opacity = 0.2; scene.image.background
    def set(self, key: str, value: Setting) -> None: ...
    def get(self, key: str) -> Any: ...
    image: Any
    camera: Any
    shading: Any
    shadows: Any
    detail: Any
    method: Any
    cloud: Any
    clip: Any
    clouds: list[Cloud]
    seed: int

@dataclass(frozen=True)
class Camera:
    eye: tuple[float, float, float] | None = None
    target: tuple[float, float, float] | None = None
    up: tuple[float, float, float] | None = None
    fov_y: float | None = None  # degrees; or
    height: float | None = None  # orthographic, world units over the image's height
    near: float | None = None
    far: float | None = None
    @classmethod
    def look_at(cls, eye: ArrayLike, target: ArrayLike, *, up: ArrayLike = (0.0, 0.0, 1.0), fov_y: float = 45.0, near: float | None = None, far: float | None = None) -> Camera: ...
    @classmethod
    def orthographic(cls, eye: ArrayLike, target: ArrayLike, height: float, *, up: ArrayLike = (0.0, 0.0, 1.0), near: float | None = None, far: float | None = None) -> Camera: ...
    @classmethod
    def from_opencv(cls, K: ArrayLike, world_to_camera: ArrayLike | None = None, *, R: ArrayLike | None = None, t: ArrayLike | None = None, size: Size) -> Camera: ...
    @classmethod
    def from_nerfstudio(cls, camera_to_world: ArrayLike, *, fl_x: float, fl_y: float, cx: float, cy: float, w: int, h: int) -> Camera: ...
    # Turned about the target by degrees: azimuth around `up`, elevation toward it (kept 1 degree off the poles).
    def orbit(self, azimuth: float, elevation: float = 0.0) -> Camera: ...
    # The distance to the target (and `height`) times a factor.
    def zoom(self, factor: float) -> Camera: ...
    # Eye and target moved across the view by shares of the image's height.
    def pan(self, right: float, up: float) -> Camera: ...

class Image:
    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[np.float32]: ...
    @property
    def shape(self) -> tuple[int, int, int]: ...
    @property
    def rgba(self) -> NDArray[np.float32]: ...
    @property
    def depth(self) -> NDArray[np.float32]: ...
    @property
    def median_depth(self) -> NDArray[np.float32] | None: ...
    @property
    def mean_depth(self) -> NDArray[np.float32] | None: ...
    @property
    def fragments(self) -> NDArray[np.uint32] | None: ...
    @property
    def stderr(self) -> float | None: ...
    @property
    def profile(self) -> Profile: ...
    method: str
    camera: Camera
    def over_background(self) -> NDArray[np.float32]: ...  # (h, w, 3) linear
    def to_srgb(self) -> NDArray[np.uint8]: ...  # (h, w, 3)
    def to_png(self, *, transparent: bool = False) -> bytes: ...
    def save(self, path: str | os.PathLike[str], *, transparent: bool = False) -> None: ...
    def _repr_png_(self) -> bytes: ...
    def _repr_html_(self) -> str: ...

class Renderer:
    def __init__(self, device: str | int | None = None) -> None: ...
    name: str
    driver: str
    def load(self, points: Any, *, seed: int = 0, progress: Progress = None, **settings: Setting) -> Loaded: ...
    def close(self) -> None: ...
    def __enter__(self) -> Renderer: ...
    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None: ...

class Loaded:
    # Any key of the scene file as settings, as in `render`; those of clouds that change points upload again.
    def frame(
        self,
        *,
        camera: Camera | None = None,
        size: Size | None = None,
        method: str | None = None,
        fragments: bool = False,
        depths: bool = False,
        accuracy: Accuracy = "exact",
        opacity_factor: float = 1.0,
        radius_factor: float = 1.0,
        seed: int | None = None,
        memory_budget: int | None = None,
        progress: Progress = None,
        **settings: Setting,
    ) -> Image: ...
    def profile(self, *, frames: int = 5, camera: Camera | None = None, size: Size | None = None, method: str | None = None, accuracy: Accuracy = "exact", progress: Progress = None, **settings: Setting) -> Profile: ...
    @property
    def camera(self) -> Camera: ...  # the scene's, or the automatic one: all of eye, target, up, fov_y or height, near, far
    @property
    def size(self) -> Size: ...
    @property
    def method(self) -> str: ...
    @property
    def reason(self) -> str: ...
    @property
    def bounds(self) -> NDArray[np.float64]: ...
    def __len__(self) -> int: ...
    def close(self) -> None: ...
    def __enter__(self) -> Loaded: ...
    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None: ...

# Plain data. `json` has the shape of the command line's JSON; `to_pandas` one row per entry of the main list;
# `figure` calls `_figures.<class in lower case>(self)` and gives a matplotlib Figure.
@dataclass(frozen=True)
class Pass:
    name: str
    gpu_ms: float
    invocations: int | None
    bytes: int | None

@dataclass(frozen=True)
class FrameCost:
    gpu_ms: float
    wall_ms: float
    waits: int
    passes: tuple[Pass, ...]

@dataclass(frozen=True)
class Profile:
    device: str
    driver: str
    points: int
    pixels: int
    fragments: int
    max_list: int
    list_histogram: tuple[tuple[int, int], ...]  # (length, pixels)
    peak_device_bytes: int
    fragment_bytes: int
    frames: tuple[FrameCost, ...]
    json: dict[str, Any]
    @property
    def gpu_ms(self) -> float: ...  # median
    @property
    def wall_ms(self) -> float: ...  # median
    def to_pandas(self) -> Any: ...  # a row per frame and pass
    def figure(self) -> Any: ...

@dataclass(frozen=True)
class TradeoffRow:
    method: str
    setting: str
    gpu_ms: float
    rmse: float
    flip: float
    above_1_255: float
    peak_device_bytes: int
    fragment_bytes: int
    frames: int
    front: bool  # on the Pareto front of device time and RMSE

@dataclass(frozen=True)
class Tradeoff:
    scene: str
    device: str
    driver: str
    size: Size
    points: int
    rows: tuple[TradeoffRow, ...]
    skipped: tuple[tuple[str, str, str], ...]  # method, setting, reason
    json: dict[str, Any]
    def to_pandas(self) -> Any: ...
    def figure(self) -> Any: ...

@dataclass(frozen=True)
class StressCell:
    workload: str  # "stack" or "mosaic"
    side: int
    layers: int
    fragments: int
    method: str
    gpu_ms: float
    peak_device_bytes: int
    max_error: float
    rmse: float

@dataclass(frozen=True)
class Stress:
    device: str
    driver: str
    cells: tuple[StressCell, ...]
    skipped: tuple[tuple[str, int, int, str, str], ...]  # workload, side, layers, method, reason
    json: dict[str, Any]
    def to_pandas(self) -> Any: ...
    def figure(self) -> Any: ...

@dataclass(frozen=True)
class CheckCase:
    name: str
    about: str
    verdict: str  # "pass", "fail" or "not applicable"
    error: float | None
    bound: float | None
    reason: str | None

@dataclass(frozen=True)
class Check:
    device: str
    driver: str
    passed: int
    failed: int
    cases: tuple[CheckCase, ...]
    json: dict[str, Any]
    def __bool__(self) -> bool: ...
    def to_pandas(self) -> Any: ...
    def figure(self) -> Any: ...

@dataclass(frozen=True)
class Comparison:
    rmse: float
    psnr: float  # inf for equal images
    ssim: float
    flip: float
    max_value: float
    max_at: tuple[int, int]  # x, y
    above_1_255: float
    difference: NDArray[np.float32]  # (h, w, 3), |a - b|
    json: dict[str, Any]
    def to_pandas(self) -> Any: ...
    def figure(self) -> Any: ...

@dataclass(frozen=True)
class PlanPass:
    name: str
    on: bool
    reason: str

@dataclass(frozen=True)
class Plan:
    method: str
    reason: str
    passes: tuple[PlanPass, ...]
    json: list[dict[str, Any]]
    def to_pandas(self) -> Any: ...
    def figure(self) -> Any: ...

@dataclass(frozen=True)
class Device:
    index: int
    name: str
    driver: str
    lacks: tuple[str, ...]
    taken: bool

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
    camera: Camera | None = None,
    size: Size | None = None,
    fragments: bool = False,
    depths: bool = False,
    accuracy: Accuracy = "exact",
    device: str | int | None = None,
    seed: int = 0,
    progress: Progress = None,
    # Keys of the scene file: `samples=64` is a key of [method], `image__background`, `shading__model`, `cloud__color_by` with two underscores for the dot;
    # the keys that only one table has need no table. A dict gives them with dots: **{"cloud.0.opacity": 0.2}.
    **settings: Setting,
) -> Image: ...
def profile(points: Any, *, frames: int = 5, camera: Camera | None = None, size: Size | None = None, method: str = "auto", device: str | int | None = None, progress: Progress = None, **settings: Setting) -> Profile: ...
def tradeoff(points: Any, *, quick: bool = False, only: Sequence[str] = (), seconds: float | None = None, folder: str | os.PathLike[str] | None = None, camera: Camera | None = None, size: Size | None = None, method: str = "auto", device: str | int | None = None, progress: Progress = None, **settings: Setting) -> Tradeoff: ...
def stress(*, sides: Sequence[int] | None = None, layers: Sequence[int] | None = None, methods: Sequence[str] | None = None, frames: int | None = None, quick: bool = False, device: str | int | None = None, progress: Progress = None) -> Stress: ...
def check(*names: str, device: str | int | None = None, progress: Progress = None) -> Check: ...
def compare(a: Image | ArrayLike | str | os.PathLike[str], b: Image | ArrayLike | str | os.PathLike[str]) -> Comparison: ...
def plan(points: Any, *, camera: Camera | None = None, size: Size | None = None, method: str = "auto", device: str | int | None = None, progress: Progress = None, **settings: Setting) -> Plan: ...
def devices() -> list[Device]: ...
def methods() -> list[str]: ...
def view(points: Any, **arguments: Any) -> Any: ...  # _view.view

# What helper B provides:
#   _foreign.columns(object) -> dict[str, Any] | None: arguments of Cloud(**columns) for an object of laspy, open3d, pyvista, plyfile
#     or pandas, None for others. No import of those packages: look at type(object).__module__.
#   _view.view(points, **arguments)
#   _figures.profile/tradeoff/stress/check/comparison/plan(data) -> matplotlib.figure.Figure
