"""Trackers whose faults are known, and a good one: interacting Kalman filters with nearest neighbours. Faults are of it."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from scipy.optimize import linear_sum_assignment

from radar_service.bench.scores.judged_scan import judged
from radar_service.bench.scores.scan_result import ScanResult, TargetTruth
from radar_service.bench.scores.scoring import at_power_centroids
from radar_service.bench.trackers.tracker import DataSheet, TrackerInput, TrackState
from radar_service.numerics.types import Floats
from radar_service.plots.plot import Plot
from radar_service.truth.crossings import closest_approach

ACCELERATION = 0.0005  # spectral density of white acceleration [m^2/s^3], for all scenarios
FIRST_SPEED = 20.0  # m/s, standard deviation of a velocity of which nothing is known
UNDER_WAY = 2.0  # m/s: the course of what is slower is not known
ACCELERATIONS, STAY = (1e-5, 0.02), (3600.0, 30.0)  # of the models that keep a course and turn [m^2/s^3], [s]
GATE = 16.0  # squared normalised distance: 1 in 3000 plots of a target lies beyond
CONFIRM, LOST = 5, 9  # plots that confirm a track, scans without one that end it
UNLIKELY = 3  # scans within which a track that is not confirmed needs its next plot; one less among clutter
CLUTTER = 1e-7  # plots of clutter per m^2 and scan from which there is clutter


class _Track:
    """A target at constant velocity. x: east, north, velocities (4,); p: its covariance (4, 4), at the time [s]."""

    def __init__(self, name: int, plot: Plot, sheet: DataSheet, acceleration: float) -> None:
        self.name, self.time, self.plots, self.missed = name, plot.time, 1, 0
        self.sheet, self.acceleration = sheet, acceleration
        self.x = np.array([plot.east, plot.north, 0.0, 0.0])
        self.p = np.diag([0.0, 0.0, FIRST_SPEED**2, FIRST_SPEED**2])
        self.p[:2, :2] = covariance(plot, sheet, self.x)

    def predicted(self, at: float) -> tuple[Floats, Floats]:
        return moved((self.x, self.p), at - self.time, self.acceleration)

    def distance(self, plot: Plot) -> float:
        x, p = self.predicted(plot.time)
        miss = np.array([plot.east, plot.north]) - x[:2]
        return float(miss @ np.linalg.solve(p[:2, :2] + covariance(plot, self.sheet, self.x), miss))

    def update(self, plot: Plot) -> None:
        self.x, self.p = filtered(self.predicted(plot.time), plot, self.sheet)[:2]
        self.time, self.plots, self.missed = plot.time, self.plots + 1, 0


class _TwoModels(_Track):
    """The same by interacting models (Blom and Bar-Shalom 1988): one keeps its course, the other one turns."""

    def __init__(self, name: int, plot: Plot, sheet: DataSheet, acceleration: float) -> None:
        super().__init__(name, plot, sheet, acceleration)
        self.models, self.weights = [(self.x, self.p)] * 2, np.array([0.9, 0.1])

    def mixed(self, step: float) -> tuple[list[tuple[Floats, Floats]], Floats]:
        """States of the models after a time [s], before a plot, and their weights."""
        leave = 1.0 - np.exp(-abs(step) / np.array(STAY))
        switch = np.array([[1.0 - leave[0], leave[0]], [leave[1], 1.0 - leave[1]]]) * self.weights[:, None]
        weights = switch.sum(axis=0)
        states = [combined(self.models, switch[:, k] / weights[k]) for k in range(2)]
        return [moved(state, step, q) for state, q in zip(states, ACCELERATIONS, strict=True)], weights

    def predicted(self, at: float) -> tuple[Floats, Floats]:
        return combined(*self.mixed(at - self.time))

    def update(self, plot: Plot) -> None:
        states, weights = self.mixed(plot.time - self.time)
        every = [filtered(state, plot, self.sheet) for state in states]
        self.weights = weights * [likelihood for _, _, likelihood in every]
        self.weights = self.weights / self.weights.sum() if self.weights.sum() > 0.0 else weights
        self.models = [(x, p) for x, p, _ in every]
        self.x, self.p = combined(self.models, self.weights)
        self.time, self.plots, self.missed = plot.time, self.plots + 1, 0


def moved(state: tuple[Floats, Floats], step: float, acceleration: float) -> tuple[Floats, Floats]:
    """A state and its covariance after a time [s]."""
    unit = np.eye(2)
    f = np.block([[unit, step * unit], [0.0 * unit, unit]])
    q = np.block([[step**3 / 3.0 * unit, step**2 / 2.0 * unit], [step**2 / 2.0 * unit, step * unit]])
    return f @ state[0], f @ state[1] @ f.T + acceleration * (q if step > 0.0 else -q)


def filtered(state: tuple[Floats, Floats], plot: Plot, sheet: DataSheet) -> tuple[Floats, Floats, float]:
    """A state and its covariance after a plot, and the likelihood of the plot."""
    x, p = state
    spread = p[:2, :2] + covariance(plot, sheet, x)
    gain, miss = p[:, :2] @ np.linalg.inv(spread), np.array([plot.east, plot.north]) - x[:2]
    likelihood = np.exp(-0.5 * miss @ np.linalg.solve(spread, miss)) / np.sqrt(np.linalg.det(spread))
    return x + gain @ miss, p - gain @ p[:2], float(likelihood)


def combined(states: Sequence[tuple[Floats, Floats]], weights: Floats) -> tuple[Floats, Floats]:
    """The mean of states and its covariance."""
    x = np.sum([w * each for w, (each, _) in zip(weights, states, strict=True)], axis=0)
    return x, np.sum([w * (p + np.outer(y - x, y - x)) for w, (y, p) in zip(weights, states, strict=True)], axis=0)


def covariance(plot: Plot, sheet: DataSheet, x: Floats) -> Floats:
    """Of a plot's position (2, 2) [m^2]; an echo wanders along its ship, whose course x (4,) has where it is known to move."""
    sine, cosine = np.sin(plot.bearing), np.cos(plot.bearing)
    turn, speed = np.array([[sine, cosine], [cosine, -sine]]), float(np.hypot(x[2], x[3]))
    along = np.outer(x[2:], x[2:]) / speed**2 if speed > UNDER_WAY else np.eye(2)
    errors = turn @ np.diag([sheet.range_error**2, (plot.range * sheet.bearing_error) ** 2]) @ turn.T
    return errors + sheet.glint**2 * along


