"""What a picture leaves out while things move."""

import pytest

from pellucid._drafts import Costs, Draft, moving, resting, whole


def costs(*frames: tuple[float, float]) -> Costs:
    found = Costs()
    for ms, work in frames:
        found.add(ms, work)
    return found


@pytest.mark.parametrize(
    ("ms", "work", "expected"),
    [
        (128, 1, Draft(16, 1)),  # 2 ms a sample
        (8, 1 / 4, Draft(64, 1)),
        (528, 1, Draft(4, 1)),
        (132, 1 / 16, Draft(4, 2)),  # 4 samples take 132 ms: a quarter of the pixels 33
        (133, 1 / 16, Draft(4, 3)),
        (1e12, 1, Draft(4, 8)),
    ],
)
def test_samples_go_first(ms: float, work: float, expected: Draft) -> None:
    assert moving(costs((ms, work)), 33, 64) == expected


@pytest.mark.parametrize(("ms", "coarse"), [(33, 1), (33.1, 2), (132, 2), (140, 3), (500, 4), (1e9, 8)])
def test_exact_methods_get_coarser(ms: float, coarse: int) -> None:
    assert moving(costs((ms, 1)), 33, None) == Draft(None, coarse)


def test_the_constant_cost_of_frames_is_separated() -> None:
    # 20 ms for any frame, 1000 for the whole picture's work.
    both = costs(*((20 + 1000 / coarse**2, 1 / coarse**2) for coarse in (1, 6, 8, 3, 8)))
    share = both.share(33)
    assert share is not None
    assert abs(share - 0.013) < 1e-9
    assert moving(both, 10, None).coarse == 8, "nothing fits less than what any frame takes"


def test_no_picture_is_coarser_than_helps() -> None:
    # 700 ms for any frame, 300 for the whole picture's work: leaving all of it out would save less than a third.
    both = costs((700 + 300 / 64, 1 / 64), (1000, 1))
    assert moving(both, 33, None, thins=False).coarse == 1
    assert moving(both, 33, None, thins=True).coarse == 8, "it would be less with the points"


def test_points_go_with_pixels() -> None:
    assert [Draft(None, coarse).points(1000) for coarse in (1, 2, 8)] == [None, 250, 15]
    assert Draft(4, 1).points(1000) is None


def test_a_picture_at_rest_becomes_the_whole_one() -> None:
    known = costs((100, 1 / 16))
    assert resting(known, 250, 64).work(64) < 1
    assert resting(known, 800, 64) == whole(64) == Draft(64, 1)
    assert resting(known, 799, 64) != whole(64)


def test_pictures_of_unknown_cost_are_small() -> None:
    assert moving(Costs(), 33, 64) == Draft(4, 2)
    assert moving(Costs(), 33, None) == Draft(None, 2)
    assert moving(Costs(), 33, 2) == Draft(2, 2), "no more samples than the whole picture has"


def test_sizes_are_rounded_up() -> None:
    assert Draft(None, 8).size((101, 1)) == (13, 1)
    assert Draft(None, 1).size((101, 1)) == (101, 1)
