"""Materials of surfaces, and their scattering at X band: sigma0 = gamma cos(incidence), gamma as a power ratio.

The constant-gamma law and its values for land are from Barton, Land clutter models for radar design and analysis (1985):
-20 dB for flat ground, -15 dB for farmland and desert, -12 dB for rolling hills, -10 dB for wooded hills, -5 dB for
mountains and towns. The spread about these means is about 5 dB. No table covers small built parts (rails, frames,
joints): their values assume that the power reflected by a smooth slab at normal incidence is scattered evenly.
"""

import math

from radar_service.world.body import Body, Material
from radar_service.world.error import SceneError

_GAMMA_DB: dict[str, tuple[float, str]] = {
    "steel": (0.0, "optics"),  # a ship's side: fittings and joints scatter nearly all power (perfect diffuser)
    "aluminium": (0.0, "optics"),  # as steel at X band: both are good conductors
    "wood": (-10.0, "diffuse"),  # |Gamma|^2 about -10 dB for permittivity 3, spread over all angles
    "fibreglass": (-10.0, "diffuse"),  # permittivity about 4 in thin sheet: half the power passes through, as for wood
    "concrete": (-6.0, "diffuse"),  # |Gamma|^2 -6 dB at normal incidence for permittivity 6 (ITU-R P.2040: 5.24)
    "brick": (-8.0, "diffuse"),  # |Gamma|^2 -9 dB for permittivity 3.9 (ITU-R P.2040), rougher than concrete
    "glass": (-8.0, "diffuse"),  # |Gamma|^2 -7 dB for permittivity 6.3 (ITU-R P.2040); frames make it scatter
    "building": (-5.0, "diffuse"),  # Barton: towns
    "rock": (-5.0, "diffuse"),  # Barton: mountains
    "land": (-12.0, "diffuse"),  # Barton: rolling hills
    "urban": (-10.0, "diffuse"),  # low houses and gardens: below Barton's towns
    "sand": (-20.0, "diffuse"),  # Barton: flat ground
    "vegetation": (-12.0, "diffuse"),  # Barton: between farmland and wooded hills
    "ice": (-15.0, "diffuse"),  # permittivity 3.2, rough at the wavelength: as farmland
    "rubber": (-15.0, "diffuse"),  # inflatable boats: thin, lossy, smooth
}

MATERIALS: dict[str, Material] = {
    name: Material(name, 10.0 ** (gamma_db / 10.0), scattering) for name, (gamma_db, scattering) in _GAMMA_DB.items()
}

BUILT = frozenset({"concrete", "brick", "glass", "building"})  # what bridges, quays and houses are made of
VESSEL_MATERIALS = frozenset({"steel", "aluminium", "wood", "fibreglass", "rubber"})  # what vessels and buoys are built of

# Power reflectivity of a smooth surface at normal incidence [dB], for bodies by physical optics:
# |Gamma|^2 = |(sqrt(eps) - 1) / (sqrt(eps) + 1)|^2 of its permittivity at 10 GHz (ITU-R P.2040 for building materials).
# Phase, polarization, angle and the reflection from the far side of a thin sheet are not modelled.
_REFLECTIVITY_DB: dict[str, float] = {
    "steel": 0.0,  # -0.01 dB: a conductor
    "aluminium": 0.0,
    "wood": -15.6,  # permittivity 2.0
    "fibreglass": -9.5,  # 4
    "concrete": -8.1,  # 5.24
    "brick": -9.7,  # 3.9
    "glass": -7.3,  # 6.3
    "building": -8.1,  # mostly concrete
    "rock": -7.3,  # 6, dry
    "land": -9.5,  # 4, dry soil; wet soil reflects about 4 dB more
    "urban": -8.1,  # concrete
    "sand": -11.4,  # 3, dry
    "vegetation": -20.0,  # leaves and air; no part is smooth at the wavelength
    "ice": -10.9,  # 3.2
    "rubber": -11.4,  # 3
}

# Land as the ground that reflects rays: rms height [m] of its surface about a plane, after the land types of Barton, Radar
# Equations for Modern Radar (2013): 10 m for towns, 1 m for flat land. Those of rock, sand, ice and concrete are estimates.
# Vegetation is not here: it absorbs what would reach the ground.
GROUND_ROUGHNESS = {
    "building": 10.0, "urban": 10.0, "brick": 10.0, "glass": 10.0, "rock": 3.0, "land": 1.0, "sand": 0.3, "ice": 0.1,
    "concrete": 0.02,
}  # fmt: skip


def is_metal(material: Material) -> bool:
    """Whether a surface reflects more than half of the power."""
    return power_reflectivity(material.name) > 0.5


def power_reflectivity(material: str) -> float:
    """Returns the power reflectivity (0 to 1) of a smooth surface of a known material at normal incidence."""
    return float(10.0 ** (_REFLECTIVITY_DB[material] / 10.0))


def permittivity(material: str) -> float:
    """Returns the relative permittivity that gives a known material, which is no metal, its power reflectivity."""
    amplitude = math.sqrt(power_reflectivity(material))
    return ((1.0 + amplitude) / (1.0 - amplitude)) ** 2


def material_from_name(name: str, location: str) -> Material:
    """Returns the material of this name. Raises SceneError at `location` with the names of all materials."""
    if name not in MATERIALS:
        raise SceneError(
            f'{location}: "{name:.60}" is not a known material; one of {", ".join(MATERIALS)}; choose the nearest'
        )
    return MATERIALS[name]


def is_diffuse_land(body: Body) -> bool:
    """Whether a body is land by its published sigma0, which holds what the ground before it reflects."""
    return is_land(body) and body.scattering == "diffuse" and body.rcs is None


def is_land(body: Body) -> bool:
    """Whether a body is land: a mesh at rest of a material that no vessel is built of."""
    return body.mesh is not None and body.motion.at_rest and body.material.name not in VESSEL_MATERIALS


def is_ground(body: Body) -> bool:
    """Whether a body is land that is not built: a height map, or of a material that is not in BUILT."""
    return is_land(body) and (body.one_sided or body.material.name not in BUILT)
