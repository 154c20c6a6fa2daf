"""Type names used in signatures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias

Path: TypeAlias = str | PathLike[str]
Size: TypeAlias = tuple[int, int]
# Samples of a pixel's area.
Samples: TypeAlias = int | Literal["auto"]
Accuracy: TypeAlias = Literal["exact", "8-bit"]
Setting: TypeAlias = bool | int | float | str | Sequence[Any] | Mapping[str, Any] | None
# True for a bar of tqdm, or what makes one: tqdm.tqdm, tqdm.notebook.tqdm.
Progress: TypeAlias = bool | Callable[..., Any] | None