class Imm:
    """A good tracker: with one setting it passes all that one should. sheet: what is known of its plots."""

    gate, acceleration = 25.0, ACCELERATION  # a turn begins beyond GATE
    track_type: type[_Track] = _TwoModels

    def __init__(self, sheet: DataSheet | None = None) -> None:
        self.sheet = sheet or DataSheet()
        self.unlikely = UNLIKELY if self.sheet.clutter < CLUTTER else UNLIKELY - 1
        self.tracks: list[_Track] = []
        self.started = 0

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        self.follow(scan.plots)
        return [self.state(track, scan.time) for track in self.tracks if track.plots >= CONFIRM]

    def follow(self, plots: Sequence[Plot]) -> None:
        cost = np.array([[track.distance(plot) for plot in plots] for track in self.tracks])
        cost = np.minimum(cost.reshape(len(self.tracks), len(plots)), self.gate)
        pairs = {j: i for i, j in zip(*linear_sum_assignment(cost), strict=True) if cost[i, j] < self.gate}
        for track in self.tracks:
            track.missed += 1
        others = [plot for j, plot in enumerate(plots) if j not in pairs]
        for j, plot in enumerate(plots):
            if j in pairs:
                self.tracks[pairs[j]].update(plot)
        for plot in others:
            self.begin(plot)
        self.tracks = [t for t in self.tracks if t.missed < (LOST if t.plots >= CONFIRM else self.unlikely)]

    def begin(self, plot: Plot) -> None:
        """Begins a track, but where the beam has met a target twice in a scan, before and after north."""
        known = [track for track in self.tracks if track.plots > 2 and track.distance(plot) < self.gate]
        if known:
            known[0].update(plot)
        else:
            self.started += 1
            self.tracks.append(self.track_type(self.started, plot, self.sheet, self.acceleration))

    def state(self, track: _Track, end: float) -> TrackState:
        """At the end of the scan where plots are missed, and else at the time of the plot."""
        at = end if track.missed else track.time
        east, north, v_east, v_north = track.predicted(at)[0].tolist()
        return TrackState(
            track=str(track.name), time=at, east=east, north=north, velocity_east=v_east, velocity_north=v_north
        )


