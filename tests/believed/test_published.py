"""The table of published figures, and what is refused of it."""

import pytest

from radar_service.believed.published import TABLE, TableError, published_rows

TEXT = TABLE.read_text(encoding="utf-8")
LINE = next(line for line in TEXT.splitlines() if line.startswith("| P06 |"))


def test_the_table_has_its_78_rows_and_says_which_count() -> None:
    rows = published_rows(TEXT)
    kinds = {kind: sum(row.kind == kind for row in rows) for kind in ("measured", "standard", "manual", "model")}
    assert len(rows) == 78 and kinds == {"measured": 28, "standard": 22, "manual": 18, "model": 10}
    assert {row.id for row in rows if row.seen == "R"} == {"K01", "K03", "K06", "L04", "L06", "H01"}
    assert {row.id for row in rows if row.uncounted and row.kind != "model" and row.seen != "R"} == {
        "G01", "K04", "K08", "W01", "F04", "B08"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (LINE.replace("2 %: definition", ""), "row P06 has no tolerance"),
        (LINE.replace("| manual |", "| rumour |"), "row P06: kind rumour"),
        (LINE.replace("| S |", ""), "row P06: 7 columns, not 8"),
        (f"{LINE}\n{LINE}", "row P06 stands twice"),
    ],
)
def test_a_faulty_row_is_named(text: str, message: str) -> None:
    with pytest.raises(TableError, match=message):
        published_rows(text)
