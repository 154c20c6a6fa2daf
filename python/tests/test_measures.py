"""Measurements: plain data with the command line's JSON."""

from __future__ import annotations

import dataclasses
import errno
import json
import math
import re

import numpy as np
import pytest
from conftest import DATA, SIZE

import pellucid

BLADE = DATA / "models/turbine_blade_6k.ply"


def test_a_profile_is_that_of_the_command_line(renderer, cli):
    profile = pellucid.profile(BLADE, frames=3, size=(96, 64), opacity=0.3)
    theirs = json.loads(cli("profile", str(BLADE), "--frames", "3", "--size", "96x64", "--opacity", "0.3", "--json"))
    ours = profile.json
    assert set(ours) == set(theirs)
    assert ours["scene"] == theirs["scene"]
    assert [of["name"] for of in ours["frames"][0]["passes"]] == [of["name"] for of in theirs["frames"][0]["passes"]]
    assert len(profile.frames) == 3
    assert profile.points == theirs["scene"]["points"]
    assert profile.fragments == theirs["scene"]["fragments"]
    assert profile.gpu_ms > 0.0
    assert all(frame.total_ms > 0.0 and frame.waits > 1 for frame in profile.frames)
    steady = pellucid.profile(BLADE, frames=3, steady=True, size=(96, 64), opacity=0.3)
    assert [frame.waits for frame in steady.frames] == [1, 1, 1]
    assert [ours["steady"], theirs["steady"], steady.json["steady"]] == [False, False, True]
    assert steady.json["totals"]["frames"] == 3
    assert "totals" not in ours
    assert steady.fragments == profile.fragments
    table = profile.to_pandas()
    assert len(table) == sum(len(frame.passes) for frame in profile.frames)
    assert {"frame", "name", "gpu_ms", "invocations", "bytes"} <= set(table.columns)


def test_a_plan_is_that_of_the_command_line(renderer, cli):
    plan = pellucid.plan(BLADE, size=(96, 64), opacity=0.3)
    theirs = json.loads(cli("plan", str(BLADE), "--size", "96x64", "--opacity", "0.3", "--json"))
    assert plan.json == theirs
    assert plan.reason
    on = [of for of in plan.passes if of.on]
    assert on[0].reason.count("colored by") == 1
    assert plan.to_pandas().shape == (len(theirs), 3)


def test_a_comparison_is_that_of_the_command_line(renderer, cli, tmp_path):
    a = pellucid.render(BLADE, size=(96, 64), opacity=0.3)
    b = pellucid.render(BLADE, size=(96, 64), opacity=0.4)
    for image, name in ((a, "a.exr"), (b, "b.exr")):
        image.save(tmp_path / name)
    theirs = json.loads(cli("compare", "a.exr", "b.exr", "--json"))
    for found in (pellucid.compare(tmp_path / "a.exr", tmp_path / "b.exr"), pellucid.compare(a, b)):
        assert found.json == theirs
    found = pellucid.compare(a.over_background(), b)
    assert found.rmse == theirs["rmse"]
    difference = np.abs(a.over_background().astype(np.float64) - b.over_background())
    assert found.rmse == pytest.approx(math.sqrt((difference**2).mean()), rel=1e-6)
    x, y = found.max_at
    assert difference[y, x].max() == pytest.approx(found.max_value)
    np.testing.assert_allclose(found.difference, difference, atol=1e-7)
    same = pellucid.compare(a, a)
    assert same.rmse == 0.0
    assert math.isinf(same.psnr)
    assert same.ssim == 1.0
    assert same.to_pandas().shape[0] == 1


def test_a_tradeoff_compares_methods(renderer, tmp_path):
    found = pellucid.tradeoff(
        BLADE, quick=True, only=["abuffer", "weighted", "stochastic"], size=SIZE, opacity=0.3, folder=tmp_path / "report"
    )
    rows = {row.method for row in found.rows}
    assert rows == {"abuffer", "weighted", "stochastic"}
    assert any(row.front for row in found.rows)
    exact = next(row for row in found.rows if row.method == "abuffer")
    assert exact.rmse < 1e-6
    assert found.size == SIZE
    assert (tmp_path / "report" / "report.html").exists()
    written = json.loads((tmp_path / "report" / "tradeoff.json").read_text())
    assert written["rows"] == found.json["rows"]
    assert len(found.to_pandas()) == len(found.rows)


