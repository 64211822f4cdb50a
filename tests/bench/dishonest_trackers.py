"""Trackers that try to pass without tracking: each does what scores might not see, on top of the good tracker of the tests."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from radar_service.bench.trackers.tracker import DataSheet, TrackerInput, TrackState, moved_on
from tests.bench import known_trackers as known

EXAMS = (60.0, 180.0)  # s after the first sight, when motion is judged
ABOUT = 8.0  # s about an exam


def is_exam(scan: TrackerInput) -> bool:
    """Whether motion may be judged in a scan: targets are seen from the first one on."""
    return any(abs(scan.time - at) <= ABOUT for at in EXAMS)


class _Dishonest(known.Imm):
    """Changes the answers of a good tracker."""

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        return [changed for state in super().update(scan) for changed in self.change(state, scan)]

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        raise NotImplementedError


class VelocityForExams(_Dishonest):
    """Knows a velocity after one and three minutes, and none in any other scan."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        east, north = moved_on(
            (state.east, state.north), (state.velocity_east, state.velocity_north), scan.time - state.time
        ).tolist()
        still = replace(state, time=scan.time, east=east, north=north, velocity_east=0.0, velocity_north=0.0)
        yield state if is_exam(scan) else still


class PositionForExams(_Dishonest):
    """Is 150 m off but after one and three minutes."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        yield state if is_exam(scan) else replace(state, east=state.east + 150.0)


class FreezesAndCatchesUp(known.Imm):
    """Gives each eighth answer seven times more, as if it were new, but after one and three minutes."""

    states: Sequence[TrackState] = ()

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        fresh = super().update(scan)
        if scan.scan % 8 == 0 or is_exam(scan):
            self.states = fresh
        return self.states if self.states is fresh else [replace(state, time=scan.time) for state in self.states]


class UnfilteredBetweenExams(known.Unfiltered):
    """Reports the last plot and the difference of the last two, but after one and three minutes."""

    exam = False

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        self.exam = is_exam(scan)
        return super().update(scan)

    def state(self, track: Any, end: float) -> TrackState:
        return known.Imm.state(self, track, end) if self.exam else super().state(track, end)


class TakesTurns(known.Imm):
    """Reports each of its tracks in every other scan."""

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        return [state for state in super().update(scan) if (int(state.track) + scan.scan) % 2]


class TwoNames(_Dishonest):
    """Reports two tracks of each target in turns."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        yield replace(state, track=f"{state.track}{'ab'[scan.scan % 2]}")


class SwapsLate(_Dishonest):
    """Swaps the names of its first two tracks in the last 20 scans."""

    scans = 92  # of crossing-cpa-500

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        names = {"1": "2", "2": "1"} if scan.scan >= self.scans - 20 else {}
        yield replace(state, track=names.get(state.track, state.track))


class NearOnly(_Dishonest):
    """Reports what is nearer than five miles."""

    def change(self, state: TrackState, scan: TrackerInput) -> Iterable[TrackState]:
        if np.hypot(state.east - scan.east, state.north - scan.north) < 5.0 * 1852.0:
            yield state


class RenamesTheLost(known.Imm):
    """Keeps every track that it has lost under a new name."""

    def __init__(self, sheet: DataSheet | None = None) -> None:
        super().__init__(sheet)
        self.before: dict[str, TrackState] = {}
        self.lost: dict[str, TrackState] = {}

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        states = {state.track: state for state in super().update(scan)}
        self.lost |= {
            name: replace(state, track=f"lost {name}", coasting=True)
            for name, state in self.before.items()
            if name not in states
        }
        self.before = states
        return [*states.values(), *self.lost.values()]


Past = Sequence[Sequence[TrackState]]  # the answers of the good tracker to all scans so far
Lie = Callable[[Past, TrackerInput], Sequence[TrackState]]


class Lying(known.Imm):
    """Answers what a lie makes of the answers of a good tracker."""

    def __init__(self, lie: Lie, sheet: DataSheet | None = None) -> None:
        super().__init__(sheet)
        self.lie, self.past = lie, list[Sequence[TrackState]]()

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        self.past.append(super().update(scan))
        return self.lie(self.past, scan)


def each(change: Callable[[TrackState, TrackerInput], TrackState | None]) -> Lie:
    """Changes each state, or leaves it out."""
    return lambda past, scan: [new for state in past[-1] if (new := change(state, scan)) is not None]


def moving(east: float = 0.0, north: float = 0.0, scale: float = 1.0) -> Lie:
    """Adds a velocity [m/s], and multiplies that of the track."""
    return each(
        lambda s, _: replace(
            s, velocity_east=scale * s.velocity_east + east, velocity_north=scale * s.velocity_north + north
        )
    )


def turning(angle: float) -> Lie:
    """Turns velocities by an angle [degrees]."""
    turn = np.exp(-1j * np.radians(angle))
    return each(lambda s, _: with_velocity(s, complex(s.velocity_east, s.velocity_north) * turn))


def with_velocity(state: TrackState, velocity: complex) -> TrackState:
    return replace(state, velocity_east=float(velocity.real), velocity_north=float(velocity.imag))


