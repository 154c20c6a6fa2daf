"""Arguments that are wrong: each error names the argument, what it is, and what it should be."""

from __future__ import annotations

import pickle
import re

import numpy as np
import pytest

import pellucid

POINTS = np.random.default_rng(3).normal(size=(20, 3))


def nan_points() -> np.ndarray:
    points = POINTS.copy()
    points[4, 1] = np.nan
    points[9] = np.inf
    return points


def scene(**settings: object) -> pellucid.Scene:
    return pellucid.Scene(pellucid.Cloud(POINTS), **settings)


# A call, the exception, and its whole message; numbers of devices and the like are left out by "…".
CASES = [
    (
        "flat",
        lambda: pellucid.Cloud(np.zeros(9)),
        ValueError,
        "points: expected an array of shape (n, 3), found (9,)",
    ),
    (
        "plane",
        lambda: pellucid.Cloud(np.zeros((9, 2))),
        ValueError,
        "points: expected an array of shape (n, 3), found (9, 2); points in a plane need a third coordinate",
    ),
    (
        "transposed",
        lambda: pellucid.Cloud(np.zeros((3, 9))),
        ValueError,
        "points: expected an array of shape (n, 3), found (3, 9); its transpose has it: points.T",
    ),
    (
        "homogeneous",
        lambda: pellucid.Cloud(np.zeros((9, 4))),
        ValueError,
        "points: expected an array of shape (n, 3), found (9, 4); points[:, :3] are the first three columns",
    ),
    (
        "none",
        lambda: pellucid.Cloud(np.zeros((0, 3))),
        ValueError,
        "points: expected at least one point, found an array of shape (0, 3)",
    ),
    (
        "texts",
        lambda: pellucid.Cloud([["a", "b", "c"]]),
        ValueError,
        "points: expected real numbers, found an array of <U1 of shape (1, 3)",
    ),
    (
        "complex",
        lambda: pellucid.Cloud(np.zeros((4, 3), dtype=complex)),
        ValueError,
        "points: expected real numbers, found an array of complex128 of shape (4, 3)",
    ),
    (
        "ragged",
        lambda: pellucid.Cloud([[1.0, 2.0, 3.0], [1.0]]),
        ValueError,
        "points: expected an array of numbers, found list (…",
    ),
    (
        "nan",
        lambda: pellucid.Cloud(nan_points()),
        ValueError,
        "points: expected finite coordinates, found (…, NaN, …) in row 4 (2 of 20 rows are not finite); leave them out: "
        "points[numpy.isfinite(points).all(axis=1)]",
    ),
    (
        "masked",
        lambda: pellucid.Cloud(np.ma.masked_less(POINTS, 0.0)),
        ValueError,
        "points: expected an array without masked values; leave those out, or fill them",
    ),
    (
        "colors of other points",
        lambda: pellucid.Cloud(POINTS, colors=np.zeros((19, 3))),
        ValueError,
        "colors: expected an array of shape (20, 3), found (19, 3)",
    ),
    (
        "rgba",
        lambda: pellucid.Cloud(POINTS, colors=np.zeros((20, 4))),
        ValueError,
        "colors: expected an array of shape (20, 3), found (20, 4); colors[:, :3] are the first three columns, and the fourth may "
        "be opacities=",
    ),
    (
        "bytes as floats",
        lambda: pellucid.Cloud(POINTS, colors=np.full((20, 3), 255.0)),
        ValueError,
        "colors: expected floats from 0 to 1, found (255.0, 255.0, 255.0) in row 0; bytes are colors.astype(numpy.uint8)",
    ),
    (
        "bytes as longs",
        lambda: pellucid.Cloud(POINTS, colors=np.full((20, 3), 255)),
        ValueError,
        "colors: expected uint8 or uint16 (sRGB) or floats from 0 to 1, found int64; bytes are colors.astype(numpy.uint8)",
    ),
    (
        "color space",
        lambda: pellucid.Cloud(POINTS, color_space="rec709"),
        ValueError,
        "color_space: expected 'linear' or 'srgb', found 'rec709'",
    ),
    (
        "opacity of each",
        lambda: pellucid.Cloud(POINTS, opacity=np.ones(20)),
        ValueError,
        "opacity: expected one number from 0 to 1, found ndarray; an opacity for each point is opacities=",
    ),
    (
        "opacity in percent",
        lambda: pellucid.Cloud(POINTS, opacity=20),
        ValueError,
        "opacity: expected a number from 0 to 1, found 20.0",
    ),
    (
        "opacities out of range",
        lambda: pellucid.Cloud(POINTS, opacities=np.linspace(0, 2, 20)),
        ValueError,
        "opacities: expected numbers from 0 to 1, found 1.0526316 in row 10",
    ),
    (
        "opacities of other points",
        lambda: pellucid.Cloud(POINTS, opacities=np.ones(3)),
        ValueError,
        "opacities: expected an array of shape (20,), one for each point, found (3,)",
    ),
    (
        "negative radius",
        lambda: pellucid.Cloud(POINTS, radii=np.full(20, -1.0)),
        ValueError,
        "radii: expected finite numbers of at least 0, found -1 in row 0",
    ),
    (
        "normals of other points",
        lambda: pellucid.Cloud(POINTS, normals=np.ones((3, 20))),
        ValueError,
        "normals: expected an array of shape (20, 3), found (3, 20); its transpose has it: normals.T",
    ),
    (
        "classes of floats",
        lambda: pellucid.Cloud(POINTS, classification=np.full(20, 2.5)),
        ValueError,
        "classification: expected whole numbers from 0 to 255, found 2.5 in row 0",
    ),
    (
        "class that is no number",
        lambda: pellucid.Cloud(POINTS, classification=[2.0] * 19 + [np.nan]),
        ValueError,
        "classification: expected whole numbers from 0 to 255, found nan in row 19",
    ),
    (
        "class of many bits",
        lambda: pellucid.Cloud(POINTS, classification=[2] * 19 + [300]),
        ValueError,
        "classification: expected whole numbers from 0 to 255, found 300 in row 19",
    ),
    (
        "scalar that overflows",
        lambda: pellucid.Cloud(POINTS, scalars={"height": [0.0] * 19 + [1e300]}),
        ValueError,
        "scalars['height']: expected numbers that a float32 holds, up to 3.4e38, found 1e+300 in row 19",
    ),
    (
        "array of objects",
        lambda: pellucid.Cloud(POINTS.astype(object)),
        ValueError,
        "points: expected real numbers, found an array of object of shape (20, 3); if all of them are numbers: "
        "numpy.asarray(points).astype(float)",
    ),
    (
        "bytes as a list",
        lambda: pellucid.Cloud(POINTS, colors=[[1, 2, 3]] * 20),
        ValueError,
        "colors: expected uint8 or uint16 (sRGB) or floats from 0 to 1, found int64; bytes are "
        "numpy.array(colors, dtype=numpy.uint8)",
    ),
    (
        "name of a color",
        lambda: pellucid.render(POINTS, colors="red"),
        ValueError,
        "colors: expected a color for each point, found 'red'; one color for all points is a setting of render and Scene: "
        "color='red'",
    ),
    (
        "one color of bytes",
        lambda: pellucid.render(POINTS, colors=(255, 0, 0)),
        ValueError,
        "colors: expected an array of shape (20, 3), found (3,); one color for all points is a setting of render and Scene: "
        "color='#ff0000'",
    ),
    (
        "one color of floats",
        lambda: pellucid.render(POINTS, colors=(1.0, 0.0, 0.0)),
        ValueError,
        "colors: expected an array of shape (20, 3), found (3,); one color for all points is a setting of render and Scene: "
        "color=[1, 0, 0]",
    ),
    (
        "opacity of each as a setting",
        lambda: pellucid.render(POINTS, opacity=np.ones(20)),
        ValueError,
        "opacity: expected one number for all points, found ndarray; one for each point is opacities=",
    ),
    (
        "radius of each",
        lambda: pellucid.render(POINTS, radius=[0.1, 0.2]),
        ValueError,
        "radius: expected one number for all points, found list; one for each point is radii=",
    ),
    (
        "color of each",
        lambda: pellucid.render(POINTS, color=np.ones((20, 3))),
        ValueError,
        "color: expected one color for all points, found ndarray; one for each point is colors=",
    ),
    (
        "empty name",
        lambda: pellucid.Cloud(POINTS, name=""),
        ValueError,
        "name: expected a text, found an empty one; without name= it is 'cloud'",
    ),
    (
        "cloud in a pickle",
        lambda: pickle.dumps(pellucid.Cloud(POINTS)),
        TypeError,
        "a Cloud can't be pickled; send its numpy arrays (points, colors, …) or its file, and make it anew there",
    ),
    (
        "scene in a pickle",
        lambda: pickle.dumps(scene()),
        TypeError,
        "a Scene can't be pickled; send scene.to_toml() and the arrays of its clouds, and make it anew from them",
    ),
    (
        "scalar of other points",
        lambda: pellucid.Cloud(POINTS, scalars={"height": np.ones(5)}),
        ValueError,
        "scalars['height']: expected an array of shape (20,), one for each point, found (5,)",
    ),
    (
        "scalars without names",
        lambda: pellucid.Cloud(POINTS, scalars=[np.ones(20)]),
        TypeError,
        "scalars: expected a dict of arrays by name, found list",
    ),
    (
        "no points",
        lambda: pellucid.render(object()),
        TypeError,
        "points: expected an array of shape (n, 3), a Cloud, a Scene, a path, or an object of laspy, open3d, pyvista, plyfile or "
        "pandas, found builtins.object",
    ),
    (
        "empty path",
        lambda: pellucid.render(""),
        ValueError,
        "paths: expected a path of a scene file or a cloud, found an empty text",
    ),
    (
        "paths as a list",
        lambda: pellucid.Scene.read(["a.las", "b.las"]),
        TypeError,
        "paths: expected a path of a scene file or a cloud, found list; Scene.read(*paths) opens several",
    ),
    (
        "cloud and array",
        lambda: pellucid.render([pellucid.Cloud(POINTS), POINTS]),
        TypeError,
        "points: expected an array of shape (n, 3) or a list of clouds, found a list of Cloud, ndarray; of several make clouds, "
        "as in [Cloud(a), Cloud(b)]",
    ),
    (
        "arrays",
        lambda: pellucid.render([POINTS, POINTS]),
        TypeError,
        "points: expected an array of shape (n, 3) or a list of clouds, found a list of ndarray; of several make clouds, as in "
        "[Cloud(a), Cloud(b)]",
    ),
    (
        "missing file",
        lambda: pellucid.render("nowhere.laz"),
        pellucid.ReadError,
        "nowhere.laz: no such file",
    ),
    (
        "columns of a file",
        lambda: pellucid.render("nowhere.laz", colors=np.zeros((3, 3))),
        TypeError,
        "colors: expected with an array of points; a path brings its own",
    ),
    (
        "misspelt key",
        lambda: pellucid.render(POINTS, opacty=0.5),
        TypeError,
        "'opacty' is neither an argument nor a key of the scene file; did you mean 'opacity'?",
    ),
    (
        "misspelt key without a value",
        lambda: scene(nonsense=None),
        TypeError,
        "'nonsense' is neither an argument nor a key of the scene file; docs/scene-file.md lists all keys",
    ),
    (
        "resolution of a picture",
        lambda: pellucid.render(POINTS, resolution=(1, 1)),
        TypeError,
        "resolution: the picture's is size=(width, height), that of shadows shadows__resolution=",
    ),
    (
        "columns of a scene",
        lambda: scene(colors=POINTS),
        TypeError,
        "colors: expected with an array of points, as in Cloud(points, colors=…)",
    ),
    (
        "arguments of a picture",
        lambda: scene(fragments=True),
        TypeError,
        "fragments: expected a key of the scene file; this is an argument of render, or of frames",
    ),
    (
        "name of a scene",
        lambda: scene(name="ball"),
        TypeError,
        "name: expected with an array of points, as in Cloud(points, name=…)",
    ),
    (
        "factor of a frame",
        lambda: pellucid.render(POINTS, opacity_factor=0.5),
        TypeError,
        "opacity_factor: expected a key of the scene file; this is an argument of Loaded.frame; opacity= is a key",
    ),
    (
        "device of a scene",
        lambda: scene(device=0),
        TypeError,
        "device: expected a key of the scene file; this is an argument of Renderer, and of render",
    ),
    (
        "seed of a scene",
        lambda: scene(seed=3),
        TypeError,
        "seed: expected a key of the scene file; this is an argument of render, Renderer.load and Loaded.frame; a scene has it as "
        "scene.seed",
    ),
    (
        "limits of a picture",
        lambda: scene(max_error=0.5),
        TypeError,
        "max_error: expected a key of the scene file; this belongs to a frame: render(…, max_error=…)",
    ),
    (
        "part of a sample",
        lambda: pellucid.render(POINTS, method="stochastic", method__samples=64.5),
        pellucid.SceneError,
        "method__samples=64.5: `method.samples` must be an integer from 1 to 4096, found 64.5",
    ),
    (
        "no shadows",
        lambda: scene(shadows=False),
        TypeError,
        "shadows: expected True or a dict of keys of [shadows], found bool; scene.shadows = None takes them out",
    ),
    (
        "shading that is true",
        lambda: scene(shading=True),
        TypeError,
        "shading: expected a dict of keys of [shading], found bool",
    ),
    (
        "value out of range",
        lambda: pellucid.render(POINTS, opacity=1.5),
        pellucid.SceneError,
        "opacity=1.5: `cloud.0.opacity` must be a number from 0.0 to 1.0, found 1.5",
    ),
    (
        "value of another type",
        lambda: pellucid.render(POINTS, method="stochastic", method__samples="many"),
        pellucid.SceneError,
        "method__samples='many': `method.samples` …integer…",
    ),
    (
        "unknown method",
        lambda: pellucid.render(POINTS, method="raytrace"),
        pellucid.SceneError,
        "method='raytrace': unknown method \"raytrace\"…",
    ),
    (
        "infinite setting",
        lambda: pellucid.render(POINTS, radius=float("inf")),
        ValueError,
        "radius: expected a finite number, found inf",
    ),
    (
        "setting that is no value",
        lambda: pellucid.render(POINTS, radius=object()),
        TypeError,
        "radius: expected a number, a bool, a text, a list or a dict, found object",
    ),
    (
        "size of one number",
        lambda: pellucid.render(POINTS, size=64),
        ValueError,
        "size: expected (width, height), whole numbers from 1 to 16384, found 64",
    ),
    (
        "size without end",
        lambda: pellucid.render(POINTS, size=(float("inf"), 3)),
        ValueError,
        "size: expected (width, height), whole numbers from 1 to 16384, found (inf, 3)",
    ),
    (
        "size of nothing",
        lambda: pellucid.render(POINTS, size=(0, 64)),
        pellucid.SceneError,
        "size=(0, 64): `image.size` …",
    ),
    (
        "accuracy",
        lambda: pellucid.render(POINTS, accuracy="good"),
        ValueError,
        "accuracy: expected 'exact' or '8-bit', found 'good'",
    ),
    (
        "view",
        lambda: pellucid.render(POINTS, view="behind"),
        ValueError,
        'view: expected one of …, found "behind"',
    ),
    (
        "class",
        lambda: pellucid.render(POINTS, class_opacity={"hedge": 0.1}),
        ValueError,
        "class_opacity: no class 'hedge'; a number from 0 to 255, or a name as docs/scene-file.md lists",
    ),
    (
        "class that is misspelt",
        lambda: pellucid.render(POINTS, classes="bulding"),
        ValueError,
        "classes: no class 'bulding'; did you mean 'building'?",
    ),
    (
        "part of a class",
        lambda: pellucid.render(POINTS, classes=[2.7]),
        ValueError,
        "classes: expected a class, a whole number from 0 to 255 or a name, found 2.7",
    ),
    (
        "class that is true",
        lambda: pellucid.render(POINTS, classes=True),
        ValueError,
        "classes: expected a class, a whole number from 0 to 255 or a name, found True",
    ),
    (
        "part of one class",
        lambda: pellucid.render(POINTS, classes=2.5),
        ValueError,
        "classes: expected a class, a whole number from 0 to 255 or a name, found 2.5",
    ),
    (
        "view beside a camera",
        lambda: scene(view="top", camera=pellucid.Camera(fov_y=30)),
        TypeError,
        "view: expected no camera beside it: both say from where; of a lens alone, camera={'fov_y': 30}",
    ),
    (
        "view beside an eye",
        lambda: pellucid.render(POINTS, view="top", camera={"eye": (0, 0, 9)}),
        TypeError,
        "view: expected no camera beside it: both say from where; of a lens alone, camera={'fov_y': 30}",
    ),
    (
        "view beside an eye as an argument",
        lambda: pellucid.render(POINTS, view="top", eye=(0, -9, 1)),
        TypeError,
        "view: expected no camera beside it: both say from where; of a lens alone, camera={'fov_y': 30}",
    ),
    (
        "angle beside a target in a scene",
        lambda: scene().update(azimuth=20, camera__target=(0, 0, 1)),
        TypeError,
        "azimuth: expected no camera beside it: both say from where; of a lens alone, camera={'fov_y': 30}",
    ),
    (
        "slice",
        lambda: pellucid.render(POINTS, slices={"w": (0, 1)}),
        ValueError,
        "slices: expected 'x', 'y' or 'z' and two ends, either of them None, found 'w': (0, 1)",
    ),
    (
        "progress",
        lambda: pellucid.render(POINTS, progress="yes"),
        TypeError,
        "progress: expected True, False, None or what makes a bar, as tqdm.tqdm, found str",
    ),
    (
        "seed",
        lambda: pellucid.render(POINTS, seed=-1),
        ValueError,
        "seed: expected a whole number from 0 to 2**64 - 1, found -1",
    ),
    (
        "camera",
        lambda: pellucid.render(POINTS, camera=(0, 0, 5)),
        TypeError,
        "camera: expected a Camera or a dict of keys of [camera], found tuple",
    ),
    (
        "camera in its target",
        lambda: pellucid.Camera.look_at((0, 0, 0), (0, 0, 0)),
        ValueError,
        "eye and target: expected two points, found (0.0, 0.0, 0.0) twice",
    ),
    (
        "camera of one number",
        lambda: pellucid.Camera.look_at(5, (0, 0, 0)),
        ValueError,
        "eye: expected 3 numbers, found an array of shape ()",
    ),
    (
        "up that is nowhere",
        lambda: pellucid.Camera.look_at((0, 0, 5), (0, 0, 0), up=(0, 0, 0)),
        ValueError,
        "up: expected a direction, found (0.0, 0.0, 0.0), which has no length",
    ),
    (
        "zoom without a place",
        lambda: pellucid.Camera(height=2).zoom(0.5),
        ValueError,
        "zoom: expected a camera with eye and target, found Camera(…); that of a picture has them: image.camera",
    ),
    (
        "orbit without up",
        lambda: pellucid.Camera.look_at((0, 0, 5), (0, 0, 0)).orbit(5),
        ValueError,
        "orbit: expected a camera with eye, target and up, found Camera(…); that of a picture has them: image.camera",
    ),
    (
        "moved along up",
        lambda: pellucid.Camera.look_at((0, 0, 5), (0, 0, 0), up=(0, 0, 1)).pan(1, 0),
        ValueError,
        "up: expected a direction aside of the view, found (0.0, 0.0, 1.0), along which the camera looks",
    ),
    (
        "angle",
        lambda: pellucid.Camera.look_at((0, 0, 5), (0, 0, 0), fov_y=180),
        ValueError,
        "fov_y: expected a number above 0 and below 180, found 180.0",
    ),
    (
        "off-center calibration",
        lambda: pellucid.Camera.from_opencv([[500, 0, 300], [0, 500, 240], [0, 0, 1]], np.eye(4), size=(640, 480)),
        ValueError,
        "K: expected a principal point in the middle of the image, (320.0, 240.0), found (300.0, 240.0), 20.0 pixels off it: a "
        "scene has none elsewhere. Crop the images around it, and say their new size",
    ),
    (
        "device",
        lambda: pellucid.Renderer("no such device"),
        pellucid.DeviceError,
        'no Vulkan device matches "no such device"; devices: …',
    ),
    (
        "no clouds",
        lambda: pellucid.Scene([]),
        ValueError,
        "clouds: expected at least one cloud, found none",
    ),
    (
        "scene of an array",
        lambda: pellucid.Scene(POINTS),
        TypeError,
        "clouds: expected a Cloud or several, found ndarray; Cloud.from_any makes one of arrays",
    ),
    (
        "scene of a path",
        lambda: pellucid.Scene("a.las"),
        TypeError,
        "clouds: expected clouds, found a path; Scene.read('a.las') opens it",
    ),
    (
        "scene of arrays",
        lambda: pellucid.Scene([POINTS]),
        TypeError,
        "clouds: expected clouds, found ndarray at 0; Cloud.from_any makes one",
    ),
    (
        "too many clouds for a text",
        lambda: pellucid.Scene.from_toml("[[cloud]]\npath = 'a'", clouds=[pellucid.Cloud(POINTS)] * 2),
        ValueError,
        "clouds: expected 1, as many as the text has, found 2",
    ),
    (
        "key of no table taken out",
        lambda: scene().set("nope.x", None),
        pellucid.SceneError,
        "nope.x: unknown key 'nope'; expected image, camera, shading, shadows, detail, method, cloud, clip",
    ),
    (
        "key that is none taken out",
        lambda: scene().set("image.sise", None),
        pellucid.SceneError,
        "image.sise: unknown key 'sise'; did you mean 'size'?",
    ),
    (
        "key of no cloud taken out",
        lambda: scene().set("cloud.7.opacity", None),
        pellucid.SceneError,
        "cloud.7.opacity: expected the index of a cloud that is there, or *, found '7'",
    ),
    (
        "key that is none",
        lambda: scene().set("nope", 1),
        pellucid.SceneError,
        "'nope' is neither an argument nor a key of the scene file; docs/scene-file.md lists all keys",
    ),
    (
        "clouds by a slice",
        lambda: scene().cloud[0:1],
        TypeError,
        "cloud: expected the index of one cloud, found slice; scene.cloud.opacity = 0.2 is of all of them",
    ),
    (
        "one value of all clouds",
        lambda: scene().cloud.opacity,
        AttributeError,
        "opacity: each cloud has its own; scene.cloud[0].opacity is that of the first one",
    ),
    (
        "key without its table",
        lambda: setattr(scene(), "background", "red"),
        AttributeError,
        "a Scene has no attribute 'background'; the key is scene.image.background",
    ),
    (
        "value of a key without its table",
        lambda: scene().opacity,
        AttributeError,
        "a Scene has no attribute 'opacity'; the key is scene.cloud[0].opacity",
    ),
    (
        "attribute that is none",
        lambda: setattr(scene(), "backgruond", "red"),
        AttributeError,
        "a Scene has no attribute 'backgruond': 'backgruond' is neither an argument nor a key of the scene file; did you mean "
        "'background'?",
    ),
    (
        "text of a scene",
        lambda: pellucid.Scene.from_toml("[image]\nsize = [1, 2"),
        pellucid.SceneError,
        "…scene.toml:2:13: unclosed array, expected `]`",
    ),
    (
        "pictures of two sizes",
        lambda: pellucid.compare(np.zeros((4, 5, 3)), np.zeros((5, 4, 3))),
        ValueError,
        "a and b: expected pictures of one size, found 5 × 4 and 4 × 5 pixels",
    ),
    (
        "picture without colors",
        lambda: pellucid.compare(np.zeros((4, 5)), np.zeros((4, 5, 3))),
        ValueError,
        "a: expected an Image, a path or an array of shape (h, w, 3), found an array of shape (4, 5)",
    ),
    (
        "frames",
        lambda: pellucid.profile(POINTS, frames=0),
        ValueError,
        "frames: expected a whole number from 1 to 100000, found 0",
    ),
    (
        "method of a tradeoff",
        lambda: pellucid.tradeoff(POINTS, only=["raytrace"]),
        ValueError,
        "only: expected names of methods (…), found 'raytrace'",
    ),
    (
        "case",
        lambda: pellucid.check("no such case"),
        ValueError,
        "names: no case matches no such case",
    ),
    (
        "see-through",
        lambda: pellucid.render(POINTS, see_through=1.5),
        ValueError,
        "see_through: expected a share from 0 to 1, found 1.5",
    ),
    (
        "see-through of walls",
        lambda: pellucid.render(POINTS, see_through=0.5, method="circles"),
        ValueError,
        "see_through=0.5: the opacity of points has no effect with method circles; use `auto`, abuffer, sorted, spbr or "
        "another transparent method",
    ),
    (
        "memory",
        lambda: pellucid.render(POINTS, memory_budget=-5),
        ValueError,
        "memory_budget: expected a number of bytes, or a text as '4GiB' or '500MB', found -5",
    ),
    (
        "memory of a scene",
        lambda: scene().update(memory_budget="4GiB"),
        TypeError,
        "memory_budget: expected a key of the scene file; this belongs to a frame: render(…, memory_budget=…)",
    ),
]


