"""Reads the table of published figures, which stands beside this file and was fixed before any of them was computed."""

import re
from dataclasses import dataclass
from pathlib import Path

TABLE = Path(__file__).with_name("published.txt")
COLUMNS = ("id", "quantity", "condition", "published", "source", "tolerance", "kind", "seen")
KINDS = {"measured", "standard", "manual", "model"}
NOT_COUNTED = {  # rows that are shown but not counted, beside those of a model, those not checked and those without a number
    "G01": "arithmetic of the closest approach: no radar takes part",
}
NO_NUMBER = ("no number", "no ranges", "signs only")


class TableError(ValueError):
    """A row of the table of published figures that cannot be used. Its text names the row."""


@dataclass(frozen=True)
class Row:
    """One published figure, as printed.

    id: as N01; quantity, condition, published: what was published of what; source: document and page; tolerance: its width, and
    why; kind: measured, standard, manual or model; seen: S read in its source, F from files, R recalled; group: its heading.
    """

    id: str
    quantity: str
    condition: str
    published: str
    source: str
    tolerance: str
    kind: str
    seen: str
    group: str

    @property
    def uncounted(self) -> str | None:
        """Returns why the row is shown but not counted; None where it counts."""
        if self.id in NOT_COUNTED:
            return NOT_COUNTED[self.id]
        if self.kind == "model":
            return "a model or a fit, not a measurement"
        if self.seen == "R":
            return "recalled: no source was found to check it"
        return "no number was published" if self.tolerance.startswith(NO_NUMBER) else None


def published_rows(text: str) -> list[Row]:
    """Returns the rows of a table in Markdown, in order. Raises TableError that names a row that is not complete."""
    rows, group = list[Row](), ""
    for line in text.splitlines():
        if line.startswith("### "):
            group = line[4:].strip()
        elif re.match(r"\| [A-Z]\d\d \|", line):
            rows.append(_row([cell.strip() for cell in line.strip().strip("|").split("|")], group))
    seen = [row.id for row in rows]
    if twice := sorted({name for name in seen if seen.count(name) > 1}):
        raise TableError(f"row {', '.join(twice)} stands twice in the table")
    return rows


def _row(cells: list[str], group: str) -> Row:
    if len(cells) != len(COLUMNS):
        raise TableError(f"row {cells[0]}: {len(cells)} columns, not {len(COLUMNS)}: {', '.join(COLUMNS)}")
    if empty := [name for name, cell in zip(COLUMNS, cells, strict=True) if not cell]:
        raise TableError(f"row {cells[0]} has no {' and no '.join(empty)}")
    row = Row(**dict(zip(COLUMNS, cells, strict=True)), group=group)
    if row.kind not in KINDS or row.seen not in "SFR":
        raise TableError(
            f"row {row.id}: kind {row.kind}, seen {row.seen}; {', '.join(sorted(KINDS))} and S, F or R are known"
        )
    return row