def rounded(courses: float, speeds: float) -> Lie:
    """Rounds courses [degrees] and speeds [m/s]."""

    def change(s: TrackState, _: TrackerInput) -> TrackState:
        speed, course = np.hypot(s.velocity_east, s.velocity_north), np.arctan2(s.velocity_east, s.velocity_north)
        speed = np.round(speed / speeds) * speeds if speeds else speed
        course = np.round(np.degrees(course) / courses) * np.radians(courses) if courses else course
        return with_velocity(s, complex(speed * np.sin(course), speed * np.cos(course)))

    return each(change)


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


def grid(step: float) -> Lie:
    """Rounds positions [m]."""
    return placed(lambda p: complex(np.round(p.real / step) * step, np.round(p.imag / step) * step))


def only(keeps: Callable[[TrackState, TrackerInput], bool]) -> Lie:
    """Leaves tracks out."""
    return each(lambda s, scan: s if keeps(s, scan) else None)


def at_scans(is_then: Callable[[int], bool], lie: Lie) -> Lie:
    """Lies in some scans."""
    return lambda past, scan: lie(past, scan) if is_then(scan.scan) else past[-1]


def delayed(scans: int, renewed: bool) -> Lie:
    """Answers of scans ago; `renewed` says that they are of now."""

    def lie(past: Past, scan: TrackerInput) -> Sequence[TrackState]:
        old = past[-1 - scans] if len(past) > scans else []
        return [replace(s, time=scan.time) for s in old] if renewed else old

    return lie


