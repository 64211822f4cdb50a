"""The table of published figures, fixed before any was computed, and what its rows give: measured, judged, told as a page."""

import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import process_time

import numpy as np

from radar_service.believed import bodies, sea, signals, targets, tracking
from radar_service.believed.run import Figure, NotExpressed, Run
from radar_service.terminal import extra, make_folder, written

MEASUREMENTS: dict[str, Callable[[Run], list[Figure]]] = {
    **sea.MEASUREMENTS, **targets.MEASUREMENTS, **bodies.MEASUREMENTS, **signals.MEASUREMENTS, **tracking.MEASUREMENTS,
}  # fmt: skip
REASONS = json.loads(Path(__file__).with_name("reasons.json").read_text(encoding="utf-8"))  # by row: why ours lies outside
CAPTURED = Path(__file__).with_name("captured.txt").read_text(encoding="utf-8")  # video of real sets, measured once
NOT_COMPUTED = "the engine cannot express it"
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


@dataclass(frozen=True)
class RowVerdict:
    """A row and what the engine has for it.

    figures: ours with their limits; reason: why a row is outside, or not counted; seconds: of processor time.
    """

    row: Row
    figures: Sequence[Figure]
    reason: str
    seconds: float

    @property
    def word(self) -> str:
        """Returns outside, inside or shown."""
        if self.row.uncounted:
            return "shown"
        return "inside" if self.figures and all(figure.inside for figure in self.figures) else "outside"

    @property
    def computed(self) -> str:
        """Returns the figures as text; those outside are bold."""
        return "; ".join(_text(figure) for figure in self.figures) or "none"


def _text(figure: Figure) -> str:
    text = f"{figure.what} {figure.computed:.4g}{' ' * bool(figure.unit)}{figure.unit} ({_limits(figure)})"
    return text if figure.inside else f"**{text}**"


def _limits(figure: Figure) -> str:
    if math.isinf(figure.high):
        return f"{figure.low:.4g} or more"
    if math.isinf(figure.low):
        return f"{figure.high:.4g} or less"
    return f"{figure.low:.4g}" if figure.low == figure.high else f"{figure.low:.4g} to {figure.high:.4g}"


def chosen_rows(names: Sequence[str]) -> list[Row]:
    """Returns the rows of these names, or all. Raises TableError for a name that no row has."""
    rows = published_rows(TABLE.read_text(encoding="utf-8"))
    known = {row.id: row for row in rows}
    if unknown := [name for name in names if name not in known]:
        raise TableError(f"no row {', '.join(unknown)}; there are {', '.join(known)}")
    return [known[name] for name in names] or rows


def measured(rows: Iterable[Row], folder: Path) -> Iterator[RowVerdict]:
    """Yields the verdict of each row. folder: gets the scenes of each row, in a folder of its name. Raises OSError."""
    for row in rows:
        make_folder(folder / row.id)
        begin, figures, reason = process_time(), list[Figure](), row.uncounted or ""
        measurement = MEASUREMENTS.get(row.id)
        try:
            figures = measurement(Run(folder / row.id)) if measurement else []
        except NotExpressed as error:
            reason = str(error)
        if not measurement and not row.uncounted:
            reason = NOT_COMPUTED
        if not reason and not all(figure.inside for figure in figures):
            reason = REASONS.get(row.id, "not explained")
        yield RowVerdict(row, figures, reason, process_time() - begin)


def row_text(verdict: RowVerdict, folder: Path) -> str:
    """Returns a row as lines of text: its number, its source, ours, and where its scenes lie."""
    row, computed = verdict.row, verdict.computed.replace("**", "")
    lines = [f"{row.id}, {verdict.word}. {row.quantity}: {row.condition}", f"published: {row.published}; {row.tolerance}"]
    lines += [f"source: {row.source}", f"ours: {computed}", f"scenes: {folder / row.id}"]
    return "\n".join([*lines, *([f"why: {verdict.reason}"] if verdict.reason else []), ""])


