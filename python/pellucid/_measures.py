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

    name: str
    """Method and stage, as in ``abuffer/store``."""
    gpu_ms: float
    """Time on the device, milliseconds."""
    invocations: int | None
    """Shader invocations, where they are counted."""
    bytes: int | None
    """Bytes that it must read and write at least, where that is known."""


@dataclass(frozen=True)
class FrameCost:
    """What a frame cost."""

    gpu_ms: float
    """Time on the device of all passes, milliseconds."""
    wall_ms: float
    """From the first submission to the picture in memory, milliseconds."""
    waits: int
    """Submissions that the host waited for."""
    passes: tuple[Pass, ...]
    """The passes, in the order of the frame."""

    @classmethod
    def _of(cls, json: dict[str, Any]) -> FrameCost:
        passes = (Pass(p["name"], p["gpu_ms"], p.get("invocations"), p.get("bytes")) for p in json["passes"])
        return cls(json["gpu_ms"], json["wall_ms"], json.get("waits", 0), tuple(passes))


@dataclass(frozen=True)
class Profile(_Shown):
    """What frames cost, pass by pass."""

    device: str
    """The device's name."""
    driver: str
    """The driver's name and version."""
    points: int
    """Points of the scene."""
    pixels: int
    """Pixels of the picture."""
    fragments: int
    """Fragments of all pixels; 0 of methods that count none."""
    max_list: int
    """Fragments of the pixel with most of them; 0 of methods that count none."""
    list_histogram: tuple[tuple[int, int], ...]
    """Length of a list, and pixels with lists of that length."""
    peak_device_bytes: int
    """Largest number of device bytes at any time, points and picture included."""
    fragment_bytes: int
    """Device bytes of the fragments that are stored at a time."""
    frames: tuple[FrameCost, ...]
    """Each frame that was measured."""
    json: dict[str, Any] = field(repr=False, compare=False)
    """What ``pellucid profile --json`` prints."""

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
    """Name of the method."""
    setting: str
    """As options of the command line would give it; empty for the defaults."""
    gpu_ms: float
    """Median time on the device, milliseconds."""
    rmse: float
    """Root mean square error against the reference, on linear R, G, B over the background."""
    flip: float
    """Mean FLIP error against the reference, from 0 to 1."""
    above_1_255: float
    """Share of pixels with a channel off by more than 1/255."""
    peak_device_bytes: int
    """Largest number of device bytes at any time, points and picture included."""
    fragment_bytes: int
    """Device bytes of the fragments that are stored at a time."""
    frames: int
    """Frames behind the median."""
    front: bool
    """True on the Pareto front of time and RMSE."""


@dataclass(frozen=True)
class Tradeoff(_Shown):
    """Accuracy against time of the methods that draw a scene."""

    scene: str
    """Name of the scene."""
    device: str
    """The device's name."""
    driver: str
    """The driver's name and version."""
    size: Size
    """Columns and rows of the picture."""
    points: int
    """Points of the scene."""
    rows: tuple[TradeoffRow, ...]
    """Each method and setting that was measured."""
    skipped: tuple[tuple[str, str, str], ...]
    """Method, setting and reason of what was not measured."""
    json: dict[str, Any] = field(repr=False, compare=False)
    """What ``pellucid tradeoff`` writes to tradeoff.json."""

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

    workload: str
    """Either "stack" (a disc over the image for each layer) or "mosaic" (discs of 3 × 3 pixels)."""
    side: int
    """Columns, and rows, of the picture."""
    layers: int
    """Layers of each pixel."""
    fragments: int
    """Fragments of all pixels."""
    method: str
    """Name of the method."""
    gpu_ms: float
    """Median time on the device, milliseconds."""
    peak_device_bytes: int
    """Largest number of device bytes at any time, points and picture included."""
    max_error: float
    """Largest error of any channel against the reference in float64."""
    rmse: float
    """Root mean square error against the reference in float64."""


@dataclass(frozen=True)
class Stress(_Shown):
    """Time, memory and error over layers and pixels."""

    device: str
    """The device's name."""
    driver: str
    """The driver's name and version."""
    cells: tuple[StressCell, ...]
    """Each combination that was measured."""
    skipped: tuple[tuple[str, int, int, str, str], ...]
    """Workload, side, layers, method and reason of what was not measured."""
    json: dict[str, Any] = field(repr=False, compare=False)
    """What ``pellucid stress`` writes to stress.json."""

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
    """Method or topic, and the case, as in ``abuffer/faint-layers``."""
    about: str
    """What is hard about it."""
    verdict: str
    """One of "pass", "fail" or "not applicable"."""
    error: float | None
    """Its error, in the unit of the bound; None where it has none."""
    bound: float | None
    """The largest error with which it passes."""
    reason: str | None
    """Of cases that did not run, or failed without an error."""


@dataclass(frozen=True)
class Check(_Shown):
    """The hard cases on a device; true if some passed and none failed."""

    device: str
    """The device's name."""
    driver: str
    """The driver's name and version."""
    passed: int
    """Number of cases that passed."""
    failed: int
    """Number of cases that failed."""
    cases: tuple[CheckCase, ...]
    """Each case, in the order in which they ran."""
    json: dict[str, Any] = field(repr=False, compare=False)
    """What ``pellucid check --json`` prints."""

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
    """Root mean square error; 0 for equal pictures."""
    psnr: float
    """Decibels; infinite for equal pictures."""
    ssim: float
    """From -1 to 1; 1 for equal pictures."""
    flip: float
    """From 0 to 1; 0 for equal pictures."""
    max_value: float
    """The largest difference in any channel."""
    max_at: tuple[int, int]
    """Its column and row."""
    above_1_255: float
    """Share of pixels with a channel off by more than 1/255."""
    difference: NDArray[np.float32] = field(repr=False)
    """Absolute differences, shape (h, w, 3)."""
    json: dict[str, Any] = field(repr=False, compare=False)
    """What ``pellucid compare --json`` prints."""

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
    """Name of the pass."""
    on: bool
    """True if it runs."""
    reason: str
    """The fact that decided it."""


@dataclass(frozen=True)
class Plan(_Shown):
    """The passes of a frame, each on or off."""

    method: str
    """Name of the method."""
    reason: str
    """Why this method."""
    passes: tuple[PlanPass, ...]
    """Each pass, in the order of a frame."""
    json: list[dict[str, Any]] = field(repr=False, compare=False)
    """What ``pellucid plan --json`` prints."""

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
    """Its index, which ``device=`` takes."""
    name: str
    """Its name; a part of it is what ``device=`` takes as well."""
    driver: str
    """The driver's name and version."""
    lacks: tuple[str, ...]
    """Features that are missing; empty if it can be used."""
    without: tuple[str, ...]
    """Methods that it can't run, since its subgroups have another size."""
    taken: bool
    """True of the one that would be taken."""
