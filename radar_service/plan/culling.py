"""Which bodies a scene can do without, and which effects: each with the reason, and by how much it moves the answer."""

import math
from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from radar_service.echo.second_time_around import echo_reach
from radar_service.fidelity import Fidelity
from radar_service.frames import effective_earth_radius
from radar_service.plan.budget import ErrorBudget
from radar_service.plan.closest_approach import nearest_and_top
from radar_service.propagation.multipath import gas_amplitude, two_ray_factor
from radar_service.propagation.radar_equation import elevation_gain, received_amplitude
from radar_service.propagation.sea_surface import rms_wave_height
from radar_service.receive.compression import receiver_noise_power
from radar_service.scattering.diffuse import triangle_frames
from radar_service.scattering.scatterer_set import uses_optics
from radar_service.scene.world import Body, Scene

Floats = NDArray[np.float64]
SPIKE = 10.0  # of the mean power: an exponential draw exceeds it once in 22 000
MIRRORED = 16.0  # |F|^4 at most: direct and reflected ray in phase, there and back
PLACES = 1024  # distances at which the mirror is looked at
LOBE = 4.0  # c / 2B: no window of ours has a wider main lobe


@dataclass(frozen=True)
class CulledBody:
    """A body left out. reason: why; error_db: by how much that moves the power of any cell [dB]; hides: whether it may still
    stand before others."""

    reason: str
    error_db: float
    hides: bool


def culled_bodies(scene: Scene, fidelity: Fidelity) -> dict[int, CulledBody]:
    """The bodies, by index in the scene, that this fidelity leaves out; none where it allows no error."""
    if fidelity.error_db == 0.0 or fidelity.chain == "documented":
        return {}
    gone = {key: never for key, body in enumerate(scene.bodies) if (never := _never_seen(body, scene)) is not None}
    return gone | _below_noise(scene, fidelity, [key for key in range(len(scene.bodies)) if key not in gone])


def _never_seen(body: Body, scene: Scene) -> CulledBody | None:
    """Beyond the reach or the horizon wherever both ever are. What is, hides nothing that is seen: it lies farther than all
    of that, or below the line of sight that touches the sea."""
    nearest, top = nearest_and_top(body, scene)
    if nearest > echo_reach(scene.radar):
        return CulledBody(f"out of range for good: never nearer than {nearest / 1000:.1f} km", 0.0, hides=False)
    if top < 0.0:
        return CulledBody(f"under the sea for good: its top is {-top:.1f} m below", 0.0, hides=False)
    if nearest <= (horizon := scene.horizon(top)):
        return None
    text = f"beyond the radar horizon for good: {horizon / 1000:.1f} km for its top at {top:.0f} m, never nearer than "
    return CulledBody(f"{text}{nearest / 1000:.1f} km", 0.0, hides=False)


def _below_noise(scene: Scene, fidelity: Fidelity, keys: list[int]) -> dict[int, CulledBody]:
    """Those of bodies `keys` whose greatest powers together stay below the noise by the budget, the faintest first."""
    if not scene.environment.noise:
        return {}
    radar, budget = scene.radar, ErrorBudget(fidelity.error_db)
    noise = receiver_noise_power(radar)
    lobe = LOBE * radar.sample_rate / radar.bandwidth  # samples that an echo fills
    spoke = 10.0 ** (budget.field_db / 10.0) * radar.bins / lobe
    allowed = noise * min(budget.share, spoke)
    powers = {key: greatest_power(scene.bodies[key], scene, fidelity.bounces) for key in keys}
    gone, total = {}, 0.0
    for key in sorted(keys, key=lambda k: (powers[k], k)):
        total += powers[key]
        if total > allowed:
            break
        below, moved = 10.0 * math.log10(powers[key] / noise), 10.0 * math.log10(1.0 + total / noise)
        gone[key] = CulledBody(f"below the noise for good: at most {below:.0f} dB of it", moved, hides=True)
    return gone


