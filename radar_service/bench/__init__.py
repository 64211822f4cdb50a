"""The test bench of trackers: scenarios, trackers, scores, verdicts, report; detection against the radar equation."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.bench.scenario import Scenario, ScenarioError, load_scenario, scenarios
    from radar_service.bench.scores.bias import Bias, bias_cause
    from radar_service.bench.single_run import missed_limits
    from radar_service.bench.trackers.gating import Tuning
    from radar_service.bench.trackers.stone_soup_parts import PlotReader, TruthReader, reference_tracks
    from radar_service.bench.trackers.tracker import Tracker, TrackerInput, TrackState

__all__ = [
    "Bias", "PlotReader", "Scenario", "ScenarioError", "TrackState", "Tracker", "TrackerInput", "TruthReader", "Tuning",
    "bias_cause", "load_scenario", "missed_limits", "reference_tracks", "scenarios",
]  # fmt: skip

__getattr__, __dir__ = lazily(__name__)
