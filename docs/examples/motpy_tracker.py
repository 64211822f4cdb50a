"""motpy (https://github.com/wmuron/motpy, MIT licence) as a tracker of the test bench: plots in and tracks out as JSON Lines.

    pip install motpy
    radar-service bench-tracker crossing-cpa-500 --tracker "python docs/examples/motpy_tracker.py" -o out

motpy follows boxes in pictures: a box belongs to a track where it overlaps the predicted one. Here a box is a square of GATE
metres around a plot, and a step is a scan. It knows no times within a scan, so it takes plots as one rotation apart.
"""

import json
import sys

import numpy as np
from motpy import Detection, MultiObjectTracker

GATE = 120.0  # m, side of the boxes: half of what a plot may miss its prediction by along east and along north
CONFIRM = 4  # scans that a track must live before it is reported
LOST = 5  # scans without a plot after which a track ends

MODEL = {
    "order_pos": 1, "dim_pos": 2, "order_size": 0, "dim_size": 2,
    "q_var_pos": 0.01,  # (m/s^2)^2: ships
    "r_var_pos": 25.0,  # m^2: of plots
    "r_var_size": 1.0, "q_var_size": 1e-6, "p_cov_p0": 100.0,  # (m/s)^2 of a speed before anything is known of it
}  # fmt: skip


class MotpyTracker:
    """A tracker of one run."""

    def __init__(self) -> None:
        self._names: dict[str, int] = {}
        self._tracker: MultiObjectTracker | None = None
        self._period = 0.0

    def answer(self, scan: dict) -> dict:
        """Returns the answer to a scan."""
        if self._tracker is None:
            self._period = scan["time"] / (scan["scan"] + 1)
            self._tracker = MultiObjectTracker(
                self._period, dict(MODEL), matching_fn_kwargs={"min_iou": 0.01},
                tracker_kwargs={"max_staleness": LOST, "smooth_score_gamma": 0.0},
                active_tracks_kwargs={"min_steps_alive": CONFIRM},
            )  # fmt: skip
        reported = self._tracker.step([self._detection(plot) for plot in scan["plots"]])
        velocity = {one.id: self._velocity(one) for one in self._tracker.trackers}
        tracks = [self._state(track, velocity[track.id], scan["time"]) for track in reported]
        return {"type": "tracks", "scan": scan["scan"], "tracks": tracks}

    @staticmethod
    def _detection(plot: dict) -> Detection:
        east, north = plot["east"], plot["north"]
        box = np.array([east, north, east, north]) + GATE / 2.0 * np.array([-1.0, -1.0, 1.0, 1.0])
        return Detection(box, score=plot["time"])  # not smoothed, the score is the time of a track's last plot

    @staticmethod
    def _velocity(tracker) -> np.ndarray:
        """Velocity (2,) of a track: motpy reports none, but its Kalman filter has it."""
        return tracker._tracker.x[[1, 3]]

    def _state(self, track, velocity: np.ndarray, end: float) -> dict:
        missed = int((end - track.score) / self._period)  # scans without a plot, through which motpy moved the box on
        east, north = (track.box[:2] + track.box[2:]) / 2.0
        return {
            "track": self._names.setdefault(track.id, len(self._names) + 1), "time": track.score + missed * self._period,
            "east": float(east), "north": float(north), "velocity_east": float(velocity[0]),
            "velocity_north": float(velocity[1]),
        }  # fmt: skip


def main() -> None:
    """Reads the header, then answers each scan."""
    sys.stdin.readline()
    tracker = MotpyTracker()
    for line in sys.stdin:
        print(json.dumps(tracker.answer(json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
