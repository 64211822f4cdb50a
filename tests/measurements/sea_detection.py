"""Detection in sea clutter as radar manuals print it, against the law of this package: which cause moves it, one at a time.

The laws alone, without a simulation: mean sigma0, its wind factor and the K distribution, an ideal threshold at Pfa 1e-4, in one
look but where a column integrates over the beam.

Run with `python -m tests.measurements.sea_detection`. The table is of JRC JMA-932B, p. 6-6, as in JMR-7230 and JMA-9110.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq
from scipy.special import gammaincc
from scipy.stats import gamma, ncx2

from radar_service.plots.false_alarms import effective_looks
from radar_service.scene_file.load import load_scene
from radar_service.stages.clutter.sea import mean_sigma0, speckle_time, swell_factor, texture_shape, wind_factor
from radar_service.world.seaway import sea_state_of

PFA, ANTENNA, DRAWS = 1e-4, 15.0, 4000
HEIGHTS = np.array([0.0, 0.6, 0.9, 1.2, 2.0, 3.0, 4.0])  # m, by the manuals' sea states 0 to 6
BANDS = {"X": (9.41e9, 1.0, 0.7), "S": (3.05e9, 1.9, 0.4)}  # Hz, beamwidth [degrees], range [NM]: 23 and 25 m across
LENGTH = 12.0  # m of range cell: a short pulse of 80 ns
PRINTED = {
    ("X", 5.0): ("V", "V-M", "M-NV", "NV"), ("X", 10.0): ("V", "V", "V", "V-M"), ("S", 0.5): ("V", "V", "V-M", "M-NV"),
}  # fmt: skip
EDGES = {"V": (0.8, 1.0), "V-M": (0.5, 1.0), "M-NV": (0.0, 0.8), "NV": (0.0, 0.5)}


@dataclass(frozen=True)
class Causes:
    """What a column of the study assumes.

    state: of the law, by the manuals' state. direction: off the wind [rad]; None: the mean. shape_factor: on Ward's shape.
    spikes: share and power of a second component. swerling: 0 or 1. loss_db: of a threshold. looks: independent ones of the
    sea, in a band.
    """

    state: Callable[[float], float] = lambda printed: printed
    direction: float | None = None
    shape_factor: float = 1.0
    spikes: tuple[float, float] = (0.0, 1.0)
    swerling: int = 1
    loss_db: float = 0.0
    looks: Callable[[str], float] = lambda band: 1.0


def by_height(printed: float) -> float:
    """The state that is as high as the manuals' state."""
    return sea_state_of(float(np.interp(printed, np.arange(len(HEIGHTS)), HEIGHTS)))


def in_the_beam(band: str, rests: bool = False) -> float:
    """Looks in the half-power beam at 24 rpm, of a sea that changes as the beam passes, or rests."""
    frequency, beamwidth, _ = BANDS[band]
    radar = load_scene({"radar": {"frequency_hz": frequency, "beamwidth_deg": beamwidth, "azimuths": 4096, "rpm": 24}}).radar
    spokes = int(radar.beamwidth / radar.azimuth_step)
    at_rest = effective_looks(radar, spokes)
    changes = radar.rotation_period * spokes / radar.azimuths / speckle_time(radar.wavelength)
    return at_rest if rests else float(np.hypot(at_rest, changes))


