"""Errors of plots on purpose, for points: a tracker that is judged by perfect plots needs no filter.

What a point lacks is the extent of the ship for which it stands: meshes and hulls have such errors from the engine, and errors of
noise are the engine's too.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from radar_service.bench.scenario import OTHERS_M, PlotErrors, Scenario
from radar_service.bench.scores.scan_result import TargetTruth, as_reported
from radar_service.numerics import PLOT_ERRORS, Floats, generator, wrap_bearing
from radar_service.plots import Plot

NEAR = 50.0  # m: a plot within half the length of an extended target and this is hers
ROLL_SHARE = (3.0 / 256.0) ** 0.5  # root mean square of `roll_error` over its phase and all bearings, of the roll's square
GLINT_SHARE = 1.0 / 6.0  # of the length of a ship: A.823(19), appendix 3
POINTS = "point", "reflector"
SMALL_M, SMALL_M2 = 10.0, 2.5  # length and cross section of a small vessel: MSC.192(79), table 2
LENGTH_POWER = 2.0 / 9.0  # cross sections grow with displacement^1.5 (Skolnik, IEEE T-AES 10(2), 292), that with length^3


def length_of(cross_section: float) -> float:
    """Returns the length [m] of a vessel of a cross section [m^2]."""
    return float(SMALL_M * (cross_section / SMALL_M2) ** LENGTH_POWER)


def lengths_of(scenario: Scenario) -> dict[str, float]:
    """Returns the length [m] of the ship for which each tracked point stands: as stated, of its `hull`, or by cross section."""
    if scenario.plot_errors is None:
        return {}
    tracked = [body for body in scenario.scene.get("body", ()) if body["name"] in scenario.tracked]
    bodies = {body["name"]: body for body in tracked if body.get("shape") in POINTS}
    if (stated := scenario.plot_errors.glint_length_m) is not None:
        return dict.fromkeys(bodies, stated)
    by_section = {name: length_of(10.0 ** (body["rcs_dbsm"] / 10.0)) for name, body in bodies.items() if "rcs_dbsm" in body}
    declared = {name: body.get("hull", {}).get("length_m") for name, body in bodies.items()}
    return by_section | {name: length for name, length in declared.items() if length is not None}


def with_errors(
    plots: Sequence[Plot], truths: Sequence[TargetTruth], errors: PlotErrors | None, heading: float, seed: int, scan: int,
    lengths: Mapping[str, float],
) -> tuple[Plot, ...]:  # fmt: skip
    """Returns the plots of a scan with errors, but for those of extended targets.

    errors: None for none; heading: of own ship [rad]; lengths: of ships [m]. Each scan of a seed draws anew, in plot order.
    """
    if errors is None:
        return tuple(plots)
    draws = generator(seed, PLOT_ERRORS, scan).standard_normal((len(plots), 3))
    phase = float(generator(seed, PLOT_ERRORS).uniform(0.0, 2.0 * np.pi))
    reported = [as_reported(truth) for truth in truths]
    shares = generator(seed, PLOT_ERRORS, scan, 1)
    seen = shares.random(len(plots)) >= errors.missed
    erring = [
        plot if _is_extended(plot, reported) else _with_errors(plot, reported, errors, heading, phase, draw, lengths)
        for plot, draw, is_seen in zip(plots, draws, seen, strict=True)
        if is_seen
    ]
    return (*erring, *_others(plots, errors, shares)) if errors.others else tuple(erring)


def _others(plots: Sequence[Plot], errors: PlotErrors, draws: np.random.Generator) -> list[Plot]:
    """Further plots of a scan: copies of its first one at other places about own ship."""
    others = []
    for _ in range(int(draws.poisson(errors.others)) if plots else 0):
        like, distance, turn = plots[0], float(draws.uniform(10.0, OTHERS_M)), float(draws.uniform(0.0, 2.0 * np.pi))
        east, north = like.east - like.range * np.sin(like.bearing), like.north - like.range * np.cos(like.bearing)
        east, north = float(east + distance * np.sin(turn)), float(north + distance * np.cos(turn))
        others.append(replace(like, range=distance, bearing=turn, east=east, north=north))
    return others


def roll_error(relative: float, roll: float, period: float, phase: float, time: float) -> float:
    """Returns the error of the bearing [rad] at a relative bearing [rad], of an antenna that rolls by `roll` [rad].

    Source: Bole, Wall and Norris, Radar and ARPA Manual, 9.4.2.2: the square of the heel, halved, times sine and cosine.
    """
    heel = roll * np.sin(2.0 * np.pi * time / period + phase)
    return float(-0.5 * heel**2 * np.sin(relative) * np.cos(relative))


def _is_extended(plot: Plot, truths: Sequence[TargetTruth]) -> bool:
    """Whether a plot is that of an extended target."""
    return any(truth.length and _distance(plot, truth) < truth.length / 2.0 + NEAR for truth in truths)


def _distance(plot: Plot, truth: TargetTruth) -> float:
    return float(np.hypot(plot.east - truth.position[0], plot.north - truth.position[1]))


def _with_errors(
    plot: Plot, truths: Sequence[TargetTruth], errors: PlotErrors, heading: float, phase: float, draw: Floats,
    lengths: Mapping[str, float],
) -> Plot:  # fmt: skip
    """A plot that wanders along its ship, then errs in range and bearing. draw: normal numbers (3,)."""
    own = np.array([plot.east - plot.range * np.sin(plot.bearing), plot.north - plot.range * np.cos(plot.bearing)])
    nearest = min(truths, key=lambda truth: _distance(plot, truth), default=None)
    course = nearest.heading if nearest else 0.0
    glint = draw[2] * GLINT_SHARE * (lengths.get(nearest.body, 0.0) if nearest else 0.0)
    east, north = np.array([plot.east, plot.north]) - own + glint * np.array([np.sin(course), np.cos(course)])
    roll = roll_error(plot.bearing - heading, np.radians(errors.roll_deg), errors.roll_period_s, phase, plot.time)
    distance = max(float(np.hypot(east, north)) + float(draw[0]) * errors.range_sd_m, 0.0)
    if errors.range_step_m:
        distance = round(distance / errors.range_step_m) * errors.range_step_m
    turn = float(draw[1]) * np.radians(errors.bearing_sd_deg) + roll
    bearing = float(wrap_bearing(np.asarray(np.arctan2(east, north) + turn)))
    return replace(
        plot, range=distance, bearing=bearing, east=float(own[0] + distance * np.sin(bearing)),
        north=float(own[1] + distance * np.cos(bearing)),
    )  # fmt: skip