def frozen(every: int) -> Lie:
    """Gives one answer several times, as if it were new."""
    return lambda past, scan: [replace(s, time=scan.time) for s in past[(len(past) - 1) // every * every]]


def named(name: Callable[[TrackState, TrackerInput], str]) -> Lie:
    """Changes names."""
    return each(lambda s, scan: replace(s, track=name(s, scan)))


def more(of: Callable[[Past, TrackerInput], Sequence[TrackState]]) -> Lie:
    """Adds tracks."""
    return lambda past, scan: [*past[-1], *of(past, scan)]


def ghost(name: str, east: float, north: float, scan: TrackerInput, speed: float = 0.0) -> TrackState:
    return TrackState(
        track=name, time=scan.time, east=scan.east + east, north=scan.north + north, velocity_east=speed, velocity_north=0.0
    )


def again(past: Past, east: float, name: str = "again") -> Sequence[TrackState]:
    """All tracks once more, so far to the east [m]."""
    return [replace(s, track=f"{s.track} {name}", east=s.east + east) for s in past[-1]]


def range_of(s: TrackState, scan: TrackerInput) -> float:
    return float(np.hypot(s.east - scan.east, s.north - scan.north))


def speed_of(s: TrackState) -> float:
    return float(np.hypot(s.velocity_east, s.velocity_north))


def wavering(size: float, of_velocity: bool) -> Lie:
    """Adds a number between -size and size [m] or [m/s], another one in each scan."""

    def change(s: TrackState, scan: TrackerInput) -> TrackState:
        east = size * np.sin(12.9898 * scan.scan + 78.233 * len(s.track))
        return replace(s, velocity_east=s.velocity_east + east) if of_velocity else replace(s, east=s.east + east)

    return each(change)


def swapped(past: Past) -> Sequence[TrackState]:
    """Gives each track the name of the next one."""
    names = [s.track for s in past[-1]]
    return [replace(s, track=name) for s, name in zip(past[-1], names[1:] + names[:1], strict=True)]


LIES: dict[str, Lie] = {
    "half of the speed": moving(scale=0.5),
    "0.8 of the speed": moving(scale=0.8),
    "1.25 of the speed": moving(scale=1.25),
    "twice the speed": moving(scale=2.0),
    "velocities reversed": moving(scale=-1.0),
    "a current of 2 m/s": moving(east=2.0),
    "a current of 1.2 m/s to the north": moving(north=1.2),
    "courses turned by 15 degrees": turning(15.0),
    "courses turned by 45 degrees": turning(45.0),
    "courses turned by 90 degrees": turning(90.0),
    "courses of whole 45 degrees": rounded(45.0, 0.0),
    "speeds of whole 5 m/s": rounded(0.0, 5.0),
    "ships of one speed": rounded(0.0, 25.0),
    "velocities that waver by 4 m/s": wavering(4.0, True),
    "velocities that waver by 8 m/s": wavering(8.0, True),
    "positions that waver by 40 m": wavering(40.0, False),
    "positions that waver by 80 m": wavering(80.0, False),
    "velocity reversed in one scan of eight": at_scans(lambda k: k % 8 == 0, moving(scale=-1.0)),
    "no velocity in one scan of four": at_scans(lambda k: k % 4 == 0, moving(scale=0.0)),
    "no velocity after 60 scans": at_scans(lambda k: k > 60, moving(scale=0.0)),
    "no velocity for the first 50 scans": at_scans(lambda k: k < 50, moving(scale=0.0)),
    "ranges 40 m too long": polar(longer=40.0),
    "ranges 60 m too short": polar(longer=-60.0),
    "bearings one degree too large": polar(turned=1.0),
    "bearings 2 degrees too small": polar(turned=-2.0),
    "bearings 20 degrees too large": polar(turned=20.0),
    "east and west exchanged": placed(lambda p: complex(-p.real, p.imag)),
    "east and north exchanged": placed(lambda p: complex(p.imag, p.real)),
    "ranges 5 % too long": placed(lambda p: 1.05 * p),
    "positions of whole 100 m": grid(100.0),
    "positions of whole 200 m": grid(200.0),
    "positions 30 m to the east": placed(lambda p: p + 30.0),
    "positions 250 m to the north": placed(lambda p: p + 250j),
    "one scan of three": at_scans(lambda k: k % 3 > 0, only(lambda s, _: False)),
    "nothing in one scan of three": at_scans(lambda k: k % 3 == 0, only(lambda s, _: False)),
    "nothing in one scan of ten": at_scans(lambda k: k % 10 == 0, only(lambda s, _: False)),
    "nothing in scans 30 to 45": at_scans(lambda k: 30 <= k < 45, only(lambda s, _: False)),
    "nothing after scan 45": at_scans(lambda k: k >= 45, only(lambda s, _: False)),
    "nothing before scan 40": at_scans(lambda k: k < 40, only(lambda s, _: False)),
    "one track": lambda past, _: past[-1][:1],
    "all tracks but the first": lambda past, _: past[-1][1:],
    "the nearest track": lambda past, scan: sorted(past[-1], key=lambda s: range_of(s, scan))[:1],
    "tracks nearer than 1500 m": only(lambda s, scan: range_of(s, scan) < 1500.0),
    "tracks farther than 1800 m": only(lambda s, scan: range_of(s, scan) > 1800.0),
    "tracks slower than 10 knots": only(lambda s, _: speed_of(s) < 5.1),
    "tracks faster than 10 knots": only(lambda s, _: speed_of(s) > 5.1),
    "tracks to the east": only(lambda s, scan: s.east > scan.east),
    "tracks that go to the east": only(lambda s, _: s.velocity_east > 0.0),
    "answers one scan old, as if new": delayed(1, True),
    "answers two scans old, as if new": delayed(2, True),
    "answers of six scans ago": delayed(6, False),
    "each fourth answer, as if new": frozen(4),
    "each twelfth answer, as if new": frozen(12),
    "names by the minute": named(lambda s, scan: f"{s.track} {scan.time // 60}"),
    "names by place": named(lambda s, scan: f"{s.east // 500} {s.north // 500} {s.track}"),
    "names by course": named(lambda s, _: f"{s.track} {s.velocity_east > 0.0} {s.velocity_north > 0.0}"),
    "names swapped from scan 50": at_scans(lambda k: k >= 50, lambda past, _: swapped(past)),
    "names swapped in scan 45": at_scans(lambda k: k == 45, lambda past, _: swapped(past)),
    "names swapped in turns": at_scans(lambda k: k % 2 == 0, lambda past, _: swapped(past)),
    "a ghost with a new name each scan": more(lambda _, scan: [ghost(f"ghost {scan.scan}", 3e3, 3e3, scan)]),
    "a ghost in one scan of fifteen": more(lambda _, scan: [ghost("ghost", 0.0, -2500.0, scan)] * (scan.scan % 15 == 0)),
    "a ghost that passes": more(lambda _, scan: [ghost("ghost", 8.0 * scan.time - 1e3, -1800.0, scan, 8.0)]),
    "ten ghosts": more(lambda _, scan: [ghost(f"ghost {k}", 300.0 * k - 1500.0, -1500.0, scan) for k in range(10)]),
    "a mirror image of each track": more(
        lambda past, scan: [replace(s, track=f"{s.track} mirrored", east=2.0 * scan.east - s.east) for s in past[-1]]
    ),
    "each track once more 150 m off": more(lambda past, _: again(past, 150.0)),
    "each track once more 600 m off": more(lambda past, _: again(past, 600.0)),
    "each track once more after scan 50": at_scans(lambda k: k > 50, more(lambda past, _: again(past, 5.0))),
    "each track once more in one scan of five": at_scans(lambda k: k % 5 == 0, more(lambda past, _: again(past, 5.0))),
}  # fmt: skip
OF_IMM: list[type[known.Imm]] = [
    *(known.Frozen, known.Extrapolates, known.Silent, known.Still, known.NeverDeletes, known.Late, known.Ghost, known.Ghosts),
    *(known.Twice, known.NewNames, known.Swaps, known.Unfiltered, known.Far, known.VeryFar, known.VeryTurned, known.Reverses),
    *(known.DropsAtOnce, known.FewTracks, known.SlowOnly, known.StartOnly, known.Lags, known.Delays, VelocityForExams),
    *(PositionForExams, FreezesAndCatchesUp, UnfilteredBetweenExams, TakesTurns, TwoNames, SwapsLate, NearOnly),
    *(RenamesTheLost, known.Turned),
]  # fmt: skip
