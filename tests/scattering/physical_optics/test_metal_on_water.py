"""Metal on the water, in shadow, near by and turning: the engine against the oracle of `tests.reference.metal_on_water`.

With b the oracle's amplitude, a the engine's, and b_loc the oracle's rms over 5 % of range and one lobe of aspect both ways,
the error of a draw is | |a| - |b| | / max(|b|, b_loc). It is below 0.12 (1 dB) in 98 % of draws and never above 0.5; summed
powers agree within 0.2 dB. The distributions of the draws are in `tests.reference.metal_draws`.

The suite takes some draws of each row, with a fixed seed. The study takes 200 of each with a fresh seed and prints a table:

    METAL_DRAWS=200 METAL_SEED=7 METAL_ROWS=1,4 METAL_FIDELITY=reference pytest -m study -s THIS_FILE
"""

import os
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import radar_service as rs
from tests.reference import metal_draws
from tests.reference.metal_draws import Draw, drawn
from tests.scattering.physical_optics import metal_engine

ROW_NAMES = {1: "over the sea", 2: "moving point", 3: "in shadow", 4: "in the water", 5: "near by", 6: "turning, passing"}
USUAL, NEVER = 0.12, 0.5  # errors that 98 % and that all draws keep
POWER_DB = 0.2  # of summed powers
SEED, FEW = 11, 4  # of the suite
FIDELITY = os.environ.get("METAL_FIDELITY", "balanced")
WHOLE_TURNS = 2  # draws of each row that go through rs.Simulator
AROUND = 2.0 * metal_draws.CELL  # of range about a body
SMALL = 0.06  # an error against |b| alone that needs no b_loc, which can only lower it


@dataclass(frozen=True)
class Outcome:
    """A draw's worst comparison: the engine's and the oracle's amplitude [m], its error, and both powers, over all spokes."""

    draw: Draw
    engine: float
    exact: float
    error: float
    engine_power: float
    exact_power: float

    def __str__(self) -> str:
        level = [20.0 * np.log10(max(x, 1e-6)) for x in (self.engine, self.exact)]
        return f"{self.error:.3f}: engine {level[0]:.1f} dBsm, oracle {level[1]:.1f} dBsm; {self.draw}"


def outcome(draw: Draw, engine: np.ndarray, exact: np.ndarray) -> Outcome:
    """The outcome of amplitudes (K,) [m] of a draw's spokes, or of its one instant."""
    gap = np.abs(engine - exact)
    floor = 0.0 if (gap <= SMALL * exact).all() else metal_draws.local_rms(draw)
    errors = gap / np.maximum(np.maximum(exact, floor), 1e-12)
    worst = int(errors.argmax())
    powers = float(np.mean(engine**2)), float(np.mean(exact**2))
    return Outcome(draw, float(engine[worst]), float(exact[worst]), float(errors[worst]), *powers)


def at_an_instant(draw: Draw) -> Outcome:
    """The sum of a scene's echoes at rest."""
    with tempfile.TemporaryDirectory() as folder:
        engine = metal_engine.amplitude(draw, Path(folder), FIDELITY)
    return outcome(draw, np.array([engine]), np.array([metal_draws.amplitude(draw)]))


def at_each_spoke(draw: Draw) -> Outcome:
    """Root energies of the spokes that the beam spends on the body, each over that of 1 m^2 there."""
    which = metal_engine.spokes_across(draw)
    with tempfile.TemporaryDirectory() as folder:
        made = metal_engine.scene_of(draw, Path(folder), moving=True)
        field = metal_engine.spokes(made, FIDELITY if draw.faces else "auto", draw.scan, which)
    loud = 1.0 if draw.faces else 10.0 ** (metal_engine.LOUD_DBSM / 20.0)
    ranges = (np.arange(field.shape[1]) + 0.5) * made.radar.range_step
    return compared_spokes(draw, ranges, which, field / loud)


def whole_turn(draw: Draw) -> Outcome:
    """The same of a body at rest in a smooth sea, by the public simulator."""
    still = metal_engine.at_rest(draw)
    which = metal_engine.spokes_across(still)
    with tempfile.TemporaryDirectory() as folder:
        scan = rs.Simulator(metal_engine.scene_of(still, Path(folder), moving=False), FIDELITY).scan()
    return compared_spokes(still, scan.range, which, scan.field[which])


