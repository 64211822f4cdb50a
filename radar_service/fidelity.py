"""How a scene is computed: one small frozen record, and its presets by name."""

from dataclasses import dataclass
from math import inf
from typing import Literal

MIN_SCATTERERS = (
    48  # points on the smallest surface, so that its speckle is that of many (sum of 48 phasors: kurtosis within 2 %)
)


@dataclass(frozen=True)
class Fidelity:
    """What is modelled, and how finely.

    engine: "documented" computes the specification's equations as printed; "corrected" is the engine of scatterers and grids.
    tracer: how the documented rays find triangles.
    sampler: how the corrected engine finds diffuse surfaces: scatterers on them, or rays from the antenna (uniform random,
        stratified, Sobol'), which are the independent check.
    scatterers_per_cell: points on extended surfaces per resolution cell (range bin x beamwidth).
    min_scatterers: points on the smallest extended surface.
    bounces: surfaces that physical optics follows in a row, 1 for none but the first.
    kernel_width: range bins that an echo is spread on (Kaiser-Bessel, even); 4 errs by -61 dB at 75 MSPS, 6 by -80.
    beam_kernel_width: azimuth rows that an echo at rest is spread on (even); 4 errs by -83 dB, 6 by less than float32.
    beam_extent: reach of the beam for moving echoes, beamwidths each side (echoes at rest always see the full circle); 3
        errs by -40 dB, 12 by -56.
    azimuths_per_block: azimuths over which moving echoes follow one parabola, with the multipath of the middle one; 16 errs
        by -71 dB, 1 takes each azimuth at its own instant.
    visibility_step: m that anything may move before visibility and scattering are renewed.
    beam_table_oversampling: times the usual number of entries in the table of the beam; 1 errs by -78 dB, 8 by -88.
    error_db: what may be left out: whatever moves the power of targets by less than this [dB]; 0 leaves out nothing.
    """

    name: str
    engine: Literal["documented", "corrected"] = "corrected"
    tracer: Literal["embree", "moller_trumbore"] = "embree"
    sampler: Literal["scatterers", "rays", "stratified", "sobol"] = "scatterers"
    scatterers_per_cell: float = 4.0
    min_scatterers: int = MIN_SCATTERERS
    bounces: int = 3
    kernel_width: int = 6
    beam_kernel_width: int = 4
    beam_extent: float = 12.0
    azimuths_per_block: int = 16
    visibility_step: float = 5.0
    beam_table_oversampling: int = 1
    error_db: float = 0.0


PRESETS: dict[str, Fidelity] = {
    "documented": Fidelity("documented", engine="documented"),
    "fast": Fidelity("fast", scatterers_per_cell=1.0, bounces=2, kernel_width=4, beam_extent=3.0, visibility_step=20.0),
    "balanced": Fidelity("balanced"),
    "reference": Fidelity(
        "reference", scatterers_per_cell=16.0, kernel_width=8, beam_kernel_width=6, beam_extent=inf, azimuths_per_block=1,
        visibility_step=1.0, beam_table_oversampling=8,
    ),
}  # fmt: skip

# What each preset is for, with the relative field error of points against the closed form (tests/test_fidelity.py holds it)
PURPOSE: dict[str, str] = {
    "documented": "the specification exactly as printed, its mistakes included",
    "fast": "points to -61 dB at rest, -40 dB moving; one scatterer to a cell",
    "balanced": "points to -83 dB at rest, -56 dB moving; four scatterers to a cell",
    "reference": "points to -89 dB at rest, -87 dB moving, each azimuth by itself; sixteen scatterers to a cell; slow",
}


def fidelity_from_name(name: str) -> Fidelity:
    """The preset of that name. Raises ValueError naming the presets, and `auto`, which is planned for each scene."""
    if name not in PRESETS:
        raise ValueError(f'fidelity: "{name}" is not one of auto, {", ".join(PRESETS)}')
    return PRESETS[name]
