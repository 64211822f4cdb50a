"""The arguments of `bench-tracker` and `plots`."""

import pytest

from radar_service.commands.command_line import parser


def test_defaults_and_values() -> None:
    options = parser().parse_args(["bench-tracker", "a", "b", "-o", "out", "--seeds", "59"])
    assert (options.scenarios, options.seeds, options.tracker, str(options.out)) == (["a", "b"], 59, "gnn", "out")
    assert options.jobs >= 1 and not options.list and options.compare is None


@pytest.mark.parametrize("wrong", [["--seeds", "0"], ["--jobs", "0"], ["--compare", "one.json"]])
def test_wrong_values_are_refused(wrong: list[str]) -> None:
    with pytest.raises(SystemExit):
        parser().parse_args(["bench-tracker", *wrong])


def test_plots_have_defaults() -> None:
    options = parser().parse_args(["plots"])
    assert (options.scene, options.scans, options.threshold, options.pfa) == ("harbour", 10, "ca", 1e-4)
    assert (options.guard_m, options.window_m, options.out, options.png) == (100.0, 300.0, None, None)


def test_bench_detection_has_a_default_scenario() -> None:
    options = parser().parse_args(["bench-detection", "-o", "out"])
    assert (options.scenario, options.scans, options.ranges, str(options.out)) == ("msc192-table2", 100, 16, "out")
