"""Tracking as an ARPA does it: relative to own ship, whose motion is that of gyro and log.

On a map that is reckoned from gyro and log the relative motion, on which CPA depends, is that of the plots alone; true motion has
the errors of gyro and log, as MSC.192(79) 5.25.4.7 presupposes.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from radar_service.bench.trackers.tracker import Tracker, TrackerInput, TrackState
from radar_service.numerics import Floats
from radar_service.plots import Plot


class ReckonedTracker:
    """A tracker.Tracker that gives another one plots on the reckoned map, and moves its tracks to the map of the position."""

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker
        self._before: tuple[float, Floats, Floats] | None = None  # time, position and velocity at the end of the last scan

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        """Returns the tracks after a scan, as Tracker.update."""
        reported, velocity = np.array([scan.east, scan.north]), _velocity(scan)
        if not np.isfinite(velocity).all():  # the heading is lost: no bearing of a plot is true
            return self._tracker.update(replace(scan, plots=()))
        time, position, earlier = self._before or (0.0, reported - scan.time * velocity, velocity)
        now = position + 0.5 * (velocity + earlier) * (scan.time - time)
        plots = tuple(
            _from(plot, now + (now - position) * (plot.time - scan.time) / (scan.time - time)) for plot in scan.plots
        )
        self._before = scan.time, now, velocity
        east, north = reported - now
        states = self._tracker.update(replace(scan, east=float(now[0]), north=float(now[1]), plots=plots))
        return [replace(state, east=float(state.east + east), north=float(state.north + north)) for state in states]


def _velocity(scan: TrackerInput) -> Floats:
    """Own velocity (2,) [m/s] of gyro and log."""
    return scan.speed * np.array([np.sin(scan.course), np.cos(scan.course)])


def _from(plot: Plot, own: Floats) -> Plot:
    """A plot as an antenna at a position (2,) [m] measures it."""
    east, north = own + plot.range * np.array([np.sin(plot.bearing), np.cos(plot.bearing)])
    return replace(plot, east=float(east), north=float(north))
