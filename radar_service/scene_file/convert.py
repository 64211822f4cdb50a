"""Converts tables of the scene model to SI units and radians: radar, environment, presence of bodies, and hulls in a seaway."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from radar_service.numerics import KNOT, LEAN, generator, name_key
from radar_service.radar import PATTERNS, NearPulse, Radar, radar_sets
from radar_service.scene_file.model.body import BodyModel
from radar_service.scene_file.model.environment import EnvironmentModel
from radar_service.scene_file.model.moving import AMPLITUDES, HullModel, MovingSection, SeawayModel
from radar_service.scene_file.model.radar import RadarModel, antenna_pattern
from radar_service.stages.fields import record_of
from radar_service.stages.registry import effect_records, environment_values
from radar_service.world import (
    NO_STREAM,
    PEAK_PERIOD,
    PERIOD_HEIGHT,
    Bounds,
    Environment,
    Fading,
    HullForm,
    Mesh,
    Motion,
    Presence,
    SceneError,
    Seaway,
    SeawayMotion,
    Stream,
    Waves,
    bounds_of,
    bounds_on_any_course,
    drawn_waves,
    easing_of,
    gas_attenuation_db_per_km,
    significant_wave_height,
)

DRAUGHT_PER_BEAM = 0.4  # of cargo ships; of boats somewhat less
STABILITY_PER_BEAM = 0.1  # metacentric height over beam: cargo ships have 0.05 to 0.1, boats 0.1 to 0.2


def radar_from_model(model: RadarModel) -> Radar:
    """Returns the radar in SI units: angles in radians, gains and losses as power ratios."""
    *near, last = [_single_pulse(pulse) for pulse in model.of_each_pulse()]
    fields = [{name: getattr(radar, name) for name in NearPulse.__dataclass_fields__} for radar in near]
    return replace(last, near_pulses=tuple(NearPulse(**pulse) for pulse in fields))


def _single_pulse(model: RadarModel) -> Radar:
    """Returns the radar of a model with a single pulse."""
    pattern = antenna_pattern(model.pattern, model)
    default_el = pattern if not isinstance(model.pattern, tuple) else PATTERNS["sinc2"]
    return record_of(
        Radar, model, bandwidth=model.band_hz, sample_rate=model.sampling_hz, bins=model.bins, pattern=pattern,
        window="none" if model.modulation == "none" else model.window, rotation_period=60.0 / model.rpm,
        pattern_el=default_el if model.pattern_el is None else antenna_pattern(model.pattern_el, model),
        noise_factor=10.0 ** (model.noise_figure_db / 10.0),
        effects=effect_records(model, "radar_keys", lambda effect, given: effect.radar_record(given)),
        scales=() if model.set is None else tuple(radar_sets()[model.set].scales),
        label_floor=0.0 if model.labels_within_db == "none" else 10.0 ** (-model.labels_within_db / 10.0),
    )  # fmt: skip


def environment_from_model(model: EnvironmentModel, radar: Radar) -> Environment:
    """Returns the environment in SI units, with "itu" gas at the radar's frequency. Raises SceneError above 54 GHz."""
    factors = {"4/3": 4.0 / 3.0, "flat": math.inf}
    gas = model.gas_db_per_km
    return record_of(
        Environment, model, earth_factor=factors[model.earth] if isinstance(model.earth, str) else model.earth,
        gas_db_per_km=gas_attenuation_db_per_km(radar.frequency) if isinstance(gas, str) else gas,
        sea_state=model.state, effect_keys=environment_values(model), stream=stream_from_model(model),
        seaway=seaway_from_model(model),
    )  # fmt: skip


def seaway_from_model(model: EnvironmentModel) -> Seaway | None:
    """Returns the seaway, None where there is none. Raises SceneError without waves."""
    if not model.seaway:
        return None
    sea = SeawayModel() if model.seaway is True else model.seaway
    if sea.height_m is None and not model.state:
        raise SceneError(
            "environment.seaway: sea_state 0 has no waves; give sea_state up to 9, give seaway.height_m, or remove seaway"
        )
    height = significant_wave_height(model.state) if sea.height_m is None else sea.height_m
    period = float(np.interp(height, PERIOD_HEIGHT, PEAK_PERIOD)) if sea.period_s is None else sea.period_s
    coming_from = model.wind_from_deg if sea.from_deg is None else sea.from_deg
    rms = {"list_rms": math.radians(sea.list_deg), "trim_rms": math.radians(sea.trim_deg)}
    return record_of(Seaway, sea, height=height, period=period, towards=math.radians(coming_from + 180.0), **rms)


def stream_from_model(model: EnvironmentModel) -> Stream:
    """Returns the velocity of the water over ground, the same everywhere, east and north [m/s]."""
    if model.current_to_deg is None:
        return NO_STREAM
    to, speed = math.radians(model.current_to_deg), model.current_kn * KNOT
    return speed * math.sin(to), speed * math.cos(to)


