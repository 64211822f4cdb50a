"""A sample has both corners and as many sets of parameters as it says, and the rest are studies."""

from typing import Any

import pytest

from tests.samples import beyond_samples


class Item:
    """A test with parameters, as far as a sample is concerned."""

    def __init__(self, nodeid: str, *markers: pytest.Mark) -> None:
        self.nodeid, self.markers = nodeid, {marker.name: marker for marker in markers}

    def get_closest_marker(self, name: str) -> pytest.Mark | None:
        return self.markers.get(name)


def items(name: str, count: int, size: int) -> list[Any]:
    """The tests of `count` sets of parameters, of which `size` are wanted."""
    return [Item(f"{name}[{k}]", pytest.mark.sample(size).mark) for k in range(count)]


def test_a_sample_has_its_size_and_both_corners_and_is_the_same_each_time() -> None:
    everything = [*items("a", 15, 4), *items("b", 15, 4), *items("few", 3, 4), Item("plain[0]")]
    others = {item.nodeid for item in beyond_samples(everything)}
    kept = [item.nodeid for item in everything if item.nodeid not in others]
    assert (
        kept[0] == "a[0]"
        and kept[3:5] == ["a[14]", "b[0]"]
        and kept[7:] == ["b[14]", "few[0]", "few[1]", "few[2]", "plain[0]"]
    )
    assert [name.replace("b", "a") for name in kept[4:8]] != kept[:4]  # drawn by the name of the test
    assert others == {item.nodeid for item in beyond_samples(everything)}


def test_what_is_a_study_already_counts_for_no_sample() -> None:
    study = Item("a[study]", pytest.mark.sample(2).mark, pytest.mark.study.mark)
    assert [item.nodeid for item in beyond_samples([study, *items("a", 3, 2)])] == ["a[1]"]


def test_a_sample_without_both_corners_is_refused() -> None:
    with pytest.raises(ValueError, match="a sample of 1 has not both corners"):
        beyond_samples(items("a", 3, 1))


@pytest.mark.sample(2)
@pytest.mark.parametrize("number", range(3))
def test_of_three_the_suite_runs_the_corners(number: int, request: pytest.FixtureRequest) -> None:
    assert (number == 1) == (request.node.get_closest_marker("study") is not None)
