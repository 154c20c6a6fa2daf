"""Scenes: point clouds and the settings for rendering them."""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, cast

from . import _pellucid
from ._camera import Camera
from ._cloud import Cloud
from ._errors import ReadError, SceneError
from ._progress import listening
from ._settings import TABLES, Change, asked, change, described, dotted, nearest, one_view, places, tables, toml
from ._types import Path, Progress, Setting


class Table:
    """A table of a scene file. Its keys are attributes, and each attribute is the value in force.

    An assigned value is checked as in a scene file. Assign None, or use ``del``, to remove a key, so that its default holds. `keys`
    lists all keys, and ``help()`` describes them.
    """

    __slots__ = ("_path", "_scene")

    _scene: Scene
    _path: str

    def __init__(self, scene: Scene, path: str) -> None:
        object.__setattr__(self, "_scene", scene)
        object.__setattr__(self, "_path", path)

    def keys(self) -> list[str]:
        """Return the names of all keys."""
        return list(tables()[_generic(self._path)])

    def doc(self, key: str) -> str:
        """Return the description of a key: values, unit, default."""
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
        setattr(self, name, None)

    def __dir__(self) -> list[str]:
        return sorted({*object.__dir__(self), *(key.replace(".", "__") for key in self.keys())})

    def __repr__(self) -> str:
        values = ", ".join(f"{key}={value!r}" for key, value in self._scene._values(self._path).items() if value is not None)
        return f"<[{self._path}] {values}>"


