"""Keyword arguments as keys of the scene file.

The keys, their tables and their descriptions come from the table of the scene file readers, which also check the values.
"""

from __future__ import annotations

import functools
import json
import math
import os
import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple, TypedDict, cast

from . import _pellucid

# Where a key without a table is looked for, in this order: a name that several tables have goes to [method], `color` to
# all clouds. `size` and `samples` are always the picture's, though methods have them as well.
_ORDER = ("method", "cloud.*", "image", "shading", "detail", "shadows", "camera", "clip.*")
TABLES = ("image", "camera", "shading", "shadows", "detail", "method", "cloud", "clip")

# Options of the command line that are no keys of a scene file.
_DIRECTIONS = ("view", "azimuth", "elevation")
_LIMITS = ("see_through", "max_error", "budget_ms", "against", "memory_budget", "host_memory")
_SHORT = ("class_opacity", "classes", "without", "slices")

# Arguments that are no keys: columns of an array of points, and what belongs to a call.
COLUMNS = ("colors", "opacities", "radii", "normals", "classification", "intensity", "scalars", "z_up", "color_space", "name")
_OF_CALLS = {
    **dict.fromkeys(("fragments", "depths", "accuracy", "progress"), "this is an argument of render, or of frames"),
    "opacity_factor": "this is an argument of Loaded.frame; opacity= is a key",
    "device": "this is an argument of Renderer, and of render",
    "seed": "this is an argument of render, Renderer.load and Loaded.frame; a scene has it as scene.seed",
}

# Names of settings in other programs.
_ALIASES = {
    "alpha": "opacity",
    "background_color": "background",
    "bg": "background",
    "bgcolor": "background",
    "cmap": "colormap",
    "colour": "color",
    "colours": "colors",
    "fov": "fov_y",
    "img_size": "size",
    "labels": "classification",
    "orthographic": "ortho",
    "point_radius": "radius",
    "point_size": "radius",
    "rgb": "colors",
    "spp": "samples",
    "transparency": "opacity",
    "width": "size",
    "window_size": "size",
}

# Keys of clouds with one value for all points, and the columns with one for each.
_OF_EACH = {"opacity": "opacities", "radius": "radii", "color": "colors"}

# Limits that are numbers of bytes, and what a text of one ends with: powers of 1000, or with an i of 1024.
_BYTES = ("memory_budget", "host_memory")
_PREFIXES = ("", "k", "m", "g", "t", "p")
_TEXT_OF_BYTES = re.compile(r"(\d+(?:\.\d+)?)\s*(?:([kmgtp])(i?))?b?", re.IGNORECASE)

# The names of classes, for near misses; docs/scene-file.md lists their numbers.
CLASSES = (
    *("never-classified", "unclassified", "ground", "low-vegetation", "medium-vegetation", "high-vegetation", "building"),
    *("low-noise", "water", "rail", "road", "wire-guard", "wire-conductor", "transmission-tower", "wire-connector"),
    *("bridge-deck", "high-noise", "overhead-structure", "ignored-ground", "snow", "temporal-exclusion", "noise"),
)

# An option as errors name it, a dotted key, its value as TOML, and if it is appended.
Change = tuple[str, str, str, bool]


class KeyInfo(TypedDict):
    """A key of the scene file."""

    name: str
    about: str
    kind: str
    unit: str
    default: str | None
    without: str
    methods: list[str]


@functools.cache
def tables() -> dict[str, dict[str, KeyInfo]]:
    """Return all keys by table and name."""
    found = json.loads(_pellucid.keys())
    all = {table["path"]: {key["name"]: cast(KeyInfo, key) for key in table["keys"]} for table in found}
    name: KeyInfo = {
        "name": "name",
        "about": "The method.",
        "kind": "one of " + ", ".join(name for name, _ in _pellucid.methods()) + ", or auto",
        "unit": "",
        "default": '"auto"',
        "without": "",
        "methods": [],
    }
    all["method"] = {"name": name, **all["method"]}
    return all


def described(info: KeyInfo) -> str:
    """Return the description of a key, as a docstring."""
    text = f"{info['about']}\n\n{info['kind']}"
    if info["unit"]:
        text += f", {info['unit']}"
    if info["default"] is not None:
        text += f"; by default {info['default']}"
    elif info["without"]:
        text += f"; without it: {info['without']}"
    if info["methods"]:
        text += f". Of {', '.join(info['methods'])}"
    return text + "."