def detection(band: str, rcs: float, printed: float, causes: Causes) -> float:
    """Pd of a point at the band's range in a sea of the manuals' state."""
    frequency, beamwidth, miles = BANDS[band]
    distance = miles * 1852.0
    grazing, area = np.arcsin(ANTENNA / distance), distance * np.radians(beamwidth) / np.sqrt(2.0) * LENGTH
    sigma0 = float(mean_sigma0(np.array(grazing), frequency, causes.state(printed), "h"))
    if causes.direction is not None:
        sigma0 *= float(wind_factor(np.array(causes.direction), np.array(grazing), 3e8 / frequency))
    shape = float(texture_shape(np.array(grazing), np.array(area), "h")) * causes.shape_factor
    share, power = causes.spikes
    texture = gamma.ppf((np.arange(DRAWS) + 0.5) / DRAWS, shape, scale=1.0 / shape)
    far = gamma.isf(np.geomspace(0.5 / DRAWS, 1e-9, 400), shape, scale=1.0 / shape)  # its tail, finer
    weight = np.append(np.full(DRAWS - 1, 1.0 / DRAWS), -np.diff(np.append(np.geomspace(1.0 / DRAWS, 1e-9, 401), 0.0))[:-1])
    local = np.maximum(np.append(texture[:-1], far), 1e-12)
    mixed, weights = np.append(local, local * power), np.append(weight * (1.0 - share), weight * share)
    mixed /= np.sum(mixed * weights)
    looks = causes.looks(band)
    threshold = brentq(lambda t: np.sum(weights * gammaincc(looks, looks * t / mixed)) - PFA, 0.1, 1e5)
    threshold *= 10.0 ** (causes.loss_db / 10.0)
    signal = rcs / (sigma0 * area)
    if looks > 1.0:  # the target rests in the beam
        powers = -np.log((np.arange(40) + 0.5) / 40)[:, None] * signal if causes.swerling else np.array([[signal]])
        seen = ncx2.sf(2.0 * looks * threshold / mixed, 2.0 * looks, 2.0 * looks * powers / mixed)
        return float(np.mean(np.sum(weights * seen, axis=1)))
    if causes.swerling == 1:
        return float(np.sum(weights * np.exp(-threshold / (mixed + signal))))
    return float(np.sum(weights * ncx2.sf(2.0 * threshold / mixed, 2.0, 2.0 * signal / mixed)))


def table(causes: Causes) -> tuple[int, list[str]]:
    """How many cells are in class, and a line for each printed row: class, Pd, + where the law is too easy, - where too hard."""
    lines, inside = [], 0
    for (band, rcs), classes in PRINTED.items():
        cells = []
        for k, printed in enumerate(classes):
            pd = detection(band, rcs, 1.5 + k, causes)
            low, high = EDGES[printed]
            inside += low <= pd <= high
            cells.append(f"{printed:>5} {pd:.2f}{' ' if low <= pd <= high else '+' if pd > high else '-'}")
        lines.append(f"  {band} {rcs:4.1f} m2 " + " ".join(cells))
    return inside, lines


def main() -> None:
    """Prints the columns, each with one cause changed."""
    now = Causes()
    high = replace(now, state=by_height)
    up = replace(high, direction=0.0)
    studies = {
        "state by its number, mean over directions, a steady target": replace(now, swerling=0),
        "state by its number, mean over directions, Swerling 1 (from here on)": now,
        "state by wave height (from here on)": high,
        "downwind": replace(high, direction=np.pi),
        "upwind (from here on)": up,
        "loss of the extractor, 1 dB": replace(up, loss_db=1.0),
        "integrated over the beam, speckle at rest": replace(up, looks=lambda band: in_the_beam(band, rests=True)),
        "integrated over the beam, speckle that changes in 7 ms": replace(up, looks=in_the_beam),
        "the same with swell along the line of sight": replace(
            up, looks=in_the_beam, shape_factor=float(swell_factor(np.zeros(1))[0])
        ),
        "swell along the line of sight, 10^(-1/3) on Ward's shape": replace(
            up, shape_factor=float(swell_factor(np.zeros(1))[0])
        ),
        "swell across": replace(up, shape_factor=float(swell_factor(np.full(1, np.pi / 2))[0])),
        "Ward's shape as in his cells of 4.2 m, and not extrapolated to 23 m": replace(
            up, shape_factor=(4.2 / 23.0) ** 0.625
        ),
        "1 % of cells with spikes of 10 dB": replace(up, spikes=(0.01, 10.0)),
    }
    for name, causes in studies.items():
        inside, lines = table(causes)
        print(f"{name}: {inside} of 12 in class")
        print("\n".join(lines))


if __name__ == "__main__":
    main()
