"""Random draws of ships of boxes under way: scene tables, of which the oracle and the engine make what they will.

Lengths and ranges are drawn evenly in their logarithm, else evenly. At the crossing, when the beam points at it, the hull is at
its drawn range, bearing and aspect.

| what | distribution |
|---|---|
| kind | straight, rolling (with pitch, yaw, heave), loop, waypoint, manoeuvre, track, own ship, wall, quay, passing: in turns |
| hull | steel box, 2.5 to 9 m long, width 0.3 to 0.6 of it, height 1.5 to 4 m, of which 5 to 40 % are in the water |
| radar | 9.41 or 3.05 GHz, h or v, antenna at 10 or 25 m, 5 or 20 MHz, beam 1.9 or 3.9 degrees, 720 spokes, 24 rpm |
| range, bearing | 150 to 3000 m (to 14 km without shadows), all round, a quarter within a beamwidth of north |
| scan | 0, within 10 minutes, or after 6 h, a third each; the sea reflects in 80 %; earth 4/3 in 80 % |
| corner | half of them within 30 spokes before or 60 after the crossing, the others 0.2 to 20 s before or after |
| sway | always in rolling, else in 30 %: 2 to 10 degrees in 4 to 12 s, heave to 0.8 m in 5 to 9 s |
| wall | 5 to 300 m long, 1 to 6 m thick, 1 to 8 m high, 10 to 150 m before, 5 to 60 m beside or behind, at any heading |
| passing | another steel hull under way, 8 to 120 m nearer or farther, within a body's width of the line of sight, or two |
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tests.reference import ship_tracks
from tests.reference.cast_shadows import in_front
from tests.reference.metal_draws import KNOT, log_uniform
from tests.reference.metal_on_water import EARTH, LIGHT, SEA_WATER, Floats, Setting

KINDS = ("straight", "rolling", "loop", "waypoint", "manoeuvre", "track", "own ship", "wall", "quay", "passing")
SHADOWED = ("wall", "quay", "passing")
AZIMUTHS, PERIOD = 720, 2.5
STEP = PERIOD / AZIMUTHS  # s between spokes
SIX_HOURS = 8640  # scans
SEA_AT = {9.41e9: SEA_WATER, 3.05e9: 71.4 - 38.7j}  # the latter of Klein and Swift 1977 at 15 C and 35 per thousand
Table = dict[str, Any]


@dataclass(frozen=True)
class Case:
    """One draw: scene tables, and the spoke of the crossing, numbered from the start.

    tracks: rows of each track file. bodies: the metal first, then what casts shadows.
    """

    number: int
    kind: str
    setting: Setting
    radar: Table
    crossing: int
    bodies: tuple[Table, ...]
    own: Table = field(default_factory=dict)
    tracks: dict[str, Floats] = field(default_factory=dict)
    remark: str = ""

    @property
    def scene(self) -> Table:
        """The scene file, without its tracks."""
        earth = "flat" if np.isinf(self.setting.earth_radius) else "4/3"
        return {
            "radar": self.radar, "own_ship": self.own, "body": list(self.bodies),
            "environment": {"multipath": self.setting.sea, "earth": earth},
        }  # fmt: skip

    @property
    def spokes(self) -> np.ndarray:
        """Spokes (K,), numbered from the start, within a beamwidth of the crossing."""
        reach = int(np.ceil(self.radar["beamwidth_deg"] / 360.0 * AZIMUTHS)) + 1
        return np.arange(max(0, self.crossing - reach), self.crossing + reach + 1)

    def __str__(self) -> str:
        hull, place = self.bodies[0], self.place(self.crossing * STEP)
        size = "x".join(f"{hull[key]:.1f}" for key in ("length_m", "width_m", "height_m"))
        roll = f", rolls {hull['roll_deg']:.1f}" if "roll_deg" in hull else ""
        return (
            f"#{self.number} {self.kind}: {size} at {np.hypot(*place):.0f} m, bearing {np.rad2deg(np.arctan2(*place)):.1f}, "
            f"scan {self.crossing // AZIMUTHS}, {self.radar['frequency_hz'] / 1e9:.1f} GHz {self.radar['polarization']}"
            f"{roll}{', sea' if self.setting.sea else ''}{self.remark}"
        )

    def place(self, time: float) -> Floats:
        """East and north (2,) of the metal about the antenna [m]."""
        stands = [ship_tracks.stand(table, time, self.tracks).position for table in (self.bodies[0], self.own)]
        return np.asarray((stands[0] - stands[1])[:2])


def drawn(number: int, seed: int) -> Case:
    """One draw."""
    for attempt in range(200):
        rng = np.random.default_rng([seed, number, attempt])
        case = attempted(number, KINDS[number % len(KINDS)], rng)
        if case is not None:
            return case
    raise AssertionError(f"draw {number} of seed {seed} does not fit")


def attempted(number: int, kind: str, rng: np.random.Generator) -> Case | None:
    """One draw of a kind; None where its bodies touch."""
    frequency = float(rng.choice([9.41e9, 3.05e9]))
    setting = Setting(
        wavelength=LIGHT / frequency, antenna_height=float(rng.choice([10.0, 25.0])), polarization=str(rng.choice(["h", "v"])),
        beamwidth_el=np.deg2rad(25.0), sea=bool(rng.random() < 0.8), permittivity=SEA_AT[frequency],
        earth_radius=EARTH if rng.random() < 0.8 else np.inf,
    )  # fmt: skip
    beamwidth = float(rng.choice([1.9, 3.9]))
    distance = log_uniform(rng, 150.0, 3000.0)
    if kind not in SHADOWED and rng.random() < 0.15:
        distance = log_uniform(rng, 3000.0, 14_000.0)
    radar = {
        "frequency_hz": frequency, "polarization": setting.polarization, "height_m": setting.antenna_height,
        "bandwidth_hz": float(rng.choice([5e6, 20e6])), "beamwidth_deg": beamwidth, "azimuths": AZIMUTHS, "rpm": 24.0,
        "beamwidth_el_deg": 25.0, "range_max_m": float(np.ceil(distance * 1.02 + 250.0)),
    }  # fmt: skip
    bearing = rng.uniform(-1.0, 1.0) * np.deg2rad(beamwidth) if rng.random() < 0.25 else rng.uniform(0.0, 2.0 * np.pi)
    scan = [0, int(rng.integers(3, 240)), SIX_HOURS][rng.integers(3)]
    crossing = max(0, scan * AZIMUTHS + round(bearing % (2.0 * np.pi) / (2.0 * np.pi) * AZIMUTHS))
    place = distance * np.array([np.sin(bearing), np.cos(bearing)])
    hull = hull_table("metal", rng)
    if kind == "rolling" or rng.random() < 0.3:
        hull |= sway(rng)
    case = Case(number, kind, setting, radar, crossing, (hull,))
    return MAKERS[kind](case, place, rng)


def hull_table(name: str, rng: np.random.Generator) -> Table:
    """A steel box."""
    length, height = log_uniform(rng, 2.5, 9.0), rng.uniform(1.5, 4.0)
    return {
        "name": name, "shape": "box", "scattering": "optics", "length_m": length, "width_m": length * rng.uniform(0.3, 0.6),
        "height_m": height, "position_m": [0.0, 0.0, -height * rng.uniform(0.05, 0.4)],
    }  # fmt: skip


def sway(rng: np.random.Generator) -> Table:
    """Roll, and half of the time each of pitch, yaw and heave."""
    keys: Table = {"roll_deg": rng.uniform(2.0, 10.0), "roll_period_s": rng.uniform(4.0, 12.0)}
    if rng.random() < 0.5:
        keys |= {"pitch_deg": rng.uniform(1.0, 4.0), "pitch_period_s": rng.uniform(4.0, 8.0)}
    if rng.random() < 0.5:
        keys |= {"yaw_deg": rng.uniform(1.0, 4.0), "yaw_period_s": rng.uniform(8.0, 20.0)}
    if rng.random() < 0.5:
        keys |= {"heave_m": rng.uniform(0.1, 0.8), "heave_period_s": rng.uniform(5.0, 9.0)}
    return keys | {key.replace("period_s", "phase_deg"): rng.uniform(-180.0, 180.0) for key in keys if "period" in key}


def moved(table: Table, by: Floats, tracks: dict[str, Floats]) -> Table:
    """A table of the same motion elsewhere; its track is moved in place."""
    if "track" in table:
        tracks[table["track"]][:, 1:3] += by
        return table
    at = table.get("position_m", [0.0, 0.0])
    table = table | {"position_m": [at[0] + by[0], at[1] + by[1], *at[2:]]}
    if "waypoints" in table:
        points = [{**each, "position_m": [a + b for a, b in zip(each["position_m"], by, strict=True)]}
                  for each in table["waypoints"]]  # fmt: skip
        table["waypoints"] = points
    return table


def settled(case: Case, table: Table, place: Floats) -> Case:
    """The case with a motion of its metal that has it at a place at the crossing."""
    position = ship_tracks.stand(table, case.crossing * STEP, case.tracks).position[:2]
    own = ship_tracks.stand(case.own, case.crossing * STEP, case.tracks).position[:2]
    return replace(case, bodies=(moved(table, place + own - position, case.tracks), *case.bodies[1:]))


def corner_time(case: Case, rng: np.random.Generator) -> tuple[float, str]:
    """When a corner is [s], after the start, and what to say of it."""
    for _ in range(100):
        near = rng.random() < 0.5
        spokes = rng.uniform(-30.0, 60.0) if near else rng.choice([-1.0, 1.0]) * log_uniform(rng, 0.2, 20.0) / STEP
        if (time := (case.crossing + spokes) * STEP) > 0.01:
            return time, f", corner after {spokes:.1f} spokes"
    return case.crossing * STEP + 0.1, ", corner after 0.1 s"


def straight(case: Case, place: Floats, rng: np.random.Generator) -> Case:
    """At rest, or on a straight course, with drift or without."""
    keys: Table = {"heading_deg": rng.uniform(0.0, 360.0)}
    if rng.random() < 0.8:
        keys = {"course_deg": rng.uniform(0.0, 360.0), "speed_kn": rng.uniform(3.0, 30.0)}
        keys |= {"drift_deg": rng.uniform(-20.0, 20.0)} if rng.random() < 0.3 else {}
    return settled(case, case.bodies[0] | keys, place)


def loop(case: Case, place: Floats, rng: np.random.Generator) -> Case:
    """A closed course of three or four legs."""
    count = int(rng.integers(2, 4))
    course = rng.uniform(0.0, 2.0 * np.pi) + np.cumsum(rng.uniform(0.4, 2.2, count) * rng.choice([-1.0, 1.0]))
    steps = np.stack([np.sin(course), np.cos(course)], axis=1) * rng.uniform(0.5, 1.5, (count, 1))
    stops = np.cumsum(steps, axis=0)
    sides = np.append(np.linalg.norm(steps, axis=1), np.linalg.norm(stops[-1]))
    time, remark = corner_time(case, rng)
    share, speed, usual = float(rng.choice(np.cumsum(sides) / sides.sum())), rng.uniform(3.0, 15.0), rng.uniform(30.0, 200.0)
    laps = max(round(time / usual - share), 0)
    if case.crossing < AZIMUTHS and rng.random() < 0.5:
        share, laps, time, remark = 1.0, 0, usual, ""
    stops *= speed * time / (laps + share) / sides.sum()
    points = [{"position_m": [float(x) for x in stop], "speed_kn": speed / KNOT} for stop in stops]
    return replace(settled(case, case.bodies[0] | {"waypoints": points, "loop": True}, place), remark=remark)


def waypoint(case: Case, place: Floats, rng: np.random.Generator) -> Case:
    """A corner, half of them rounded, and the end of the course after it."""
    time, remark = corner_time(case, rng)
    course, turn, speed = (
        rng.uniform(0.0, 2.0 * np.pi),
        rng.uniform(0.2, 2.0) * rng.choice([-1.0, 1.0]),
        rng.uniform(3.0, 12.0),
    )
    keys: Table = {}
    if rng.random() < 0.5:
        rate = rng.uniform(1.0, 6.0)
        cut = speed / np.deg2rad(rate) * np.tan(abs(turn) / 2.0) / speed  # s before the corner, where the arc begins
        time += cut
        keys = {"turn_rate_deg_s": rate} if rng.random() < 0.5 else {"turn_radius_m": speed / np.deg2rad(rate)}
        remark += f", rounded at {rate:.1f} deg/s"
    legs = [(course, time), (course + turn, rng.uniform(150.0, 300.0))]
    stops = np.cumsum([speed * span * np.array([np.sin(c), np.cos(c)]) for c, span in legs], axis=0)
    points = [{"position_m": [float(x) for x in stop], "speed_kn": speed / KNOT} for stop in stops]
    if keys and legs[0][1] < cut + 0.1:
        return waypoint(case, place, rng)
    if rng.random() < 0.15:
        keys["heading_deg"] = rng.uniform(0.0, 360.0)
    return replace(settled(case, case.bodies[0] | {"waypoints": points} | keys, place), remark=remark)


def manoeuvre(case: Case, place: Floats, rng: np.random.Generator) -> Case:
    """A new course at once or at a rate, a new rate, or a new speed."""
    time, remark = corner_time(case, rng)
    course, turn = rng.uniform(0.0, 360.0), rng.uniform(10.0, 120.0) * rng.choice([-1.0, 1.0])
    change: Table = {"time_s": time}
    keys: Table = {"course_deg": course, "speed_kn": rng.uniform(5.0, 25.0)}
    match int(rng.integers(4)):
        case 0:
            change |= {"course_deg": (course + turn) % 360.0}
        case 1:
            change |= {"course_deg": (course + turn) % 360.0, "turn_rate_deg_s": rng.uniform(1.0, 10.0)}
        case 2:
            change |= {"turn_rate_deg_s": float(rng.uniform(1.0, 6.0) * rng.choice([-1.0, 1.0]))}
            if time > 3600.0:
                keys["turn_rate_deg_s"] = 0.0
        case _:
            change |= {"course_deg": (course + turn) % 360.0, "speed_kn": rng.uniform(5.0, 25.0)}
    keys |= {"drift_deg": rng.uniform(-15.0, 15.0)} if rng.random() < 0.2 else {}
    return replace(settled(case, case.bodies[0] | keys | {"manoeuvre": [change]}, place), remark=remark)


def track(case: Case, place: Floats, rng: np.random.Generator) -> Case:
    """A file of three legs, the corner between the first two; a third of them with headings of their own."""
    time, remark = corner_time(case, rng)
    speed, course = rng.uniform(3.0, 12.0), rng.uniform(0.0, 2.0 * np.pi) + np.cumsum([0.0, *rng.uniform(-2.0, 2.0, 2)])
    times = np.array([0.0, time, time + rng.uniform(1.0, 40.0), time + 200.0])
    steps = speed * np.diff(times)[:, None] * np.stack([np.sin(course), np.cos(course)], axis=1)
    hull = {key: value for key, value in case.bodies[0].items() if key != "position_m"}
    up = np.full((4, 1), case.bodies[0]["position_m"][2])
    rows = np.hstack([times[:, None], np.vstack([np.zeros(2), np.cumsum(steps, axis=0)]), up])
    if rng.random() < 0.33:
        rows = np.hstack([rows, rng.uniform(0.0, 360.0) + np.cumsum(rng.uniform(-90.0, 90.0, (4, 1)), axis=0)])
    case = replace(case, tracks={"metal.csv": rows}, remark=remark)
    return settled(case, hull | {"track": "metal.csv"}, place)


def own_ship(case: Case, place: Floats, rng: np.random.Generator) -> Case:
    """Own ship under way: straight, round a corner, or with a manoeuvre."""
    time, remark = corner_time(case, rng)
    course, turn, speed = rng.uniform(0.0, 360.0), rng.uniform(10.0, 120.0) * rng.choice([-1.0, 1.0]), rng.uniform(4.0, 20.0)
    own: Table = {"course_deg": course, "speed_kn": speed}
    match int(rng.integers(3)):
        case 0:
            remark = ""
        case 1:
            own["manoeuvre"] = [{"time_s": time, "course_deg": (course + turn) % 360.0}]
        case _:
            legs = [(np.deg2rad(course), time), (np.deg2rad(course + turn), 200.0)]
            stops = np.cumsum([speed * KNOT * span * np.array([np.sin(c), np.cos(c)]) for c, span in legs], axis=0)
            own = {"waypoints": [{"position_m": [float(x) for x in stop], "speed_kn": speed} for stop in stops]}
            own["position_m"] = [0.0, 0.0]
    return replace(straight(replace(case, own=own), place, rng), remark=remark)


def wall(case: Case, place: Floats, rng: np.random.Generator) -> Case | None:
    """A wall before, beside or behind the metal, which is at rest in half of the draws."""
    return walled(case, place, rng, log_uniform(rng, 5.0, 60.0))


def quay(case: Case, place: Floats, rng: np.random.Generator) -> Case | None:
    """As `wall`, of 30 to 300 m."""
    return walled(case, place, rng, log_uniform(rng, 30.0, 300.0))


def walled(case: Case, place: Floats, rng: np.random.Generator, length: float) -> Case | None:
    """The metal and a wall of a length [m] that is as good as silent; None where they touch, or the wall is at the antenna."""
    ahead = place / np.hypot(*place)
    aside = np.array([ahead[1], -ahead[0]])
    where = str(rng.choice(["before", "before", "beside", "behind"]))
    gap = log_uniform(rng, 10.0, 150.0) if where == "before" else log_uniform(rng, 5.0, 60.0)
    way = {"before": -ahead, "behind": ahead, "beside": float(rng.choice([-1.0, 1.0])) * aside}[where]
    turned = np.rad2deg(np.arctan2(*aside)) + rng.uniform(-40.0, 40.0) + (90.0 if where == "beside" else 0.0)
    shift = rng.uniform(-0.5, 0.5) * length * (ahead if where == "beside" else aside)
    table = {
        "name": "wall", "shape": "box", "length_m": length, "width_m": rng.uniform(1.0, 6.0), "height_m": rng.uniform(2.0, 9.0),
        "position_m": [*(place + way * gap + shift).tolist(), -1.0], "heading_deg": turned % 360.0, "rcs_dbsm": -100.0,
    }  # fmt: skip
    keys: Table = {"heading_deg": rng.uniform(0.0, 360.0)}
    if rng.random() < 0.5:
        keys = {"course_deg": rng.uniform(0.0, 360.0), "speed_kn": rng.uniform(3.0, 20.0)}
    case = settled(replace(case, bodies=(*case.bodies, table)), case.bodies[0] | keys, place)
    return checked(replace(case, remark=f", {length:.0f} m {where} at {gap:.0f} m"), 20.0)


def passing(case: Case, place: Floats, rng: np.random.Generator) -> Case | None:
    """Another hull near the line of sight, half of them with a third one beyond; the first is at rest in a third of draws."""
    ahead = place / np.hypot(*place)
    aside = np.array([ahead[1], -ahead[0]])
    keys: Table = {"heading_deg": rng.uniform(0.0, 360.0)}
    if rng.random() < 0.67:
        keys = {"course_deg": rng.uniform(0.0, 360.0), "speed_kn": rng.uniform(3.0, 20.0)}
    case, remarks = settled(case, case.bodies[0] | keys, place), []
    for k in range(int(rng.integers(1, 3))):
        gap, off = log_uniform(rng, 8.0, 120.0) * rng.choice([-1.0, -1.0, 1.0]), rng.uniform(-1.0, 1.0) * 8.0
        other = hull_table(f"other {k}", rng) | {"course_deg": rng.uniform(0.0, 360.0), "speed_kn": rng.uniform(3.0, 20.0)}
        other |= sway(rng) if rng.random() < 0.3 else {}
        target = replace(case, bodies=(other,))
        other = settled(target, other, place + ahead * gap + aside * off).bodies[0]
        case = replace(case, bodies=(*case.bodies, other))
        remarks.append(f"{gap:+.0f} m off {off:+.1f}")
    return checked(replace(case, remark=f", passing {', '.join(remarks)}"), 20.0)


def checked(case: Case, nearest: float) -> Case | None:
    """The case, or None where its bodies come within a metre of each other in the passage, or any of them to the antenna."""
    for time in case.spokes[[0, -1]] * STEP:
        own = ship_tracks.stand(case.own, time, case.tracks).position
        grown = [outline(table, time, own, case.tracks, 1.0) for table in case.bodies]
        antenna = outline(
            {"position_m": [0.0, 0.0], "width_m": nearest, "length_m": nearest, "height_m": 1.0}, 0.0, 0.0 * own, {}, 0.0
        )
        for k, solid in enumerate(grown):
            for other in [*grown[:k], antenna]:
                try:
                    in_front(solid, other)
                except ValueError:
                    return None
    return case


def outline(table: Table, time: float, own: Floats, tracks: dict[str, Floats], wider: float) -> list[Floats]:
    """The bottom of a body [m] about the antenna, wider on all sides."""
    stand = ship_tracks.stand(table, time, tracks)
    x, y = table["width_m"] / 2.0 + wider, table["length_m"] / 2.0 + wider
    ring = np.array([(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)])
    return [ring @ stand.rotation.T + stand.position - own]


MAKERS = {
    "straight": straight, "rolling": straight, "loop": loop, "waypoint": waypoint, "manoeuvre": manoeuvre, "track": track,
    "own ship": own_ship, "wall": wall, "quay": quay, "passing": passing,
}  # fmt: skip
