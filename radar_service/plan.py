"""What is modelled of a scene, what is left out, and why: said, not guessed."""

import math
from dataclasses import asdict, dataclass
from typing import Any

from radar_service.fidelity import Fidelity
from radar_service.scene.doubts import pulse_doppler_shift, top_speed
from radar_service.scene.world import Body, Radar, Scene
from radar_service.trace.rays import REACH

TWO_RAY = "two-ray, complex F^2; nothing diffracts: too strong close before the horizon, nothing beyond"
SAMPLER_WORDS = {"rays": "uniform random", "stratified": "stratified", "sobol": "Sobol'"}


@dataclass(frozen=True)
class Choice:
    """One thing that could be modelled."""

    what: str
    modelled: bool
    how: str  # how, or why not


@dataclass(frozen=True)
class Plan:
    """All choices for one scene at one fidelity."""

    fidelity: str
    choices: tuple[Choice, ...]

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)

    def __str__(self) -> str:
        width = max(len(choice.what) for choice in self.choices)
        lines = [f"{'+' if c.modelled else '-'} {c.what:<{width}}  {c.how}" for c in self.choices]
        return "\n".join([f"fidelity {self.fidelity}", *lines])


def plan_for(scene: Scene, fidelity: Fidelity) -> Plan:
    """The plan of a scene at a fidelity."""
    effects = _documented_effects(scene) if fidelity.chain == "documented" else _corrected_effects(scene, fidelity)
    bodies = [_body(body, scene, fidelity) for body in scene.bodies]
    return Plan(fidelity.name, (*effects, *bodies))


def _documented_effects(scene: Scene) -> list[Choice]:
    environment, radar = scene.environment, scene.radar
    return [
        Choice(
            "signal chain",
            True,
            f"the specification as printed, {radar.rays} rays per azimuth ({radar.azimuths} azimuths); {_missed(scene)}",
        ),
        Choice("beam", True, "printed pattern within 1.5 beamwidths, then the Gaussian spread of eq. 19"),
        Choice("earth", False, "flat: the specification bends nothing"),
        Choice("multipath", environment.multipath, "|F|^2 of eq. 12" if environment.multipath else "not asked for"),
        Choice("noise", False, "not in the specification"),
        *_clutter(scene),
    ]


def _corrected_effects(scene: Scene, fidelity: Fidelity) -> list[Choice]:
    environment = scene.environment
    curved = environment.earth_factor != float("inf")
    rest = "the full circle" if scene.own_ship.at_rest else f"{fidelity.beam_extent:g} beamwidths each side"
    return [
        Choice("range", True, f"exact delays, Kaiser-Bessel grid of {fidelity.kernel_width} bins, closed-form spectrum"),
        Choice("beam", True, f"{scene.radar.pattern if isinstance(scene.radar.pattern, str) else 'table'}, {rest}"),
        Choice(
            "earth",
            curved,
            f"effective radius {environment.earth_factor:.4g} x the earth's" if curved else "asked to be flat",
        ),
        Choice("multipath", environment.multipath, TWO_RAY if environment.multipath else "not asked for"),
        Choice(
            "gas and rain loss",
            environment.gas_db_per_km > 0 or environment.rain_mm_h > 0,
            f"{environment.gas_db_per_km:.4g} dB/km one way, rain {environment.rain_mm_h:g} mm/h (ITU-R P.838)",
        ),
        Choice("noise", environment.noise, "thermal, k T0 F" if environment.noise else "not asked for"),
        *_doppler(scene),
        *_clutter(scene),
    ]


def _doppler(scene: Scene) -> list[Choice]:
    """What is made of the speed at which echoes come nearer; nothing is said where all is at rest."""
    speed = top_speed(scene.own_ship) + max((top_speed(body.motion) for body in scene.bodies), default=0.0)
    if speed == 0.0 or scene.radar.modulation != "lfm":
        return []
    cells = pulse_doppler_shift(speed, scene.radar.pulse, scene.radar.wavelength)
    left_out = f"from spoke to spoke it is exact; within a pulse it would move echoes by up to {cells:.2g} range cells"
    return [Choice("Doppler within the pulse", False, left_out)]


def _missed(scene: Scene) -> str:
    """From where on rays miss a square metre."""
    radar = scene.radar
    return f"a square metre is missed by one azimuth in twenty or more beyond {starving_range(radar):.0f} m"


def starving_range(radar: Radar) -> float:
    """Range [m] from which uniform rays miss a square metre at boresight with 5 % probability or more: (1 - p)^N, p its
    share of the box of rays."""
    share = -math.expm1(math.log(0.05) / radar.rays)
    return 1.0 / math.sqrt(share * (2.0 * REACH) ** 2 * radar.beamwidth * radar.beamwidth_el)


def _clutter(scene: Scene) -> list[Choice]:
    left_out = "asked for, but this version has no clutter"
    choices = []
    if scene.environment.sea_state:
        choices.append(Choice("sea clutter", False, f"{left_out} (the sea state still roughens the multipath mirror)"))
    if scene.environment.rain_mm_h:
        choices.append(Choice("rain clutter", False, f"{left_out} (rain still attenuates)"))
    return choices


def _body(body: Body, scene: Scene, fidelity: Fidelity) -> Choice:
    what = f"body {body.name}"
    if fidelity.chain == "documented":
        return Choice(
            what, True, "one hit per azimuth" if body.mesh is None else f"rays against {len(body.mesh.faces)} triangles"
        )
    rests = scene.own_ship.at_rest and body.motion.at_rest and body.swerling == 0
    laid = "laid once" if rests else "laid azimuth by azimuth"
    if body.rcs is not None:
        kind = f"declared cross-section, Swerling {body.swerling}" if body.swerling else "declared cross-section, steady"
        return Choice(what, True, f"{kind}, {laid}")
    if body.scattering == "optics":
        return Choice(what, True, f"physical optics, up to {fidelity.bounces} bounces, {laid}")
    if fidelity.sampler != "scatterers":
        rays = f"{SAMPLER_WORDS[fidelity.sampler]} rays, {scene.radar.rays} to 3 x 3 beamwidths ({_missed(scene)})"
        return Choice(what, True, f"diffuse, {laid}, by {rays}; beyond 1.5 beamwidths above and below nothing is met")
    return Choice(what, True, f"diffuse, {laid}, {fidelity.scatterers_per_cell:g} scatterers to a resolution cell")