def toml(name: str, value: Any) -> str:
    """Return a value as TOML. Raises ValueError and TypeError that name the argument."""
    if hasattr(value, "tolist") and not isinstance(value, (str, bytes)):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{name}: expected a finite number, found {value}")
        return repr(value)
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        entries = (f"{toml(name, str(key))} = {toml(name, item)}" for key, item in value.items() if item is not None)
        return "{ " + ", ".join(entries) + " }"
    if isinstance(value, Iterable) and not isinstance(value, bytes):
        return "[" + ", ".join(toml(name, item) for item in value) + "]"
    kind = type(value).__name__
    raise TypeError(f"{name}: expected a number, a bool, a text, a list or a dict, found {kind}")


def dotted(name: str) -> str:
    """Return the dotted key that a keyword stands for. Raises TypeError for a keyword that no table has."""
    path = name.replace("__", ".")
    first, _, rest = path.partition(".")
    if rest and first in ("cloud", "clip"):
        return path if rest.partition(".")[0].isdigit() or rest.startswith("*.") else f"{first}.*.{rest}"
    if rest and first in TABLES:
        return path
    if path in ("size", "samples"):
        return f"image.{path}"
    if path in COLUMNS:
        # Though [method] has a name as well.
        raise TypeError(_unknown(name))
    if path == "resolution":
        raise TypeError("resolution: the picture's is size=(width, height), that of shadows shadows__resolution=")
    for table in _ORDER:
        if path in tables()[table]:
            return f"{table}.{path}"
    raise TypeError(_unknown(name))


def _unknown(name: str) -> str:
    if name in COLUMNS:
        return f"{name}: expected with an array of points, as in Cloud(points, {name}=…)"
    if name in _OF_CALLS:
        return f"{name}: expected a key of the scene file; {_OF_CALLS[name]}"
    keys = {key for table in tables().values() for key in table}
    known = keys | {"camera", *TABLES, *_DIRECTIONS, *_LIMITS, *_SHORT, *COLUMNS, *_OF_CALLS}
    near = _ALIASES.get(name.lower()) or nearest(name, known)
    hint = f"; did you mean {near!r}?" if near else "; docs/scene-file.md lists all keys"
    return f"{name!r} is neither an argument nor a key of the scene file{hint}"


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that is most like an unknown one, or None."""
    import difflib

    return next(iter(difflib.get_close_matches(name.lower(), sorted(known), n=1, cutoff=0.7)), None)


class Asked(NamedTuple):
    """Keyword arguments, sorted into changes of keys, directions and limits."""

    changes: list[Change]
    direction: dict[str, Any]
    limits: dict[str, Any]


def asked(settings: Mapping[str, Any]) -> Asked:
    """Sort keyword arguments that are keys or options. A value of None counts as not given."""
    found = Asked([], {}, {})
    for name, value in with_bytes(settings).items():
        if value is None:
            check_name(name)
        elif name in _DIRECTIONS:
            found.direction[name] = str(value) if name == "view" else _number(name, value)
        elif name in _LIMITS:
            found.limits[name] = _limit(name, value)
        elif name in _SHORT:
            found.changes.extend(_short(name, value))
        elif name in TABLES:
            _table(name, value, found)
        else:
            found.changes.append(change(name, dotted(name), value))
    if places(found.changes):
        one_view(found.direction)
    return found


def _limit(name: str, value: Any) -> Any:
    if name == "against":
        return picture_against(value)
    return value if name in _BYTES else _number(name, value)


def picture_against(value: Any) -> str:
    """Return the picture that errors are measured against, or raise ValueError."""
    if value not in ("center", "area"):
        raise ValueError(f"against: expected 'center' or 'area', found {value!r}")
    return str(value)


def check_name(name: str) -> None:
    """Raise TypeError for a name that is neither a key nor an option."""
    if name not in TABLES + _DIRECTIONS + _LIMITS + _SHORT:
        dotted(name)


def places(changes: Iterable[Change]) -> bool:
    """Return True if changes say where the camera is, or what it looks at."""
    return any(path in ("camera.eye", "camera.target") for _, path, _, _ in changes)


def one_view(direction: Mapping[str, Any]) -> None:
    """Refuse a direction where a camera was given."""
    for name in direction:
        raise TypeError(f"{name}: expected no camera beside it: both say from where; of a lens alone, camera={{'fov_y': 30}}")


def change(name: str, path: str, value: Any) -> Change:
    """Return the change of a dotted key. Raises ValueError and TypeError that call the key by `name`."""
    _check_one(name, path, value)
    given = _size(value) if name == "size" else value.tolist() if hasattr(value, "tolist") else value
    info = _info(path)
    if info is not None and "integer" in info["kind"]:
        given = _whole(given)
    return (f"{name}={_shown(value)}", path, toml(name, given), False)


def _info(path: str) -> KeyInfo | None:
    """Return what is known of a dotted key."""
    table, _, key = path.partition(".")
    if table in ("cloud", "clip"):
        table, key = f"{table}.*", key.partition(".")[2]
    return tables().get(table, {}).get(key)


def _whole(value: Any) -> Any:
    """Return whole floats as integers, also in lists, and all else as it is."""
    if isinstance(value, (list, tuple)):
        return [_whole(item) for item in value]
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _check_one(name: str, path: str, value: Any) -> None:
    """Refuse a value for each point where there is one for all of them."""
    key = path.rpartition(".")[2]
    if key not in _OF_EACH or not path.startswith("cloud.") or "class" in path:
        return
    levels = _levels(value) - (key == "color")
    if levels > 0:
        wanted = "one color" if key == "color" else "one number"
        kind, column = type(value).__name__, _OF_EACH[key]
        raise ValueError(f"{name}: expected {wanted} for all points, found {kind}; one for each point is {column}=")


def _levels(value: Any) -> int:
    """Return how deep lists are nested: 0 for a number, 1 for a list of numbers."""
    if hasattr(value, "ndim"):
        return int(value.ndim)
    return 1 + (_levels(value[0]) if value else 0) if isinstance(value, (list, tuple)) else 0


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _number(name: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: expected a number, found {type(value).__name__}") from None


def with_bytes(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings with ``memory_budget`` and ``host_memory`` in bytes, which may be texts such as "4GiB"."""
    return {**settings, **{name: _bytes(name, settings[name]) for name in _BYTES if settings.get(name) is not None}}


