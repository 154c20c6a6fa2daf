"""Samples of a pixel's area: the mean of images, each moved by a fraction of a pixel."""

from __future__ import annotations

import json

import numpy as np
import pytest
from conftest import SIZE

import pellucid

LOOK = {"opacity": 0.3, "method": "abuffer", "size": SIZE}


def test_counts_are_means_of_whole_numbers_and_whole_for_one_sample(renderer, points) -> None:
    one = pellucid.render(points, fragments=True, **LOOK)
    assert one.samples == 1
    assert one.fragments is not None
    assert one.fragments.dtype == np.uint32
    four = pellucid.render(points, fragments=True, samples=4, **LOOK)
    assert four.samples == 4
    assert four.fragments is not None
    assert four.fragments.dtype == np.float32
    sums = 4 * four.fragments
    assert (sums == np.round(sums)).all()
    assert (sums % 4 != 0).any()


def test_the_argument_and_the_key_are_the_same_samples(renderer, points) -> None:
    asked = pellucid.render(points, samples=4, **LOOK)
    assert (pellucid.render(points, image={"samples": 4}, **LOOK) == asked).all()
    scene = pellucid.Scene([pellucid.Cloud(points)], samples=4, opacity=0.3, method="abuffer", size=SIZE)
    assert scene.image.samples == 4
    assert (pellucid.render(scene) == asked).all()
    with renderer.load(points, **LOOK) as loaded:
        assert (loaded.frame(samples=4) == asked).all()
        assert loaded.frame().samples == 1


def test_auto_says_what_it_found(renderer, points) -> None:
    found = pellucid.render(points, samples="auto", sampling_error=0.02, **LOOK)
    said = json.loads(found.metadata["pellucid:samples"])
    assert said["samples"] == found.samples
    assert said["sampling_error"] <= 0.02
    given = pellucid.render(points, samples=found.samples, **LOOK)
    assert (given == found).all()
    assert json.loads(given.metadata["pellucid:samples"]) == {"samples": found.samples}
    # Half as many differ by what is said, or, of 4 samples, no fewer were tried.
    half = pellucid.render(points, samples=found.samples // 2, **LOOK)
    rmse = np.sqrt(np.mean((found.over_background().astype(float) - half.over_background()) ** 2))
    assert said["sampling_error"] == pytest.approx(rmse, rel=1e-5)


def test_wrong_numbers_are_named(renderer, points) -> None:
    for wrong in (3, 0, 128, "many", 2.5):
        with pytest.raises(pellucid.SceneError, match=r"samples=.*1, 2, 4, 8, 16, 32, 64"):
            pellucid.render(points, samples=wrong, **LOOK)
    with pytest.raises(ValueError, match="samples"):
        pellucid.render(points, samples=[4, 4], **LOOK)


def test_a_plan_knows_the_number(renderer, points) -> None:
    plan = pellucid.plan(points, samples=4, **LOOK)
    assert any("mean of 4 images" in of.reason for of in plan.passes)
