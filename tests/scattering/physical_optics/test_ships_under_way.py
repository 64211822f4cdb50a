"""Ships of boxes under way, in shadow and in a seaway: the engine, spoke by spoke, against `tests.reference.ship_fields`.

The error of a draw is the largest |field - oracle| over the largest |oracle| of the range cells and spokes of a passage. The
distributions of the draws are in `tests.reference.ship_draws`. The suite takes a few; the study 200, and prints a table:

    SHIP_DRAWS=200 SHIP_SEED=5 SHIP_PRESETS=auto,balanced,reference pytest -n 0 -m study -s THIS_FILE
"""

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.engine.pipeline import profiles, tile_azimuths
from radar_service.engine.preparation import prepare
from radar_service.plan.culling import cull
from radar_service.records.fidelity import Fidelity
from radar_service.simulation.engine_set_up import chosen_fidelity
from tests.reference import ship_fields
from tests.reference.ship_draws import KINDS, Case, drawn

PRESETS = ("auto", "balanced", "reference")
USUAL, NEVER = 0.03, 0.12  # errors that 98 % and that all draws keep
NOTHING = 1e-3  # of the floor of errors: below it is no echo
WORSE = 0.01  # by which `reference` may err more than `balanced`
SEED = 5
HOLDING = (5, 12, 40, 46, 92, 131, 147)
SLOW = pytest.param(159, marks=pytest.mark.study, id="159-passing")  # test_ships_in_shadow.py has such a ship


class Outcome(NamedTuple):
    """A draw, the errors and the errors of summed power [dB] by preset."""

    case: Case
    error: dict[str, float]
    power_db: dict[str, float]

    def __str__(self) -> str:
        parts = [f"{name} {self.error[name]:.3f} ({self.power_db[name]:+.2f} dB)" for name in self.error]
        return f"{', '.join(parts)}; {self.case}"


def scene_of(case: Case, folder: Path) -> rs.Scene:
    """The scene of a draw."""
    for name, rows in case.tracks.items():
        head = "time_s,east_m,north_m,up_m" + (",heading_deg" if rows.shape[1] == 5 else "")
        (folder / name).write_text("\n".join([head, *(",".join(f"{x:.9f}" for x in row) for row in rows)]) + "\n")
    return rs.load_scene(case.scene, folder=folder)


def spokes(made: rs.Scene, fidelity: str | Fidelity, numbers: np.ndarray) -> np.ndarray:
    """Fields (K, N) of spokes (K,), numbered from the start, as `rs.Simulator` computes them."""
    settings = chosen_fidelity(made, fidelity)
    culled = cull(made, settings)
    prepared = prepare(made, settings, 0, culled, [key for key in culled if not culled[key].occludes])
    scan, index = np.divmod(numbers, made.radar.azimuths)
    start = index // prepared.tile * prepared.tile
    tiles = {
        key: profiles(prepared, tile_azimuths(prepared, *key))
        for key in set(zip(scan.tolist(), start.tolist(), strict=True))
    }
    return np.array([tiles[a, b][c - b] for a, b, c in zip(scan.tolist(), start.tolist(), index.tolist(), strict=True)])


def outcome(case: Case, presets: Sequence[str] = PRESETS, every: int = 1) -> Outcome:
    """The errors of a draw; every: 2 for every other spoke about its crossing."""
    numbers = case.spokes[every // 2 :: every]
    with tempfile.TemporaryDirectory() as folder:
        made = scene_of(case, Path(folder))
        which = ship_fields.cells(case, made.radar.range_step, int(case.radar["range_max_m"] / made.radar.range_step))
        ranges = (which + 0.5) * made.radar.range_step
        exact = ship_fields.field(case, ranges, numbers)
        results = {name: spokes(made, name, numbers)[:, which] for name in presets}
    floor = ship_fields.level(case, ranges, exact)
    return Outcome(
        case,
        {name: float(np.abs(result - exact).max()) / floor for name, result in results.items()},
        {name: 10.0 * np.log10(power_of(result, floor) / power_of(exact, floor)) for name, result in results.items()},
    )


def power_of(field: NDArray[np.complexfloating], floor: float) -> float:
    """The sum of the powers of cells [W]. A ship that is hidden as a whole has next to nothing of its `floor` [sqrt(W)]."""
    return max(float((np.abs(field) ** 2).sum(dtype=np.float64)), (NOTHING * floor) ** 2)


@pytest.mark.sample(4)
@pytest.mark.parametrize(
    "number", [*HOLDING, SLOW], ids=lambda number: f"{number}-{KINDS[number % len(KINDS)].replace(' ', '-')}"
)
def test_ships_under_way_are_the_oracles(number: int) -> None:
    result = outcome(drawn(number, SEED))
    assert max(result.error.values()) < USUAL, str(result)
    assert result.error["reference"] < result.error["balanced"] + WORSE, str(result)


def table(outcomes: Sequence[Outcome]) -> str:
    """Errors by kind: 98 % below, the maximum, and how many draws are above both limits, of each preset."""
    rows = ["| kind | preset | draws | median | 98 % below | maximum | above 0.03 | above 0.12 |", "|" + "---|" * 8]
    for kind in (*KINDS, "all"):
        for name in outcomes[0].error:
            errors = np.array([each.error[name] for each in outcomes if kind in (each.case.kind, "all")])
            if len(errors):
                counts = f"{(errors > USUAL).sum()} | {(errors > NEVER).sum()}"
                low, high, worst = np.median(errors), np.quantile(errors, 0.98), errors.max()
                rows.append(f"| {kind} | {name} | {len(errors)} | {low:.3f} | {high:.3f} | {worst:.3f} | {counts} |")
    return "\n".join(rows)


@pytest.mark.study
def test_study_of_two_hundred_ships() -> None:
    count, seed = int(os.environ.get("SHIP_DRAWS", "200")), int(os.environ.get("SHIP_SEED", str(SEED)))
    outcomes = []
    for number in range(count):
        outcomes.append(outcome(drawn(number, seed), os.environ.get("SHIP_PRESETS", ",".join(PRESETS)).split(",")))
        print(outcomes[-1], flush=True)
    print(table(outcomes))
    errors = np.array([list(each.error.values()) for each in outcomes])
    assert (errors > USUAL).sum(axis=0).max() <= 0.02 * count
    assert errors.max() <= NEVER
    assert all(each.error.get("reference", 0.0) <= each.error.get("balanced", np.inf) + WORSE for each in outcomes)
