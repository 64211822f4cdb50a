"""A good tracker, of interacting Kalman filters with nearest neighbours, and others whose faults are known."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial, reduce
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.optimize import linear_sum_assignment

from radar_service.bench.scores.judged_scan import judged
from radar_service.bench.scores.scan_result import ScanResult, TargetTruth
from radar_service.bench.scores.scoring import at_power_centroids
from radar_service.bench.trackers.tracker import DataSheet, TrackerInput, TrackState, moved_on
from radar_service.numerics.types import Floats
from radar_service.plots.plot import Plot

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


class Extrapolates(Imm):
    """Takes no plots after 30 scans, and moves its tracks on honestly."""

    def follow(self, plots: Sequence[Plot]) -> None:
        self.scans = getattr(self, "scans", 0) + 1
        if self.scans <= 30:
            super().follow(plots)
        for track in self.tracks if self.scans > 30 else ():
            track.missed = 1


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


class DropsAtOnce(Imm):
    """Ends a track with its first scan without a plot."""

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        states = super().update(scan)
        self.tracks = [track for track in self.tracks if not track.missed]
        return [state for state in states if state.track in {str(track.name) for track in self.tracks}]


class StartOnly(Imm):
    """Begins no track after the first minute."""

    def follow(self, plots: Sequence[Plot]) -> None:
        before = len(self.tracks)
        names = {track.name for track in self.tracks}
        super().follow(plots)
        if before and plots and plots[0].time > 60.0:
            self.tracks = [track for track in self.tracks if track.name in names]


EXAMS = (60.0, 180.0)  # s after the first sight, when motion is judged
ABOUT = 8.0  # s about an exam


def is_exam(time: float) -> bool:
    """Whether motion may be judged at a time [s]: targets are seen from the first scan on."""
    return any(abs(time - at) <= ABOUT for at in EXAMS)


class UnfilteredBetweenExams(Unfiltered):
    """Reports the last plot and the difference of the last two, but after one and three minutes."""

    exam = False

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        self.exam = is_exam(scan.time)
        return super().update(scan)

    def state(self, track: _Track, end: float) -> TrackState:
        return Imm.state(self, track, end) if self.exam else super().state(track, end)


Past = Sequence[Sequence[TrackState]]  # the answers of the good tracker to all scans so far
Lie = Callable[[Past, TrackerInput], Sequence[TrackState]]


class Lying(Imm):
    """Answers what a lie makes of the answers of the good tracker."""

    def __init__(self, lie: Lie, sheet: DataSheet | None = None) -> None:
        super().__init__(sheet)
        self.lie, self.past = lie, list[Sequence[TrackState]]()

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        self.past.append(super().update(scan))
        return self.lie(self.past, scan)


def each(change: Callable[[TrackState, TrackerInput], TrackState | None]) -> Lie:
    """Changes each state, or leaves it out."""
    return lambda past, scan: [new for state in past[-1] if (new := change(state, scan)) is not None]


def only(keeps: Callable[[TrackState, TrackerInput], bool]) -> Lie:
    """Leaves tracks out."""
    return each(lambda s, scan: s if keeps(s, scan) else None)


def named(name: Callable[[TrackState, TrackerInput], str]) -> Lie:
    """Changes names."""
    return each(lambda s, scan: replace(s, track=name(s, scan)))


def moving(east: float = 0.0, north: float = 0.0, scale: float = 1.0) -> Lie:
    """Adds a velocity [m/s], and multiplies that of the track."""
    return each(lambda s, _: with_velocity(s, scale * complex(s.velocity_east, s.velocity_north) + complex(east, north)))


def with_velocity(state: TrackState, velocity: complex) -> TrackState:
    return replace(state, velocity_east=float(velocity.real), velocity_north=float(velocity.imag))


def placed(of: Callable[[complex], complex]) -> Lie:
    """Changes positions from own ship, east + i north [m]."""

    def change(s: TrackState, scan: TrackerInput) -> TrackState:
        own = complex(scan.east, scan.north)
        place = own + of(complex(s.east, s.north) - own)
        return replace(s, east=float(place.real), north=float(place.imag))

    return each(change)


def polar(longer: float = 0.0, turned: float = 0.0) -> Lie:
    """Adds to ranges [m] and bearings [degrees]."""
    return placed(lambda p: p * (1.0 + longer / max(abs(p), 1.0)) * np.exp(-1j * np.radians(turned)))


def at_scans(is_then: Callable[[int], bool], lie: Lie) -> Lie:
    """Lies in some scans."""
    return lambda past, scan: lie(past, scan) if is_then(scan.scan) else past[-1]


def between_exams(lie: Lie) -> Lie:
    """Lies but after one and three minutes."""
    return lambda past, scan: past[-1] if is_exam(scan.time) else lie(past, scan)


def more(of: Callable[[Past, TrackerInput], Iterable[TrackState]]) -> Lie:
    """Adds tracks."""
    return lambda past, scan: [*past[-1], *of(past, scan)]


def again(past: Past, east: float, name: str = "again") -> Sequence[TrackState]:
    """All tracks once more, so far to the east [m]."""
    return [replace(s, track=f"{s.track} {name}", east=s.east + east) for s in past[-1]]


def ghost(name: str, east: float, north: float, scan: TrackerInput, speed: float = 0.0) -> TrackState:
    """A track of nothing, so far from own ship [m]."""
    return TrackState(
        track=name, time=scan.time, east=scan.east + east, north=scan.north + north, velocity_east=speed, velocity_north=0.0
    )


def range_of(s: TrackState, scan: TrackerInput) -> float:
    return float(np.hypot(s.east - scan.east, s.north - scan.north))


def speed_of(s: TrackState) -> float:
    return float(np.hypot(s.velocity_east, s.velocity_north))


def still(s: TrackState, scan: TrackerInput) -> TrackState:
    """A state at the end of the scan, without velocity."""
    east, north = moved_on((s.east, s.north), (s.velocity_east, s.velocity_north), scan.time - s.time).tolist()
    return replace(s, time=scan.time, east=east, north=north, velocity_east=0.0, velocity_north=0.0)


def delayed(past: Past, scan: TrackerInput) -> Sequence[TrackState]:
    """The answer of one scan ago, as if it were new."""
    later = past[-2] if len(past) > 1 else ()
    return [replace(s, time=s.time + 2.5) for s in later if s.time + 2.5 <= scan.time]


def lagging(past: Past, scan: TrackerInput) -> Sequence[TrackState]:
    """Velocities that are the mean of a minute."""
    velocities = defaultdict[str, list[complex]](list)
    for s in (s for states in past for s in states):
        velocities[s.track].append(complex(s.velocity_east, s.velocity_north))
    return [with_velocity(s, reduce(lambda mean, v: 0.99 * mean + 0.01 * v, velocities[s.track])) for s in past[-1]]


def freezing(past: Past, scan: TrackerInput) -> Sequence[TrackState]:
    """Each eighth answer seven times more, as if it were new, but after one and three minutes."""
    period, number = scan.time / (scan.scan + 1), len(past) - 1
    last = max(k for k in range(len(past)) if k % 8 == 0 or is_exam((k + 1) * period))
    return past[last] if last == number else [replace(s, time=scan.time) for s in past[last]]


def lost(past: Past, scan: TrackerInput) -> Iterable[TrackState]:
    """Every track that has ended, under a new name."""
    ended = {s.track: s for before, now in pairwise(past) for s in before if s.track not in {n.track for n in now}}
    return [replace(s, track=f"lost {s.track}", coasting=True) for s in ended.values()]


exchanged = named(lambda s, _: {"1": "2", "2": "1"}.get(s.track, s.track))
FAULTS: dict[str, Lie] = {
    "Frozen": lambda past, _: past[:8][-1],  # the states of its eighth scan for ever
    "Silent": at_scans(lambda k: k < 39, only(lambda s, _: False)),
    "Still": moving(scale=0.0),
    "HalfSpeed": moving(scale=0.5),
    "Reverses": at_scans(lambda k: k % 10 == 0, moving(scale=-1.0)),
    "Delays": delayed,
    "NeverDeletes": lambda past, _: [*{s.track: replace(s, coasting=True) for some in past for s in some}.values()],
    "Late": each(lambda s, _: replace(s, time=s.time + 1.0)),
    "Ghost": more(lambda _, scan: [ghost("ghost", 9e3, 9e3, scan)]),
    "Ghosts": more(lambda _, scan: [ghost(f"ghost {k}", 25.0 * k, -2e3, scan) for k in range(200)]),
    "Twice": more(lambda past, _: again(past, 0.0)),
    "NewNames": named(lambda s, scan: f"{s.track} of scan {scan.scan}"),
    "Swaps": at_scans(lambda k: k >= 40, exchanged),
    "Far": polar(longer=150.0),
    "VeryFar": polar(longer=300.0),
    "Turned": polar(turned=0.5),
    "VeryTurned": polar(turned=3.0),
    "FewTracks": lambda past, _: past[-1][:20],
    "SlowOnly": only(lambda s, _: speed_of(s) < 28.0 * 1852.0 / 3600.0),  # takes what is faster for noise
    "Lags": lagging,
    "VelocityForExams": between_exams(each(still)),
    "PositionForExams": between_exams(placed(lambda p: p + 150.0)),
    "FreezesAndCatchesUp": freezing,
    "TakesTurns": only(lambda s, scan: bool((int(s.track) + scan.scan) % 2)),
    "TwoNames": named(lambda s, scan: f"{s.track}{'ab'[scan.scan % 2]}"),
    "SwapsLate": at_scans(lambda k: k >= 72, exchanged),  # in the last 20 scans of crossing-cpa-500
    "NearOnly": only(lambda s, scan: range_of(s, scan) < 5.0 * 1852.0),
    "RenamesTheLost": more(lost),
}
WRONG: dict[str, Callable[[DataSheet], Imm]] = {
    **{name: partial(Lying, lie) for name, lie in FAULTS.items()},
    **{kind.__name__: kind for kind in (Extrapolates, Unfiltered, DropsAtOnce, StartOnly, UnfilteredBetweenExams)},
}
Swaps = WRONG["Swaps"]  # as a tracker of its own