def presence_from_model(model: BodyModel, rotation_period: float) -> Presence:
    """Returns when a body is present; a unit of its fading is by default a scan of `rotation_period` [s]."""
    fading = None
    if model.fading is not None:
        unit = rotation_period if model.fading.unit_s is None else model.fading.unit_s
        fading = Fading(np.array(model.fading.pattern(), dtype=np.bool_), unit, model.fading.offset_s)
    changes = [(0.0, model.start_s <= 0.0)]
    changes += [(model.start_s, True)] if model.start_s > 0.0 else []
    changes += [(model.end_s, False)] if model.end_s is not None else []
    if len(changes) == 1 and fading is None:
        return Presence.always
    time, present = zip(*changes, strict=True)
    return Presence(np.array(time), np.array(present, dtype=np.bool_), fading)


class HullExtent(NamedTuple):
    """Length and breadth [m] of a body, how deep it reaches [m], and its middle, starboard and forward [m]."""

    length: float
    breadth: float
    depth: float
    middle: tuple[float, float]


OWN_SHIP = HullExtent(75.0, 12.5, 0.0, (0.0, 0.0))  # that is no body


def extent_of(mesh: Mesh | None, up: float) -> HullExtent:
    """Returns the extent of a mesh whose origin is `up` [m] above the sea; 0 without a mesh."""
    if mesh is None:
        return HullExtent(0.0, 0.0, 0.0, (0.0, 0.0))
    low, high = mesh.used_vertices.min(axis=0), mesh.used_vertices.max(axis=0)
    beam, length = (high - low)[:2].tolist()
    east, north = ((low + high) / 2.0)[:2].tolist()
    return HullExtent(length, beam, max(0.0, -float(low[2]) - up), (east, north))


def hull_from_model(table: HullModel | None, extent: HullExtent, draught: float | None, location: str) -> HullForm:
    """Returns the hull of a ship, by default that of an empty table. draught: of the body, or None. Raises SceneError.

    Its roll period by default is 2 C B / sqrt(GM), C = 0.373 + 0.023 B / T - 0.043 L / 100: IMO MSC.267(85), 2008 Intact
    Stability Code, part A, 2.3.4. Its waterplane by default is that of Schneekluth and Bertram 1998, (1 + 2 C_B) / 3.
    """
    model = table or HullModel()
    length, breadth = model.length_m or extent.length, model.beam_m or extent.breadth
    if not length or not breadth:
        missing = "length_m" if not length else "beam_m"
        raise SceneError(
            f"{location}.hull.{missing}: the body has no size of its own; give {missing}, or hull.floats = false"
        )
    deep = next((value for value in (model.draught_m, draught, extent.depth) if value), DRAUGHT_PER_BEAM * breadth)
    coefficient = 0.373 + 0.023 * breadth / deep - 0.043 * length / 100.0
    stability = STABILITY_PER_BEAM * breadth
    waterplane = (1.0 + 2.0 * model.block) / 3.0 if model.waterplane is None else model.waterplane
    roll_period = max(1.0, 2.0 * coefficient * breadth / math.sqrt(stability))
    return record_of(
        HullForm, model, length=length, breadth=breadth, draught=deep, waterplane=waterplane,
        roll_period=roll_period if model.roll_period_s is None else model.roll_period_s, middle=extent.middle,
    )  # fmt: skip


class SeawayBuilder:
    """Puts ships into the seaway of a scene."""

    def __init__(self, seaway: Seaway, stream: Stream) -> None:
        self.seaway, self._stream = seaway, stream
        self._waves: Waves = drawn_waves(seaway, stream)
        self._bounds: dict[tuple[HullForm, float, float], Bounds] = {}

    def moves(self, section: MovingSection, is_vessel: bool) -> bool:
        """Returns whether the seaway moves a body: it floats, and has no sway of its own."""
        if any(getattr(section, amplitude) for amplitude in AMPLITUDES.values()):
            return False
        floats = None if section.hull is None else section.hull.floats
        return (is_vessel or section.hull is not None) if floats is None else floats

    def moved(self, motion: Motion, section: MovingSection, form: HullForm, name: str) -> Motion:
        """Returns the motion of a ship with the sway of the seaway; name: of the ship, which keys its list."""
        rng = generator(self.seaway.seed, LEAN, name_key(name))
        drawn_list, drawn_trim = (rng.standard_normal(2) * [self.seaway.list_rms, self.seaway.trim_rms]).tolist()
        lean = (
            drawn_list if section.list_deg is None else math.radians(section.list_deg),
            drawn_trim if section.trim_deg is None else math.radians(section.trim_deg),
        )
        if motion.keeps_course and motion.time[0] <= 0.0:
            velocity = motion.final_velocity[None, :2] - self._stream
            bounds = bounds_of(self._waves, form, motion.heading, velocity)
        else:
            key = form, motion.top_speed + math.hypot(*self._stream), motion.top_turn_rate
            if key not in self._bounds:
                self._bounds[key] = bounds_on_any_course(self._waves, *key)
            bounds = self._bounds[key]
        sway = SeawayMotion(self._waves, form, bounds, lean, easing_of(motion), self._stream)
        return replace(motion, sway=sway)


def builder_from_model(model: EnvironmentModel) -> SeawayBuilder | None:
    """Returns what puts ships into the seaway of a scene, None where it has none. Raises SceneError."""
    seaway = seaway_from_model(model)
    return None if seaway is None else SeawayBuilder(seaway, stream_from_model(model))
