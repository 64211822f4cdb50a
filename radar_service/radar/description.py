"""Describes a radar in text: numbers that follow from its parameters."""

import math

import numpy as np

from radar_service.radar.parameters import Radar

APERTURE = 0.8859  # half-power beamwidth x aperture / wavelength, uniform aperture (Balanis 2016)
TWO_WAY_SINC2 = 0.7200  # two-way over one-way half-power width of a sinc^2 beam (docs/specification.md, errata row 2)


def two_way_beamwidth(radar: Radar) -> float | None:
    """Returns the two-way half-power beamwidth [rad] of the sinc^2 and Gaussian patterns; None for others."""
    ratios = {"sinc2": TWO_WAY_SINC2, "gaussian": math.sqrt(0.5)}
    ratio = ratios.get(radar.pattern.name)
    return None if ratio is None else ratio * radar.beamwidth


def far_field(radar: Radar) -> float:
    """Returns the far-field range [m]: 2 D^2 / lambda of a uniform aperture D that has the narrower beamwidth."""
    aperture = APERTURE * radar.wavelength / min(radar.beamwidth, radar.beamwidth_el)
    return 2.0 * aperture**2 / radar.wavelength


def _straddling(radar: Radar) -> str:
    """Returns text with the straddling loss half-way between spokes, if it exceeds 3 dB."""
    steps = radar.beamwidth / radar.azimuth_step
    if radar.pattern.name != "sinc2" or TWO_WAY_SINC2 * steps >= 1.0:
        return ""
    offset = APERTURE / (2.0 * steps)
    loss_db = -40.0 * math.log10(max(abs(np.sinc(offset)), 1e-6))
    return f"; half-way between spokes the loss is {loss_db:.1f} dB"


def radar_lines(radar: Radar) -> list[str]:
    """Returns lines of its derived numbers: waveform, ranges, scan and beam."""
    two_way = two_way_beamwidth(radar)
    beam = "" if two_way is None else f", two-way {math.degrees(two_way):.3f}"
    pattern = radar.pattern.description
    if radar.pattern_el != radar.pattern:
        pattern += f", vertical {radar.pattern_el.description}"
    rpm, rate = 60.0 / radar.rotation_period, 1.0 / radar.spoke_period
    step = math.degrees(radar.azimuth_step)
    width, height = math.degrees(radar.beamwidth), math.degrees(radar.beamwidth_el)
    return [
        f"radar       {radar.frequency / 1e9:.4g} GHz, wavelength {radar.wavelength * 1e3:.2f} mm, {radar.power / 1e3:g} kW",
        f"  pulse     {_pulse_text(radar)}",
        f"  range     to {radar.range_max:g} m in {radar.bins} bins of {radar.range_step:.4f} m",
        f"  resolves  {_resolution_text(radar)}",
        *(f"  nearer    to {near.range_max:g} m: {_pulse_text(near)}" for near in radar.of_each_pulse[:-1]),
        f"  scan      {radar.azimuths} spokes, {step:.4g} degrees, {rpm:g} rpm, {rate:.1f} spokes/s",
        f"  beam      {width:g} x {height:g} degrees one-way{beam} ({pattern}){_straddling(radar)}",
        f"  far field begins at {far_field(radar):.3g} m; near-field effects are not modelled",
    ]


def _pulse_text(radar: Radar) -> str:
    kind = "not modulated" if radar.modulation == "none" else _chirp_text(radar)
    rate = "" if radar.prf is None else f", {radar.prf:g} a second: unambiguous to {radar.unambiguous_range:.0f} m"
    folded = ", second-time-around echoes fold" if radar.second_time_around else ""
    eclipsed = f", eclipsed to {radar.blind_range:.0f} m" if radar.eclipsing else ""
    return f"{radar.pulse * 1e6:g} us, {radar.bandwidth / 1e6:g} MHz, {kind}{rate}{folded}{eclipsed}"


def _chirp_text(radar: Radar) -> str:
    nonlinear = "nonlinear chirp, " if radar.modulation == "nlfm" else ""
    inverse = ", compressed by the inverse filter" if radar.compression == "inverse" else ""
    return f"{nonlinear}product {radar.pulse * radar.bandwidth:.0f}{inverse}"


def _resolution_text(radar: Radar) -> str:
    if radar.modulation == "none":
        return f"{radar.blind_range:.3f} m, half the length of the pulse"
    return f"{radar.range_resolution:.3f} m before the window ({radar.window}) widens it"
