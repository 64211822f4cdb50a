"""The model of the radar in a scene file, and checks of settings that the physics cannot compute together."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, ModelWrapValidatorHandler, model_validator

from radar_service.numerics import SPEED_OF_LIGHT
from radar_service.radar import PATTERNS, AntennaPattern, Table, Taylor, grid_rows, max_rpm, radar_sets
from radar_service.scene_file.model.errors import RadarErrorsModel
from radar_service.stages.fields import Bearing, Flag, Number, Section, Whole
from radar_service.stages.registry import effects, given_keys

MAX_AZIMUTHS = 16_384  # twice the finest marine radar (8192 spokes)
MAX_BINS = 65_536  # 64 NM at 0.9 m
MAX_CELLS = 2**26  # azimuths x bins: one scan of complex64 is then 512 MiB
MAX_GRID = 2**27  # cells of the grid of a scan, 24 bytes each: 3 GB
MAX_PULSE_SAMPLES = 2**18  # pulse x sample rate
EDGELESS = ("hann", "blackman", "blackman-harris", "nuttall")  # windows that end at zero, to 6e-5 of their middle
MAX_NONLINEAR_PRODUCT = 20_000  # bandwidth x pulse: the spectrum then has 1.3 million samples
MIN_CHIRP_PRODUCT = 4  # bandwidth x pulse: below, the edges of the chirp make its spectrum twice as wide as the band
RECEIVER_PRODUCTS = (0.25, 20)  # bandwidth x pulse of a plain pulse: at these limits 3 and 13 dB of signal to noise are lost
MIN_TABLE_STEP_DEG = 1e-6  # between rows of a pattern's table: the slope of its curve stays finite


class WaveformModel(Section):
    """A pulse and the filter that compresses it."""

    modulation: Literal["lfm", "nlfm", "none"] = Field(
        "lfm",
        description='"nlfm": a nonlinear chirp, whose power spectrum is the window; "none": a plain pulse, as of a magnetron',
    )
    bandwidth_hz: Number | None = Field(
        None, ge=1e5, le=2e9, description='default 50e6; with modulation = "none" the receiver\'s, default 1.2 / pulse_s'
    )
    pulse_s: Number = Field(10e-6, ge=1e-8, le=1e-3)
    window: Literal["none", "hamming", "hann", "blackman", "blackman-harris", "nuttall", "taylor"] = Field(
        "hamming", description='on the reference of the chirp; with "nlfm" or "inverse" on the spectrum'
    )
    compression: Literal["matched", "inverse"] = Field(
        "matched",
        description='of a chirp; "inverse": by a filter that leaves the range sidelobes of the window alone',
    )

    @property
    def band_hz(self) -> float:
        """The bandwidth [Hz], given or by default; 1.2 / T is usual for the receiver of a plain pulse (Skolnik 2001)."""
        if self.bandwidth_hz is not None:
            return self.bandwidth_hz
        return 1.2 / self.pulse_s if self.modulation == "none" else 50e6


class PulseModel(WaveformModel):
    """One of several pulses, each of which serves the ranges from the end of the one before."""

    range_max_m: Number | None = Field(
        None,
        ge=10,
        le=200_000,
        description="end of the ranges that it serves; of the last pulse that of the radar, left out",
    )


WAVEFORM_KEYS = tuple(WaveformModel.model_fields)
OF_A_SCALE = {*WAVEFORM_KEYS, "pulses", "sample_rate_hz", "prf_hz", "integration"}  # keys that belong to a set

if TYPE_CHECKING:
    PatternName = str
    SetName = str
else:
    PatternName = Literal[tuple(PATTERNS)]
    SetName = Literal[tuple(radar_sets())]
PatternTable = tuple[tuple[Number, Number], ...]


class RadarModel(WaveformModel):
    """The radar: waveform, scan, antenna, receiver."""

    set: SetName | None = Field(
        None,
        description="a set that is sold, docs/sets.md: its keys on the scale range_max_m, 11112 by default; other keys replace "
        "its own, but for those of the pulse",
    )
    frequency_hz: Number = Field(9.41e9, ge=1e9, le=100e9)
    sample_rate_hz: Number | None = Field(None, ge=1e5, le=4e9, description="complex; default 1.5 x bandwidth")
    pulses: tuple[PulseModel, ...] = Field(
        (), max_length=4, description="instead of a single pulse: several, the shortest first, each for its own ranges"
    )
    prf_hz: Number | None = Field(None, ge=10, le=1e6, description="pulses per second; default: no limit on range")
    second_time_around: Flag = Field(False, description="echoes from beyond Ru = c / (2 prf_hz) are received at R - n Ru")
    integration: Flag = Field(
        False, description="noncoherent, of the pulses of a spoke: prf_hz x 60 / (rpm x azimuths) of them"
    )
    azimuths: Whole = Field(720, ge=4, le=MAX_AZIMUTHS, description="spokes per scan")
    rpm: Number = Field(24.0, ge=0.01, le=600)
    range_max_m: Number = Field(5000.0, ge=10, le=200_000)
    range_min_m: Number = Field(1.0, gt=0, le=1000, description="echoes from nearer are computed at this range")
    beamwidth_deg: Number = Field(3.9, ge=0.05, le=90, description="horizontal, one-way, half power")
    beamwidth_el_deg: Number = Field(25.0, ge=0.05, le=180, description="vertical, one-way, half power")
    tilt_deg: Number = Field(0.0, ge=-45, le=45)
    coarse_azimuths: Flag = Field(False, description="allow a beam narrower than the step between spokes")
    pattern: PatternName | PatternTable = Field(
        "sinc2",
        description="or a table of (offset in degrees, one-way gain in dB), symmetric about 0 and joined by a smooth curve, "
        "for the horizontal",
    )
    pattern_el: PatternName | PatternTable | None = Field(
        None, description="the vertical one; a table is about tilt_deg; default: as pattern, sinc2 where that is a table"
    )
    taylor_sidelobe_db: Number = Field(30.0, ge=15, le=60, description='of pattern = "taylor": sidelobes below the peak')
    taylor_nbar: Whole = Field(4, ge=2, le=20, description='of pattern = "taylor": one more than its equal sidelobes')
    height_m: Number = Field(15.0, gt=0, le=5000, description="antenna above the sea")
    power_w: Number = Field(25e3, gt=0, le=1e9)
    gain_dbi: Number = Field(30.0, ge=-20, le=80)
    loss_db: Number = Field(0.0, ge=0, le=60)
    noise_figure_db: Number = Field(4.0, ge=0, le=40)
    polarization: Literal["h", "v"] = "h"
    eclipsing: Flag = Field(False, description="a radar with one antenna cannot receive while it transmits")
    rays: Whole = Field(
        2000, ge=1, le=1_000_000, description="per azimuth, of the documented fidelity and of the ray samplers"
    )
    blind_sectors_deg: tuple[tuple[Bearing, Bearing], ...] = Field(
        (),
        max_length=16,
        description="no transmission between these angles, clockwise from the bow; [0, 360] is the full circle",
    )
    errors: RadarErrorsModel | None = Field(None, description="of its antenna and its feed, on purpose")
    labels_within_db: Literal["none"] | Annotated[float, Field(strict=True, gt=0, le=200)] = Field(
        30.0,
        description='labels name a body down to this level below its peak in the spoke; "none": down to any',
    )

    @property
    def sampling_hz(self) -> float:
        """The complex sampling rate [Hz], given or by default."""
        return self.sample_rate_hz if self.sample_rate_hz is not None else 1.5 * self.band_hz

    @property
    def bins(self) -> int:
        """Range bins of a spoke."""
        return math.ceil(self.range_max_m / (SPEED_OF_LIGHT / (2.0 * self.sampling_hz)) - 1e-9)

    @model_validator(mode="wrap")
    @classmethod
    def _with_set(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Adds the keys of a set at its scale, which do not count as given."""
        known = radar_sets().get(str(data.get("set"))) if isinstance(data, Mapping) else None
        if known is None:
            return handler(data)
        if pulse := sorted(OF_A_SCALE.intersection(data)):
            value = str(data[pulse[0]])[:60]
            raise ValueError(f'{pulse[0]}: {value} beside set "{known.name}", which has its own: remove one of the two')
        scale = data.get("range_max_m")
        try:
            keys = known.scales[known.scale(scale if isinstance(scale, int | float) else None)]
        except ValueError as error:
            raise ValueError(f"range_max_m: {error}") from None
        model = handler({**keys, **data})
        model.model_fields_set.intersection_update(data)
        return model

    @model_validator(mode="after")
    def _check_radar(self) -> Self:
        for name in ("pattern", "pattern_el"):
            table = getattr(self, name)
            if isinstance(table, tuple):
                _check_table(name, table)
        _check_pulses(self)
        for k, radar in enumerate(self.of_each_pulse()):
            try:
                for check in CHECKS:
                    check(radar)
            except ValueError as error:
                named = str(error).split(":")[0] in PulseModel.model_fields and self.pulses
                raise ValueError(f"pulses[{k}].{error}" if named else str(error)) from error
        return self

    def of_each_pulse(self) -> list["RadarModel"]:
        """A radar for each pulse, as if it had that one alone out to the end of its ranges; all have the same sampling."""
        if not self.pulses:
            return [self]
        rate = self.sample_rate_hz or 1.5 * max(pulse.band_hz for pulse in self.pulses)
        given = [{key: getattr(pulse, key) for key in pulse.model_fields_set} for pulse in self.pulses]
        given[-1].setdefault("range_max_m", self.range_max_m)
        return [self.model_copy(update={**keys, "sample_rate_hz": rate, "pulses": ()}) for keys in given]


