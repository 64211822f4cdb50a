"""The models of own ship's structures near an antenna, and of echoes that she throws back; the check of where they stand."""

import math
from collections.abc import Sequence
from typing import Annotated

from pydantic import Field

from radar_service.radar.patterns import PATTERNS, line_source
from radar_service.radar.structures import Aperture
from radar_service.stages.fields import Bearing, Number, Section

MAX_DISTANCE = 300.0  # m: the longest ships are 400 m


class StructureModel(Section):
    """A mast, a funnel or a post of own ship near the antenna: an upright opaque cylinder."""

    name: Annotated[str, Field(strict=True, min_length=1, max_length=64)] = "structure"
    bearing_deg: Bearing = Field(description="of its middle from the antenna, clockwise from the bow")
    distance_m: Annotated[float, Field(strict=True, gt=0, le=MAX_DISTANCE)] = Field(
        description="from the middle of the antenna to its middle"
    )
    width_m: Annotated[float, Field(strict=True, ge=0.01, le=50)] = Field(description="its diameter")
    top_m: Annotated[float, Field(strict=True, ge=-50, le=100)] | None = Field(
        None, description="of its top over the middle of the antenna; default: far above the beam"
    )
    reflection: Number = Field(
        1.0, ge=0, le=1, description="of the field at its side: 1 metal, 0 absorber; of indirect echoes"
    )


class MultipleEchoesModel(Section):
    """Echoes between own ship and ships near by, at two and more times their range."""

    own_rcs_dbsm: Number = Field(ge=-20, le=80, description="of own ship, towards the other one")
    range_m: Annotated[float, Field(strict=True, gt=0, le=20_000)] = Field(
        2000.0, description="ships within it have such echoes"
    )
    orders: Annotated[int, Field(strict=True, ge=1, le=4)] = Field(
        2, description="how many: 1 is a second trace at twice the range, 2 a third one too"
    )


def check_structures(structures: Sequence[StructureModel], aperture: Aperture | None, pattern: str) -> None:
    """Raises ValueError where the antenna has no aperture of a known illumination, strikes a structure, or two overlap."""
    if not structures:
        return
    if aperture is None:
        known = ", ".join(f'"{name}"' for name, each in PATTERNS.items() if line_source(each) is not None)
        raise ValueError(
            f"structure: pattern {pattern} has no aperture that a structure could stand before; set pattern to {known}"
        )
    for k, structure in enumerate(structures):
        nearest = 0.5 * (aperture.length + structure.width_m)
        if structure.distance_m <= nearest:
            raise ValueError(
                f"structure[{k}].distance_m: {structure.distance_m:g} m; the antenna of {aperture.length:.3g} m would strike the "
                f"structure within {nearest:.3g} m: move it farther off, up to {MAX_DISTANCE:g} m, or make it thinner"
            )
        for n, other in enumerate(structures[:k]):
            between = abs((structure.bearing_deg - other.bearing_deg + 180.0) % 360.0 - 180.0)
            both = sum(math.degrees(math.asin(0.5 * each.width_m / each.distance_m)) for each in (structure, other))
            if between < both:
                raise ValueError(
                    f"structure[{k}].bearing_deg: {structure.bearing_deg:g} is {between:.3g} degrees from structure[{n}]; seen "
                    f"from the antenna they overlap below {both:.3g} degrees: move one, or describe both as one"
                )
