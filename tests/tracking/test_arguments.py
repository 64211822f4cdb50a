"""The arguments of `bench-tracker`."""

import pytest

from radar_service.command_line import parser


def test_defaults_and_values() -> None:
    options = parser().parse_args(["bench-tracker", "a", "b", "-o", "out", "--seeds", "59"])
    assert (options.scenarios, options.seeds, options.tracker, str(options.out)) == (["a", "b"], 59, "gnn", "out")
    assert options.jobs >= 1 and not options.list and options.compare is None


@pytest.mark.parametrize("wrong", [["--seeds", "0"], ["--jobs", "0"], ["--compare", "one.json"]])
def test_wrong_values_are_refused(wrong: list[str]) -> None:
    with pytest.raises(SystemExit):
        parser().parse_args(["bench-tracker", *wrong])


def test_bench_detection_has_a_default_scenario() -> None:
    options = parser().parse_args(["bench-detection", "-o", "out"])
    assert (options.scenario, options.scans, options.ranges, str(options.out)) == ("msc192-table2", 100, 16, "out")
