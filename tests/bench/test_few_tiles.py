"""Plots from few tiles have the bytes of those of whole scans, and scenes whose tiles hold more than noise take the whole way."""

import gzip
from dataclasses import asdict
from pathlib import Path

import pytest

from radar_service.bench import few_tiles
from radar_service.bench import run as run_module
from radar_service.bench.kept_plots import keep_plots, observed_run, plots_path
from radar_service.bench.run import observed, simulator_of, threshold_of
from radar_service.bench.scenario import Scenario, load_scenario
from radar_service.echo.moving import MovingEchoes
from tests.bench.test_bench import FILE

MOVES = """
[scene.own_ship]
speed_kn = 10
course_deg = 20
[scene.errors]
profile = "imo-2004"
[[scene.body]]
name = "u"
shape = "point"
position_m = [-30, -700, 5]
rcs_dbsm = 0
speed_kn = 40
swerling = 1
start_s = 3
fading.present = 1
fading.of = 2
fading.offset_s = 1.27
[plots]
pfa = 3e-5
"""

COARSE = FILE.replace("= 256", "= 64\ncoarse_azimuths = true").replace("_deg = 4", "_deg = 8")
COARSE = COARSE.replace("[500, 300, 10]\nrcs_dbsm = -15", "[-1164, 607, 10]\nrcs_dbsm = 60")


def scenario(tmp_path: Path, text: str) -> Scenario:
    path = tmp_path / "small.toml"
    path.write_text(text)
    return load_scenario(str(path))


@pytest.mark.same_bytes
@pytest.mark.parametrize("text", [FILE + MOVES, FILE, COARSE], ids=["moves", "plain", "coarse"])
def test_the_bytes_are_those_of_whole_scans(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With noise over the threshold, a body that comes near, and a strong one a wide spoke beyond the beam's extent."""
    made = scenario(tmp_path, text.format(scans=6))
    calls = list[int]()
    profiles = few_tiles.profiles
    monkeypatch.setattr(few_tiles, "profiles", lambda prepared, azimuths: (calls.append(1), profiles(prepared, azimuths))[1])
    few = [asdict(result) for result in observed(made, 5)]
    (prepared,) = simulator_of(made, 5).pulses
    assert 0 < len(calls) < 6 * -(-prepared.scene.radar.azimuths // prepared.tile)
    monkeypatch.setattr(run_module, "has_few", lambda *_: False)
    assert few == [asdict(result) for result in observed(made, 5)] and any(result["given"]["plots"] for result in few)


@pytest.mark.parametrize(
    "change", [("noise = true", "noise = true\nsea_state = 2"), ("noise = true", "noise = false"), ("= 20\n", "= 0\n")]
)
def test_other_scenes_take_the_whole_way(change: tuple[str, str], tmp_path: Path) -> None:
    made = scenario(tmp_path, FILE.format(scans=2).replace(*change))
    simulator = simulator_of(made, 0)
    assert not few_tiles.has_few(simulator, threshold_of(made.plots, simulator.scene))


@pytest.mark.same_bytes
def test_seeds_that_are_made_together_have_the_bytes_of_each_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With one echo in the beam, two, and none; of both ships those alone where both are in it."""
    moves = MOVES.replace("swerling = 1\n", "").replace("[-30, -700, 5]", "[510, 500, 5]")
    made, calls = scenario(tmp_path, (FILE + moves).format(scans=6)), list[int]()
    echoes = MovingEchoes.echoes
    monkeypatch.setattr(MovingEchoes, "echoes", lambda *given: (calls.append(1), echoes(*given))[1])
    keep_plots(tmp_path / "together", made, [3, 5, 9])
    together = len(calls)
    runs = [observed_run(tmp_path / "alone", made, seed) for seed in (3, 5, 9)]
    assert together < len(calls) - together and any(result.given.plots for run in runs for result in run.results)
    for seed in (3, 5, 9):
        kept = [gzip.decompress(plots_path(tmp_path / way, made, seed).read_bytes()) for way in ("together", "alone")]
        assert kept[0] == kept[1]
