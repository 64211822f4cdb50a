"""Which runs of a scenario fail, the worst first, what goes wrong in them, and which one is drawn."""

from collections.abc import Mapping, Sequence
from typing import Any

from radar_service.bench.run_picture import gravest_of, ppi_at
from radar_service.bench.scenario import Scenario
from radar_service.bench.scores.verdicts import is_gross

MAX_EVENTS = 12  # of a run that a report lists
AROUND = 2  # scans before and after an event that a recording has
Run = Mapping[str, Any]  # as plain data


def worst_first(scenario: Scenario, runs: Sequence[Run]) -> list[Run]:
    """Returns runs: those in which the tracker failed, then by limits missed, by gross misses, by OSPA."""
    return sorted(runs, key=lambda run: _badness(scenario, run), reverse=True)


def failed_runs(scenario: Scenario, runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Returns runs that miss a limit that decides, the worst first: seed, the limits with their values, the gravest events of
    which there are MAX_EVENTS at most, and the number of all."""
    return [
        {
            "seed": run["seed"],
            "missed": missed,
            "events": [*map(vars, gravest_of(run, MAX_EVENTS))],
            "event_count": len(run["events"]),
        }
        for run in worst_first(scenario, runs)
        if (missed := missed_limits_of(scenario, run))
    ]


def missed_limits_of(scenario: Scenario, run: Run) -> dict[str, float | None]:
    """Returns the limits that decide and that a run misses, by metric: a tracker that failed misses all."""
    if run["failure"]:
        return {limit.metric: None for limit in scenario.limits if limit.decides}
    return scenario.missed(run["metrics"])


def drawn_run(scenario: Scenario, runs: Sequence[Run]) -> Run | None:
    """Returns the worst of the runs that gave a scan, with the PPI of its last one; None where none did. Raises SceneError."""
    worst = next((run for run in worst_first(scenario, runs) if run["scans"]), None)
    return worst and {**worst, "ppi": ppi_at(scenario, worst["seed"], worst["scans"][-1]["scan"])}


def scans_of_interest(scenario: Scenario, failed: Mapping[str, Any]) -> range:
    """Returns the scans from AROUND before to AROUND after the gravest event of one of `failed_runs`; without events the last."""
    gravest_one = gravest_of(failed, 1)
    middle = gravest_one[0].scan if gravest_one else scenario.scans
    return range(max(middle - AROUND, 0), min(middle + AROUND + 1, scenario.scans))


def _badness(scenario: Scenario, run: Run) -> tuple[bool, int, int, float]:
    missed = missed_limits_of(scenario, run)
    gross = [limit for limit in scenario.limits if limit.metric in missed and is_gross(limit, missed[limit.metric])]
    return run["failure"] is not None, len(missed), len(gross), run["metrics"].get("ospa_m") or 0.0
