"""The models of AIS in a scene file: of one transponder, and of what happens to all reports."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from radar_service.stages.fields import Bearing, Number, Section, Whole

MAX_PERIODS = 100
Text = Annotated[str, Field(strict=True, max_length=20, pattern=r"^[ -~]*$")]
Instant = Annotated[float, Field(strict=True, ge=0, le=1e9)]  # s of simulated time
Deck = Annotated[float, Field(strict=True, ge=-600, le=600)]  # m


class TransponderModel(Section):
    """What the AIS of a body says of it, beside its motion; it has one where it has an `mmsi`."""

    kind: Literal["ship", "aid", "sart"] = Field(
        "ship", description="aid: to navigation, message 21; sart: an active search and rescue transponder"
    )
    class_: Literal["A", "B-SO", "B-CS"] = Field(
        "A", alias="class", description="B-SO and B-CS: class B, by SOTDMA or by carrier sense"
    )
    name: Text | None = Field(None, description="default: that of the body, in capitals")
    call_sign: Annotated[str, Field(strict=True, max_length=7, pattern=r"^[ -~]*$")] = ""
    ship_type: Whole = Field(0, ge=0, le=99, description="70: cargo, 80: tanker, 60: passenger, 30: fishing, 0: not known")
    aid_type: Whole = Field(0, ge=0, le=31, description="of an aid; 1: reference point, 24: port hand mark, 0: not known")
    imo: Whole = Field(0, ge=0, le=999_999_999)
    destination: Text = ""
    length_m: Annotated[float, Field(strict=True, ge=0, le=1022)] | None = Field(
        None, description="default: that of the body"
    )
    beam_m: Annotated[float, Field(strict=True, ge=0, le=126)] | None = Field(None, description="default: that of the body")
    antenna_m: tuple[Deck, Deck] = Field(
        (0.0, 0.0), description="where its position is: starboard and forward of the middle of its length and beam"
    )
    off_s: tuple[tuple[Instant, Instant], ...] = Field(
        (), max_length=MAX_PERIODS, description="periods without reports, from and to"
    )
    heading_error_deg: Bearing = Field(0.0, description="added to the heading that it reports")

    def problems(self) -> Iterator[str]:
        for k, (start, end) in enumerate(self.off_s):
            if end <= start:
                yield f"off_s[{k}]: {end:g} is not after {start:g}; exchange them"


class AisModel(Section):
    """What happens on purpose to the AIS reports of all bodies; own ship's own are exact."""

    latency_s: Number = Field(0.0, ge=0, le=60, description="from the second of a report to its sentence, beside the slot")
    loss_percent: Number = Field(0.0, ge=0, le=100, description="of messages, drawn by the seed")
    position_error_m: Number = Field(
        0.0, ge=0, le=10_000, description="standard deviation, east and north each, drawn by the seed"
    )