class CloudTables:
    """Settings of the clouds: ``scene.cloud[0].opacity = 0.2`` changes one, ``scene.cloud.opacity = 0.2`` changes all."""

    __slots__ = ("_scene",)

    _scene: Scene

    def __init__(self, scene: Scene) -> None:
        object.__setattr__(self, "_scene", scene)

    def __len__(self) -> int:
        return self._scene._native.counts()[0]

    def __getitem__(self, index: int) -> Table:
        count = len(self)
        if not hasattr(index, "__index__"):
            kind = type(index).__name__
            raise TypeError(f"cloud: expected the index of one cloud, found {kind}; scene.cloud.opacity = 0.2 is of all of them")
        if not -count <= index < count:
            raise IndexError(f"cloud: expected an index below {count}, found {index}")
        return _table(self._scene, f"cloud.{index % count}")

    # Type checkers should go on to refuse it.
    if not TYPE_CHECKING:

        def __getattr__(self, name):
            if not name.startswith("_") and name.replace("__", ".") in tables()["cloud.*"]:
                raise AttributeError(f"{name}: each cloud has its own; scene.cloud[0].{name} is that of the first one")
            raise AttributeError(f"[[cloud]] has no key {name!r}; it has {', '.join(tables()['cloud.*'])}")

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
    """Return the class of a table, with a property for each key, for completion and help."""

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
    """Point clouds and the settings for rendering them, as in a scene file.

    The tables of the file are attributes, and their keys are attributes of the tables: ``scene.method.samples = 64``,
    ``scene.image.background``, ``scene.cloud[0].opacity``. docs/scene-file.md describes all keys. So do completion and
    ``help(scene.method)``.

    Parameters
    ----------
    clouds
        A `Cloud`, or several of them.
    camera
        A `Camera`, or keys of [camera]. By default, a camera that sees all clouds.
    settings
        Keys of the scene file, as for `render`; ``size=(480, 360)`` is the size of the picture. If several tables have a key, its
        plain name means the key of [method], as for ``ensembles``, or of all clouds, as for ``color``; ``shadows__samples`` is the
        key of [shadows]. ``shadows=True`` or an empty dict switches shadows on with their defaults.

    Raises
    ------
    SceneError
        A key or value is not possible in a scene file. SceneError is also a ValueError.
    TypeError
        Something is not a cloud, or an argument has an unknown name.
    """

    __slots__ = ("_direction", "_named", "_native", "seed")

    _native: _pellucid.Scene
    # Clouds by index that have a name in place of a file.
    _named: frozenset[int]
    # From where all clouds are seen: view, azimuth, elevation.
    _direction: dict[str, Any]
    seed: int
    """Seed of everything random, a whole number from 0 to 2**64 - 1."""

    def __init__(
        self, clouds: Cloud | Iterable[Cloud], *, camera: Camera | Mapping[str, Any] | None = None, **settings: Setting
    ) -> None:
        given = _several(clouds)
        self._native = _pellucid.Scene.of_clouds([cloud._native for cloud in given], _names(given))
        self._named = _without_files(given)
        self._direction = {}
        self.seed = 0
        opacities = [(index, cloud.opacity) for index, cloud in enumerate(given) if cloud.opacity is not None]
        self._change([(f"opacity={a}", f"cloud.{index}.opacity", toml("opacity", a), False) for index, a in opacities])
        self.update(camera=camera, **settings)

    @classmethod
    def read(cls, *paths: Path, progress: Progress = None) -> Scene:
        """Open a scene file (``.toml``), or point clouds, which are read when they are needed.

        Very large clouds stay where they are stored. Raises SceneError for an error in the scene file, with line and column, and
        ReadError for a missing cloud.
        """
        if not paths:
            raise TypeError("paths: expected a scene file or clouds, found none; Scene.built_in() is the built-in scene")
        for path in paths:
            if not isinstance(path, (str, os.PathLike)):
                help = "; Scene.read(*paths) opens several" if isinstance(path, (list, tuple)) else ""
                raise TypeError(f"paths: expected a path of a scene file or a cloud, found {type(path).__name__}{help}")
            if not os.fspath(path):
                raise ValueError("paths: expected a path of a scene file or a cloud, found an empty text")
        scene = cls._of(_pellucid.Scene.of_files([os.fspath(path) for path in paths], 0))
        # Missing files are reported here.
        missing = [path for path in paths if not os.path.exists(path)]
        if missing:
            raise ReadError(f"{os.fspath(missing[0])}: no such file")
        if progress:
            scene._clouds(progress)
        return scene

    @classmethod
    def from_toml(
        cls, text: str, *, folder: Path = ".", clouds: Cloud | Iterable[Cloud] | None = None, progress: Progress = None
    ) -> Scene:
        """Make a scene from the text of a scene file. Relative paths in it start from ``folder``.

        ``clouds`` replace the files, in the order of [[cloud]]. For a scene made from arrays, ``Scene.from_toml(scene.to_toml(),
        clouds=scene.clouds)`` has the same points and keys. The text doesn't contain what isn't a key: ``view``, ``azimuth``,
        ``elevation`` and the seed. Raises SceneError for an error in the text, and ValueError if the number of clouds differs from
        that in the text.
        """
        scene = cls._of(_pellucid.Scene.of_toml(text, os.fspath(folder)))
        if clouds is not None:
            return scene._filled(_several(clouds))
        if progress:
            scene._clouds(progress)
        return scene

    def _filled(self, clouds: list[Cloud]) -> Scene:
        """Return a scene with the same settings and clouds in place of the files."""
        tables = self.given()
        entries, clips = tables.pop("cloud", []), tables.pop("clip", None)
        if len(entries) != len(clouds):
            raise ValueError(f"clouds: expected {len(entries)}, as many as the text has, found {len(clouds)}")
        paths = [entry.pop("path") for entry in entries]
        names = [cloud.name if cloud._file else path for cloud, path in zip(clouds, paths, strict=True)]
        filled = Scene._of(_pellucid.Scene.of_clouds([cloud._native for cloud in clouds], names))
        filled._named = _without_files(clouds)
        tables |= {f"cloud.{index}": entry for index, entry in enumerate(entries)}
        keys = {f"{table}.{key}": value for table, items in tables.items() for key, value in items.items()}
        # A table [shadows] without keys has a meaning, too.
        shadows = True if tables.get("shadows") == {} else None
        filled._change(
            [*(change(key, key, value) for key, value in keys.items()), *asked({"clip": clips, "shadows": shadows}).changes]
        )
        return filled

    @classmethod
    def built_in(cls, seed: int = 0) -> Scene:
        """Return the built-in scene: a garden with a house. ``seed`` is from 0 to 2**64 - 1."""
        scene = cls._of(_pellucid.Scene.of_files([], seed))
        scene.seed = seed
        return scene

    @classmethod
    def _of(cls, native: _pellucid.Scene) -> Scene:
        scene = cls.__new__(cls)
        scene._native, scene.seed = native, native.seed
        scene._named, scene._direction = frozenset(), {}
        return scene

    def copy(self) -> Scene:
        """Return another scene with the same clouds, whose settings change independently."""
        scene = Scene._of(self._native.copy())
        scene.seed = self.seed
        scene._named, scene._direction = self._named, dict(self._direction)
        return scene

    def __copy__(self) -> Scene:
        return self.copy()

    def __deepcopy__(self, memo: dict[int, Any]) -> Scene:
        # Clouds never change.
        return self.copy()

    def __reduce__(self) -> str | tuple[Any, ...]:
        raise TypeError("a Scene can't be pickled; send scene.to_toml() and the arrays of its clouds, and make it anew from them")

    def to_toml(self, folder: Path = ".") -> str:
        """Return the text of a scene file that lies in ``folder``. Paths of clouds are relative to it.

        Clouds made from arrays have their names in place of files. Such a text isn't a scene without the clouds; pass them to
        `from_toml` with it. ``view``, ``azimuth``, ``elevation`` and the seed aren't keys, so the text doesn't contain them.
        """
        written = self.copy()
        entries = self.given()["cloud"] if self._named else []
        # A path in the folder is written without it.
        paths = [(index, os.path.join(os.path.abspath(folder), entries[index]["path"])) for index in self._named]
        written._change([change("path", f"cloud.{index}.path", path) for index, path in paths])
        return written._native.to_toml(os.fspath(folder))

    def set(self, key: str, value: Setting) -> None:
        """Set a dotted key, such as ``method.samples``, ``cloud.0.opacity`` or ``cloud.*.radius``. None removes the key.

        A plain name means the same key as it does as an argument of `Scene`: ``samples`` is ``image.samples``. Raises SceneError
        for a key or value that no scene has; the scene is then unchanged.
        """
        if not isinstance(key, str):
            raise TypeError(f"key: expected a dotted key as 'method.samples', found {type(key).__name__}")
        path = _full(key)
        if value is None:
            self._check_key(path)
            self._native.remove(path)
        else:
            self._change([change(key, path, value)])

    def _check_key(self, path: str) -> None:
        """Refuse a dotted key that no scene has. A part of a key is also a key."""
        parts = path.split(".")
        table = parts.pop(0)
        if table in ("cloud", "clip") and parts:
            if parts[0] != "*" and not self._has(table, parts[0]):
                raise SceneError(f"{path}: expected the index of a {table} that is there, or *, found {parts[0]!r}")
            table, parts = f"{table}.*", parts[1:]
        if table not in tables() and table not in TABLES:
            raise SceneError(f"{path}: unknown key {table!r}; expected {', '.join(TABLES)}")
        known = {key.partition(".")[0] for key in tables().get(table, {})}
        if parts and parts[0] not in known:
            near = nearest(parts[0], known)
            hint = f"; did you mean {near!r}?" if near else ""
            raise SceneError(f"{path}: unknown key {parts[0]!r}{hint}")

    def _has(self, table: str, index: str) -> bool:
        clouds, clips = self._native.counts()
        return index.isdigit() and int(index) < (clouds if table == "cloud" else clips)

    def get(self, key: str) -> Any:
        """Return the value in force of a dotted key, or None where nothing is given and there is no default.

        Raises KeyError for unknown keys.
        """
        path = _path(key)
        if key in TABLES:
            return self.given().get(key)
        if path[0] in ("cloud", "clip") and not self._has(path[0], path[1]):
            raise KeyError(key)
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
        """Return all keys that were given, table by table."""
        return cast("dict[str, Any]", json.loads(self._native.given()))

    def update(self, *, camera: Camera | Mapping[str, Any] | None = None, **settings: Setting) -> None:
        """Change several settings at once, with names as for `render`: either all of them change or none.

        ``size`` is the size of the picture. A `Camera` replaces the whole table [camera]; a dict changes keys of it. ``view``,
        ``azimuth`` and ``elevation`` give the direction from which all clouds are seen. A new ``view`` discards earlier angles, and
        so does a camera.

        ``clip``, ``slices``, ``classes`` and ``without`` leave out further points: after ``classes=[2]`` and then ``classes=[6]``,
        no point is left. ``scene.clip = []`` removes all clips and slices. ``scene.set("cloud.*.class", None)`` removes all
        settings of classes, ``class_opacity`` included.
        """
        found = asked(settings if isinstance(camera, Camera) else {"camera": camera, **settings})
        for name in found.limits:
            raise TypeError(f"{name}: expected a key of the scene file; this belongs to a frame: render(…, {name}=…)")
        changed = self.copy()
        if isinstance(camera, Camera):
            one_view(found.direction)
            changed._look(camera)
        changed._change(found.changes)
        if found.direction:
            changed._direct(found.direction)
        self._native, self._direction = changed._native, changed._direction

    def _look(self, camera: Camera) -> None:
        """Replace the scene's own camera, and a direction, by a camera."""
        self._native.change(["camera"], camera._changes())
        self._turn({})

    def _direct(self, direction: dict[str, Any]) -> None:
        """Look from a direction. Angles change the direction in force; a view replaces it."""
        self._turn(direction if "view" in direction else {**self._direction, **direction})

    def _turn(self, direction: dict[str, Any]) -> None:
        self._native.set_view({name: direction.get(name) for name in ("view", "azimuth", "elevation")})
        self._direction = dict(direction)

    def _change(self, changes: list[Change]) -> None:
        if changes:
            self._native.change([], changes)
        # Beside a direction a place of the camera would be ignored.
        if places(changes):
            self._turn({})

    def _assign(self, table: str, value: Mapping[str, Any] | bool | None) -> None:
        """Replace a whole table by a dict; None removes the table."""
        self._native.change([table], asked({table: value}).changes)

    def _values(self, table: str) -> dict[str, Any]:
        return {name: None if text is None else _parsed(text) for name, text in self._native.values(table)}

    def _clouds(self, progress: Progress) -> list[_pellucid.Cloud]:
        with listening(progress) as listener:
            return self._native.clouds(listener)

    @property
    def clouds(self) -> list[Cloud]:
        """Point clouds of the scene. Those of files are read when you ask for them."""
        natives = self._clouds(None)
        names = [str(self.get(f"cloud.{index}.path")) for index in range(len(natives))]
        return [
            Cloud._of(native, name, file=index not in self._named)
            for index, (native, name) in enumerate(zip(natives, names, strict=True))
        ]

    # Type checkers should go on to refuse other attributes.
    if not TYPE_CHECKING:

        def __getattr__(self, name):
            raise AttributeError(name if name.startswith("_") else _where(name))

        def __setattr__(self, name, value):
            if not hasattr(type(self), name):
                raise AttributeError(_where(name))
            object.__setattr__(self, name, value)

    @property
    def image(self) -> Any:
        """``[image]``: size, background, color space. An assigned dict replaces all its keys, as for other tables."""
        return _table(self, "image")

    @image.setter
    def image(self, keys: Mapping[str, Any] | None) -> None:
        self._assign("image", keys)

    @property
    def camera(self) -> Any:
        """``[camera]``. Assign a `Camera` to look from elsewhere, or None for a camera that sees all clouds."""
        return _table(self, "camera")

    @camera.setter
    def camera(self, camera: Camera | Mapping[str, Any] | None) -> None:
        if isinstance(camera, Mapping):
            self._assign("camera", camera)
            self._turn({})
        else:
            self.update(camera=Camera() if camera is None else camera)

    @property
    def shading(self) -> Any:
        """``[shading]``: how points are lit."""
        return _table(self, "shading")

    @shading.setter
    def shading(self, keys: Mapping[str, Any] | None) -> None:
        self._assign("shading", keys)

    @property
    def shadows(self) -> Any:
        """``[shadows]``. Assign True or a dict to switch shadows on, None to switch them off."""
        return _table(self, "shadows")

    @shadows.setter
    def shadows(self, keys: Mapping[str, Any] | bool | None) -> None:
        self._assign("shadows", keys)

    @property
    def detail(self) -> Any:
        """``[detail]``: which points are left out."""
        return _table(self, "detail")

    @detail.setter
    def detail(self, keys: Mapping[str, Any] | None) -> None:
        self._assign("detail", keys)

    @property
    def method(self) -> Any:
        """``[method]``: the name, and the keys of the method."""
        return _table(self, "method")

    @method.setter
    def method(self, name: str | Mapping[str, Any]) -> None:
        if isinstance(name, Mapping):
            self._assign("method", name)
        else:
            self.set("method.name", name)

    @property
    def cloud(self) -> CloudTables:
        """Settings of the clouds; ``scene.cloud[0]`` has those of the first one."""
        return CloudTables(self)

    @property
    def clip(self) -> tuple[dict[str, Any], ...]:
        """``[[clip]]``: copies of the boxes, planes, slabs and polygons that points must lie in.

        Assign dicts to change them, as in ``scene.clip = [*scene.clip, {"slab": {"axis": "z", "max": 2.0}}]``.
        """
        return tuple(self.given().get("clip", []))

    @clip.setter
    def clip(self, clips: Mapping[str, Any] | Iterable[Mapping[str, Any]] | None) -> None:
        self._native.change(["clip"], asked({"clip": clips}).changes)

    def __repr__(self) -> str:
        count = len(self.cloud)
        return f"<pellucid.Scene of {count} cloud{'' if count == 1 else 's'}, method {self.method.name}>"


