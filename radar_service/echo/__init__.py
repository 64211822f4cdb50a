"""Echoes, resting and moving: visibility, range histories, passages of the beam, second time around."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.echo.beam_passage import BeamPassages
    from radar_service.echo.beam_paths import Beam, BeamPath, DirectPath, Sights, false_echoes
    from radar_service.echo.block_geometry import ObservedEchoes
    from radar_service.echo.boresight_track import BoresightTrack
    from radar_service.echo.closest_approach import max_power, nearest_and_top
    from radar_service.echo.echoes import SECOND_TIME, AzimuthTimes, BeamTable, BeamWeightedEchoes, Echoes, concatenated
    from radar_service.echo.land import GROUND, NEAREST_BORDER, PIECE, LandPassages, joined
    from radar_service.echo.moving import MovingEchoes
    from radar_service.echo.passage_nodes import HELD_PHASE, MAX_PHASE
    from radar_service.echo.range_history import apparent_position, elevation_of, slant_range
    from radar_service.echo.resting import OccludedEchoes, PassingShadows, RestingEchoes, resting_echoes
    from radar_service.echo.second_time_around import apparent_range, fold_ranges, max_echo_range
    from radar_service.echo.visibility import Visibility, mast_speed
else:
    __getattr__, __dir__ = lazily(__name__)
