"""The lines of a plan on what was held against published figures: the table agrees with the page, and lines follow the scene."""

import re
from itertools import chain
from pathlib import Path

from radar_service.believed.verdicts import chosen_rows
from radar_service.plan.plan import held, plan_for
from radar_service.records.fidelity import PRESETS
from tests.scenes import scene

PAGE = Path(__file__).parents[2] / "docs/believed.md"
HULL = {"shape": "hull", "length_m": 20, "beam_m": 5, "height_m": 4, "scattering": "optics"}


def test_the_table_has_each_counted_row_and_those_outside_of_the_page() -> None:
    counted = {row.id for row in chosen_rows([]) if not row.uncounted}
    assert set(chain(*held()["rows"].values(), held()["elsewhere"])) == counted
    outside = PAGE.read_text(encoding="utf-8").split("## Outside")[1].split("## Inside")[0]
    assert sorted(held()["outside"]) == sorted(re.findall(r"^\| ([A-Z]\d\d) \|", outside, flags=re.M))


def believed(bodies: list[dict[str, object]], **tables: dict[str, object]) -> str:
    return "\n".join(plan_for(scene(bodies, **tables), PRESETS["balanced"]).believed)


def test_lines_name_what_is_modelled_alone() -> None:
    calm = believed([])
    assert "sea clutter" not in calm and "set that is sold" not in calm
    rough = believed([], environment={"sea_state": 3, "noise": True}, radar={"set": "furuno-1824c"})
    assert "sea clutter: 7 of 12 published figures inside, outside C03" in rough and "set that is sold: 4 of 4" in rough


def test_bodies_stand_under_their_kinds_and_what_nobody_has_measured_at_the_end() -> None:
    bodies = [
        HULL | {"name": "a", "material": "steel", "position_m": [500, 0, 0]},
        HULL | {"name": "b", "material": "fibreglass", "position_m": [0, 500, 0]},
        {"name": "c", "shape": "reflector", "reflector": "octahedral", "edge_m": 0.3, "position_m": [700, 0, 4]},
        {"name": "d", "shape": "point", "rcs_dbsm": 10, "position_m": [0, 900, 4]},
    ]
    lines = believed(bodies).splitlines()
    assert [line.split(":")[0] for line in lines[-4:]] == [
        "metal ships", "boats", "radar reflectors", "held against nothing published",
    ]  # fmt: skip
    assert "cross-sections as declared" in lines[-1]
