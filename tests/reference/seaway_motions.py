"""Slow reference: how a seaway moves a body of a scene file, wave by wave, from the words of docs/scenes.md.

The waves themselves are those that the engine has drawn; responses and their sum share no code with it.
"""

import cmath
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from tests.reference import ship_tracks
from tests.reference.metal_on_water import Floats
from tests.reference.ship_tracks import Stand, Table

GRAVITY = 9.80665
TIME_CONSTANT = 10.0  # s in which a ship comes to respond to a new speed


def roll_period(table: Table, draught: float) -> float:
    """By the weather criterion of the IMO, with a metacentric height of a tenth of the breadth [s]."""
    length, breadth = table["length_m"], table["width_m"]
    factor = 0.373 + 0.023 * breadth / draught - 0.043 * length / 100.0
    return float(2.0 * factor * breadth / math.sqrt(0.1 * breadth))


def slope_factor(x: float) -> float:
    """Mean slope of a wave over a line, over its largest: by quadrature of its moment about the middle."""
    at = (np.arange(2000) + 0.5) / 1000.0 - 1.0
    return float(np.mean(at * np.sin(x * at)) * 3.0 / x) if x else 1.0


def height_factor(x: float) -> float:
    """Mean of a wave over a line, over its height in the middle."""
    return math.sin(x) / x if x else 1.0


def sway(table: Table, stand: Stand, heading: float, felt: Floats, time: float, waves: Any) -> tuple[float, float, float]:
    """Roll, pitch [rad] and heave [m] of a box; felt: velocity (2,) to which it responds [m/s]."""
    length, breadth = table["length_m"], table["width_m"]
    depth = -table["position_m"][2] if "position_m" in table else -stand.position[2]
    damping, block, waterplane, period = 0.1, 0.7, 0.8, roll_period(table, depth)
    fastest = 0.4 * math.sqrt(GRAVITY * length)
    felt = felt * min(1.0, fastest / max(float(np.hypot(*felt)), 1e-12))
    roll = pitch = heave = 0j
    for a, w, (k_east, k_north), phase in zip(waves.amplitude, waves.frequency, waves.wavenumber, waves.phase, strict=True):
        k = w * w / GRAVITY
        ahead = k_east * math.sin(heading) + k_north * math.cos(heading)
        side = k_east * math.cos(heading) - k_north * math.sin(heading)
        met = w - k_east * felt[0] - k_north * felt[1]
        sea = a * cmath.exp(1j * (k_east * stand.position[0] + k_north * stand.position[1] - w * time + phase))
        kappa, alpha, wide = math.exp(-k * depth), met / w, block * breadth
        made = 2.0 * math.sin(k * alpha**2 * wide / 2.0) * math.exp(-k * depth * alpha**2)
        loss = made**2 / (k * wide * alpha**2)
        force = kappa * math.sqrt((1.0 - k * depth) ** 2 + (loss / alpha) ** 2)
        resonance = 1.0 - 2.0 * k * depth * alpha**2 - 1j * math.copysign(loss, met)
        heave += sea * force * height_factor(ahead * length / 2.0) / resonance
        pitch += sea * force * 1j * ahead * slope_factor(ahead * length / 2.0) / resonance
        ratio = met * period / (2.0 * math.pi)
        slope = -1j * side * kappa * height_factor(ahead * length / 2.0) * slope_factor(side * waterplane * breadth / 2.0)
        roll += sea * slope / (1.0 - ratio**2 - 2j * damping * ratio)
    return roll.real, pitch.real, heave.real


def stand_in_seaway(table: Table, time: float, tracks: Mapping[str, Floats], waves: Any) -> Stand:
    """Where a body is at a time [s] as `ship_tracks.stand` has it, and as the seaway moves it if it has a table `hull`."""
    upright = ship_tracks.stand(table, time, tracks)
    if "hull" not in table:
        return upright
    heading = math.atan2(upright.rotation[0, 1], upright.rotation[1, 1])
    felt = felt_velocity(table, time, tracks)
    roll, pitch, heave = sway(table, upright, heading, felt, time, waves)
    rotation = ship_tracks.turned_to(heading) @ ship_tracks.bow_up(pitch) @ ship_tracks.starboard_down(roll)
    return Stand(upright.position + [0.0, 0.0, heave], rotation)


def felt_velocity(table: Table, time: float, tracks: Mapping[str, Floats]) -> Floats:
    """A ship's velocity (2,) [m/s], and what is left of each jump of it before: by differences of its positions."""
    tiny = 1e-4

    def velocity(at: float) -> Floats:
        ends = [ship_tracks.stand(table, at + h, tracks).position[:2] for h in (-tiny, tiny)]
        return np.asarray((ends[1] - ends[0]) / (2.0 * tiny))

    felt = velocity(time)
    for corner in corners(table):
        if corner < time - tiny:
            lost = velocity(corner - 2 * tiny) - velocity(corner + 2 * tiny)
            felt = felt + lost * math.exp(-(time - corner) / TIME_CONSTANT)
    return felt


def corners(table: Table) -> list[float]:
    """Times [s] at which its velocity may jump, of a table without track and loop."""
    times = [change["time_s"] for change in table.get("manoeuvre", [])]
    if "waypoints" in table:
        times += np.cumsum([part.duration for part in ship_tracks.route(table)]).tolist()
    return [time for time in times if np.isfinite(time)]