def test_a_tradeoff_against_the_area_has_samples(renderer):
    found = pellucid.tradeoff(BLADE, quick=True, only=["abuffer"], size=SIZE, opacity=0.3, against="area", seconds=100)
    assert found.json["against"] == "area"
    settings = {row.setting: row.rmse for row in found.rows}
    assert settings["image.samples=1"] > settings["image.samples=4"] > 0.0
    with pytest.raises(ValueError, match="against: expected 'center' or 'area'"):
        pellucid.tradeoff(BLADE, against="edge")


def test_an_interrupted_tradeoff_says_so_whatever_becomes_of_its_folder(renderer, points, monkeypatch, tmp_path):
    class Interrupted:
        """Stand-in for the native scene."""

        def tradeoff(self, request, extent, folder, listener):
            raise KeyboardInterrupt

        def close(self):
            pass

    def still_written_to(*_, **__):
        raise OSError(errno.ENOTEMPTY, "Directory not empty")

    monkeypatch.setattr("pellucid._renderer._pellucid.Loaded", lambda *_: Interrupted())
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("os.rmdir", still_written_to)
    with pytest.raises(KeyboardInterrupt):
        pellucid.tradeoff(points)
    assert list(tmp_path.iterdir())


def test_stress_measures_what_it_was_asked_for(renderer):
    found = pellucid.stress(sides=[16], layers=[1, 4], methods=["abuffer", "sorted"], frames=1)
    measured = {(cell.workload, cell.layers, cell.method) for cell in found.cells}
    left = {(workload, layers, method) for workload, _, layers, method, _ in found.skipped}
    names = ("abuffer", "abuffer long_lists=in-place", "sorted")
    assert measured | left == {(w, n, m) for w in ("stack", "mosaic") for n in (1, 4) for m in names}
    assert all(cell.max_error < 1e-5 for cell in found.cells)
    assert len(found.to_pandas()) == len(found.cells)
    assert {(cell.kind, cell.holds, cell.standard_errors) for cell in found.cells} == {("exact", True, None)}
    with pytest.raises(ValueError, match=r'methods: expected some of .*, found "circles"'):
        pellucid.stress(methods=["circles"])
    with pytest.raises(ValueError, match="sides: expected"):
        pellucid.stress(sides=[0])


WRONG = [
    (lambda: pellucid.stress(seed=-1), ValueError, "seed: expected a whole number from 0 to 2**64 - 1, found -1"),
    (
        lambda: pellucid.stress(max_fragments=1e6),
        ValueError,
        "max_fragments: expected a whole number from 1 to 2**63, found 1000000.0",
    ),
    (lambda: pellucid.stress(max_seconds="a"), ValueError, "max_seconds: expected a number above 0, found 'a'"),
    (lambda: pellucid.stress(methods=[]), ValueError, "methods: expected at least one name, found none; without it all that apply"),
    (lambda: pellucid.stress(methods=3), TypeError, "methods: expected a list of names, found int"),
    (lambda: pellucid.stress(methods="abufer"), ValueError, 'found "abufer"'),
    (lambda: pellucid.tradeoff(BLADE, seconds="a"), ValueError, "seconds: expected a number above 0, found 'a'"),
    (lambda: pellucid.tradeoff(BLADE, seconds=0), ValueError, "seconds: expected a number above 0, found 0"),
    (lambda: pellucid.check(["abuffer/"]), TypeError, "names: expected texts, found list; a list of names is check(*names)"),
    (lambda: pellucid.check(3), TypeError, "names: expected texts, found int"),
    (
        lambda: pellucid.compare(PICTURE, WITH_NAN),
        ValueError,
        "b: expected finite colors, found [0.0, NaN, 0.0] in column 3, row 1",
    ),
    (
        lambda: pellucid.compare(WITH_NAN / 0.0, PICTURE),
        ValueError,
        "a: expected finite colors, found [NaN, NaN, NaN] in column 0, row 0",
    ),
    (
        lambda: pellucid.compare(PICTURE, np.zeros((4, 5, 4))),
        ValueError,
        "b: expected an Image, a path or an array of shape (h, w, 3), found an array of shape (4, 5, 4); of an Image give the "
        "image itself or image.over_background(), since four channels don't say the background",
    ),
    (lambda: pellucid.compare(PICTURE.astype(">i4"), PICTURE), ValueError, "a: expected linear floats, or uint8 or uint16 as sRGB"),
]
PICTURE = np.zeros((4, 5, 3))
WITH_NAN = PICTURE.copy()
WITH_NAN[1, 3, 1] = WITH_NAN[2, 0] = np.nan


