"""Scenes: clouds, and the settings by which they are rendered."""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Iterable, Mapping
from typing import Any, cast

from . import _pellucid
from ._cloud import Cloud
from ._progress import listening
from ._settings import TABLES, Change, asked, described, dotted, tables, toml
from ._types import Path, Progress, Setting


class Table:
    """A table of a scene file; its keys are attributes, each with the value in force.

    What is assigned is checked as in a scene file. None, or ``del``, takes a key out, so that its default holds. `keys` lists
    them, and ``help()`` describes them.
    """

    __slots__ = ("_path", "_scene")

    _scene: Scene
    _path: str

    def __init__(self, scene: Scene, path: str) -> None:
        object.__setattr__(self, "_scene", scene)
        object.__setattr__(self, "_path", path)

    def keys(self) -> list[str]:
        """The names of all keys."""
        return list(tables()[_generic(self._path)])

    def doc(self, key: str) -> str:
        """The description of a key: values, unit, default."""
        table = tables()[_generic(self._path)]
        if key not in table:
            raise AttributeError(f"[{self._path}] has no key {key!r}; it has {', '.join(table)}")
        return described(table[key])

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        raise AttributeError(f"[{self._path}] has no key {name!r}; it has {', '.join(self.keys())}")

    def __setattr__(self, name: str, value: Any) -> None:
        key = name.replace("__", ".")
        if key not in tables()[_generic(self._path)]:
            raise AttributeError(f"[{self._path}] has no key {name!r}; it has {', '.join(self.keys())}")
        self._scene.set(f"{self._path}.{key}", value)

    def __delattr__(self, name: str) -> None:
        self._scene.set(f"{self._path}.{name.replace('__', '.')}", None)

    def __dir__(self) -> list[str]:
        return sorted({*object.__dir__(self), *(key.replace(".", "__") for key in self.keys())})

    def __repr__(self) -> str:
        values = ", ".join(f"{key}={value!r}" for key, value in self._scene._values(self._path).items() if value is not None)
        return f"<[{self._path}] {values}>"


class CloudTables:
    """The settings of the clouds: ``scene.cloud[0].opacity = 0.2`` of one, ``scene.cloud.opacity = 0.2`` of all."""

    __slots__ = ("_scene",)

    _scene: Scene

    def __init__(self, scene: Scene) -> None:
        object.__setattr__(self, "_scene", scene)

    def __len__(self) -> int:
        return self._scene._native.counts()[0]

    def __getitem__(self, index: int) -> Table:
        count = len(self)
        if not -count <= index < count:
            raise IndexError(f"cloud: expected an index below {count}, found {index}")
        return _table(self._scene, f"cloud.{index % count}")

    def __setattr__(self, name: str, value: Any) -> None:
        key = name.replace("__", ".")
        if key not in tables()["cloud.*"]:
            raise AttributeError(f"[[cloud]] has no key {name!r}; it has {', '.join(tables()['cloud.*'])}")
        self._scene.set(f"cloud.*.{key}", value)

    def __dir__(self) -> list[str]:
        return sorted({*object.__dir__(self), *(key.replace(".", "__") for key in tables()["cloud.*"])})


def _generic(path: str) -> str:
    first, _, rest = path.partition(".")
    return f"{first}.*" if rest and first in ("cloud", "clip") else path


@functools.cache
def _class(path: str) -> type[Table]:
    """A class of a table with a property for each key, for completion and help."""

    def key_property(key: str, about: str) -> property:
        def get(table: Table) -> Any:
            return table._scene.get(f"{table._path}.{key}")

        return property(get, None, None, about)

    keys = tables()[path]
    members: dict[str, Any] = {key.replace(".", "__"): key_property(key, described(info)) for key, info in keys.items()}
    members["__slots__"] = ()
    members["__doc__"] = f"The keys of [{path}] of a scene file, with their values in force."
    name = "".join(part.title() for part in path.replace("*", "").split("."))
    return cast("type[Table]", type(f"{name}Table", (Table,), members))


def _table(scene: Scene, path: str) -> Table:
    return _class(_generic(path))(scene, path)