def antenna_pattern(pattern: PatternName | PatternTable, radar: RadarModel) -> AntennaPattern:
    """Returns the pattern in radians and power ratios; "taylor" has the Taylor parameters of the radar."""
    if isinstance(pattern, tuple):
        return Table(tuple((math.radians(offset_deg), 10.0 ** (gain_db / 10.0)) for offset_deg, gain_db in pattern))
    return Taylor(radar.taylor_sidelobe_db, radar.taylor_nbar) if pattern == "taylor" else PATTERNS[pattern]


def _check_pulses(radar: RadarModel) -> None:
    if not radar.pulses:
        return
    if own := sorted(radar.model_fields_set.intersection(WAVEFORM_KEYS)):
        raise ValueError(f"{own[0]}: with pulses, each pulse has its own: move it into pulses, or remove pulses")
    ends = [pulse.range_max_m for pulse in radar.pulses]
    if ends[-1] is not None:
        raise ValueError(f"pulses[{len(ends) - 1}].range_max_m: the last pulse serves all farther ranges: remove it")
    last = 0.0
    for k, end in enumerate(ends[:-1]):
        if end is None or not last < end < radar.range_max_m:
            raise ValueError(
                f"pulses[{k}].range_max_m: {'it is missing' if end is None else f'{end:g} m'}; the ends rise strictly, from "
                f"above {last:g} m to below range_max_m, {radar.range_max_m:g} m: correct it"
            )
        last = end