def compared_spokes(draw: Draw, ranges: np.ndarray, which: np.ndarray, field: np.ndarray) -> Outcome:
    """The outcome of spokes `which` (K,) with fields (K, N), about the body: clutter near the antenna is louder than any."""
    near = np.abs(ranges - draw.slant) < AROUND
    ranges, field = ranges[near], field[:, near]
    boresight = 2.0 * np.pi * which / 720
    time = (draw.scan + which / 720) * metal_draws.PERIOD
    unit = metal_draws.unit_energy(draw, ranges, boresight)
    exact = np.linalg.norm(metal_draws.spoke_field(draw, ranges, boresight, time), axis=1) / unit
    return outcome(draw, np.linalg.norm(field, axis=1) / unit, exact)


COMPARISONS: dict[int, Callable[[Draw], Outcome]] = {
    1: at_an_instant, 2: at_each_spoke, 3: at_an_instant, 4: at_an_instant, 5: at_an_instant, 6: at_each_spoke,
}  # fmt: skip


def power_error_db(outcomes: list[Outcome]) -> float:
    """Summed powers of the engine over those of the oracle [dB]."""
    return float(10 * np.log10(sum(o.engine_power for o in outcomes) / sum(o.exact_power for o in outcomes)))


def judged(outcomes: list[Outcome]) -> None:
    """Asserts what docs/engine.md promises; of few draws, one may be above the usual error."""
    worst = sorted(outcomes, key=lambda o: -o.error)
    message = "\n".join(map(str, worst[:5]))
    unusual = sum(o.error > USUAL for o in outcomes)
    assert unusual <= max(1, 0.02 * len(outcomes)), f"{unusual} of {len(outcomes)} above {USUAL}:\n{message}"
    assert worst[0].error <= NEVER, message
    assert abs(power_error_db(outcomes)) <= POWER_DB, (
        f"summed powers differ by {power_error_db(outcomes):.2f} dB:\n{message}"
    )


@pytest.mark.parametrize("row", COMPARISONS, ids=lambda row: ROW_NAMES[row].replace(" ", "-"))
def test_the_engine_is_the_oracle(row: int) -> None:
    judged([COMPARISONS[row](drawn(row, i, SEED)) for i in range(FEW)])


def smooth(draw: Draw) -> Draw:
    """The draw in sea state 0, whose clutter is nothing."""
    return replace(draw, setting=replace(draw.setting, sea_state=0))


@pytest.mark.parametrize("row", [1, 3, 4, 5], ids=lambda row: ROW_NAMES[row].replace(" ", "-"))
def test_the_simulator_shows_what_its_echoes_say(row: int) -> None:
    """Compressed spokes of the whole chain: two draws of each row."""
    judged([whole_turn(smooth(drawn(row, i, SEED + 1))) for i in range(WHOLE_TURNS)])


@pytest.mark.study
def test_study_of_two_hundred_draws() -> None:
    count = int(os.environ.get("METAL_DRAWS", "200"))
    seed = int(os.environ.get("METAL_SEED", str(np.random.SeedSequence().entropy)[:9]))
    rows = [int(row) for row in os.environ.get("METAL_ROWS", "1,2,3,4,5,6").split(",")]
    print(f"\nseed {seed}, fidelity {FIDELITY}")
    print("| row | draws | 98 % below | maximum | above 0.12 | power [dB] |", "|---|---|---|---|---|---|", sep="\n")
    results = {}
    for row in rows:
        outcomes = results[row] = [COMPARISONS[row](drawn(row, i, seed)) for i in range(count)]
        errors = np.array([o.error for o in outcomes])
        print(
            f"| {row} {ROW_NAMES[row]} | {count} | {np.quantile(errors, 0.98):.3f} | {errors.max():.3f} | "
            f"{(errors > USUAL).sum()} | {power_error_db(outcomes):+.2f} |",
            flush=True,
        )
    for outcomes in results.values():
        print(*sorted(map(str, outcomes), reverse=True)[:8], sep="\n")
    for outcomes in results.values():
        judged(outcomes)