class Scene:
    """Clouds, and the settings by which they are rendered: what a scene file holds.

    The tables of the file are attributes, their keys attributes of those: ``scene.method.samples = 64``,
    ``scene.image.background``, ``scene.cloud[0].opacity``. docs/scene-file.md describes all keys; so do completion and
    ``help(scene.method)``.

    Parameters
    ----------
    clouds
        A `Cloud`, or several.
    settings
        Keys of the scene file, as of `render`.

    Raises
    ------
    SceneError
        A key or value that a scene file can't have. It is a ValueError, too.
    """

    __slots__ = ("_native", "seed")

    _native: _pellucid.Scene
    #: Of everything random.
    seed: int

    def __init__(self, clouds: Cloud | Iterable[Cloud], **settings: Setting) -> None:
        given = [clouds] if isinstance(clouds, Cloud) else list(clouds)
        for index, cloud in enumerate(given):
            if not isinstance(cloud, Cloud):
                raise TypeError(f"clouds: expected clouds, found {type(cloud).__name__} at {index}; Cloud.from_any makes one")
        if not given:
            raise ValueError("clouds: expected at least one cloud, found none")
        self._native = _pellucid.Scene.of_clouds([cloud._native for cloud in given], _names(given))
        self.seed = 0
        opacities = [(index, cloud.opacity) for index, cloud in enumerate(given) if cloud.opacity is not None]
        self._change([(f"opacity={a}", f"cloud.{index}.opacity", toml("opacity", a), False) for index, a in opacities])
        self.update(**settings)

    @classmethod
    def read(cls, *paths: Path, progress: Progress = None) -> Scene:
        """Opens a scene file (``.toml``), or clouds. Clouds are read when they are needed; huge ones stay where they are stored.

        Raises SceneError for what is wrong with the file, by line and column, and ReadError for a cloud that isn't there.
        """
        if not paths:
            raise TypeError("paths: expected a scene file or clouds, found none; Scene.built_in() is the built-in scene")
        scene = cls._of(_pellucid.Scene.of_files([os.fspath(path) for path in paths], 0))
        # What is missing should be told here.
        missing = [path for path in paths if not os.path.exists(path)]
        if missing:
            from ._errors import ReadError

            raise ReadError(f"{os.fspath(missing[0])}: no such file")
        if progress:
            scene._clouds(progress)
        return scene

    @classmethod
    def from_toml(cls, text: str, *, folder: Path = ".", progress: Progress = None) -> Scene:
        """A scene of the text of a scene file, whose relative paths begin in ``folder``."""
        scene = cls._of(_pellucid.Scene.of_toml(text, os.fspath(folder)))
        if progress:
            scene._clouds(progress)
        return scene

    @classmethod
    def built_in(cls, seed: int = 0) -> Scene:
        """The built-in scene: a garden with a house."""
        scene = cls._of(_pellucid.Scene.of_files([], seed))
        scene.seed = seed
        return scene

    @classmethod
    def _of(cls, native: _pellucid.Scene) -> Scene:
        scene = cls.__new__(cls)
        scene._native, scene.seed = native, native.seed
        return scene

    def copy(self) -> Scene:
        """Another scene of the same clouds, whose settings change by themselves."""
        scene = Scene._of(self._native.copy())
        scene.seed = self.seed
        return scene

    def to_toml(self, folder: Path = ".") -> str:
        """The text of a scene file for ``folder``; clouds that came from arrays have names in place of files."""
        return self._native.to_toml(os.fspath(folder))

    def set(self, key: str, value: Setting) -> None:
        """Gives a dotted key a value, as in ``method.samples``, ``cloud.0.opacity`` or ``cloud.*.radius``; None takes it out.

        Raises SceneError for a key or value that no scene has; the scene then stays as it was.
        """
        if not isinstance(key, str):
            raise TypeError(f"key: expected a dotted key as 'method.samples', found {type(key).__name__}")
        if value is None:
            self._native.remove(key)
        else:
            self._change([(f"{key}={value!r}", key, toml(key, value), False)])

    def get(self, key: str) -> Any:
        """The value in force of a dotted key; None where nothing is given and nothing stands for it. KeyError for unknown keys."""
        path = _path(key)
        table, name = _split(path)
        values = self._values(table)
        if values.get(name) is not None:
            return values[name]
        given: Any = self.given()
        for part in path:
            if isinstance(given, list) and part.isdigit() and int(part) < len(given):
                given = given[int(part)]
            elif isinstance(given, dict) and part in given:
                given = given[part]
            elif name in tables().get(_generic(table), {}):
                return None
            else:
                raise KeyError(key)
        return given

    def given(self) -> dict[str, Any]:
        """All keys that were given, table by table."""
        return cast("dict[str, Any]", json.loads(self._native.given()))

    def update(self, **settings: Setting) -> None:
        """Changes several settings at once, named as for `render`; all of them or none."""
        found = asked(settings)
        for name in found.limits:
            raise TypeError(f"{name}: expected a key of the scene file; this belongs to a frame: render(…, {name}=…)")
        self._native.change(found.drop, found.changes)
        if found.direction:
            self._direct(found.direction)

    def _direct(self, direction: dict[str, Any]) -> None:
        self._native.set_view({name: direction.get(name) for name in ("view", "azimuth", "elevation")})

    def _change(self, changes: list[Change]) -> None:
        if changes:
            self._native.change([], changes)

    def _values(self, table: str) -> dict[str, Any]:
        return {name: None if text is None else _parsed(text) for name, text in self._native.values(table)}

    def _clouds(self, progress: Progress) -> list[_pellucid.Cloud]:
        with listening(progress) as listener:
            return self._native.clouds(listener)

    @property
    def clouds(self) -> list[Cloud]:
        """The points of its clouds; those of files are read now."""
        natives = self._clouds(None)
        names = [str(self.get(f"cloud.{index}.path")) for index in range(len(natives))]
        return [Cloud._of(native, name) for native, name in zip(natives, names, strict=True)]

    @property
    def image(self) -> Any:
        """``[image]``: size, background, color space."""
        return _table(self, "image")

    @property
    def camera(self) -> Any:
        """``[camera]``."""
        return _table(self, "camera")

    @property
    def shading(self) -> Any:
        """``[shading]``."""
        return _table(self, "shading")

    @property
    def shadows(self) -> Any:
        """``[shadows]``."""
        return _table(self, "shadows")

    @property
    def detail(self) -> Any:
        """``[detail]``: points that are left out."""
        return _table(self, "detail")

    @property
    def method(self) -> Any:
        """``[method]``: the name, and the keys that the method has."""
        return _table(self, "method")

    @method.setter
    def method(self, name: str) -> None:
        self.set("method.name", name)

    @property
    def cloud(self) -> CloudTables:
        """The settings of the clouds, ``scene.cloud[0]`` those of the first one."""
        return CloudTables(self)

    @property
    def clip(self) -> list[dict[str, Any]]:
        """``[[clip]]``: boxes, planes, slabs and polygons that points must lie in. Assign a list of dicts to change it."""
        return cast("list[dict[str, Any]]", self.given().get("clip", []))

    @clip.setter
    def clip(self, clips: Iterable[Mapping[str, Any]]) -> None:
        entries: list[Change] = [(f"clip={clip!r}", "clip", toml("clip", clip), True) for clip in clips]
        self._native.change(["clip"], entries)

    def __repr__(self) -> str:
        count = len(self.cloud)
        return f"<pellucid.Scene of {count} cloud{'' if count == 1 else 's'}, method {self.method.name}>"


def _names(clouds: list[Cloud]) -> list[str]:
    """Names that tell clouds apart."""
    names = [cloud.name for cloud in clouds]
    return [name if names.count(name) == 1 else f"{name}-{index}" for index, name in enumerate(names)]


def _path(key: str) -> list[str]:
    """The parts of a dotted key; of all clouds the first one stands for them."""
    parts = key.split(".") if "." in key or key in TABLES else dotted(key).split(".")
    if parts[0] in ("cloud", "clip") and len(parts) > 1 and parts[1] == "*":
        parts[1] = "0"
    return parts


def _split(path: list[str]) -> tuple[str, str]:
    """Table and name of a key."""
    head = 2 if path[0] in ("cloud", "clip") else 1
    return ".".join(path[:head]), ".".join(path[head:])


def _parsed(text: str) -> Any:
    """A value as the scene file writes it."""
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        return text.strip('"')