def _bytes(name: str, value: Any) -> int:
    number: Any = _bytes_of(value) if isinstance(value, str) else value
    is_number = isinstance(number, float) or (hasattr(number, "__index__") and not isinstance(number, bool))
    if not is_number or not 0 <= number < 2**63:
        raise ValueError(f"{name}: expected a number of bytes, or a text as '4GiB' or '500MB', found {value!r}")
    return int(number)


def _bytes_of(text: str) -> float:
    """Return the bytes that a text stands for, as on the command line; NaN for any other text."""
    parts = _TEXT_OF_BYTES.fullmatch(text.strip())
    if parts is None:
        return math.nan
    number, prefix, binary = parts.groups()
    unit: int = (1024 if binary else 1000) ** _PREFIXES.index((prefix or "").lower())
    return float(number) * unit


def _table(name: str, value: Any, found: Asked) -> None:
    """Add a whole table: its keys one by one; the method by its name alone, clips as a list, shadows as True or empty."""
    if name == "method" and isinstance(value, str):
        found.changes.append((f"method={value!r}", "method.name", toml(name, value), False))
    elif name == "clip":
        clips = [value] if isinstance(value, Mapping) else value
        if not isinstance(clips, Iterable) or isinstance(clips, str):
            raise TypeError(f"clip: expected a dict or a list of them, found {type(value).__name__}")
        found.changes.extend((f"clip={_shown(clip)}", "clip", toml("clip", clip), True) for clip in clips)
    elif name == "shadows" and (value is True or value == {}):
        # Of all tables this one does something by being there.
        found.changes.append((f"shadows={value!r}", "shadows", "{}", False))
    elif isinstance(value, Mapping):
        prefix = "cloud.*" if name == "cloud" else name
        paths = ((f"{prefix}.{key}", item) for key, item in value.items() if item is not None)
        found.changes.extend(change(path, path, item) for path, item in paths)
    else:
        kinds = {"camera": "a Camera or a dict", "method": "a name or a dict", "shadows": "True or a dict"}.get(name, "a dict")
        help = "; scene.shadows = None takes them out" if value is False and name == "shadows" else ""
        raise TypeError(f"{name}: expected {kinds} of keys of [{name}], found {type(value).__name__}{help}")


