"""The effects of a scene: which are modelled, how, and their errors and costs."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from radar_service.echo import PIECE
from radar_service.numerics import effective_earth_radius
from radar_service.plan.cost_model import EngineStatistics
from radar_service.plan.settings_search import all_rests, beam_kernel_db, extent_db, kernel_db, motion_db, multipath_db
from radar_service.propagation import diffraction_height
from radar_service.radar import Radar, pulse_doppler_shift
from radar_service.receive import receiver_noise_power
from radar_service.records import Fidelity, PlanItem
from radar_service.scattering import scattering_model
from radar_service.stages.registry import effects_in
from radar_service.trace import missed_area_range
from radar_service.world import MAX_FROUDE, WAVES, Scene, SeawayMotion, is_land

PLATED_SHARE = 0.02  # rms of 300 walls against elements with real dents (tests/scattering/physical_optics/test_plating.py)
TWO_RAY = "two-ray, complex F^2; nothing diffracts: too strong close before the horizon, nothing beyond"
LAND_DB = -50.0  # of points from 1 km on, at 25 kn, turning or rolling (tests/engine/test_land_rows.py)
SIGHT_WAY, SIGHT_DB = 2.1, 0.1  # m of way in a piece of land; of mean power in rings, against steps of 1 m (the same tests)
BY_LAND = "; land reflects in place of the sea, as rough as its material"
SERIES = "two-ray, complex F^2; smooth-sea diffraction near the horizon and beyond, of all but what is above {:.0f} m"
BAND = 1.81  # 2 pi times the rms frequency of a uniform band B: relative change of a pulse moved by a cell of c / 2B
NOT_REQUESTED = "not requested"
NOT_SPECIFIED = "requested, but not in the specification"


def effects(scene: Scene, fidelity: Fidelity, statistics: EngineStatistics) -> list[PlanItem]:
    """The items of all effects, bodies apart."""
    if fidelity.engine == "documented":
        return _documented_effects(scene, fidelity)
    return _corrected_effects(scene, fidelity, statistics)


def _documented_effects(scene: Scene, fidelity: Fidelity) -> list[PlanItem]:
    environment, radar = scene.environment, scene.radar
    chain = f"the specification as printed, {radar.rays} rays per azimuth ({radar.azimuths} azimuths); {missed_area(scene)}"
    return [
        PlanItem("signal chain", True, chain),
        PlanItem("beam", True, "printed pattern within 1.5 beamwidths, then the Gaussian spread of eq. 19"),
        *_undocumented_waveform(radar),
        PlanItem("earth", False, "flat: the specification has no refraction and no curvature"),
        PlanItem("multipath", environment.multipath, "|F|^2 of eq. 12" if environment.multipath else NOT_REQUESTED),
        *_sway(scene, "the mast and the heading sway; the specification does not tilt the beam"),
        *_unspecified(_stages(scene, fidelity, True)),
        *_seaway(scene),
        PlanItem("noise", False, "not in the specification"),
        *_unspecified(_stages(scene, fidelity, False)),
    ]


def _undocumented_waveform(radar: Radar) -> list[PlanItem]:
    """What a radar transmits or filters beyond linear chirps and matched filters."""
    names = {"lfm": [], "nlfm": ["nonlinear chirp"], "none": ["plain pulse"]}[radar.modulation]
    names += ["inverse filter"] if radar.compression == "inverse" else []
    names += ["nearer pulses"] if radar.near_pulses else []
    return [PlanItem(name, False, "the specification has one linear chirp and its matched filter") for name in names]


def _corrected_effects(scene: Scene, fidelity: Fidelity, statistics: EngineStatistics) -> list[PlanItem]:
    environment, costs = scene.environment, statistics.costs
    of_effects = {} if costs is None else costs.effects
    receiver = None if costs is None else costs.receiver
    pulses = scene.radar.pulses_integrated
    integrated = f"; the {pulses} pulses of a spoke are integrated without their phases" * (pulses > 1)
    noise = f"thermal, k T0 F{integrated}" if environment.noise else NOT_REQUESTED
    return [
        *_waveform(scene.radar, fidelity, None if environment.noise else receiver),
        *_near_pulses(scene.radar),
        _beam(scene, fidelity),
        *_stages(scene, fidelity, True, of_effects),
        *_motion(scene, fidelity, None if costs is None else costs.looks),
        *_land(scene, statistics.land_border),
        _earth(scene),
        _multipath(scene, fidelity),
        _air(scene),
        *_sway(scene, "the mast sways; bearings and elevations are those of the tilted antenna; sea clutter stays level"),
        *_seaway(scene),
        *_plating(scene),
        PlanItem("noise", environment.noise, noise, microseconds=receiver if environment.noise else None),
        *_doppler(scene),
        *_stages(scene, fidelity, False, of_effects),
    ]


def _waveform(radar: Radar, fidelity: Fidelity, microseconds: float | None) -> list[PlanItem]:
    pulse = f"exact delays, Kaiser-Bessel grid of {fidelity.kernel_width} bins, closed-form spectrum"
    if radar.compression == "inverse":
        pulse += "; the inverse filter leaves the sidelobes of the window alone"
    if radar.modulation == "none":
        pulse = "plain pulse behind a Gaussian receiver, gridded in closed form at exact delays"
    error = kernel_db(radar, fidelity.kernel_width)
    eclipsed = f"echoes within {radar.pulse * 1e6:g} us lose what arrives during transmission; noise does not change"
    choices = [
        PlanItem("range", True, pulse, field_db=error if math.isfinite(error) else None, microseconds=microseconds),
        PlanItem("eclipsing", radar.eclipsing, eclipsed if radar.eclipsing else NOT_REQUESTED),
    ]
    if radar.prf is not None:
        folds = f"echoes beyond {radar.unambiguous_range:.0f} m fold, with the phase of their own pulse"
        how = folds if radar.second_time_around else f"{NOT_REQUESTED}: echoes beyond the unambiguous range are dropped"
        choices.append(PlanItem("second-time echoes", radar.second_time_around, how))
    return choices


def _near_pulses(radar: Radar) -> list[PlanItem]:
    """The pulses that serve nearer ranges, each with the loss of signal to noise against the last one."""
    pulses = []
    for near in radar.of_each_pulse[:-1]:
        lost_db = 10.0 * math.log10(receiver_noise_power(near) / receiver_noise_power(radar))
        pulses.append(f"{near.pulse * 1e6:g} us to {near.range_max:g} m, where signal to noise is {lost_db:.1f} dB lower")
    how = f"{'; '.join(pulses)}; each costs as much as a radar with that pulse alone"
    return [PlanItem("nearer pulses", True, how)] if pulses else []


def _beam(scene: Scene, fidelity: Fidelity) -> PlanItem:
    """The full circle for resting echoes, and the beam extent for moving ones."""
    radar = scene.radar
    error, extent = beam_kernel_db(radar, fidelity.beam_kernel_width), "the full circle"
    cut = extent_db(radar, fidelity.beam_extent)
    if not all_rests(scene) and math.isfinite(cut):
        error, extent = cut, f"{fidelity.beam_extent:g} beamwidths each side"
        if scene.own_ship.at_rest:
            extent = f"the full circle, {extent} for moving echoes"
    return PlanItem("beam", True, f"{radar.pattern.description}, {extent}", field_db=error if math.isfinite(error) else None)


def _motion(scene: Scene, fidelity: Fidelity, microseconds: float | None) -> list[PlanItem]:
    """How echoes that move relative to the antenna are computed; no item where all bodies and own ship rest."""
    if scene.own_ship.at_rest and all(body.at_rest for body in scene.bodies):
        return []
    blocks = f"in blocks of {fidelity.azimuths_per_block}" if fidelity.azimuths_per_block > 1 else "one by one"
    how = f"range, phase and beam weight of every azimuth, {blocks}; visibility updated every {fidelity.visibility_step:g} m"
    return [PlanItem("motion", True, how, field_db=motion_db(fidelity), microseconds=microseconds)]


def _land(scene: Scene, border: float | None) -> list[PlanItem]:
    """How land under way is computed that follows own ship on a grid; no item without any."""
    if border is None:
        return []
    way = scene.own_ship.top_speed * PIECE * scene.radar.spoke_period
    error = f", which errs by {SIGHT_DB:g} dB at most" if way <= SIGHT_WAY else ""
    how = (
        f"diffuse land at rest from {border:.0f} m on, each point once a passage of the beam; its visibility updated every scan, "
        f"in steps of {way:.2g} m of way{error}"
    )
    return [PlanItem("land under way", True, how, field_db=LAND_DB)]


def _earth(scene: Scene) -> PlanItem:
    factor = scene.environment.earth_factor
    if math.isinf(factor):
        return PlanItem("earth", False, "flat, as requested")
    antenna = scene.antenna(0.0)[0][:2]
    distance = max((math.dist(antenna, body.middle_at(0.0)[:2]) for body in scene.bodies), default=0.0)
    distance = min(scene.radar.range_max, distance)
    drop = distance**2 / (2.0 * effective_earth_radius(factor))
    raised = f"a flat earth would raise targets at {distance / 1000:.1f} km by {drop:.2g} m"
    return PlanItem("earth", True, f"effective radius {factor:.4g} x the earth's; costs nothing; {raised}")


def _multipath(scene: Scene, fidelity: Fidelity) -> PlanItem:
    if not scene.environment.multipath:
        return PlanItem("multipath", False, NOT_REQUESTED)
    error = multipath_db(scene, fidelity)
    diffracting = diffraction_height(scene.radar, scene.environment)
    how = SERIES.format(diffracting) if scene.radar.height < diffracting else TWO_RAY
    how += BY_LAND if any(is_land(body) for body in scene.bodies) else ""
    return PlanItem("multipath", True, how, field_db=error if math.isfinite(error) else None)


def _air(scene: Scene) -> PlanItem:
    environment = scene.environment
    uniform = environment.gas_db_per_km > 0 or environment.rain_mm_h > 0
    text = f"{environment.gas_db_per_km:.4g} dB/km one way, rain {environment.rain_mm_h:g} mm/h (ITU-R P.838)"
    text += "".join(f"; {attenuator.text}" for attenuator in environment.attenuators)
    text += "; costs nothing" if uniform and not environment.attenuators else ""
    return PlanItem("gas and rain loss", uniform or len(environment.attenuators) > 0, text)


def _doppler(scene: Scene) -> list[PlanItem]:
    """Doppler shift within a chirp, which is not modelled; no item where nothing moves."""
    speed = scene.own_ship.top_speed + max((body.motion.top_speed for body in scene.bodies), default=0.0)
    if speed == 0.0 or scene.radar.modulation == "none":
        return []
    radar = scene.radar
    cells = pulse_doppler_shift(speed, radar.pulse, radar.wavelength, radar.chirp.doppler_coupling)
    how = f"from spoke to spoke it is exact; within a pulse it would move echoes by up to {cells:.2g} range cells"
    error = min(0.0, 20.0 * math.log10(BAND * cells))
    return [PlanItem("Doppler within the pulse", False, how, field_db=error)]


def missed_area(scene: Scene) -> str:
    """The range beyond which rays miss a square metre, as text."""
    radar = scene.radar
    distance = missed_area_range(radar.rays, radar.beamwidth, radar.beamwidth_el)
    return f"beyond {distance:.0f} m, one azimuth in twenty or more misses a square metre"


def _sway(scene: Scene, how: str) -> list[PlanItem]:
    """How roll, pitch, yaw and heave are modelled, where own ship has them."""
    sway = scene.own_ship.sway
    return [] if sway is None else [PlanItem("roll, pitch, yaw" + (", heave" if sway.max_heave else ""), True, how)]


def _seaway(scene: Scene) -> list[PlanItem]:
    """How a seaway moves ships, without a cost: aspects of metal include it."""
    seaway = scene.environment.seaway
    if seaway is None:
        return []
    laws = [(motion, motion.sway) for motion in (scene.own_ship, *(body.motion for body in scene.bodies))]
    ships = [(motion, law) for motion, law in laws if isinstance(law, SeawayMotion)]
    planing = sum(motion.top_speed > law.form.max_speed for motion, law in ships)
    fast = f"; {planing} faster than Froude {MAX_FROUDE:g} answer as at that" if planing else ""
    how = (
        f"{len(ships)} ships by closed-form responses to {WAVES} waves of {seaway.height:.3g} m in {seaway.period:.3g} s, "
        f"exact at any time; hulls are boxes, without yaw and planing{fast}; metal has as many aspects as their rates ask"
    )
    return [PlanItem("seaway", bool(ships), how if ships else "no ship floats")]


def _plating(scene: Scene) -> list[PlanItem]:
    """How walls are dented, without a cost: aspects of metal include it."""
    plated = [body for body in scene.bodies if body.plating is not None and scattering_model(body).by_aspect]
    dents = [body.plating.depth for body in plated if body.plating is not None and body.plating.depth > 0.0]
    depths = f"{1e3 * min(dents, default=0.0):g} to {1e3 * max(dents, default=0.0):g} mm"
    how = (
        f"walls of {len(dents)} bodies, {depths} deep between frames, as phases of strips near their normals: "
        f"{PLATED_SHARE:.0%} of the field off; metal takes up to 3 times as long abeam"
    )
    return [PlanItem("dented plating", True, how)] if dents else []


def _stages(
    scene: Scene, fidelity: Fidelity, of_radar: bool, costs: Mapping[str, float] = MappingProxyType({})
) -> list[PlanItem]:
    """What effects say of themselves: those with keys of the radar, or all others. costs: by their names [us]."""
    chosen = [effect for effect in effects_in(scene) if bool(effect.radar_keys) == of_radar]
    return [item for effect in chosen for item in effect.stage().plan(scene, fidelity, costs.get(effect.name))]


def _unspecified(items: Sequence[PlanItem]) -> list[PlanItem]:
    """The same effects, as the specification has none of them."""
    return [PlanItem(item.what, False, NOT_SPECIFIED) for item in items]
