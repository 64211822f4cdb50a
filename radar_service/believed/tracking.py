"""Rows of tracking by the bench's reference tracker, and of plots of two boats as of the recorded set of Trondheim."""

import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from radar_service.believed.run import Figure, Measurement, Run, Table
from radar_service.bench import load_scenario
from radar_service.bench.bench import bench
from radar_service.bench.run import threshold_of
from radar_service.bench.scenario import PlotSettings
from radar_service.numerics import Floats
from radar_service.plots import PlotExtractor, labelled_plots
from radar_service.scene_file import packaged_folder
from radar_service.terminal import write_file

SEEDS = 3


def verdicts(run: Run, name: str) -> Mapping[str, Mapping[str, float]]:
    """Returns the limits of a packaged scenario by metric, with the 95th percentile of the reference tracker over three seeds."""
    write_file(run.folder / f"{name}.toml", (packaged_folder("scenes") / "scenarios" / f"{name}.toml").read_bytes())
    with tempfile.TemporaryDirectory() as folder:
        report, _ = bench([load_scenario(name)], SEEDS, "gnn", Path(folder) / "bench")
    return {each["metric"]: each for each in report["scenarios"][0]["verdicts"]}


def fading(run: Run) -> list[Figure]:
    """A target that is seen in 5 of 10 scans: the share of the time that it is held, and its speed after a minute of 20 scans."""
    results = verdicts(run, "fading")
    return [
        Figure.least("held", results["held"]["value_95"], 0.95),
        Figure.most("speed after 1 min", results["velocity_kn_1min"]["value_95"], 1.5, "kn"),
    ]


TABLE_3 = ("relative_course_deg_1min", "relative_speed_kn_1min", "cpa_nm_1min", "relative_course_deg_3min",
           "relative_speed_kn_3min", "cpa_nm_3min", "tcpa_min_3min")  # fmt: skip


def accuracy(run: Run) -> list[Figure]:
    """Table 3 in the four geometries of A.823(19), with the sensors that carriage rules ask for; the worst of the four."""
    results = [verdicts(run, f"msc192-table3-{number}") for number in (1, 2, 3, 4)]
    figures = []
    for metric in TABLE_3:
        worst = max(
            (each[metric] for each in results if metric in each), key=lambda each: each["value_95"] / each["maximum"]
        )
        figures.append(Figure.most(metric.replace("_", " "), worst["value_95"], worst["maximum"]))
    return figures


# A dome of 5.2 degrees that turns in 1.68 s, and vessels like those of the set: a leisure craft, a research vessel, a jet boat.
DOME = {
    "azimuths": 1024, "rpm": 60 / 1.68, "beamwidth_deg": 5.2, "pattern": "taylor", "power_w": 25, "gain_dbi": 22,
    "noise_figure_db": 5, "bandwidth_hz": 32e6, "pulse_s": 1e-5, "range_max_m": 500, "height_m": 3, "loss_db": 3,
}  # fmt: skip
BOATS: dict[str, Table] = {
    "leisure craft": {"hull_type": "pilot", "material": "fibreglass", "length_m": 8, "beam_m": 2.8, "height_m": 2.5},
    "research vessel": {"hull_type": "fishing", "length_m": 31, "beam_m": 9.6, "height_m": 9},
    "jet boat": {"hull_type": "pilot", "material": "aluminium", "length_m": 8, "beam_m": 2.5, "height_m": 2},
}


def plots_of_boats(run: Run, boats: dict[str, Table] = BOATS, scans: int = 30) -> dict[str, tuple[float, Floats]]:
    """Returns of each boat the share of scans with a plot, and the errors of its plots in range (K,) [m], along two routes."""
    bodies = [
        boat | {"name": name, "shape": "hull", "waypoints": [{"position_m": [120 - 110 * k, 60 + 60 * k], "speed_kn": 5}],
                "position_m": [-160 + 140 * k, 90 + 50 * k, 0]}
        for k, (name, boat) in enumerate(boats.items())
    ]  # fmt: skip
    simulator = run.simulator(DOME, {"noise": True, "multipath": True}, bodies, fidelity="balanced", labels=True)
    settings = PlotSettings(threshold="known", pfa=1e-6, gap_spokes=4, gap_cells=4, split_db=200.0)
    extractor = PlotExtractor(simulator.scene.radar, threshold_of(settings, simulator.scene), max_plots=40, nearest=10.0)
    report = labelled_plots(simulator, extractor, scans)
    results = {}
    for body in report.bodies:
        plots = [each.plot for each in report.plots if each.source == body.name]
        (states,) = simulator.ship_states([plot.time for plot in plots], [body.name])
        true = np.hypot(states.position[:, 0], states.position[:, 1])
        results[body.name] = (float(body.pd or 0.0), np.array([plot.range for plot in plots]) - true)
    return results


def detections(run: Run) -> list[Figure]:
    """The share of scans with a plot of each vessel; published are 0.88 to 1."""
    return [Figure(name, share, 0.88 - 0.1, 1.0) for name, (share, _) in plots_of_boats(run).items()]


def range_errors(run: Run) -> list[Figure]:
    """The standard deviation of plots in range."""
    return [
        Figure.by_factor(name, float(errors.std()), 2.1, 5.2, 1.5, "m") for name, (_, errors) in plots_of_boats(run).items()
    ]


MEASUREMENTS: dict[str, Measurement] = {"G03": fading, "G05": accuracy, "M01": detections, "M03": range_errors}
