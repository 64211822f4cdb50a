"""The radar key of own ship's structures, the check of where they stand, and what a radar keeps of them."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from radar_service.radar import PATTERNS, AntennaPattern, Aperture, aperture_of, line_source
from radar_service.stages.effect import Effect, Source
from radar_service.stages.fields import Bearing, Number, Section, record_of
from radar_service.stages.structures.structure import Structure

if TYPE_CHECKING:
    from radar_service.world import Scene

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


class StructureEffect(Effect):
    """Own ship's structures near the antenna, which shadow sectors and reflect: indirect echoes are false ones by their way."""

    name = "structures"
    stage_at = "radar_service.stages.structures.stage:StructureStage"
    radar_keys = {
        "structure": (
            tuple[StructureModel, ...],
            Field((), max_length=16, description="own ship's masts and funnels, which shadow sectors"),
        )
    }
    sources = (Source("indirect", "clutter", number=7, has_echoes=True),)

    def check_radar(self, given: Mapping[str, Any], pattern: AntennaPattern, beamwidth: float, wavelength: float) -> None:
        check_structures(given["structure"], aperture_of(pattern, beamwidth, wavelength), pattern.description)

    def radar_record(self, given: Mapping[str, Any]) -> tuple[Structure, ...] | None:
        return tuple(_structure(model) for model in given["structure"]) or None

    def sources_of(self, scene: "Scene") -> Sequence[Source]:
        structures: Sequence[Structure] = scene.radar.effects.get(self.name, ())
        return self.sources if any(each.reflection > 0.0 for each in structures) else ()


def _structure(model: StructureModel) -> Structure:
    """Returns a structure near the antenna in SI units."""
    top = math.inf if model.top_m is None else model.top_m
    return record_of(Structure, model, radius=0.5 * model.width_m, top=top)


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
