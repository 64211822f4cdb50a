"""How a scene is computed: one small frozen record, and its presets by name."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Fidelity:
    """What is modelled, and how finely.

    chain: "documented" computes the specification's equations as printed; "corrected" is the engine of scatterers and grids.
    tracer: how the documented rays find triangles.
    sampler: how the corrected chain finds diffuse surfaces: scatterers on them, or rays from the antenna (uniform random,
        stratified, Sobol'), which are the independent check.
    scatterers_per_cell: points on extended surfaces per resolution cell (range bin x beamwidth).
    kernel_width: range bins that an echo is laid on (Kaiser-Bessel); 4 errs by -61 dB at 75 MSPS, 6 by -80.
    bounces: surfaces that physical optics follows in a row, 1 for none but the first.
    beam_extent: reach of the beam for moving echoes, beamwidths each side (echoes at rest always see the full circle).
    """

    name: str
    chain: Literal["documented", "corrected"] = "corrected"
    tracer: Literal["embree", "moller_trumbore"] = "embree"
    sampler: Literal["scatterers", "rays", "stratified", "sobol"] = "scatterers"
    scatterers_per_cell: float = 4.0
    bounces: int = 3
    kernel_width: int = 6
    beam_extent: float = 12.0


PRESETS: dict[str, Fidelity] = {
    "documented": Fidelity("documented", chain="documented"),
    "balanced": Fidelity("balanced"),
}


def fidelity_from_name(name: str) -> Fidelity:
    """The preset of that name; `auto` means `balanced` until it is planned. Raises ValueError naming the presets."""
    if name == "auto":
        return PRESETS["balanced"]
    if name not in PRESETS:
        raise ValueError(f'fidelity: "{name}" is not one of auto, {", ".join(PRESETS)}')
    return PRESETS[name]