def greatest_power(body: Body, scene: Scene, bounces: int) -> float:
    """A power [W] that the echoes of a body hardly ever exceed in any cell, wherever it goes."""
    nearest, _ = nearest_and_top(body, scene)
    level = float(received_amplitude(scene.radar, np.array([nearest]))[0] ** 2)
    return (
        level * greatest_section(body, scene.radar.wavelength, bounces) * (MIRRORED if scene.environment.multipath else 1.0)
    )


def greatest_section(body: Body, wavelength: float, bounces: int) -> float:
    """A cross-section [m^2] that a body hardly ever exceeds: SPIKE times the mean where phases are random, and by optics that
    of a plate of all its area, which every bounce may light once more (4 pi A^2 / lambda^2)."""
    area = 0.0 if body.mesh is None else float(triangle_frames(body.mesh)[2].sum())
    if uses_optics(body):
        return 4.0 * math.pi * (bounces * area / wavelength) ** 2
    spike = 1.0 if body.mesh is None and body.swerling == 0 else SPIKE
    return spike * (body.rcs if body.rcs is not None else body.material.gamma * area)


def negligible_effects(scene: Scene, fidelity: Fidelity) -> dict[str, float]:
    """The sea's mirror ("multipath") and the air's loss ("gas") where they are asked for and move no field by as much as
    methods may err; and by how much they do [dB]."""
    if fidelity.error_db == 0.0 or fidelity.chain == "documented":
        return {}
    environment, found = scene.environment, {}
    if environment.multipath:
        found["multipath"] = mirror_db(scene)
    if environment.gas_db_per_km > 0.0:
        found["gas"] = gas_db(scene)
    allowed = ErrorBudget(fidelity.error_db).method_db
    return {name: error for name, error in found.items() if error < allowed}


def without(idle: Collection[str], scene: Scene) -> Scene:
    """The scene without these effects."""
    environment = scene.environment
    if "multipath" in idle:
        environment = replace(environment, multipath=False)
    if "gas" in idle:
        environment = replace(environment, gas_db_per_km=0.0)
    return replace(scene, environment=environment)


def gas_db(scene: Scene) -> float:
    """Relative field error [dB] of leaving out the gas, at the farthest range that is heard."""
    reach = min(echo_reach(scene.radar), 1e6)
    return _relative_db(float(1.0 - gas_amplitude(reach, scene.environment.gas_db_per_km)))


def mirror_db(scene: Scene) -> float:
    """Relative field error [dB] at most of leaving out the sea's mirror, over all distances that bodies can have; 0 where
    one has a surface, which may reach down to the sea where the mirror is perfect, or moves up and down."""
    return max((_mirrored_db(body, scene) for body in scene.bodies), default=-math.inf)


def _mirrored_db(body: Body, scene: Scene) -> float:
    height = body.motion.position[:, 2]
    level = bool(np.ptp(height) == 0.0 and body.motion.final_velocity[2] == 0.0)
    if body.mesh is not None or not level or height[0] <= 0.0 or scene.own_ship.sway is not None:
        return 0.0
    nearest, top = nearest_and_top(body, scene)
    farthest = max(nearest, min(echo_reach(scene.radar), scene.horizon(top), 1e6))
    if body.motion.at_rest and scene.own_ship.at_rest:
        farthest = nearest
    factor = two_ray_factor(
        np.geomspace(max(nearest, 1.0), max(farthest, 1.0), PLACES),
        top,
        scene.radar.height,
        scene.radar.wavelength,
        earth_radius=effective_earth_radius(scene.environment.earth_factor),
        polarization=scene.radar.polarization,
        wave_height=rms_wave_height(scene.environment.sea_state),
        elevation_gain=partial(elevation_gain, scene.radar),
    )
    mirror = np.abs(factor - 1.0)
    return _relative_db(float(np.max(mirror * (2.0 + mirror))))  # |F^2 - 1| whatever the phases


def _relative_db(ratio: float) -> float:
    return 20.0 * math.log10(ratio) if ratio > 0.0 else -math.inf