PAGE = Path("docs/believed.md").name
ORDER = ("outside", "inside", "shown")
LONG = 30  # letters of a source, a tolerance or a reason that is printed once, and named by its row after that
HEAD = """# Believed

This page holds the simulator against figures that others have published. `radar-service believed -o DIR` computes it again,
`radar-service believed {example} -o DIR` one row. The scenes of a row run by themselves: `radar-service scan
DIR/{example}/scene-1.json -o out.npz`.

The rows were fixed before any was computed, gaps between ids included; none was dropped. A row is inside where all its figures
are; one that the engine cannot express is outside. Rows of a model, without a source or without a number are shown, not counted.
Rows of antennas and sets test that a scan shows what a maker prints. Detection ranges of the standard are those of the Furuno
sets of ships (`[radar] set`), on the scale that shows all that is asked, with power averaged over the beam, in steps of 4 %
(targets), 10 % (shores) or 20 % (ships).

**{inside} of {counted} rows are inside.** {shown} are shown.

![Ours within the limits of each row](believed.png)
"""


def page(verdicts: Sequence[RowVerdict]) -> str:
    """Returns the page: misses first, each row with its source, its number, ours, its tolerance and the reason of a miss."""
    groups = {word: [each for each in verdicts if each.word == word] for word in ORDER}
    counted = len(groups["outside"]) + len(groups["inside"])
    example = next((each.row.id for each in verdicts if each.word == "inside"), verdicts[0].row.id)
    lines = [HEAD.format(example=example, inside=len(groups["inside"]), counted=counted, shown=len(groups["shown"]))]
    printed = dict[str, str]()  # the row that first gave a text
    for word in ORDER:
        if groups[word]:
            lines += [f"## {word.capitalize()}", "", *_table(groups[word], printed), ""]
    return "\n".join([*lines, CAPTURED])


def _table(verdicts: Sequence[RowVerdict], printed: dict[str, str]) -> list[str]:
    def once(text: str, row: str) -> str:
        first = printed.setdefault(text, row)
        return text if first == row or len(text) < LONG else f"as {first}"

    last = "why" if verdicts[0].word != "inside" else "kind"
    rows = [
        (each.row.id, f"{each.row.quantity}: {each.row.condition}", each.row.published, each.computed,
         once(each.row.tolerance, each.row.id), once(each.row.source, each.row.id),
         once(each.reason, each.row.id) if last == "why" else each.row.kind)
        for each in verdicts
    ]  # fmt: skip
    head = ("row", "of what", "published", "ours (limits)", "tolerance", "source", last)
    return ["| " + " | ".join(cells) + " |" for cells in (head, ("---",) * len(head), *rows)]


COLOURS = {"inside": "#0072B2", "outside": "#D55E00", "shown": "#999999"}
REACH = 3.0  # half widths of tolerance at which figures are cut


def write_picture(verdicts: Sequence[RowVerdict], path: Path) -> None:
    """Draws the figures of each row over its tolerance, misses first. Raises MissingExtra and OSError."""
    with extra("pictures", "pictures of `believed`"):
        from matplotlib.figure import Figure as Drawing

    rows = [each for word in ORDER for each in verdicts if each.word == word and each.figures]
    drawing = Drawing(figsize=(8.3, 1.2 + 0.16 * len(rows)), layout="constrained")
    axes = drawing.add_subplot()
    axes.axvspan(-1.0, 1.0, color="#e8f0f4")
    for place, verdict in enumerate(rows):
        deviation = np.clip([figure.deviation for figure in verdict.figures], -REACH, REACH)
        axes.plot(deviation, np.full(len(deviation), place), "o", ms=3.5, color=COLOURS[verdict.word], alpha=0.7)
    axes.set(ylim=(max(len(rows), 1) - 0.5, -0.5), xlim=(-REACH - 0.2, REACH + 0.2))
    axes.set_yticks(range(len(rows)), [each.row.id for each in rows], fontsize=6.5)
    axes.set_xlabel("ours in half widths of tolerance; the band is inside, of a single limit all that is not beyond 1")
    axes.grid(axis="x", color="#dddddd", lw=0.5)
    with written(path) as part:
        drawing.savefig(part, format="png", dpi=150, metadata={"Software": None})
