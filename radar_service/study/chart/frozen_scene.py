"""A scene frozen at t = 0, on which the chart compares methods."""

from dataclasses import replace

import numpy as np

from radar_service.echo import Echoes, max_echo_range, resting_echoes
from radar_service.numerics import effective_earth_radius
from radar_service.records import PRESETS, Fidelity
from radar_service.scattering import ScattererSet, ScatteringContext, build_scatterers
from radar_service.trace import OcclusionScene
from radar_service.world import Body, Motion, Scene


def frozen(scene: Scene) -> Scene:
    """Returns the scene with all poses of t = 0, without fluctuation, blind sectors and eclipsing."""
    bodies = tuple(replace(body, motion=_at_rest(body.motion), swerling=0) for body in scene.bodies)
    radar = replace(scene.radar, blind_sectors=(), eclipsing=False)
    platform = replace(scene.platform, motion=_at_rest(scene.platform.motion))
    return replace(scene.with_world(bodies=bodies), radar=radar, platform=platform)


def _at_rest(motion: Motion) -> Motion:
    pose = motion.pose(0.0)
    return Motion(np.zeros(1), pose.position, pose.heading)


def only_diffuse(scene: Scene) -> Scene:
    """Returns the scene with its diffuse surfaces only, without multipath, gas, rain and noise."""
    environment = replace(scene.environment, multipath=False, gas_db_per_km=0.0, rain_mm_h=0.0, noise=False)
    return scene.with_world(environment=environment, bodies=tuple(body for body in scene.bodies if is_diffuse(body)))


def is_diffuse(body: Body) -> bool:
    """Whether a body has a mesh that scatters diffusely and declares no cross-section."""
    return body.mesh is not None and body.rcs is None and body.scattering == "diffuse"


def occlusion_of(scene: Scene) -> OcclusionScene:
    """Returns the occlusion of the scene's bodies."""
    return OcclusionScene(scene.bodies, effective_earth_radius(scene.environment.earth_factor))


def all_echoes(scene: Scene, seed: int) -> Echoes:
    """Returns the echoes of a frozen scene in the preset `balanced`, up to `max_echo_range`."""
    return echoes_of(scene, all_scatterers(scene, PRESETS["balanced"], seed), occlusion_of(scene))


def all_scatterers(scene: Scene, fidelity: Fidelity, seed: int) -> ScattererSet:
    """Returns the scatterers of all bodies of a scene."""
    earth_radius = effective_earth_radius(scene.environment.earth_factor)
    antenna, environment = scene.antenna(0.0)[0], scene.environment
    context = ScatteringContext(
        scene.radar, fidelity, seed, antenna, environment, scene.bodies, earth_radius, scene_name=scene.name
    )
    return build_scatterers(scene.bodies, range(len(scene.bodies)), context)


def echoes_of(scene: Scene, scatterers: ScattererSet, occlusion: OcclusionScene) -> Echoes:
    """Returns the echoes of scatterers in a frozen scene, up to `max_echo_range`."""
    return resting_echoes(scene, scatterers, occlusion, max_echo_range(scene.radar)).echoes
