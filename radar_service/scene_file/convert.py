"""Converts the radar, the environment and the presence of bodies of the scene model to SI units and radians."""

import math
from dataclasses import replace

import numpy as np

from radar_service.numerics import KNOT
from radar_service.radar import PATTERNS, NearPulse, Radar, radar_sets
from radar_service.scene_file.model.body import BodyModel
from radar_service.scene_file.model.environment import EnvironmentModel
from radar_service.scene_file.model.radar import RadarModel, antenna_pattern
from radar_service.scene_file.model.seaway import SeawayModel
from radar_service.stages.fields import record_of
from radar_service.stages.registry import effect_records, environment_values
from radar_service.world import (
    NO_STREAM,
    PEAK_PERIOD,
    PERIOD_HEIGHT,
    Environment,
    Fading,
    Presence,
    SceneError,
    Seaway,
    Stream,
    gas_attenuation_db_per_km,
    significant_wave_height,
)


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