def _check_sampling(radar: RadarModel) -> None:
    if radar.sampling_hz < radar.band_hz:
        raise ValueError(
            f"sample_rate_hz: {radar.sampling_hz:g} is below the bandwidth; complex sampling needs at least "
            f"{radar.band_hz:g} Hz: raise sample_rate_hz or lower bandwidth_hz"
        )


def _check_sizes(radar: RadarModel) -> None:
    if not 1 <= radar.bins <= MAX_BINS:
        raise ValueError(
            f"range_max_m: {radar.range_max_m:g} m at {radar.sampling_hz:g} samples/s gives {radar.bins} range bins; "
            f"at most {MAX_BINS} are allowed: lower range_max_m or sample_rate_hz"
        )
    if radar.bins * radar.azimuths > MAX_CELLS:
        raise ValueError(
            f"azimuths: {radar.azimuths} x {radar.bins} range bins are {radar.azimuths * radar.bins} cells; at most "
            f"{MAX_CELLS} are allowed: lower azimuths, range_max_m or sample_rate_hz"
        )
    if radar.pulse_s * radar.sampling_hz > MAX_PULSE_SAMPLES:
        raise ValueError(
            f"pulse_s: {radar.pulse_s:g} s at {radar.sampling_hz:g} samples/s are "
            f"{radar.pulse_s * radar.sampling_hz:.0f} samples; at most {MAX_PULSE_SAMPLES} are allowed: shorten the pulse"
        )


def _check_waveform(radar: RadarModel) -> None:
    product = radar.band_hz * radar.pulse_s
    if radar.modulation != "none":
        if radar.compression == "inverse" and radar.window not in EDGELESS:
            raise ValueError(
                f'compression: "inverse" with window "{radar.window}" leaves sidelobes along the whole profile, as that jumps '
                f'at the edges of the band; set window to one of {", ".join(EDGELESS)}, or compression to "matched"'
            )
        if radar.modulation == "nlfm" and product > MAX_NONLINEAR_PRODUCT:
            raise ValueError(
                f"pulse_s: bandwidth x pulse is {product:.3g}; a nonlinear chirp has at most {MAX_NONLINEAR_PRODUCT}: shorten "
                'the pulse, narrow bandwidth_hz, or set modulation = "lfm"'
            )
        if product < MIN_CHIRP_PRODUCT:
            raise ValueError(
                f"pulse_s: bandwidth x pulse is {product:.3g}; a chirp needs at least {MIN_CHIRP_PRODUCT}: lengthen the pulse, "
                'widen bandwidth_hz, or set modulation = "none"'
            )
        return
    low, high = RECEIVER_PRODUCTS
    if not low <= product <= high:
        raise ValueError(
            f"bandwidth_hz: {radar.band_hz:g} Hz x {radar.pulse_s:g} s is {product:.3g}; the receiver of a plain pulse has "
            f"{low} to {high}: leave bandwidth_hz out for 1.2 / pulse_s, or correct one of the two"
        )
    if "window" in radar.model_fields_set and radar.window != "none":
        raise ValueError(f'window: "{radar.window}" needs a chirp, and modulation = "none" has none; remove window')
    if radar.compression != "matched":
        raise ValueError(
            f'compression: "{radar.compression}" needs a chirp, and modulation = "none" has none; remove compression'
        )