def _short(name: str, value: Any) -> list[Change]:
    """Return the changes for options that leave points out or make them see-through."""

    def entry(text: str, entry: dict[str, Any]) -> Change:
        return (text, "cloud.*.class", toml(name, entry), True)

    if name == "slices":
        return _slices(value)
    if name == "class_opacity":
        if not isinstance(value, Mapping):
            raise TypeError(f"class_opacity: expected a dict of opacities by class, found {type(value).__name__}")
        return [
            entry(f"class_opacity={{{key!r}: {opacity!r}}}", {"id": _code(name, key), "opacity": opacity})
            for key, opacity in value.items()
        ]
    if isinstance(value, str) or not isinstance(value, Iterable):
        value = [value]
    codes = [_code(name, item) for item in value]
    text = f"{name}={_shown(value)}"
    if name == "without":
        return [entry(text, {"id": code, "visible": False}) for code in codes]
    hidden = [code for code in range(256) if code not in codes]
    runs: list[list[int]] = []
    for code in hidden:
        if runs and runs[-1][1] == code - 1:
            runs[-1][1] = code
        else:
            runs.append([code, code])
    return [entry(text, {"scalar": "classification", "range": run, "visible": False}) for run in runs]


def _code(name: str, given: Any) -> int:
    """Return the code of a class, given by its number or name."""
    if isinstance(given, str) and not given.isdigit():
        code = _pellucid.class_code(given)
        if code is None:
            near = nearest(given.replace("_", "-").replace(" ", "-"), CLASSES)
            help = f"; did you mean {near!r}?" if near else "; a number from 0 to 255, or a name as docs/scene-file.md lists"
            raise ValueError(f"{name}: no class {given!r}{help}")
        return code
    try:
        number = math.nan if isinstance(given, bool) else float(given)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: expected a class, a number or a name, found {type(given).__name__}") from None
    if not (number.is_integer() and 0 <= number <= 255):
        raise ValueError(f"{name}: expected a class, a whole number from 0 to 255 or a name, found {given}")
    return int(number)


def _slices(value: Any) -> list[Change]:
    if not isinstance(value, Mapping):
        raise TypeError(f"slices: expected a dict as {{'z': (2, 4)}}, found {type(value).__name__}")
    changes: list[Change] = []
    for axis, ends in value.items():
        if axis not in ("x", "y", "z") or not isinstance(ends, (tuple, list)) or len(ends) != 2:
            raise ValueError(f"slices: expected 'x', 'y' or 'z' and two ends, either of them None, found {axis!r}: {ends!r}")
        slab = {"axis": axis, "min": _end(ends[0]), "max": _end(ends[1])}
        changes.append((f"slices={{{axis!r}: {ends!r}}}", "clip", toml("slices", {"slab": slab}), True))
    return changes


def _end(value: Any) -> float | None:
    return None if value is None else _number("slices", value)


def ask(
    found: Asked,
    *,
    camera_changes: list[Change] | None = None,
    fragments: bool = False,
    depths: bool = False,
    accuracy: str = "exact",
    opacity_factor: float = 1.0,
    radius_factor: float = 1.0,
    seed: int | None = None,
) -> dict[str, Any]:
    """Return a request for native code."""
    if accuracy not in ("exact", "8-bit"):
        raise ValueError(f"accuracy: expected 'exact' or '8-bit', found {accuracy!r}")
    return {
        "drop": [] if camera_changes is None else ["camera"],
        "changes": [*found.changes, *(camera_changes or [])],
        # Beside a direction a place of the camera would be ignored.
        "framed": camera_changes is None and not places(found.changes),
        "fragments": bool(fragments),
        "depths": bool(depths),
        "eight_bit": accuracy == "8-bit",
        "opacity_factor": _number("opacity_factor", opacity_factor),
        "radius_factor": _number("radius_factor", radius_factor),
        "seed": _seed(seed),
        **{name: found.limits.get(name) for name in _LIMITS},
    }


def _size(size: Any) -> list[int]:
    try:
        width, height = size
        sides = [int(width), int(height)]
        fine = sides == [width, height]
    except (TypeError, ValueError, OverflowError):
        fine = False
    if not fine:
        raise ValueError(f"size: expected (width, height), whole numbers from 1 to 16384, found {size!r}")
    return sides


def _seed(seed: int | None) -> int | None:
    if seed is None:
        return None
    if isinstance(seed, bool) or not hasattr(seed, "__index__") or not 0 <= seed.__index__() < 2**64:
        raise ValueError(f"seed: expected a whole number from 0 to 2**64 - 1, found {seed!r}")
    return seed.__index__()
