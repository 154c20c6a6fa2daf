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
    """Base of all measurements."""

    json: Any

    def _rows(self) -> list[dict[str, Any]]:
        raise NotImplementedError

    def to_pandas(self) -> Any:
        """Return a pandas.DataFrame. Raises ImportError without pandas."""
        try:
            import pandas
        except ImportError as error:
            raise ImportError("to_pandas() needs pandas: pip install pandas") from error
        return pandas.DataFrame(self._rows())

    def figure(self) -> Any:
        """Return a matplotlib.figure.Figure. Raises ImportError without matplotlib."""
        try:
            import matplotlib  # noqa: F401
        except ImportError as error:
            raise ImportError("figure() needs matplotlib: pip install matplotlib") from error
        from . import _figures

        return getattr(_figures, type(self).__name__.lower())(self)


@dataclass(frozen=True)
class Pass:
    """A pass of a frame, with all its dispatches added up."""

    name: str
    """Method and stage, as in ``abuffer/store``."""
    gpu_ms: float
    """Time on the device, in milliseconds."""
    invocations: int | None
    """Number of shader invocations; None where they are not counted."""
    bytes: int | None
    """Smallest number of bytes that the pass must read and write; None where it is unknown."""


@dataclass(frozen=True)
class FrameCost:
    """Cost of a frame."""

    gpu_ms: float
    """Time of all passes on the device, in milliseconds."""
    total_ms: float | None
    """Time of the whole frame on the device, without timestamps between passes, in milliseconds; None of a picture."""
    wall_ms: float
    """Time from the first submission to the picture in memory, in milliseconds."""
    waits: int
    """Number of submissions that the host waited for."""
    passes: tuple[Pass, ...]
    """Passes, in the order of the frame."""

    @classmethod
    def _of(cls, json: dict[str, Any]) -> FrameCost:
        passes = (Pass(p["name"], p["gpu_ms"], p.get("invocations"), p.get("bytes")) for p in json["passes"])
        return cls(json["gpu_ms"], json.get("total_ms"), json["wall_ms"], json.get("waits", 0), tuple(passes))


@dataclass(frozen=True)
class Profile(_Shown):
    """Cost of frames, pass by pass."""

    device: str
    """Name of the device."""
    driver: str
    """Name and version of the driver."""
    points: int
    """Number of points in the scene."""
    pixels: int
    """Number of pixels in the picture."""
    fragments: int
    """Number of fragments of all pixels; 0 for methods that don't count them."""
    max_list: int
    """Number of fragments of the pixel with the most; 0 for methods that don't count them."""
    list_histogram: tuple[tuple[int, int], ...]
    """Pairs of a list length and the number of pixels with lists of that length."""
    peak_device_bytes: int
    """Largest number of device bytes in use at any time, points and picture included."""
    fragment_bytes: int
    """Number of device bytes for the fragments stored at a time."""
    frames: tuple[FrameCost, ...]
    """Frames that were measured."""
    json: dict[str, Any] = field(repr=False, compare=False)
    """JSON that ``pellucid profile --json`` prints."""

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
        """Median time of a frame on the device, in milliseconds."""
        return _median([frame.gpu_ms for frame in self.frames])

    @property
    def wall_ms(self) -> float:
        """Median time of a frame, in milliseconds."""
        return _median([frame.wall_ms for frame in self.frames])

    def _rows(self) -> list[dict[str, Any]]:
        """Return a row for each pass of each frame."""
        frames = enumerate(self.frames)
        return [{"frame": number, **asdict(of)} for number, frame in frames for of in frame.passes]


def _median(values: list[float]) -> float:
    if not values:
        return math.nan
    ordered, middle = sorted(values), len(values) // 2
    return ordered[middle] if len(ordered) % 2 else (ordered[middle - 1] + ordered[middle]) / 2.0


@dataclass(frozen=True)
class TradeoffRow:
    """Measurement of a method with one setting."""

    method: str
    """Name of the method."""
    setting: str
    """Setting as options of the command line; empty for the defaults."""
    gpu_ms: float
    """Median time on the device, in milliseconds."""
    rmse: float
    """Root mean square error against the reference, in linear R, G, B over the background."""
    flip: float
    """Mean FLIP error against the reference, from 0 to 1."""
    above_1_255: float
    """Share of pixels with a channel off by more than 1/255, from 0 to 1."""
    peak_device_bytes: int
    """Largest number of device bytes in use at any time, points and picture included."""
    fragment_bytes: int
    """Number of device bytes for the fragments stored at a time."""
    frames: int
    """Number of frames of which the median is taken."""
    front: bool
    """True if the row is on the Pareto front of time and RMSE."""