class Warns(Imm):
    """Says CPA and TCPA, alarms, which targets are lost, and that it follows `capacity` targets, which it never exceeds."""

    capacity = 30

    def __init__(self, sheet: DataSheet | None = None) -> None:
        super().__init__(sheet)
        self.before: dict[str, TrackState] = {}

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        now = {state.track: self.said(state, scan) for state in list(super().update(scan))[: self.capacity]}
        lost = [replace(state, lost=True) for name, state in self.before.items() if name not in now]
        is_full = len(now) == self.capacity
        self.before = now
        return [*(replace(state, full=is_full) for state in now.values()), *lost]

    def said(self, state: TrackState, scan: TrackerInput) -> TrackState:
        """A state with its CPA and what follows from it."""
        velocity = np.array([state.velocity_east, state.velocity_north])
        own = scan.speed * np.array([np.sin(scan.course), np.cos(scan.course)])
        offset = np.array([state.east, state.north]) + (scan.time - state.time) * velocity - (scan.east, scan.north)
        (cpa,), (tcpa,) = closest_approach(offset[None], (velocity - own)[None])
        alarm = bool(cpa <= self.sheet.cpa_limit and 0.0 <= tcpa <= self.sheet.tcpa_limit)
        said = None if np.isnan(tcpa) else float(tcpa)
        return replace(state, cpa=float(cpa), tcpa=said, alarm=alarm, lost=False)


class Obeys(Imm):
    """Acquires in the zone by itself and elsewhere on order, and cancels, but for the orders in `ignored`."""

    ignored: str = ""

    def __init__(self, sheet: DataSheet | None = None) -> None:
        super().__init__(sheet)
        self.zone: Sequence[float] | None = None
        self.places: list[Sequence[float]] = []
        self.how: dict[str, Literal["automatic", "manual"] | None] = {}

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        for order in scan.orders or ():
            self.zone = order.get("zone", self.zone)
            self.places += [order["acquire"]] if "acquire" in order else []
            self.how |= {order["cancel"]: None} if "cancel" in order and self.ignored != "cancel" else {}
        states = [state for state in super().update(scan) if self.how.setdefault(state.track, self.acquired(state, scan))]
        return [replace(state, acquired=self.how[state.track]) for state in states]

    def acquired(self, state: TrackState, scan: TrackerInput) -> Literal["automatic", "manual"] | None:
        if self.ignored != "acquire" and any(np.hypot(state.east - e, state.north - n) < 150.0 for e, n in self.places):
            return "manual"
        apart = np.hypot(state.east - scan.east, state.north - scan.north)
        bearing = np.arctan2(state.east - scan.east, state.north - scan.north)
        nearest, farthest, begin, end = self.zone or (0.0, 1e9, 0.0, 6.2831)
        is_in = nearest < apart < farthest and (bearing - begin) % (2.0 * np.pi) < (end - begin) % (2.0 * np.pi)
        return "automatic" if is_in or self.ignored == "zone" else None


class Kalman(Imm):
    """Has one model of motion for all ships: it is late in turns."""

    gate = GATE
    track_type: type[_Track] = _Track


