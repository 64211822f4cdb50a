"""Sea and rain as sources of a scene."""

from radar_service.plots.plot_report import kinds_of
from radar_service.sources.numbers import source_names
from radar_service.stages.clutter.effect import RAIN, SEA
from tests.scenes import scene


def test_every_scene_names_sea_and_rain_as_sources_of_their_own() -> None:
    """So tables of labels are alike, whether a scene has clutter or not."""
    for environment in ({}, {"sea_state": 3}):
        names = source_names(made := scene(environment=environment))
        assert (names[SEA], names[RAIN]) == (names[1], names[2]) == ("sea", "rain")
        assert kinds_of(made, [SEA, RAIN]) == {SEA: "clutter", RAIN: "clutter"}