@pytest.mark.parametrize(("call", "kind", "message"), [case[1:] for case in CASES], ids=[case[0] for case in CASES])
def test_the_error_says_what_is_wrong(renderer, call, kind, message):
    with pytest.raises(kind) as caught:
        call()
    pattern = ".*".join(re.escape(part) for part in message.split("…"))
    assert re.fullmatch(pattern, str(caught.value), re.DOTALL), str(caught.value)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("colours", "colors"),
        ("opacitys", "opacity"),
        ("fragment", "fragments"),
        ("camra", "camera"),
        ("point_size", "radius"),
        ("alpha", "opacity"),
        ("bgcolor", "background"),
        ("background_color", "background"),
        ("fov", "fov_y"),
        ("smaples", "samples"),
    ],
)
def test_a_near_miss_is_told(name, meant):
    message = f"'{name}' is neither an argument nor a key of the scene file; did you mean '{meant}'?"
    with pytest.raises(TypeError, match=f"^{re.escape(message)}$"):
        scene(**{name: 1})


def test_every_name_of_a_class_has_a_number():
    from pellucid._settings import CLASSES

    assert None not in [pellucid._pellucid.class_code(name) for name in CLASSES]


def test_an_extension_that_is_no_picture(renderer, points, tmp_path):
    image = pellucid.render(points, size=(8, 8))
    with pytest.raises(OSError, match=r"x\.jpg"):
        image.save(tmp_path / "x.jpg")
    with pytest.raises(OSError, match="nowhere"):
        image.save(tmp_path / "nowhere" / "x.png")
    assert not list(tmp_path.iterdir())


