"""A tracker of one track, which stands where own ship is."""

from collections.abc import Sequence

from radar_service.bench import TrackerInput, TrackState


class StillTracker:
    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        return [TrackState(track="a", time=scan.time, east=scan.east, north=scan.north, velocity_east=0, velocity_north=0)]
