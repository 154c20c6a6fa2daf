"""Names of types in signatures."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Union

Path = Union[str, "os.PathLike[str]"]
Size = tuple[int, int]
Accuracy = Literal["exact", "8-bit"]
Setting = Union[bool, int, float, str, Sequence[Any], Mapping[str, Any], None]
# True for a bar of tqdm, or what makes one: tqdm.tqdm, tqdm.notebook.tqdm.
Progress = Union[bool, Callable[..., Any], None]
