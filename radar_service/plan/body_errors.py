"""Errors of a body over a whole run, predicted at its closest approach, and what `check` says of it: when that is, and why.

A run lasts until all courses are final and ranges increase for good. A loop runs for one period; where the other ship moves as
well, to HORIZON. Each piece between knots has its own closest approach.
"""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from radar_service.echo import HELD_PHASE, MAX_PHASE, mast_speed, nearest_and_top
from radar_service.numerics import SPEED_OF_LIGHT, Floats
from radar_service.plan.settings_search import combine_db
from radar_service.propagation import specular_geometry
from radar_service.records import Fidelity
from radar_service.scattering import NEAREST, BodyRun, Conditions, scattering_model
from radar_service.world import Body, Motion, Scene, SteeredMotion

HORIZON = 3600.0  # s: length of a run of loops that do not repeat together
PER_ARC = 16  # pieces of an arc
MAX_PIECES = 4096  # of a run; a longer track is sampled at as many of its knots
ASPECTS = np.tan(np.linspace(-1.54, 1.54, 33))  # rad from the closest approach: it passes within 3 % of its distance
LEVER = 1e-3  # s over which rates are taken
NODES = 0.1  # of MAX_PHASE squared: the field between nodes so far apart, measured (tests/plan/test_body_errors.py)
HELD = 0.2  # of the field, at HELD_PHASE: that of one node, by its square; 95 % of 73 passing plates err less
ASPECT_FLOOR_DB = -65.0  # centres that are left out, at other moments others
EXCESS_SHARE = 0.1  # of the range cell: a longer way by the sea moves a part of a point's echo by so much


def body_run(body: Body, scene: Scene) -> BodyRun:
    """How a body passes the antenna. Rates are those of the nearest part of the body while it is in range."""
    time = sample_times(body, scene)
    offset, later = _offset(body, scene, time), _offset(body, scene, time + LEVER)
    distance = np.hypot(offset[:, 0], offset[:, 1])
    part = np.maximum(distance - body.radius, NEAREST)
    velocity = (later - offset) / LEVER
    unit = offset[:, :2] / np.maximum(distance, 1e-9)[:, None]
    sway = mast_speed(scene)
    radial = np.abs(np.einsum("ij,ij->i", velocity[:, :2], unit)) + sway
    aside = np.abs(velocity[:, 0] * unit[:, 1] - velocity[:, 1] * unit[:, 0]) + sway
    aside += radial * np.minimum(1.0, body.radius / np.maximum(distance, NEAREST))  # of its ends, where it is long
    turned = body.motion.pose(time + LEVER).heading - body.motion.pose(time).heading
    turn = np.abs(np.angle(np.exp(1j * turned))) / LEVER + aside / part
    if body.motion.sway is not None:
        roll, pitch, yaw, heave = body.motion.sway.likely_rates.tolist()
        turn, radial = turn + roll + pitch + yaw + heave / part, radial + heave
    closest = int(np.argmin(distance))
    received = part <= max(scene.radar.range_max, float(part.min()))
    lean = 0.0 if scene.own_ship.sway is None else scene.radar.height  # the mast sways about the water line
    run = BodyRun(
        nearest=max(0.0, float(distance[closest]) - body.radius - lean),
        approach=float(distance[closest]),
        time=float(time[closest]),
        turn=float(turn[received].max()),
        radial=float(radial[received].max()),
        sea_turn=float((2.0 * scene.radar.height * radial / part**2)[received].max()),
        start=float(distance[0]),
    )
    return _within_limits(run, body, scene) if is_steered(body, scene) else run


def is_steered(body: Body, scene: Scene) -> bool:
    """Whether commands may change how a body passes: it is steerable, or own ship is."""
    return isinstance(body.motion, SteeredMotion) or isinstance(scene.own_ship, SteeredMotion)


def _within_limits(run: BodyRun, body: Body, scene: Scene) -> BodyRun:
    """The bounds of all runs that commands may make of one: anywhere, on any course, at the limits of speed and turn."""
    speed = body.motion.top_speed + scene.own_ship.top_speed + mast_speed(scene)
    rate = body.motion.limits.max_turn_rate if isinstance(body.motion, SteeredMotion) else 0.0
    return run._replace(
        nearest=0.0,
        approach=0.0,
        turn=max(run.turn, rate + 2.0 * speed / NEAREST),  # of the nearest part, and of the ends of a long body
        radial=max(run.radial, speed),
        sea_turn=max(run.sea_turn, 2.0 * scene.radar.height * speed / NEAREST**2),
    )