@dataclass(frozen=True)
class Tradeoff(_Shown):
    """Error against time of the methods that draw a scene."""

    scene: str
    """Name of the scene."""
    device: str
    """Name of the device."""
    driver: str
    """Name and version of the driver."""
    size: Size
    """Width and height of the picture in pixels."""
    points: int
    """Number of points in the scene."""
    rows: tuple[TradeoffRow, ...]
    """Methods and settings that were measured."""
    skipped: tuple[tuple[str, str, str], ...]
    """Method, setting and reason for each row that was not measured."""
    json: dict[str, Any] = field(repr=False, compare=False)
    """JSON that ``pellucid tradeoff`` writes to tradeoff.json."""

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
    """Measurement of a method on a scene in which every pixel has the same number of layers."""

    workload: str
    """Either "stack" (each layer is a disc over the whole image) or "mosaic" (discs of 3 × 3 pixels)."""
    side: int
    """Width, and height, of the picture in pixels."""
    layers: int
    """Number of layers of each pixel."""
    fragments: int
    """Number of fragments of all pixels."""
    method: str
    """Name of the method, and behind it settings that are not its defaults."""
    gpu_ms: float
    """Median time on the device, in milliseconds."""
    peak_device_bytes: int
    """Largest number of device bytes in use at any time, points and picture included."""
    max_error: float
    """Largest error of any channel against the exact picture in float64."""
    rmse: float
    """Root mean square error against the exact picture in float64."""
    kind: str
    """Kind of method: "exact", "approximate" or "stochastic"."""
    bound: float | None
    """Largest error that the roundings of an exact method explain; None for other methods."""
    standard_errors: float | None
    """RMSE over the standard errors that a stochastic method states: about 1 if both are right; None for other methods."""
    holds: bool | None
    """True if the error is as expected; None for an approximation, of which nothing is expected."""


@dataclass(frozen=True)
class Stress(_Shown):
    """Time, memory and error for numbers of layers and pixels."""

    device: str
    """Name of the device."""
    driver: str
    """Name and version of the driver."""
    cells: tuple[StressCell, ...]
    """Combinations that were measured."""
    skipped: tuple[tuple[str, int, int, str, str], ...]
    """Workload, side, layers, method and reason for each combination that was not measured."""
    json: dict[str, Any] = field(repr=False, compare=False)
    """JSON that ``pellucid stress`` writes to stress.json."""

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
                of["kind"],
                of["bound"],
                error["standard_errors"],
                of["holds"],
            )

        device = json["device"]
        skipped = ((of["workload"], of["side"], of["layers"], of["method"], of["reason"]) for of in json["skipped"])
        return cls(device["name"], device["driver"], tuple(cell(of) for of in json["cells"]), tuple(skipped), json)

    def _rows(self) -> list[dict[str, Any]]:
        return [asdict(cell) for cell in self.cells]


@dataclass(frozen=True)
class CheckCase:
    """A numerically hard case with a known answer."""

    name: str
    """Method or topic, and the case, as in ``abuffer/faint-layers``."""
    about: str
    """What makes the case hard."""
    verdict: str
    """One of "pass", "fail" or "not applicable"."""
    error: float | None
    """Error, in the unit of the bound; None if the case has none."""
    bound: float | None
    """Largest error with which the case passes."""
    reason: str | None
    """Reason why the case did not run, or failed without an error; else None."""


@dataclass(frozen=True)
class Check(_Shown):
    """Results of the hard cases on a device; true if some passed and none failed."""

    device: str
    """Name of the device."""
    driver: str
    """Name and version of the driver."""
    passed: int
    """Number of cases that passed."""
    failed: int
    """Number of cases that failed."""
    cases: tuple[CheckCase, ...]
    """Cases, in the order in which they ran."""
    json: dict[str, Any] = field(repr=False, compare=False)
    """JSON that ``pellucid check --json`` prints."""

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
    """Difference of two pictures, in linear R, G, B of all pixels."""

    rmse: float
    """Root mean square error; 0 for equal pictures."""
    psnr: float
    """Peak signal-to-noise ratio in decibels; infinite for equal pictures."""
    ssim: float
    """Structural similarity, from -1 to 1; 1 for equal pictures."""
    flip: float
    """Mean FLIP error, from 0 to 1; 0 for equal pictures."""
    max_value: float
    """Largest difference in any channel."""
    max_at: tuple[int, int]
    """Column and row of the largest difference."""
    above_1_255: float
    """Share of pixels with a channel off by more than 1/255, from 0 to 1."""
    difference: NDArray[np.float32] = field(repr=False)
    """Absolute differences, shape (h, w, 3)."""
    json: dict[str, Any] = field(repr=False, compare=False)
    """JSON that ``pellucid compare --json`` prints."""

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
    """A pass, whether it runs, and the fact about the scene that decided it."""

    name: str
    """Name of the pass."""
    on: bool
    """True if the pass runs."""
    reason: str
    """Fact that decided whether it runs."""


@dataclass(frozen=True)
class Plan(_Shown):
    """Passes of a frame, each on or off."""

    method: str
    """Name of the method."""
    reason: str
    """Reason for the method."""
    passes: tuple[PlanPass, ...]
    """Passes, in the order of a frame."""
    json: list[dict[str, Any]] = field(repr=False, compare=False)
    """JSON that ``pellucid plan --json`` prints."""

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
    """Index, which ``device=`` takes."""
    name: str
    """Name; ``device=`` also takes a part of it."""
    driver: str
    """Name and version of the driver."""
    lacks: tuple[str, ...]
    """Features that the device lacks; empty if it can be used."""
    without: tuple[str, ...]
    """Methods that the device can't run, because its subgroups have another size."""
    taken: bool
    """True if this is the device that is used by default."""
