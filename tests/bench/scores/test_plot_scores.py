"""Which plots belong to which targets, and what they say, by hand."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.bench.scores.plot_scores import matches, plot_metrics
from radar_service.bench.scores.scan_result import ScanResult, TargetTruth
from radar_service.plots.plot import Plot
from tests.bench.scores.test_scoring import given, truth


def plot(time: float, distance: float, bearing: float = 0.0) -> Plot:
    return Plot(
        scan=0, time=time, range=distance, bearing=bearing % (2.0 * np.pi), east=0.0, north=0.0, snr_db=30.0, cells=4,
        range_extent=(0.0, 0.0), bearing_extent=(0.0, 0.0),
    )  # fmt: skip


def target(name: str, time: float, distance: float, bearing: float = 0.0, length: float = 0.0) -> TargetTruth:
    return replace(truth(name, time, 0.0, 0.0), echo=(distance, bearing), length=length)


def scan(number: int, plots: list[Plot], truths: list[TargetTruth]) -> ScanResult:
    return ScanResult(replace(given(number), plots=tuple(plots)), (), tuple(truths))


def test_each_target_has_the_plot_that_is_nearest_in_all() -> None:
    """Two targets 20 m apart, and one plot between them that belongs to the second: the first has the one before."""
    truths = [target("one", 1.0, 1000.0), target("two", 1.0, 1020.0)]
    (found,) = matches([scan(0, [plot(1.0, 1012.0), plot(1.0, 995.0)], truths)])
    assert {match.truth.body: match.range_error for match in found} == {"one": -5.0, "two": -8.0}


@pytest.mark.parametrize(
    ("made", "is_hers"),
    [
        (plot(1.0, 1014.0), True),
        (plot(1.0, 1016.0), False),
        (plot(1.0, 1000.0, 0.014), True),
        (plot(1.0, 1000.0, -0.014), True),
        (plot(1.0, 1000.0, 0.016), False),
        (plot(1.6, 1000.0), True),
        (plot(1.7, 1000.0), False),  # a quarter of a scan of 2.5 s
    ],
)
def test_the_gate_of_a_point(made: Plot, is_hers: bool) -> None:
    """15 m along and across."""
    assert len(matches([scan(0, [made], [target("one", 1.0, 1000.0)])])[0]) == is_hers


def test_the_gate_is_wider_for_ships_and_far_off() -> None:
    assert matches([scan(0, [plot(1.0, 1060.0)], [target("ship", 1.0, 1000.0, length=100.0)])])[0]
    assert matches([scan(0, [plot(1.0, 10_000.0, 0.009)], [target("far", 1.0, 10_000.0)])])[0]


def test_a_plot_that_ends_a_scan_later_counts() -> None:
    """At north the beam meets a target at the end of one scan; its plot is reported with the next one."""
    results = [scan(k, [], [target("north", 2.5 * (k + 1) - 0.01, 1000.0)]) for k in range(3)]
    late = [
        replace(results[k], given=replace(given(k), plots=(plot(2.5 * k + 0.001, 1000.0),) if k else ())) for k in range(3)
    ]
    assert [len(some) for some in matches(late)] == [1, 1, 0]


def test_metrics_of_a_run() -> None:
    """Two targets, four scans of which the first does not count; the second target is missed once, once a plot is false."""
    results = []
    for k in range(4):
        time = 2.5 * k + 1.0
        plots = (
            [plot(time, 1001.0, 1e-3)]
            + ([plot(time, 2003.0, 1e-3)] if k != 2 else [])
            + ([plot(time, 500.0)] if k == 3 else [])
        )
        results.append(scan(k, plots, [target("one", time, 1000.0), target("two", time, 2000.0)]))
    metrics = plot_metrics(results)
    assert metrics["detected"] == pytest.approx(5 / 6) and metrics["detected_worst"] == pytest.approx(2 / 3)
    assert metrics["resolved"] == pytest.approx(2 / 3) and metrics["false_plots"] == pytest.approx(1 / 3)
    assert metrics["range_bias_m"] == pytest.approx(9 / 5) and metrics["range_sd_m"] == pytest.approx(np.sqrt(1.2))
    assert metrics["bearing_bias_deg"] == pytest.approx(np.degrees(1e-3)) and metrics["bearing_sd_deg"] == pytest.approx(
        0.0, abs=1e-12
    )


def test_without_plots_there_is_nothing_to_judge() -> None:
    metrics = plot_metrics([scan(k, [], [target("one", 2.5 * k, 1000.0)]) for k in range(3)])
    assert metrics["detected"] == 0.0 and metrics["range_bias_m"] is None and metrics["false_plots"] == 0.0
    assert set(plot_metrics([]).values()) == {None}
    unseen = [scan(k, [], [truth("one", 2.5 * k, 0.0, 0.0)]) for k in range(3)]  # no crossing
    assert plot_metrics(unseen)["detected"] is None and plot_metrics(unseen)["resolved"] is None
