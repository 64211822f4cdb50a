"""One line of a plan."""

from dataclasses import dataclass


@dataclass(frozen=True)
class PlanItem:
    """One thing that could be modelled. Predicted, None where it does not apply: power_db, by how much the power of targets is
    wrong for it [dB]; field_db, its relative field error [dB]; microseconds of CPU time per azimuth on this machine."""

    what: str
    modelled: bool
    how: str  # how, or why not
    power_db: float | None = None
    field_db: float | None = None
    microseconds: float | None = None

    def price(self) -> str:
        """Error and cost as text, "" where neither is known."""
        said = []
        if self.power_db is not None:
            said.append(f"{self.power_db:.2g} dB")
        if self.field_db is not None:
            said.append(f"field {self.field_db:.0f} dB")
        if self.microseconds is not None:
            said.append(f"{self.microseconds:.3g} us")
        return ", ".join(said)
