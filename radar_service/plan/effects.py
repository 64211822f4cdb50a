"""The effects of a scene: which are modelled, how, and what each errs and costs."""

import math

from radar_service.clutter.clutter import MATTERS
from radar_service.clutter.rain import RAIN_HEIGHT
from radar_service.clutter.sea import HIGHEST_SEA_STATE
from radar_service.fidelity import Fidelity
from radar_service.frames import effective_earth_radius
from radar_service.plan.items import PlanItem
from radar_service.plan.multipath_error import multipath_error_db
from radar_service.plan.settings_search import all_rests, beam_kernel_db, extent_db, kernel_db, motion_db
from radar_service.plan.statistics import EngineStatistics
from radar_service.radar.parameters import Radar
from radar_service.scene.checks.validity import pulse_doppler_shift
from radar_service.scene.world import Scene
from radar_service.trace.ray_sampling import missed_area_range

TWO_RAY = "two-ray, complex F^2; nothing diffracts: too strong close before the horizon, nothing beyond"
BAND = 1.81  # 2 pi times the rms frequency of a uniform band B: relative change of a pulse moved by a cell of c / 2B


def effects(scene: Scene, fidelity: Fidelity, statistics: EngineStatistics) -> list[PlanItem]:
    """The choices for everything but bodies."""
    return _documented_effects(scene) if fidelity.engine == "documented" else _corrected_effects(scene, fidelity, statistics)


def _documented_effects(scene: Scene) -> list[PlanItem]:
    environment, radar = scene.environment, scene.radar
    return [
        PlanItem(
            "signal chain",
            True,
            f"the specification as printed, {radar.rays} rays per azimuth ({radar.azimuths} azimuths); {missed(scene)}",
        ),
        PlanItem("beam", True, "printed pattern within 1.5 beamwidths, then the Gaussian spread of eq. 19"),
        *([PlanItem("plain pulse", False, "the specification knows chirps alone")] if radar.modulation == "none" else []),
        PlanItem("earth", False, "flat: the specification bends nothing"),
        PlanItem("multipath", environment.multipath, "|F|^2 of eq. 12" if environment.multipath else "not asked for"),
        *_sway(scene, "the mast swings and the heading too; the specification does not tilt the beam"),
        PlanItem("noise", False, "not in the specification"),
        *_documented_clutter(scene),
    ]


def _corrected_effects(scene: Scene, fidelity: Fidelity, statistics: EngineStatistics) -> list[PlanItem]:
    environment, costs = scene.environment, statistics.costs
    receiver = None if costs is None else costs.receiver
    noise = "thermal, k T0 F" if environment.noise else "not asked for"
    return [
        *_waveform(scene.radar, fidelity, None if environment.noise else receiver),
        _beam(scene, fidelity),
        *_motion(scene, fidelity, None if costs is None else costs.looks),
        _earth(scene),
        _multipath(scene, fidelity, statistics),
        *_air(scene, statistics),
        *_sway(scene, "the mast swings, bearings and elevations are those of the tilted antenna; sea clutter keeps level"),
        PlanItem("noise", environment.noise, noise, microseconds=receiver if environment.noise else None),
        *_doppler(scene),
        *_clutter(scene, None if costs is None else costs.clutter),
        *_interference(scene, None if costs is None else costs.interference),
    ]


def _waveform(radar: Radar, fidelity: Fidelity, microseconds: float | None) -> list[PlanItem]:
    gridded = f"exact delays, Kaiser-Bessel grid of {fidelity.kernel_width} bins, closed-form spectrum"
    pulse = (
        "plain pulse behind a Gaussian receiver, laid in closed form at exact delays"
        if radar.modulation == "none"
        else gridded
    )
    error = kernel_db(radar, fidelity.kernel_width)
    eclipsed = f"what comes within {radar.pulse * 1e6:g} us is not heard, echo by echo; noise stays as it is"
    choices = [
        PlanItem("range", True, pulse, field_db=error if math.isfinite(error) else None, microseconds=microseconds),
        PlanItem("eclipsing", radar.eclipsing, eclipsed if radar.eclipsing else "not asked for"),
    ]
    if radar.prf is not None:
        folds = f"echoes beyond {radar.unambiguous_range:.0f} m fold, with the phase of their own pulse"
        how = folds if radar.second_time_around else "not asked for: what lies beyond is left out"
        choices.append(PlanItem("second-time echoes", radar.second_time_around, how))
    return choices


def _beam(scene: Scene, fidelity: Fidelity) -> PlanItem:
    """The full circle for all that is laid once, and how far it reaches for what moves."""
    radar = scene.radar
    error, extent = beam_kernel_db(radar, fidelity.beam_kernel_width), "the full circle"
    cut = extent_db(radar, fidelity.beam_extent)
    if not all_rests(scene) and math.isfinite(cut):
        error, extent = cut, f"{fidelity.beam_extent:g} beamwidths each side"
        if scene.own_ship.at_rest:
            extent = f"the full circle, {extent} for what moves"
    return PlanItem("beam", True, f"{radar.pattern.description}, {extent}", field_db=error if math.isfinite(error) else None)


def _motion(scene: Scene, fidelity: Fidelity, microseconds: float | None) -> list[PlanItem]:
    """How what moves relative to the antenna is followed, where anything does."""
    if scene.own_ship.at_rest and all(body.motion.at_rest for body in scene.bodies):
        return []
    many = fidelity.azimuths_per_block > 1
    together_text = f"swept {fidelity.azimuths_per_block} azimuths at a time" if many else "each by itself"
    how = f"range, phase and beam weight of every azimuth, {together_text}; sight looked at anew every {fidelity.visibility_step:g} m"
    return [PlanItem("motion", True, how, field_db=motion_db(fidelity), microseconds=microseconds)]