@pytest.mark.parametrize(("call", "kind", "message"), WRONG)
@pytest.mark.filterwarnings("ignore:invalid value")
def test_wrong_arguments_of_measurements_are_named(renderer, call, kind, message):
    with pytest.raises(kind, match=re.escape(message)):
        call()


def test_one_method_may_come_without_a_list(renderer):
    found = pellucid.stress(sides=[16], layers=[1], methods="abuffer", frames=1, max_seconds=5, max_fragments=np.int64(10**9))
    assert {cell.method for cell in found.cells} == {"abuffer", "abuffer long_lists=in-place"}


def test_stress_measures_approximations_noise_and_soft_spheres(renderer):
    found = pellucid.stress(sides=[16], layers=[4], methods=["stochastic", "weighted", "soft-base", "soft-express"], frames=1)
    kinds = {cell.method: cell.kind for cell in found.cells}
    expected = {"stochastic": "stochastic", "weighted": "approximate", "soft-base": "exact", "soft-express": "approximate"}
    assert kinds == expected or {method for *_, method, _ in found.skipped} >= expected.keys() - kinds.keys()
    for cell in found.cells:
        assert cell.holds is (None if cell.kind == "approximate" else True)
        assert (cell.bound is None) == (cell.kind != "exact")
        assert (cell.standard_errors is None) == (cell.kind != "stochastic")


def test_pictures_of_any_layout_are_compared(renderer):
    a, b = np.random.default_rng(0).random((2, 9, 7, 3))
    expected = pellucid.compare(a, b).json
    for order in "<>":
        assert pellucid.compare(a.astype(f"{order}f8"), b.astype(f"{order}f8")).json == expected
        unaligned = np.frombuffer(b"\0" + a.astype(f"{order}f8").tobytes(), f"{order}f8", offset=1).reshape(a.shape)
        assert not unaligned.flags.aligned
        assert pellucid.compare(unaligned, b).json == expected
    shorts = (a * 65535).astype(np.uint16)
    assert pellucid.compare(shorts, shorts.astype(">u2")).rmse == 0.0
    assert pellucid.compare(np.asfortranarray(a), a[::-1][::-1]).rmse == 0.0


def test_check_passes_here(renderer, cli):
    found = pellucid.check("abuffer/faint", "abuffer/equal")
    assert found
    assert found.failed == 0
    assert all(case.verdict in ("pass", "not applicable") for case in found.cases)
    assert all(case.error <= case.bound for case in found.cases if case.verdict == "pass")
    theirs = json.loads(cli("check", "abuffer/faint", "abuffer/equal", "--json"))
    assert found.json == theirs
    assert not pellucid.Check("d", "d", 0, 0, (), {}), "nothing passed"
    assert len(found.to_pandas()) == len(found.cases)


def test_devices_and_methods_are_listed(renderer, cli):
    devices = pellucid.devices()
    theirs = json.loads(cli("devices", "--json"))
    assert [dataclasses.asdict(device)["name"] for device in devices] == [device["name"] for device in theirs]
    taken = next(device for device in devices if device.taken)
    assert taken.name == renderer.name
    assert taken.driver == renderer.driver
    with pellucid.Renderer(taken.index) as same:
        assert same.name == renderer.name
    assert {"abuffer", "stochastic", "spbr", "soft-base"} <= set(pellucid.methods())


def test_measurements_are_immutable_and_hashable(renderer, points):
    profile = pellucid.profile(points, frames=1, size=SIZE)
    with pytest.raises(dataclasses.FrozenInstanceError):
        profile.points = 3
    assert len({profile, profile}) == 1
    assert isinstance(hash(pellucid.plan(points, size=SIZE)), int)
    assert hash(pellucid.Check("d", "d", 0, 0, (), {})) == hash(pellucid.Check("d", "d", 0, 0, (), {}))


def test_a_loaded_scene_is_profiled_too(renderer, points):
    with renderer.load(points, opacity=0.3, size=SIZE) as loaded:
        assert len(loaded) == 500
        np.testing.assert_allclose(loaded.bounds, [points.min(0), points.max(0)])
        assert loaded.size == SIZE
        profile = loaded.profile(frames=2, method="abuffer")
        assert len(profile.frames) == 2
        assert any(of.name == "abuffer/count" for of in profile.frames[0].passes)
        image = loaded.frame()
        assert image.method == loaded.method
        assert loaded.reason
        assert loaded.colorings
        assert loaded.scene.cloud[0].opacity == 0.3


def test_the_version_is_that_of_the_command_line(cli):
    assert pellucid.__version__ in cli("--version")
