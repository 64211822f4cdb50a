"""Dented plating: rising depth of dents, by which a wall loses its coherent echo."""

import numpy as np
from scipy.special import j0

from radar_service.engine.pipeline import profiles, tile_azimuths
from radar_service.engine.preparation import prepare
from radar_service.numerics import Profiles
from radar_service.records import PRESETS
from radar_service.scattering import SPREAD
from radar_service.study.stability.finding import WAVELENGTH, Axis, Expected, Finding, crossing, curve, plain, scene_of

LIMIT_DB = 1.0
SEEDS = 4  # walls over which fields are averaged: the coherent part remains
DISTANCE = 4000.0  # m
WALL = {
    "shape": "plate", "width_m": 28.0, "height_m": 8.0, "position_m": [0.0, DISTANCE, 15.0], "heading_deg": 180.0,
    "scattering": "optics", "material": "steel",
}  # fmt: skip
RADAR = {"range_max_m": 4500, "height_m": 15.0}


def dented_walls(fine: int = 1) -> Finding:
    """Drives the depth of dents: the mean field of walls along their normal, against the mean of J0 over depths."""
    depths = np.linspace(0.001, 0.009, 4 * fine + 1)
    flat, exact = _field(0.0, 0), np.array([_coherent(depth) for depth in depths])
    means = np.array([np.mean([_field(float(depth), seed) for seed in range(SEEDS)], axis=0) for depth in depths])
    share = np.abs(means @ flat.conj()) / np.sum(np.abs(flat) ** 2)
    losses = -20.0 * np.log10(exact)
    return Finding(
        name="dented plating",
        method="flat walls",
        setup=f"{SEEDS} steel walls of 28 x 8 m, 4 km away, along their normal, with frames 0.7 m apart",
        parameter=Axis("mean depth of dents [mm]"),
        values=plain(1e3 * depths),
        measured=Axis("error of the coherent power [dB]"),
        curves=(curve("walls with plating", np.abs(20.0 * np.log10(share / exact))), curve("flat walls", losses)),
        limit=LIMIT_DB,
        limit_reason="a decibel of every flash",
        boundary=crossing(1e3 * depths, losses, LIMIT_DB),
        expected=Expected(3.1, 0.06, "J0(k w)^2 of all depths alike is -1 dB at 3.4 mm; of those drawn at 3.1 mm"),
        response="another method",
        instead="dents as phases of strips, with `plating`",
        details="Dents between frames take power from the direction of a wall's normal and put it into lobes 1.3 degrees apart. "
        "Shapes and meshes are flat unless they have `plating`; hull types other than `plain` have dents of 4 mm. "
        "Of bounces the coherent part alone is kept.",
    )


def _coherent(depth: float) -> float:
    """The share of the field that panels of uniformly drawn depths keep along their normal."""
    drawn = depth * (1.0 + SPREAD * np.sqrt(3.0) * np.linspace(-1.0, 1.0, 2001))
    phase = 2.0 * np.pi / WAVELENGTH * drawn
    return float(np.abs(np.mean(j0(phase) * np.exp(1j * phase))))


def _field(depth: float, seed: int) -> Profiles:
    """The field of a wall in the cells about its range, on the spoke that points at it."""
    scene = scene_of({**WALL, "plating": {"dent_m": depth, "seed": seed}}, radar=RADAR, environment={"earth": "flat"})
    prepared = prepare(scene, PRESETS["balanced"], 0)
    field: Profiles = profiles(prepared, tile_azimuths(prepared, 0, 0))[0]
    middle = round(DISTANCE / scene.radar.range_step)
    return field[middle - 30 : middle + 30]


STUDIES = (dented_walls,)