def _earth(scene: Scene) -> PlanItem:
    factor = scene.environment.earth_factor
    if math.isinf(factor):
        return PlanItem("earth", False, "asked to be flat")
    far = min(scene.radar.range_max, max((math.dist(scene.antenna(0.0)[0][:2], body.middle_at(0.0)[:2])
                                          for body in scene.bodies), default=0.0))  # fmt: skip
    drop = far**2 / (2.0 * effective_earth_radius(factor))
    lifted = f"flat would lift what is {far / 1000:.1f} km off by {drop:.2g} m"
    return PlanItem("earth", True, f"effective radius {factor:.4g} x the earth's; costs nothing, {lifted}")


def _multipath(scene: Scene, fidelity: Fidelity, statistics: EngineStatistics) -> PlanItem:
    if not scene.environment.multipath:
        return PlanItem("multipath", False, "not asked for")
    if "multipath" in statistics.culling.effects:
        return PlanItem(
            "multipath",
            False,
            "the sea mirrors too little: too rough, too steeply met, outside the beam",
            field_db=statistics.culling.effects["multipath"],
        )
    held = multipath_error_db(scene, fidelity.azimuths_per_block)
    if math.isinf(held):
        return PlanItem("multipath", True, TWO_RAY)
    how = f"{TWO_RAY}; the way by the sea is that of the middle of {fidelity.azimuths_per_block} azimuths"
    return PlanItem("multipath", True, how, field_db=min(held, 0.0))


def _air(scene: Scene, statistics: EngineStatistics) -> list[PlanItem]:
    environment = scene.environment
    lossy = environment.gas_db_per_km > 0 or environment.rain_mm_h > 0
    if "gas" in statistics.culling.effects and not environment.rain_mm_h:
        text = f"{environment.gas_db_per_km:.4g} dB/km moves nothing within the range of this radar"
        return [PlanItem("gas and rain loss", False, text, field_db=statistics.culling.effects["gas"])]
    text = f"{environment.gas_db_per_km:.4g} dB/km one way, rain {environment.rain_mm_h:g} mm/h (ITU-R P.838)"
    return [PlanItem("gas and rain loss", lossy, text + ("; costs nothing" if lossy else ""))]


def _doppler(scene: Scene) -> list[PlanItem]:
    """What is made of the speed at which echoes come nearer; nothing is said where all is at rest."""
    speed = scene.own_ship.top_speed + max((body.motion.top_speed for body in scene.bodies), default=0.0)
    if speed == 0.0 or scene.radar.modulation != "lfm":
        return []
    cells = pulse_doppler_shift(speed, scene.radar.pulse, scene.radar.wavelength)
    culled_bodies = f"from spoke to spoke it is exact; within a pulse it would move echoes by up to {cells:.2g} range cells"
    error = min(0.0, 20.0 * math.log10(BAND * cells))
    return [PlanItem("Doppler within the pulse", False, culled_bodies, field_db=error)]


def missed(scene: Scene) -> str:
    """From where on rays miss a square metre."""
    radar = scene.radar
    return f"a square metre is missed by one azimuth in twenty or more beyond {missed_area_range(radar.rays, radar.beamwidth, radar.beamwidth_el):.0f} m"


def _documented_clutter(scene: Scene) -> list[PlanItem]:
    environment = scene.environment
    asked = {"sea clutter": environment.sea_state, "rain clutter": environment.rain_mm_h, "interference": scene.interference}
    return [PlanItem(what, False, "asked for, but not in the specification") for what, much in asked.items() if much]


def _sway(scene: Scene, how: str) -> list[PlanItem]:
    """How roll, pitch and yaw are modelled, where own ship has them."""
    return [] if scene.own_ship.sway is None else [PlanItem("roll, pitch, yaw", True, how)]


def _clutter(scene: Scene, microseconds: float | None) -> list[PlanItem]:
    environment = scene.environment
    sea, rain = environment.sea_state, environment.rain_mm_h
    fit = "" if sea <= HIGHEST_SEA_STATE else f" (as {HIGHEST_SEA_STATE}, where the measurements end)"
    shape = environment.sea_texture_shape
    texture = "shape by grazing angle and cell (Ward)" if shape is None else f"shape {shape:g}"
    sea_text = f"NRL 2012 sigma0 of sea state {sea}{fit}, GIT wind factor, K-distributed: {texture}; hidden by what rests"
    rain_text = f"Marshall-Palmer, {rain:g} mm/h everywhere up to {RAIN_HEIGHT:g} m, Rayleigh"
    floor = f"; below {10 * math.log10(MATTERS):g} dB of the noise left out" if environment.noise else ""
    culled_bodies = 10.0 * math.log10(1.0 + MATTERS) if environment.noise else None
    return [
        PlanItem("sea clutter", sea > 0, sea_text + floor if sea else "sea state 0",
               culled_bodies if sea else None, microseconds=microseconds if sea else None),
        PlanItem("rain clutter", rain > 0, rain_text + floor if rain else "no rain",
               culled_bodies if rain else None, microseconds=microseconds if rain and not sea else None),
    ]  # fmt: skip


def _interference(scene: Scene, microseconds: float | None) -> list[PlanItem]:
    if not scene.interference:
        return []
    others = f"{len(scene.interference)} other radar{'s' if len(scene.interference) > 1 else ''}"
    how = f"{others}, each pulse at its instant through both beams and the filter"
    return [PlanItem("interference", True, how, microseconds=microseconds)]