def sample_times(body: Body, scene: Scene) -> Floats:
    """Times (K,) [s] of a run at which a body is observed, those about its closest approach among them."""
    motions = (body.motion, scene.own_ship)
    end, repeats = _end(*motions)
    knots = np.concatenate([[0.0, end], *(_knots(motion, end if repeats else None) for motion in motions)])
    knots = np.unique(knots[(knots >= 0.0) & (knots <= end)])
    knots = knots[:: max(1, len(knots) // MAX_PIECES)]
    place = _offset(body, scene, knots)[:, :2]
    length, step = np.diff(knots), np.diff(place, axis=0)
    if not repeats:
        away = (_offset(body, scene, knots[-1:] + 1.0) - _offset(body, scene, knots[-1:]))[:, :2]
        speed = float(np.linalg.norm(away))
        reach = (scene.radar.range_max + body.radius + float(np.linalg.norm(place[-1]))) / speed if speed > 0.0 else 0.0
        length, step = np.append(length, reach), np.concatenate([step, away * reach])
        place = np.concatenate([place, place[-1:]])
    return np.concatenate([[0.0], _about_approach(knots[: len(length)], length, place[: len(length)], step).ravel()])


def _about_approach(start: Floats, length: Floats, place: Floats, step: Floats) -> Floats:
    """Times (P, S) within pieces that begin at `start` (P,), evenly in aspect about the closest approach of each.

    length: (P,) [s]; place, step: (P, 2) where each begins, and its way [m].
    """
    velocity = step / np.maximum(length, 1e-9)[:, None]
    speed = np.maximum(np.linalg.norm(velocity, axis=1), 1e-9)
    approach = -np.einsum("ij,ij->i", place, velocity) / speed**2
    abeam = np.linalg.norm(place + velocity * approach[:, None], axis=1)
    elapsed = approach[:, None] + (np.maximum(abeam, NEAREST) / speed)[:, None] * ASPECTS
    return np.asarray(start[:, None] + np.clip(elapsed, 0.0, length[:, None]))


def _end(ship: Motion, body: Motion) -> tuple[float, bool]:
    """The last time [s] at which a course changes, and whether loops end the run there."""
    periods = {motion.period for motion in (ship, body) if motion.period is not None}
    periods |= {2.0 * np.pi / abs(motion.final_turn) for motion in (ship, body) if motion.final_turn}
    last = max(0.0, float(ship.time[-1]), float(body.time[-1]))
    if not periods:
        return last, False
    together = len(periods) == 1 and all(motion.at_rest or motion.period is not None for motion in (ship, body))
    return (max(periods), True) if together else (max(HORIZON, last), True)


def _knots(motion: Motion, end: float | None) -> Floats:
    """Knots of a motion up to `end` [s], those within its arcs among them; end: None for a motion that does not repeat."""
    knots = motion.time
    if motion.arcs is not None or motion.turning:
        knots = np.concatenate([np.linspace(a, b, PER_ARC, endpoint=False) for a, b in pairwise(knots)] + [knots[-1:]])
    if motion.final_turn and end is not None:
        knots = np.append(knots, np.arange(knots[-1], end, 2.0 * np.pi / abs(motion.final_turn) / PER_ARC))
    if motion.period is None or end is None:
        return knots
    return np.asarray((knots + motion.period * np.arange(int(end / motion.period) + 1)[:, None]).ravel())


def _offset(body: Body, scene: Scene, time: Floats) -> Floats:
    """Middle of a body relative to the antenna's foot (K, 3) [m], mast upright."""
    return np.asarray(body.middles_at(time) - scene.own_ship.pose(time).position)


class BodyError(NamedTuple):
    """Errors of a body over a run, None where they do not apply.

    power_db: of its mean power [dB].
    field_db: of its field, relative [dB].
    remarks: sentences about them.
    """

    power_db: float | None
    field_db: float | None
    remarks: tuple[str, ...]


def body_error(body: Body, scene: Scene, fidelity: Fidelity, scatterers: int | None) -> BodyError:
    """What is predicted for a body over its run; scatterers: how many it has, None before they are drawn."""
    model, conditions = scattering_model(body, fidelity.sampler), Conditions.of_scene(scene, fidelity, scatterers)
    power = model.error_db(body, conditions)
    remarks = _split_paths(body, scene) if model.tells_sea_delay and scene.environment.multipath else []
    if body.mesh is None or power is None:
        return BodyError(power, None, tuple(remarks))
    run = body_run(body, scene)
    over_run, aspects = model.run_error(body, conditions, run), aspect_db(body, scene, run)
    field = aspects if math.isfinite(aspects) else None
    return BodyError(math.hypot(power, over_run.power_db), field, (*over_run.remarks, *remarks))


def aspects_db(scene: Scene) -> float:
    """Predicted relative field error [dB] of interpolating echoes between aspects: the worst of all bodies at any time of the
    run; -inf where no aspect changes, or no echo depends on it."""
    bodies = [body for body in scene.bodies if scattering_model(body).by_aspect]
    return max((aspect_db(body, scene, body_run(body, scene)) for body in bodies), default=-math.inf)


def aspect_db(body: Body, scene: Scene, run: BodyRun) -> float:
    """The error of `aspects_db` of one body: of second order in the phase that its echoes turn while the main beam passes."""
    radar = scene.radar
    rate = run.turn + (run.sea_turn if scene.environment.multipath else 0.0)
    size = min(scattering_model(body).coherence_at(body, radar, max(run.nearest, NEAREST)), body.diagonal)
    turned = 2.0 * np.pi / radar.wavelength * size * rate * radar.rotation_period * radar.beamwidth / (2.0 * np.pi)
    if turned == 0.0:
        return -math.inf
    error = min(HELD * (turned / HELD_PHASE) ** 2, NODES * MAX_PHASE**2)
    return combine_db(20.0 * math.log10(error), ASPECT_FLOOR_DB)


def _split_paths(body: Body, scene: Scene) -> list[str]:
    """Where the way by the sea is so much longer that it should be an echo of its own; not of land."""
    nearest, top = nearest_and_top(body, scene)
    if not 0.0 < top < math.inf or _excess_cells(nearest, top, scene) <= EXCESS_SHARE:
        return []
    nearest = body_run(body, scene).nearest
    cells = _excess_cells(nearest, top, scene)
    if cells <= EXCESS_SHARE or body.radius > nearest:
        return []
    return [f"at its closest the way by the sea is {cells:.2g} range cells longer; the echo keeps the direct range"]


def _excess_cells(distance: float, top: float, scene: Scene) -> float:
    """How many range cells longer the way by the sea is, to a height `top` [m] at `distance` [m]."""
    radar = scene.radar
    cell = SPEED_OF_LIGHT * radar.pulse / 2.0 if radar.modulation == "none" else radar.range_resolution
    return float(specular_geometry(max(distance, NEAREST), top, radar.height).excess) / cell


def body_remarks(scene: Scene, fidelity: Fidelity) -> dict[str, list[str]]:
    """Sentences about each body, by its name."""
    remarks = {}
    for body in scene.bodies:
        run, model = body_run(body, scene), scattering_model(body, fidelity.sampler)
        mesh = model.mesh_remarks(body, Conditions.of_scene(scene, fidelity), run.nearest)
        errors = mesh or body_error(body, scene, fidelity, None).remarks  # what is said of the mesh takes their place
        remarks[body.name] = [*_passage(body, scene, run), *errors]
    return remarks


def _passage(body: Body, scene: Scene, run: BodyRun) -> list[str]:
    """When a body is nearest, and how fast its aspect changes; nothing where it stays."""
    if scene.own_ship.at_rest and body.motion.at_rest:
        return []
    turn = f"its aspect turns by up to {math.degrees(run.turn):.2g} degrees/s, its range by {run.radial:.2g} m/s"
    if is_steered(body, scene):
        bounds = "errors are bounds for the antenna beside it, at the limits of speed and turn"
        return [f"commands may bring it anywhere: {bounds}: {turn}"]
    when = "now" if run.time == 0.0 else f"after {run.time:.0f} s"
    end, repeats = _end(body.motion, scene.own_ship)
    at_horizon = repeats and end not in (body.motion.period, scene.own_ship.period)  # loops that do not repeat together
    loops = f"; its loops are followed for {HORIZON:.0f} s" if at_horizon else ""
    return [f"nearest {when}: {run.nearest:.0f} m; {turn}{loops}"]
