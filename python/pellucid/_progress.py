"""Progress bars: tqdm, or any callable with the same arguments."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ._types import Progress

Listener = Callable[[str, int, "int | None"], None]


class _Bars:
    """A single bar at a time, and a new bar for each stage."""

    def __init__(self, make: Callable[..., Any]) -> None:
        self.make = make
        self.bar: Any = None
        self.stage: str | None = None
        self.done = 0
        self.total: int | None = None

    def __call__(self, stage: str, done: int, total: int | None) -> None:
        if self.bar is None or stage != self.stage or done < self.done:
            self.finish()
            self.bar = self.make(total=total, desc=stage)
            self.stage, self.done, self.total = stage, 0, None
        if total is not None:
            self.bar.total = self.total = total
        self.bar.update(done - self.done)
        self.done = done

    def finish(self) -> None:
        """End the bar of a finished stage. It becomes full, since the last step may not have been reported."""
        if self.bar is not None and self.total is not None and self.done < self.total:
            self.bar.update(self.total - self.done)
        self.close()

    def close(self) -> None:
        """End the bar where it is, for example after an error."""
        if self.bar is not None:
            self.bar.close()
            self.bar = None


@contextmanager
def listening(progress: Progress) -> Iterator[Listener | None]:
    """Yield a callable that native code reports progress to, or None. Raises what `maker_of` raises."""
    make = maker_of(progress)
    if make is None:
        yield None
        return
    bars = _Bars(make)
    try:
        yield bars
        bars.finish()
    finally:
        bars.close()


def maker_of(progress: Progress) -> Callable[..., Any] | None:
    """Return the callable that makes bars, or None.

    Raises TypeError for a ``progress`` that is neither a bool, None nor callable, and ImportError without tqdm.
    """
    if progress is None or progress is False:
        return None
    if progress is True:
        try:
            from tqdm.auto import tqdm
        except ImportError as error:
            raise ImportError(
                "progress=True needs tqdm (pip install tqdm); any callable with total= and desc= will do as well"
            ) from error
        made: Callable[..., Any] = tqdm
        return made
    if callable(progress):
        return progress
    kind = type(progress).__name__
    raise TypeError(f"progress: expected True, False, None or what makes a bar, as tqdm.tqdm, found {kind}")
