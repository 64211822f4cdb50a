"""The fidelity of a simulation: how finely a scene is computed, and the presets by name."""

from dataclasses import dataclass
from math import inf
from typing import Literal

MIN_SCATTERERS = 48  # on the smallest surface: the speckle of 48 phasors has the limit's kurtosis within 2 %


@dataclass(frozen=True)
class Fidelity:
    """What is modelled, and how finely.

    name: of the preset, or of the plan.
    engine: "documented" computes the equations of the specification as printed; "corrected" is the engine of scatterers and
        grids.
    tracer: ray tracer of the documented engine.
    sampler: how the corrected engine samples diffuse surfaces: by scatterers on them, or by rays from the antenna (uniform
        random, stratified, Sobol'), which are the independent check.
    scatterers_per_cell: on extended surfaces, per resolution cell (range bin x beamwidth).
    min_scatterers: on the smallest extended surface.
    bounces: maximum number of reflections in physical optics; 1 is the first surface alone.
    kernel_width: range bins of the gridding kernel (Kaiser-Bessel, even); 4 errs by -61 dB at 75 MSPS, 6 by -80.
    beam_kernel_width: azimuth rows of the gridding kernel for resting echoes (even); 4 errs by -83 dB, 6 by less than float32.
    beam_extent: of the beam for moving echoes, beamwidths each side; 3 errs by -40 dB, 12 by -56. Resting echoes always have
        the full circle.
    azimuths_per_block: azimuths over which range histories of moving echoes are interpolated, by the sea too; 16 errs by -71
        dB, 1 computes each azimuth at its own time. Where there are few echoes and none is near, a longer block keeps the limits.
    held_false_echoes: whether indirect echoes of metal have the aspect of the beam's crossing, in cells; else aspects are as
        close as on boresight.
    visibility_step: relative motion [m] after which line of sight and scattering are computed again.
    beam_table_oversampling: of the table of the beam; 1 errs by -78 dB, 8 by -88.
    error_db: bodies and effects that change target power by less than this may be culled [dB]; 0 culls nothing.
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
    held_false_echoes: bool = True
    visibility_step: float = 5.0
    beam_table_oversampling: int = 1
    error_db: float = 0.0


PRESETS: dict[str, Fidelity] = {
    "documented": Fidelity("documented", engine="documented"),
    "fast": Fidelity("fast", scatterers_per_cell=1.0, bounces=2, kernel_width=4, beam_extent=3.0, visibility_step=20.0),
    "balanced": Fidelity("balanced"),
    "reference": Fidelity(
        "reference", scatterers_per_cell=16.0, kernel_width=8, beam_kernel_width=6, beam_extent=inf, azimuths_per_block=1,
        held_false_echoes=False, visibility_step=1.0, beam_table_oversampling=8,
    ),
}  # fmt: skip

# The purpose of each preset, with the relative field error of points against the closed form (tests/test_presets.py)
PURPOSE: dict[str, str] = {
    "documented": "the specification exactly as printed, with its mistakes",
    "fast": "points to -61 dB at rest, -40 dB moving; one scatterer per cell",
    "balanced": "points to -83 dB at rest, -56 dB moving; four scatterers per cell",
    "reference": "points to -89 dB at rest, -87 dB moving, each azimuth by itself; sixteen scatterers per cell; slow",
}


def fidelity_from_name(name: str) -> Fidelity:
    """The preset of that name. Raises ValueError that lists the presets, and `auto`, which is planned for each scene."""
    if name not in PRESETS:
        raise ValueError(f'fidelity: "{name}" is not one of auto, {", ".join(PRESETS)}')
    return PRESETS[name]