class StraightLine(Kalman):
    """A straight line through all plots of a target, weighted by their errors: the best there is where it keeps its course."""

    acceleration = 0.0


class NarrowGate(Kalman):
    """Has a gate that holds 86 % of the plots of a target."""

    gate = 4.0


class Truth:
    """Answers the truth, as own ship reports it, from the first scan in which a target is seen to the last one.

    Its relative motion is true; its true motion is that with own ship's of gyro and log.
    """

    def __init__(self, observed: Sequence[ScanResult]) -> None:
        run = judged(at_power_centroids(observed))
        self.answers = [
            [
                _true_state(truth, scan.result.given)
                for body, truth in scan.truths.items()
                if number <= run.sightings[body].last
            ]
            for number, scan in enumerate(run.scans)
        ]

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        return self.answers[scan.scan]


def _true_state(truth: TargetTruth, own: TrackerInput) -> TrackState:
    """A target as own ship reports it at the end of a scan."""
    sensed = own.speed * np.array([np.sin(own.course), np.cos(own.course)])
    east, north = (np.array(truth.velocity) - truth.own_velocity + sensed).tolist()
    return TrackState(
        track=truth.body, time=own.time, east=truth.position[0], north=truth.position[1], velocity_east=east,
        velocity_north=north,
    )  # fmt: skip


class _Wrong(Imm):
    """A good tracker whose answers are changed."""

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        return [changed for state in super().update(scan) for changed in self.change(state, scan)]

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        raise NotImplementedError


class Frozen(Imm):
    """Gives the states of its eighth scan for ever."""

    states: Sequence[TrackState] = ()

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        self.states = super().update(scan) if scan.scan < 8 else self.states
        return self.states


class Extrapolates(Imm):
    """Takes no plots after 30 scans, and moves its tracks on honestly."""

    def follow(self, plots: Sequence[Plot]) -> None:
        self.scans = getattr(self, "scans", 0) + 1
        if self.scans <= 30:
            super().follow(plots)
        for track in self.tracks if self.scans > 30 else ():
            track.missed = 1


class Silent(Imm):
    """Says nothing for 39 scans."""

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        states = super().update(scan)
        return states if scan.scan >= 39 else []


class Still(_Wrong):
    """Knows no velocity."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        yield replace(state, velocity_east=0.0, velocity_north=0.0)


class HalfSpeed(_Wrong):
    """Gives half the velocity."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        yield replace(state, velocity_east=state.velocity_east / 2.0, velocity_north=state.velocity_north / 2.0)


class Reverses(_Wrong):
    """Reverses its velocities in one scan of ten."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        sign = -1.0 if scan.scan % 10 == 0 else 1.0
        yield replace(state, velocity_east=sign * state.velocity_east, velocity_north=sign * state.velocity_north)


class Delays(Imm):
    """Gives each answer one scan later, as if it were new."""

    states: Sequence[TrackState] = ()

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        later, self.states = self.states, super().update(scan)
        return [replace(state, time=state.time + 2.5) for state in later if state.time + 2.5 <= scan.time]


class NeverDeletes(Imm):
    """Keeps every track that it has reported, and says that it coasts."""

    def __init__(self, sheet: DataSheet | None = None) -> None:
        super().__init__(sheet)
        self.known: dict[str, TrackState] = {}

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        self.known |= {state.track: state for state in super().update(scan)}
        return [replace(state, coasting=True) for state in self.known.values()]


class Late(_Wrong):
    """Gives each state a time one second later."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        yield replace(state, time=state.time + 1.0)


class Ghost(Imm):
    """Has one more track, of nothing."""

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        ghost = TrackState(track="ghost", time=scan.time, east=9e3, north=9e3, velocity_east=0.0, velocity_north=0.0)
        return [*super().update(scan), ghost]


class Ghosts(Imm):
    """Has two hundred more tracks, of nothing."""

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        ghosts = [
            TrackState(track=f"ghost {k}", time=scan.time, east=25.0 * k, north=-2e3, velocity_east=0.0, velocity_north=0.0)
            for k in range(200)
        ]
        return [*super().update(scan), *ghosts]