def _check_repetition(radar: RadarModel) -> None:
    if radar.prf_hz is None:
        for key in ("second_time_around", "integration"):
            if getattr(radar, key):
                raise ValueError(f"{key}: it needs a pulse repetition frequency; add prf_hz")
        return
    interval = 1.0 / radar.prf_hz
    if radar.pulse_s >= interval:
        raise ValueError(
            f"pulse_s: {radar.pulse_s:g} s is not below the {interval:g} s from pulse to pulse; shorten it or lower prf_hz"
        )
    if radar.rpm > max_rpm(radar.prf_hz, radar.azimuths):
        spokes = radar.azimuths * radar.rpm / 60.0
        raise ValueError(
            f"prf_hz: {radar.prf_hz:g} is less than a pulse for each of the {spokes:g} spokes a second; raise it or lower "
            "azimuths or rpm"
        )
    unambiguous = SPEED_OF_LIGHT * interval / 2.0
    if radar.range_max_m > unambiguous and not radar.second_time_around:
        raise ValueError(
            f"range_max_m: {radar.range_max_m:g} m is beyond the {unambiguous:.0f} m from which echoes of {radar.prf_hz:g} "
            "pulses a second arrive in time; lower one of the two, or set second_time_around = true"
        )


def _check_beam(radar: RadarModel) -> None:
    pattern, nominal = antenna_pattern(radar.pattern, radar), math.radians(radar.beamwidth_deg)
    step_deg, width_deg = 360.0 / radar.azimuths, math.degrees(pattern.half_power_width(nominal))
    location = "pattern" if isinstance(radar.pattern, tuple) else "beamwidth_deg"
    if width_deg < step_deg * (1.0 - 1e-9) and not radar.coarse_azimuths:
        raise ValueError(
            f"{location}: {width_deg:g} degrees are narrower than the {step_deg:.4g} degrees from spoke to spoke, so "
            f"targets are missed; raise azimuths to {math.ceil(360 / width_deg)} or set coarse_azimuths = true"
        )
    rows = grid_rows(radar.azimuths, pattern.aperture_beamwidth(nominal))
    if rows * radar.bins > MAX_GRID:
        raise ValueError(
            f"{location}: {width_deg:g} degrees need a grid of {rows} rows x {radar.bins} range bins; at "
            f"most {MAX_GRID} cells are allowed: widen the beam, or lower range_max_m or sample_rate_hz"
        )


def _check_sectors(radar: RadarModel) -> None:
    for k, (start, stop) in enumerate(radar.blind_sectors_deg):
        if start == stop:
            raise ValueError(
                f"blind_sectors_deg[{k}]: [{start:g}, {stop:g}] is not allowed; two different angles from -360 to 360 degrees; "
                "remove the sector, or write [0, 360] for the full circle"
            )


def _check_effects(radar: RadarModel) -> None:
    antenna = antenna_pattern(radar.pattern, radar), math.radians(radar.beamwidth_deg), SPEED_OF_LIGHT / radar.frequency_hz
    for effect in effects():
        if given := given_keys(radar, effect.radar_keys):
            effect.check_radar(given, *antenna)


CHECKS = (
    _check_sampling, _check_sizes, _check_waveform, _check_repetition, _check_beam, _check_sectors, _check_effects,
)  # fmt: skip


def _check_table(name: str, table: tuple[tuple[float, float], ...]) -> None:
    if not 2 <= len(table) <= 10_000:
        raise ValueError(f"{name}: a table has 2 to 10000 rows of (degrees, dB), this one has {len(table)}: thin it")
    offsets = [row[0] for row in table]
    rises = all(b - a >= MIN_TABLE_STEP_DEG for a, b in zip(offsets, offsets[1:], strict=False))
    if offsets[0] != 0 or offsets[-1] > 180 or not rises:
        raise ValueError(
            f"{name}: the offsets start at 0 and rise strictly, by {MIN_TABLE_STEP_DEG:g} at least, to at most 180 degrees; "
            "sort the rows of the table"
        )
    if table[0][1] != 0 or max(row[1] for row in table) > 0:
        raise ValueError(f"{name}: gains are in dB below boresight: the first is 0, none is positive; subtract the largest")
