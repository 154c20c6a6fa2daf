"""Measurements as plain data, each with the JSON of the command line."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from ._types import Size

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class _Shown:
    """What all of them can do."""

    json: Any

    def _rows(self) -> list[dict[str, Any]]:
        raise NotImplementedError

    def to_pandas(self) -> Any:
        """A pandas.DataFrame. Raises ImportError without pandas."""
        try:
            import pandas
        except ImportError as error:
            raise ImportError("to_pandas() needs pandas: pip install pandas") from error
        return pandas.DataFrame(self._rows())

    def figure(self) -> Any:
        """A matplotlib.figure.Figure. Raises ImportError without matplotlib."""
        try:
            import matplotlib  # noqa: F401
        except ImportError as error:
            raise ImportError("figure() needs matplotlib: pip install matplotlib") from error
        from . import _figures

        return getattr(_figures, type(self).__name__.lower())(self)


@dataclass(frozen=True)
class Pass:
    """A pass of a frame, with all its dispatches together."""

    #: Method and stage, as in ``abuffer/store``.
    name: str
    #: Time on the device, milliseconds.
    gpu_ms: float
    #: Shader invocations, where they are counted.
    invocations: int | None
    #: Bytes that it must read and write at least, where that is known.
    bytes: int | None


@dataclass(frozen=True)
class FrameCost:
    """What a frame cost."""

    #: Time on the device of all passes, milliseconds.
    gpu_ms: float
    #: From the first submission to the picture in memory, milliseconds.
    wall_ms: float
    #: Submissions that the host waited for.
    waits: int
    passes: tuple[Pass, ...]

    @classmethod
    def _of(cls, json: dict[str, Any]) -> FrameCost:
        passes = (Pass(p["name"], p["gpu_ms"], p.get("invocations"), p.get("bytes")) for p in json["passes"])
        return cls(json["gpu_ms"], json["wall_ms"], json.get("waits", 0), tuple(passes))


@dataclass(frozen=True)
class Profile(_Shown):
    """What frames cost, pass by pass."""

    device: str
    driver: str
    #: Points of the scene, and pixels of the picture.
    points: int
    pixels: int
    #: Fragments of all pixels, and of the pixel with most of them; 0 of methods that count none.
    fragments: int
    max_list: int
    #: Length of a list, and pixels with lists of that length.
    list_histogram: tuple[tuple[int, int], ...]
    #: Largest number of device bytes at any time, points and picture included.
    peak_device_bytes: int
    fragment_bytes: int
    frames: tuple[FrameCost, ...]
    json: dict[str, Any] = field(repr=False)

    @classmethod
    def _of(cls, json: dict[str, Any]) -> Profile:
        device, scene, memory = json["device"], json["scene"], json["memory"]
        return cls(
            device["name"],
            device["driver"],
            scene["points"],
            scene["pixels"],
            scene["fragments"],
            scene["max_list"],
            tuple((length, pixels) for length, pixels in scene["list_histogram"]),
            memory["peak_device_bytes"],
            memory["fragment_bytes"],
            tuple(FrameCost._of(frame) for frame in json["frames"]),
            json,
        )

    @property
    def gpu_ms(self) -> float:
        """Median time on the device of a frame, milliseconds."""
        return _median([frame.gpu_ms for frame in self.frames])

    @property
    def wall_ms(self) -> float:
        """Median time of a frame, milliseconds."""
        return _median([frame.wall_ms for frame in self.frames])

    def _rows(self) -> list[dict[str, Any]]:
        """A row for each pass of each frame."""
        frames = enumerate(self.frames)
        return [{"frame": number, **asdict(of)} for number, frame in frames for of in frame.passes]


def _median(values: list[float]) -> float:
    if not values:
        return math.nan
    ordered, middle = sorted(values), len(values) // 2
    return ordered[middle] if len(ordered) % 2 else (ordered[middle - 1] + ordered[middle]) / 2.0


@dataclass(frozen=True)
class TradeoffRow:
    """A method with a setting."""

    method: str
    #: As options of the command line would give it; empty for the defaults.
    setting: str
    #: Median time on the device, milliseconds.
    gpu_ms: float
    #: Against the reference, on linear R, G, B over the background.
    rmse: float
    flip: float
    #: Share of pixels with a channel off by more than 1/255.
    above_1_255: float
    peak_device_bytes: int
    fragment_bytes: int
    #: Frames behind the median.
    frames: int
    #: True on the Pareto front of time and RMSE.
    front: bool


@dataclass(frozen=True)
class Tradeoff(_Shown):
    """Accuracy against time of the methods that draw a scene."""

    scene: str
    device: str
    driver: str
    size: Size
    points: int
    rows: tuple[TradeoffRow, ...]
    #: Method, setting and reason of what was not measured.
    skipped: tuple[tuple[str, str, str], ...]
    json: dict[str, Any] = field(repr=False)

    @classmethod
    def _of(cls, json: dict[str, Any]) -> Tradeoff:
        def row(of: dict[str, Any]) -> TradeoffRow:
            errors = of["errors"]
            return TradeoffRow(
                of["method"],
                of["setting"],
                of["gpu_ms"]["median"],
                errors["rmse"],
                errors["flip"],
                errors["above_1_255"],
                of["peak_device_bytes"],
                of["fragment_bytes"],
                of["frames"],
                of["front"],
            )

        width, height = json["size"]
        return cls(
            json["scene"],
            json["device"],
            json["driver"],
            (width, height),
            json["points"],
            tuple(row(of) for of in json["rows"]),
            tuple((of["method"], of["setting"], of["reason"]) for of in json["skipped"]),
            json,
        )

    def _rows(self) -> list[dict[str, Any]]:
        return [asdict(row) for row in self.rows]


@dataclass(frozen=True)
class StressCell:
    """A method on a scene in which every pixel has so many layers."""

    #: "stack" (a disc over the image for each layer) or "mosaic" (discs of 3 × 3 pixels).
    workload: str
    #: Columns, and rows.
    side: int
    layers: int
    fragments: int
    method: str
    #: Median time on the device, milliseconds.
    gpu_ms: float
    peak_device_bytes: int
    #: Against the reference in float64.
    max_error: float
    rmse: float


@dataclass(frozen=True)
class Stress(_Shown):
    """Time, memory and error over layers and pixels."""

    device: str
    driver: str
    cells: tuple[StressCell, ...]
    #: Workload, side, layers, method and reason of what was not measured.
    skipped: tuple[tuple[str, int, int, str, str], ...]
    json: dict[str, Any] = field(repr=False)

    @classmethod
    def _of(cls, json: dict[str, Any]) -> Stress:
        def cell(of: dict[str, Any]) -> StressCell:
            error = of["error"]
            return StressCell(
                of["workload"],
                of["side"],
                of["layers"],
                of["fragments"],
                of["method"],
                of["gpu_ms"]["median"],
                of["peak_device_bytes"],
                error["max"],
                error["rmse"],
            )

        device = json["device"]
        skipped = ((of["workload"], of["side"], of["layers"], of["method"], of["reason"]) for of in json["skipped"])
        return cls(device["name"], device["driver"], tuple(cell(of) for of in json["cells"]), tuple(skipped), json)

    def _rows(self) -> list[dict[str, Any]]:
        return [asdict(cell) for cell in self.cells]


@dataclass(frozen=True)
class CheckCase:
    """A hard case with a known answer."""

    name: str
    about: str
    #: "pass", "fail" or "not applicable".
    verdict: str
    error: float | None
    bound: float | None
    #: Of cases that did not run, or failed without an error.
    reason: str | None


@dataclass(frozen=True)
class Check(_Shown):
    """The hard cases on a device; true if some passed and none failed."""

    device: str
    driver: str
    passed: int
    failed: int
    cases: tuple[CheckCase, ...]
    json: dict[str, Any] = field(repr=False)

    @classmethod
    def _of(cls, json: dict[str, Any]) -> Check:
        def number(value: Any) -> float | None:
            return None if value is None else float(value)

        def case(of: dict[str, Any]) -> CheckCase:
            error, bound = number(of.get("error")), number(of.get("bound"))
            return CheckCase(of["name"], of["about"], of["verdict"], error, bound, of.get("reason"))

        device = json["device"]
        cases = tuple(case(of) for of in json["cases"])
        return cls(device["name"], device["driver"], json["passed"], json["failed"], cases, json)

    def __bool__(self) -> bool:
        return self.failed == 0 and self.passed > 0

    def _rows(self) -> list[dict[str, Any]]:
        return [asdict(case) for case in self.cases]


@dataclass(frozen=True, eq=False)
class Comparison(_Shown):
    """How far a picture is off another one, on linear R, G, B of all pixels."""

    rmse: float
    #: Decibels; infinite for equal pictures.
    psnr: float
    #: From -1 to 1; 1 for equal pictures.
    ssim: float
    #: From 0 to 1; 0 for equal pictures.
    flip: float
    #: The largest difference in any channel, and its column and row.
    max_value: float
    max_at: tuple[int, int]
    #: Share of pixels with a channel off by more than 1/255.
    above_1_255: float
    #: Absolute differences, shape (h, w, 3).
    difference: NDArray[np.float32] = field(repr=False)
    json: dict[str, Any] = field(repr=False)

    @classmethod
    def _of(cls, json: dict[str, Any], difference: NDArray[np.float32]) -> Comparison:
        most = json["max"]
        psnr = math.inf if json["psnr"] is None else json["psnr"]
        at = (most["x"], most["y"])
        values = (json["rmse"], psnr, json["ssim"], json["flip"], most["value"], at, json["above_1_255"])
        return cls(*values, difference, json)

    def _rows(self) -> list[dict[str, Any]]:
        names = ("rmse", "psnr", "ssim", "flip", "max_value", "above_1_255")
        return [{name: getattr(self, name) for name in names}]


@dataclass(frozen=True)
class PlanPass:
    """A pass, if it runs, and the fact about the scene that decided it."""

    name: str
    on: bool
    reason: str


@dataclass(frozen=True)
class Plan(_Shown):
    """The passes of a frame, each on or off."""

    method: str
    #: Why this method.
    reason: str
    passes: tuple[PlanPass, ...]
    json: list[dict[str, Any]] = field(repr=False)

    @classmethod
    def _of(cls, method: str, reason: str, json: list[dict[str, Any]]) -> Plan:
        passes = tuple(PlanPass(of["name"], of["on"], of["reason"]) for of in json)
        return cls(method, reason, passes, json)

    def _rows(self) -> list[dict[str, Any]]:
        return [asdict(of) for of in self.passes]


@dataclass(frozen=True)
class Device:
    """A Vulkan device of this machine."""

    index: int
    name: str
    driver: str
    #: Features that are missing; empty if it can be used.
    lacks: tuple[str, ...]
    #: Methods that it can't run, since its subgroups have another size.
    without: tuple[str, ...]
    #: True of the one that would be taken.
    taken: bool