class Twice(_Wrong):
    """Has each track twice."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        return (state, replace(state, track=f"{state.track} again"))


class NewNames(_Wrong):
    """Gives each track a new name in each scan."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        yield replace(state, track=f"{state.track} of scan {scan.scan}")


class Swaps(_Wrong):
    """Swaps the names of its first two tracks at scan 40."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        names: Mapping[str, str] = {"1": "2", "2": "1"} if scan.scan >= 40 else {}
        yield replace(state, track=names.get(state.track, state.track))


class Unfiltered(Imm):
    """Reports the last plot, and the difference of the last two as velocity."""

    def __init__(self, sheet: DataSheet | None = None) -> None:
        super().__init__(sheet)
        self.before: dict[str, list[TrackState]] = defaultdict(list)

    def follow(self, plots: Sequence[Plot]) -> None:
        super().follow(plots)
        for track in self.tracks:
            plot = next((plot for plot in plots if plot.time == track.time), None)
            if plot is not None:
                east, north, _, _ = track.x
                self.before[str(track.name)].append(
                    TrackState(track="", time=plot.time, east=plot.east, north=plot.north, velocity_east=0, velocity_north=0)
                )

    def state(self, track: _Track, end: float) -> TrackState:
        one, two = self.before[str(track.name)][-2:]
        step = two.time - one.time
        return replace(
            two,
            track=str(track.name),
            velocity_east=(two.east - one.east) / step,
            velocity_north=(two.north - one.north) / step,
        )


class _Displaced(_Wrong):
    """Errs in range [m] and bearing [degrees] from own ship."""

    range_m = bearing_deg = 0.0

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        east, north = state.east - scan.east, state.north - scan.north
        distance, bearing = np.hypot(east, north) + self.range_m, np.arctan2(east, north) + np.radians(self.bearing_deg)
        yield replace(
            state, east=float(scan.east + distance * np.sin(bearing)), north=float(scan.north + distance * np.cos(bearing))
        )


class Far(_Displaced):
    """Has ranges 150 m too long."""

    range_m = 150.0


class VeryFar(_Displaced):
    """Has ranges 300 m too long."""

    range_m = 300.0


class Turned(_Displaced):
    """Has bearings half a degree too large."""

    bearing_deg = 0.5


class VeryTurned(_Displaced):
    """Has bearings three degrees too large."""

    bearing_deg = 3.0


class DropsAtOnce(Imm):
    """Ends a track with its first scan without a plot."""

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        states = super().update(scan)
        self.tracks = [track for track in self.tracks if not track.missed]
        return [state for state in states if state.track in {str(track.name) for track in self.tracks}]


class FewTracks(_Wrong):
    """Follows twenty targets at most."""

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        return list(super().update(scan))[:20]

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        yield state


class SlowOnly(_Wrong):
    """Takes what moves faster than 28 knots for noise."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        if np.hypot(state.velocity_east, state.velocity_north) < 28.0 * 1852.0 / 3600.0:
            yield state


class StartOnly(Imm):
    """Begins no track after the first minute."""

    def follow(self, plots: Sequence[Plot]) -> None:
        before = len(self.tracks)
        names = {track.name for track in self.tracks}
        super().follow(plots)
        if before and plots and plots[0].time > 60.0:
            self.tracks = [track for track in self.tracks if track.name in names]


class Lags(_Wrong):
    """Follows courses slowly: its velocity is the mean of a minute."""

    def __init__(self, sheet: DataSheet | None = None) -> None:
        super().__init__(sheet)
        self.mean: dict[str, Floats] = {}

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        now = np.array([state.velocity_east, state.velocity_north])
        mean = self.mean[state.track] = self.mean.get(state.track, now) * 0.99 + now * 0.01
        yield replace(state, velocity_east=float(mean[0]), velocity_north=float(mean[1]))
