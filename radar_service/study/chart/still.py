"""A scene with its clock stopped: what the chart compares methods on."""

from dataclasses import replace

import numpy as np

from radar_service.echo.resting import resting_echoes
from radar_service.echo.second_time_around import heard_reach
from radar_service.fidelity import PRESETS
from radar_service.frames import effective_earth_radius
from radar_service.propagation.radar_equation import Echoes
from radar_service.scattering.scatterer_set import build_scatterers
from radar_service.scene.body import Body
from radar_service.scene.motion import Motion
from radar_service.scene.platform import Platform
from radar_service.scene.world import Scene
from radar_service.trace.line_of_sight import OcclusionScene


def stopped(scene: Scene) -> Scene:
    """The scene as it stands at t = 0, for ever; nothing fluctuates, no sector is blind, and a second antenna receives."""
    bodies = tuple(replace(body, motion=_standing(body.motion), swerling=0) for body in scene.bodies)
    radar = replace(scene.radar, blind_sectors=(), eclipsing=False)
    platform = Platform(_standing(scene.own_ship))
    return replace(scene.with_world(bodies=bodies), platform=platform, radar=radar)


def _standing(motion: Motion) -> Motion:
    pose = motion.pose(0.0)
    return Motion(np.zeros(1), pose.position, pose.heading)


def diffuse_alone(scene: Scene) -> Scene:
    """The scene's diffuse surfaces in empty air: no other bodies, no multipath, no gas, no rain."""
    environment = replace(scene.environment, multipath=False, gas_db_per_km=0.0, rain_mm_h=0.0, noise=False)
    return scene.with_world(environment=environment, bodies=tuple(body for body in scene.bodies if is_diffuse(body)))


def is_diffuse(body: Body) -> bool:
    """Whether samplers have a surface to sample: a mesh that scatters diffusely and declares no cross-section."""
    return body.mesh is not None and body.rcs is None and body.scattering == "diffuse"


def landscape_of(scene: Scene) -> OcclusionScene:
    """What hides what."""
    return OcclusionScene(scene.bodies, effective_earth_radius(scene.environment.earth_factor))


def all_echoes(scene: Scene, seed: int) -> Echoes:
    """The echoes of a stopped scene as the preset `balanced` has them, those before and behind included whose sidelobes
    are heard."""
    fidelity, radar = PRESETS["balanced"], scene.radar
    ensemble = build_scatterers(
        scene.bodies, radar, scene.antenna(0.0)[0], fidelity.scatterers_per_cell, seed, range(len(scene.bodies))
    )
    return resting_echoes(scene, ensemble, landscape_of(scene), heard_reach(scene.radar)).echoes