def test_a_failed_update_leaves_the_scene_as_it_was(points):
    scene = pellucid.Scene(pellucid.Cloud(points), opacity=0.25)
    before = scene.to_toml()
    with pytest.raises(pellucid.SceneError):
        scene.update(opacity=0.5, radius=-1.0)
    with pytest.raises(ValueError, match="view: expected one of"):
        scene.update(opacity=0.5, view="behind")
    with pytest.raises(pellucid.SceneError):
        scene.update(radius=-1.0, camera=pellucid.Camera.look_at((0, 0, 5), (0, 0, 0)))
    with pytest.raises(pellucid.SceneError):
        scene.method.name = "no such method"
    with pytest.raises(AttributeError, match="has no key"):
        scene.method.smaples = 3
    assert scene.to_toml() == before
    with pytest.raises(ValueError, match="view: expected one of"):
        scene.update(background="red", view="bogus")
    assert scene.to_toml() == before


def test_bytes_may_be_in_another_order_or_place():
    """Arrays of files are big-endian, unaligned, or have steps."""
    single = POINTS.astype(np.float32)
    shorts = np.arange(60, dtype=np.uint16).reshape(20, 3)
    codes = np.arange(20)
    expected = pellucid.Cloud(single, colors=shorts, classification=codes, intensity=single[:, 0])
    unaligned = np.frombuffer(b"x" + single.tobytes(), np.float32, offset=1).reshape(20, 3)
    assert not unaligned.flags.aligned
    swapped = pellucid.Cloud(single.astype(">f4"), colors=shorts.astype(">u2"), classification=codes.astype(">i4")[:, None])
    moved = pellucid.Cloud(unaligned, colors=np.asfortranarray(shorts), intensity=unaligned[:, 0])
    for found in (swapped, moved):
        np.testing.assert_array_equal(found.points, expected.points)
        np.testing.assert_array_equal(found.colors, expected.colors)
    np.testing.assert_array_equal(swapped.classification, codes)
    np.testing.assert_array_equal(moved.intensity, expected.intensity)
    assert pellucid.Cloud(POINTS, classification=np.ones(20, dtype=bool)).classification.tolist() == [1] * 20
    assert np.isinf(pellucid.Cloud(POINTS, scalars={"height": np.full(20, np.inf)}).scalars["height"]).all()
