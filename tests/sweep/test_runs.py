"""The runs of a sweep: their order, their values, and that all of it hangs on the number alone."""

from typing import Any

import numpy as np
import pytest
from scipy.stats import kstest

from radar_service.sweep.spec import Runs, SweepError, SweepSpec


def runs(**spec: Any) -> Runs:
    return Runs(SweepSpec(**{"scene": "a", **spec}))


def test_all_are_crossed_radars_first_then_seeds() -> None:
    some = runs(scene=("a", "b"), vary={"x": [1, 2, 3], "y": ["p", "q"]}, seeds=2, radars=("bow", "pier"))
    expected = [
        (scene, x, y, radar)
        for scene in (0, 1)
        for x in (1, 2, 3)
        for y in "pq"
        for _ in range(2)
        for radar in ("bow", "pier")
    ]
    assert [(run.scene, run.values["x"], run.values["y"], run.radar) for run in some] == expected
    assert [run.number for run in some] == [*range(len(some))] and some[-1] == some[47] and some[4:6] == [some[4], some[5]]
    with pytest.raises(IndexError, match="run 48 of 48"):
        some[48]


def test_each_run_has_its_own_seed_and_radars_of_one_world_the_same() -> None:
    some = runs(seeds=50, radars=("bow", "pier"))
    seeds = [run.seed for run in some]
    assert seeds[::2] == seeds[1::2] and len(set(seeds)) == 50 and all(0 <= seed < 2**63 for seed in seeds)
    assert not {run.seed for run in runs(seeds=50, seed=1)} & set(seeds)


def test_a_run_hangs_on_its_number_alone() -> None:
    spec = {"vary": {"x": {"uniform": [4, 18]}, "y": {"normal": [0, 1]}}, "seeds": 20}
    backwards = {k: runs(**spec)[k] for k in reversed(range(20))}
    assert [backwards[k] for k in range(20)] == [*runs(**spec)]
    assert runs(**{**spec, "seeds": 1000})[7].seed == backwards[7].seed


def test_values_that_go_together_are_zipped() -> None:
    some = runs(vary={"x": [1, 2], "y": [3, 4], "z": {"uniform": [0, 1]}}, zip=True, seeds=2)
    assert [(run.values["x"], run.values["y"]) for run in some] == [(1, 3), (1, 3), (2, 4), (2, 4)]
    assert len({run.values["z"] for run in some}) == 4 and some.drawn == ("z",)
    with pytest.raises(SweepError, match="^zip: lists that go together are equally long; here {'x': 2, 'y': 3}"):
        runs(vary={"x": [1, 2], "y": {"uniform": [0, 1], "count": 3}}, zip=True)


def test_a_range_has_both_ends() -> None:
    assert [run.values["x"] for run in runs(vary={"x": {"range": [4, 18], "count": 3}})] == [4.0, 11.0, 18.0]


def test_a_count_draws_once_and_is_crossed() -> None:
    some = runs(vary={"x": {"uniform": [4, 18], "count": 3}, "y": [1, 2]})
    values = [run.values["x"] for run in some]
    assert len(values) == 6 and values[::2] == values[1::2] and len(set(values)) == 3


LAWS = {
    "uniform": ({"uniform": [4, 18]}, "uniform", (4, 14)),
    "log_uniform": ({"log_uniform": [1, 100]}, "loguniform", (1, 100)),
    "normal": ({"normal": [3, 2]}, "norm", (3, 2)),
}


@pytest.mark.parametrize("law", LAWS)
def test_draws_follow_their_law(law: str) -> None:
    """At a level of 0.001 for each of three laws and one seed: nothing is drawn anew."""
    values, name, parameters = LAWS[law]
    drawn = [run.values["x"] for run in runs(vary={"x": values}, seeds=500)]
    assert kstest(drawn, name, parameters).pvalue > 1e-3


def test_draws_of_whole_numbers_and_of_choices_have_all_of_them() -> None:
    some = runs(vary={"x": {"integers": [-1, 2]}, "y": {"choice": ["p", [1, 2]]}}, seeds=200)
    numbers, counts = np.unique([run.values["x"] for run in some], return_counts=True)
    assert numbers.tolist() == [-1, 0, 1, 2] and counts.min() > 20  # 50 expected: 4.9 standard deviations of 6.1
    assert all(type(run.values["x"]) is int for run in some)
    assert {repr(run.values["y"]) for run in some} == {"'p'", "[1, 2]"} or {repr(r.values["y"]) for r in some} == {
        "'p'",
        "(1, 2)",
    }


def test_draws_of_two_keys_and_two_seeds_are_independent() -> None:
    spec = {"x": {"uniform": [0, 1]}, "y": {"uniform": [0, 1]}}
    one, other = runs(vary=spec, seeds=400), runs(vary=spec, seeds=400, seed=1)
    columns = [[run.values[key] for run in some] for some in (one, other) for key in "xy"]
    correlation = np.corrcoef(columns) - np.eye(4)
    assert np.abs(correlation).max() < 4.5 / 20.0  # standard deviation 1 / sqrt(400)


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ({"seeds": 10**6, "vary": {"x": list(range(1000))}}, r"^1000000000 runs \(1000 of x x 1000000 of seeds\) are not"),
        ({"seeds": 10**6, "vary": {k: list(range(100_000)) for k in "abcd"}}, r"^1" + "0" * 26 + " runs"),
    ],
)
def test_too_many_runs_are_refused_at_once(spec: dict[str, Any], message: str) -> None:
    with pytest.raises(SweepError, match=message):
        runs(**spec)


def test_corners_have_each_value_of_each_key() -> None:
    some = runs(scene=("a", "b"), vary={"x": list(range(50)), "y": [1, 2]}, seeds=100)
    corners = some.corners()
    assert {run.values["x"] for run in corners} == {*range(50)} and {run.values["y"] for run in corners} == {1, 2}
    assert {run.scene for run in corners} == {0, 1} and len(corners) < 160 and corners[0].number == 0
