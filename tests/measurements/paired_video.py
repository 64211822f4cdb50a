"""Compares a tracker on plots with the same on video, behind the product's own extractor as a child, seed by seed.

    nice python -m tests.measurements.paired_video FOLDER [SEEDS [TRACKER [SCENARIO...]]]

Video has no errors of plots, so that the scenarios are taken without them. Each metric has the mean of the differences and its
95 % interval (Student); the exit status is 1 where one does not hold 0. Twenty seconds a seed, in clutter two minutes.
"""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from scipy.stats import t

from radar_service.bench.scenario import Scenario, load_scenario, with_video
from radar_service.bench.single_run import single_run

SCENARIOS = ("crossing-cpa-500", "overtaking", "crossing-hulls", "rain-with-sea")
SHOWN = ("ospa_m", "gospa_m", "completeness", "identity_changes", "velocity_kn_median", "localisation_m", "spurious")
Metrics = Mapping[str, float | None]


def pair_of(scenario: Scenario, seed: int, tracker: str, folder: Path) -> tuple[Metrics, Metrics]:
    """The metrics of a tracker on plots and on video. Raises RuntimeError for a failed run."""
    bare = scenario.model_copy(update={"plot_errors": None})
    runs = [single_run(each, seed, tracker, folder) for each in (bare, with_video(bare))]
    for run in runs:
        if run["failure"]:
            raise RuntimeError(f"{scenario.name}, seed {seed}: {run['failure']['message']}")
    return runs[0]["metrics"], runs[1]["metrics"]


def interval(differences: Sequence[float]) -> tuple[float, float, float]:
    """Mean, and the 95 % interval about it."""
    mean, count = float(np.mean(differences)), len(differences)
    half = float(t.ppf(0.975, count - 1) * np.std(differences, ddof=1) / np.sqrt(count))
    return mean, mean - half, mean + half


def main(folder: Path, seeds: int, tracker: str, names: Sequence[str]) -> int:
    """Prints the table."""
    print("| scenario | metric | on plots | on video less on plots | 95 % interval | largest |\n|---|---|---|---|---|---|")
    status = 0
    for name in names:
        pairs = [pair_of(load_scenario(name), seed, tracker, folder) for seed in range(seeds)]
        for metric in SHOWN:
            values = [(one[metric], two[metric]) for one, two in pairs]
            differences = [two - one for one, two in values if one is not None and two is not None]
            mean, low, high = interval(differences)
            status |= not low <= 0.0 <= high
            plots = np.mean([one for one, _ in values if one is not None])
            most = max(map(abs, differences))
            print(f"| {name} | {metric} | {plots:.4g} | {mean:.3g} | {low:.3g} to {high:.3g} | {most:.3g} |", flush=True)
    return status


if __name__ == "__main__":
    given = [*sys.argv[1:], *("10", "gnn")[len(sys.argv) - 2 :]]
    sys.exit(main(Path(given[0]), int(given[1]), given[2], given[3:] or SCENARIOS))
