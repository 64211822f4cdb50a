"""What is modelled of a scene, what is left out, and why: said, not guessed."""

import math
from dataclasses import asdict, dataclass
from math import pi
from typing import Any

from radar_service.echo.optics.optical_body import coarsening
from radar_service.echo.optics.pieces import MOST
from radar_service.echo.rain_clutter import RAIN_HEIGHT
from radar_service.echo.sea_clutter import HIGHEST_SEA_STATE
from radar_service.fidelity import Fidelity
from radar_service.receive.clutter import MATTERS
from radar_service.scene.describe import pattern_text
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
        *([Choice("plain pulse", False, "the specification knows chirps alone")] if radar.modulation == "none" else []),
        Choice("earth", False, "flat: the specification bends nothing"),
        Choice("multipath", environment.multipath, "|F|^2 of eq. 12" if environment.multipath else "not asked for"),
        *_sway(scene, "the mast swings and the heading too; the specification does not tilt the beam"),
        Choice("noise", False, "not in the specification"),
        *_documented_clutter(scene),
    ]


def _corrected_effects(scene: Scene, fidelity: Fidelity) -> list[Choice]:
    environment = scene.environment
    curved = environment.earth_factor != float("inf")
    rest = "the full circle" if scene.own_ship.at_rest else _extent(scene, fidelity)
    return [
        *_waveform(scene.radar, fidelity),
        Choice("beam", True, f"{pattern_text(scene.radar.pattern)}, {rest}"),
        *_motion(scene, fidelity),
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
        *_sway(scene, "the mast swings, bearings and elevations are those of the tilted antenna; sea clutter keeps level"),
        Choice("noise", environment.noise, "thermal, k T0 F" if environment.noise else "not asked for"),
        *_doppler(scene),
        *_clutter(scene),
    ]


def _waveform(radar: Radar, fidelity: Fidelity) -> list[Choice]:
    laid = f"exact delays, Kaiser-Bessel grid of {fidelity.kernel_width} bins, closed-form spectrum"
    pulse = (
        "plain pulse behind a Gaussian receiver, laid in closed form at exact delays" if radar.modulation == "none" else laid
    )
    eclipsed = f"what comes within {radar.pulse * 1e6:g} us is not heard, echo by echo; noise stays as it is"
    choices = [
        Choice("range", True, pulse),
        Choice("eclipsing", radar.eclipsing, eclipsed if radar.eclipsing else "not asked for"),
    ]
    if radar.prf is not None:
        folds = f"echoes beyond {radar.unambiguous_range:.0f} m fold, with the phase of their own pulse"
        how = folds if radar.second_time_around else "not asked for: what lies beyond is left out"
        choices.append(Choice("second-time echoes", radar.second_time_around, how))
    return choices


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


def _documented_clutter(scene: Scene) -> list[Choice]:
    environment = scene.environment
    asked = {"sea clutter": environment.sea_state, "rain clutter": environment.rain_mm_h, "interference": scene.interference}
    return [Choice(what, False, "asked for, but not in the specification") for what, much in asked.items() if much]


def _extent(scene: Scene, fidelity: Fidelity) -> str:
    whole = fidelity.beam_extent * scene.radar.beamwidth >= pi
    return "the full circle" if whole else f"{fidelity.beam_extent:g} beamwidths each side"


def _motion(scene: Scene, fidelity: Fidelity) -> list[Choice]:
    """How what moves relative to the antenna is followed, where anything does."""
    if scene.own_ship.at_rest and all(body.motion.at_rest for body in scene.bodies):
        return []
    together = f"swept {fidelity.swept_together} azimuths at a time" if fidelity.swept_together > 1 else "each by itself"
    how = f"range, phase and beam weight of every azimuth, {together}; sight looked at anew every {fidelity.glance:g} m"
    return [Choice("motion", True, how)]


def _sway(scene: Scene, how: str) -> list[Choice]:
    """How roll, pitch and yaw are modelled, where own ship has them."""
    return [] if scene.own_ship.sway is None else [Choice("roll, pitch, yaw", True, how)]


def _clutter(scene: Scene) -> list[Choice]:
    environment = scene.environment
    sea, rain = environment.sea_state, environment.rain_mm_h
    fit = "" if sea <= HIGHEST_SEA_STATE else f" (as {HIGHEST_SEA_STATE}, where the measurements end)"
    shape = environment.sea_texture_shape
    texture = "shape by grazing angle and cell (Ward)" if shape is None else f"shape {shape:g}"
    sea_text = f"NRL 2012 sigma0 of sea state {sea}{fit}, GIT wind factor, K-distributed: {texture}; hidden by what rests"
    rain_text = f"Marshall-Palmer, {rain:g} mm/h everywhere up to {RAIN_HEIGHT:g} m, Rayleigh"
    floor = f"; below {10 * math.log10(MATTERS):g} dB of the noise left out" if environment.noise else ""
    return [
        Choice("sea clutter", sea > 0, sea_text + floor if sea else "sea state 0"),
        Choice("rain clutter", rain > 0, rain_text + floor if rain else "no rain"),
        *_interference(scene),
    ]


def _interference(scene: Scene) -> list[Choice]:
    if not scene.interference:
        return []
    others = f"{len(scene.interference)} other radar{'s' if len(scene.interference) > 1 else ''}"
    return [Choice("interference", True, f"{others}, each pulse at its instant through both beams and the filter")]


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
        return Choice(what, True, f"physical optics, up to {fidelity.bounces} bounces, {laid}{_coarsely(body, scene)}")
    if fidelity.sampler != "scatterers":
        rays = f"{SAMPLER_WORDS[fidelity.sampler]} rays, {scene.radar.rays} to 3 x 3 beamwidths ({_missed(scene)})"
        return Choice(what, True, f"diffuse, {laid}, by {rays}; beyond 1.5 beamwidths above and below nothing is met")
    return Choice(what, True, f"diffuse, {laid}, {fidelity.scatterers_per_cell:g} scatterers to a resolution cell")


def _coarsely(body: Body, scene: Scene) -> str:
    """What is said of a body by optics that is too large for its pieces to be as fine as they should."""
    distance = math.dist(body.motion.pose(0.0).position[0], scene.antenna(0.0)[0]) - body.length / 2.0
    times = coarsening(body, scene.radar, distance)
    return "" if times == 1.0 else f"; pieces {times:.1f} times longer than they should be, at most {MOST} of them"