def _several(clouds: Cloud | Iterable[Cloud]) -> list[Cloud]:
    """Return one cloud or several as a list. Raises TypeError for anything else, and ValueError for none."""
    if isinstance(clouds, Cloud):
        return [clouds]
    if isinstance(clouds, (str, os.PathLike)):
        raise TypeError(f"clouds: expected clouds, found a path; Scene.read({os.fspath(clouds)!r}) opens it")
    if hasattr(clouds, "__array__") or not isinstance(clouds, Iterable):
        raise TypeError(f"clouds: expected a Cloud or several, found {type(clouds).__name__}; Cloud.from_any makes one of arrays")
    given = list(clouds)
    for index, cloud in enumerate(given):
        if not isinstance(cloud, Cloud):
            raise TypeError(f"clouds: expected clouds, found {type(cloud).__name__} at {index}; Cloud.from_any makes one")
    if not given:
        raise ValueError("clouds: expected at least one cloud, found none")
    return given


def _without_files(clouds: list[Cloud]) -> frozenset[int]:
    """Return the indices of clouds that have a name in place of a file."""
    return frozenset(index for index, cloud in enumerate(clouds) if not cloud._file)


def _names(clouds: list[Cloud]) -> list[str]:
    """Return names that tell clouds apart; those of files stay as they are."""
    names = [cloud.name for cloud in clouds]
    return [
        name if cloud._file or names.count(name) == 1 else f"{name}-{index}"
        for index, (name, cloud) in enumerate(zip(names, clouds, strict=True))
    ]


