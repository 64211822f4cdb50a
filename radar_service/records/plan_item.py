"""One line of a plan."""

from dataclasses import dataclass


@dataclass(frozen=True)
class PlanItem:
    """One body or effect that could be modelled.

    what: its name.
    modelled: whether it is modelled.
    how: how, or why not.
    power_db: predicted error of target power from it [dB]; None where it does not apply.
    field_db: predicted relative field error [dB]; None where it does not apply.
    microseconds: CPU time per azimuth on this machine [us]; None where unknown.
    """

    what: str
    modelled: bool
    how: str
    power_db: float | None = None
    field_db: float | None = None
    microseconds: float | None = None

    def price(self) -> str:
        """Error and cost as text, "" where neither is known."""
        parts = []
        if self.power_db is not None:
            parts.append(f"{self.power_db:.2g} dB")
        if self.field_db is not None:
            parts.append(f"field {self.field_db:.0f} dB")
        if self.microseconds is not None:
            parts.append(f"{self.microseconds:.3g} us")
        return ", ".join(parts)