def _full(key: str) -> str:
    """Return the dotted key that a name stands for. Raises SceneError for a name that no table has."""
    if "." in key or key in TABLES:
        return key
    try:
        return dotted(key)
    except TypeError as error:
        raise SceneError(str(error)) from None


def _where(name: str) -> str:
    """Return a message for an attribute that a scene doesn't have."""
    try:
        table, _, key = dotted(name).partition(".")
    except TypeError as error:
        return f"a Scene has no attribute {name!r}: {error}"
    table = {"cloud": "cloud[0]", "clip": "clip[0]"}.get(table, table)
    return f"a Scene has no attribute {name!r}; the key is scene.{table}.{key.removeprefix('*.')}"


def _path(key: str) -> list[str]:
    """Return the parts of a dotted key, with the first cloud in place of all. Raises KeyError for a name that no table has."""
    try:
        parts = _full(key).split(".")
    except SceneError as error:
        raise KeyError(str(error)) from None
    if parts[0] in ("cloud", "clip") and len(parts) > 1 and parts[1] == "*":
        parts[1] = "0"
    return parts


def _split(path: list[str]) -> tuple[str, str]:
    """Return the table and the name of a key."""
    head = 2 if path[0] in ("cloud", "clip") else 1
    return ".".join(path[:head]), ".".join(path[head:])


def _parsed(text: str) -> Any:
    """Return a value as it is written in the scene file."""
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        return text.strip('"')
