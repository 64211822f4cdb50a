"""The short modules of believed, each under its name."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.believed import sea, signals, tracking, verdicts
from radar_service.believed.bodies import ASPECTS, land_sigma0, nulls, octahedral, pattern, ship_sections, tri_lens
from radar_service.believed.run import BARE, NM, Figure, NotExpressed, Run, around, sections
from radar_service.believed.sea import reflectivity, seen_in_clutter, wave_heights
from radar_service.believed.signals import rain_loss, slow_dots, width
from radar_service.believed.targets import (
    PFA,
    X,
    detected,
    first_detection,
    horizon,
    local_level,
    over_beam,
    threshold_in_noise,
)
from radar_service.believed.verdicts import (
    REASONS,
    TABLE,
    TableError,
    chosen_rows,
    measured,
    page,
    published_rows,
    row_text,
    write_picture,
)
from radar_service.bench.detection.detection import Target, ground_distance, signal_to_noise, spoke_gains, steady_detection
from radar_service.scene_file.load import load_scene


# sea: the reflectivity that is measured is the engine's law, whatever beam, pulse and power.
@pytest.mark.parametrize(("state", "published"), [(1, -56.55), (3, -43.74)])
def test_sigma0_is_that_of_the_law(tmp_path: Path, state: int, published: float) -> None:
    """NRL 2012 at 9.41 GHz, HH, 1 degree (docs/accuracy.md); 0.1 dB of speckle."""
    assert reflectivity(Run(tmp_path), 9.41e9, "h", 1.0, state) == pytest.approx(published, abs=0.1)


def test_wave_heights_are_those_of_the_scale(tmp_path: Path) -> None:
    """Within 5 %, as two hours of 64 waves scatter."""
    assert wave_heights(Run(tmp_path), (3, 5)) == pytest.approx([1.04, 2.98], rel=0.05)


@pytest.mark.study
def test_a_larger_target_is_seen_more_often_in_clutter(tmp_path: Path) -> None:
    small, large = (seen_in_clutter(Run(tmp_path), X, section, 1296.0, 2.0, 2) for section in (1.0, 1e3))
    assert small < 0.7 < large


def test_wave_age_is_not_expressed(tmp_path: Path) -> None:
    with pytest.raises(NotExpressed, match="wind and waves of different ages"):
        sea.MEASUREMENTS["W02"](Run(tmp_path))


# tracking: rows of tracking: what the bench's report gives, without its runs, and plots of vessels.
def limit(metric: str, value: float, **bounds: float) -> dict[str, Any]:
    return {"metric": metric, "value_95": value, **bounds}


def test_accuracy_is_the_worst_of_four_geometries(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    values = iter((0.2, 0.9, 0.1, 0.3))

    def fake_bench(scenarios: list[Any], seeds: int, tracker: str, folder: Path) -> tuple[dict[str, Any], None]:
        share = next(values)
        return {"scenarios": [{"verdicts": [limit(metric, share, maximum=1.0) for metric in tracking.TABLE_3]}]}, None

    monkeypatch.setattr(tracking, "bench", fake_bench)
    figures = tracking.accuracy(Run(tmp_path))
    assert [figure.computed for figure in figures] == [0.9] * 7 and len([*tmp_path.glob("msc192-table3-*.toml")]) == 4


def test_a_track_that_is_lost_is_outside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    verdicts = [limit("held", 0.5), limit("velocity_kn_1min", 0.2)]
    monkeypatch.setattr(tracking, "bench", lambda *given: ({"scenarios": [{"verdicts": verdicts}]}, None))
    assert [figure.inside for figure in tracking.fading(Run(tmp_path))] == [False, True]


def test_plots_of_a_boat_stand_by_her(tmp_path: Path) -> None:
    """Of a jet boat of 8 m: errors in range are within her length, and most scans have her."""
    boats = {"jet boat": tracking.BOATS["jet boat"]}
    ((share, errors),) = tracking.plots_of_boats(Run(tmp_path), boats, scans=3).values()
    assert share > 0.8 and len(errors) and abs(errors).max() < 8.0


# signals: measurements of the signal: each finds what its scene has.
@pytest.mark.parametrize(("frequency", "polarization", "rain", "loss"), [(9.41e9, "v", 16, 0.274), (9.41e9, "h", 50, 1.443)])
def test_rain_weakens_by_the_recommendation(
    tmp_path: Path, frequency: float, polarization: str, rain: float, loss: float
) -> None:
    assert rain_loss(Run(tmp_path), frequency, polarization, rain) == pytest.approx(loss, rel=0.005)


@pytest.mark.parametrize("vertical", [False, True])
def test_a_beam_has_its_width(tmp_path: Path, vertical: bool) -> None:
    """A wrong width is seen as what it is."""
    key = "beamwidth_el_deg" if vertical else "beamwidth_deg"
    assert width(Run(tmp_path), {key: 2.0}, 3.0, vertical) == pytest.approx(2.0, rel=0.01)


def test_slow_dots_are_the_stronger_ones() -> None:
    distance = np.arange(0.0, 4000.0, 10.0)
    power = np.zeros(400)
    power[[100, 220, 340]], power[[60, 180, 300]] = 1.0, 0.2
    np.testing.assert_array_equal(slow_dots(distance, power), [1000.0, 2200.0, 3400.0])


@pytest.mark.parametrize("row", ["P04", "T06", "E01", "E03"])
def test_rows_give_the_same_verdict(tmp_path: Path, row: str) -> None:
    """Cheap rows."""
    assert all(figure.inside for figure in signals.MEASUREMENTS[row](Run(tmp_path)))


# bodies: patterns, nulls and land, against closed forms.
@pytest.mark.parametrize(
    ("weak", "expected"),
    [("0011", (180.0, 180.0)), ("1001", (180.0, 180.0)), ("0000", (0.0, 360.0)), ("1111", (360.0, 0.0))],
)
def test_nulls_close_round_the_circle(weak: str, expected: tuple[float, float]) -> None:
    assert nulls(np.array([letter == "1" for letter in weak])) == expected


def test_a_lens_has_its_closed_form_and_stands_aside(tmp_path: Path) -> None:
    """4 pi^3 r^4 / lambda^2 ahead of one of three, and cos^2 of the angle off it while the others are behind."""
    lens, wavelength = tri_lens(0.1), 299792458.0 / 9.41e9
    found = pattern(Run(tmp_path), lens[:1], 0.0)
    assert len(found) == 2 * ASPECTS and found[0] == pytest.approx(4.0 * math.pi**3 * 0.1**4 / wavelength**2, rel=0.02)
    assert found[12] / found[0] == pytest.approx(math.cos(math.radians(30.0)) ** 2, rel=0.03)
    assert found[ASPECTS] < 1e-6 * found[0]


@pytest.mark.study
def test_heel_weakens_an_octahedral_reflector(tmp_path: Path) -> None:
    upright, heeled = (float(np.mean(pattern(Run(tmp_path), octahedral(0.8), heel) >= 7.5)) * 360.0 for heel in (0.0, 10.0))
    assert upright == pytest.approx(300.0, abs=8.0) and heeled == pytest.approx(284.0, abs=8.0)  # docs/scenes.md


def test_ships_stand_round_the_antenna_at_the_aspects_asked_for(tmp_path: Path) -> None:
    """A corner reflector has an echo ahead alone."""
    corner = {"shape": "reflector", "reflector": "corner", "edge_m": 0.3}
    found = ship_sections(Run(tmp_path), corner, np.array([0.0, 90.0, 180.0, 270.0]), air={})
    assert found.argmax() == 0 and np.sort(found)[-2] < found[0] - 20.0


def test_land_has_sigma0_of_its_material(tmp_path: Path) -> None:
    """Vegetation has -12 dB sin(psi): of low relief seen from 5 degrees above, where nothing is in shadow, within 1 dB."""
    mean, spread = land_sigma0(Run(tmp_path), 5.0)
    assert mean == pytest.approx(-12.0 + 10.0 * math.log10(math.sin(math.radians(5.0))), abs=1.0)
    assert 0.7 < spread < 1.5  # exponential speckle has 1


# run: figures and their limits, and the scenes that a run keeps.
@pytest.mark.parametrize(
    ("figure", "inside", "deviation"),
    [
        (Figure.near("", 103.0, 100.0, 0.02), False, 1.5),
        (Figure.within("", -61.0, -60.0, 2.0), True, -0.5),
        (Figure.by_factor("", 1.9, 2.0, 4.0, 2.0), True, 2.0 * 0.9 / 7.0 - 1.0),
        (Figure.least("", 0.6, 0.8), False, -1.5),
        (Figure.most("", 5.0, 10.0), True, 0.0),
        (Figure.most("", 12.0, 10.0), False, 1.4),
        (Figure.least("", 9.0, 0.8), True, 1.0),
        (Figure("", 2.0, 2.0, 2.0), True, 0.0),
    ],
)
def test_a_figure_is_inside_its_limits(figure: Figure, inside: bool, deviation: float) -> None:
    assert figure.inside is inside and figure.deviation == pytest.approx(deviation)
    assert (abs(figure.deviation) <= 1.0) is inside


def test_a_run_keeps_each_scene_as_a_file_that_gives_the_same_bytes(tmp_path: Path) -> None:
    bodies = [{"shape": "point", "rcs_dbsm": 10, "position_m": [0, 800, 4]}]
    simulator = Run(tmp_path).simulator(
        BARE | {"azimuths": 120, "beamwidth_deg": 6, "range_max_m": 1500}, {}, bodies, fidelity="fast"
    )
    scan = simulator.scan()
    again = rs.Simulator(rs.load_scene(tmp_path / "scene-1.json"), "fast").scan()
    np.testing.assert_array_equal(scan.power, again.power)
    assert around(scan.power, simulator, 0.0, 800.0).max() == scan.power.max()


def test_sections_are_those_of_the_bodies(tmp_path: Path) -> None:
    """A body behind the horizon has none."""
    bodies = [
        {"shape": "point", "rcs_dbsm": s, "position_m": p}
        for s, p in ((7, [0, 900, 4]), (-3, [800, 0, 4]), (9, [0, -40e3, 1]))
    ]
    found = sections(Run(tmp_path), BARE | {"range_max_m": 45e3, "bandwidth_hz": 5e6}, {}, bodies)
    np.testing.assert_allclose(found, [7.0, -3.0, -100.0], atol=0.1)  # of the gate, 20 dB below the peak


# targets: detection ranges against the radar equation, horizons against geometry, and two targets apart.
BUOY = {"shape": "point", "rcs_dbsm": 10.0}


def test_first_detection_is_where_the_radar_equation_has_it(tmp_path: Path) -> None:
    """Within 0.2 NM, of Marcum's Q for the mean over the 3 spokes of the beam: steps are 0.15, and cells lose up to 1 dB."""
    radar = X | {"azimuths": 360, "beamwidth_deg": 2.0, "range_max_m": 14000}
    computed = first_detection(Run(tmp_path), radar, BUOY, 3.5, np.linspace(4.0, 7.0, 21))
    scene = load_scene({"radar": radar, "environment": {"noise": True, "multipath": True}})
    slant, gains = np.linspace(4.0, 7.0, 300) * NM, spoke_gains(scene.radar)
    ground = ground_distance(slant, 3.5, scene.radar, scene.environment)
    snr = signal_to_noise(scene.radar, scene.environment, ground, Target("buoy", 3.5, 10.0, 0, None))
    pd = steady_detection(snr * gains.mean(), PFA, len(gains))
    assert computed == pytest.approx(slant[pd >= 0.8].max() / NM, abs=0.2)


def test_the_mean_over_a_beam_of_noise_keeps_the_false_alarms(tmp_path: Path) -> None:
    """Of 280,000 cells, 4 deviations of clumps of three spokes."""
    simulator = Run(tmp_path).simulator(X | {"azimuths": 360, "beamwidth_deg": 2.0, "range_max_m": 14000}, {"noise": True})
    power = np.concatenate([over_beam(simulator.scan().power, simulator.scene.radar) for _ in range(2)])
    expected = PFA * power.size
    assert (power > threshold_in_noise(simulator)).sum() == pytest.approx(expected, abs=4.0 * np.sqrt(3.0 * expected))


def test_a_threshold_by_the_cells_beside_keeps_false_alarms_few(tmp_path: Path) -> None:
    """Of 60 faint points with 9 cells each, 10 scans, at 1e-4: 0.5 are expected, 5 or more in one run of 5000."""
    bodies = [
        {"shape": "point", "rcs_dbsm": -60, "position_m": [3000 * np.sin(a), 3000 * np.cos(a), 4]}
        for a in np.linspace(0, 6.2, 60)
    ]
    radar = X | {"azimuths": 360, "beamwidth_deg": 2.0, "range_max_m": 6000}
    assert detected(Run(tmp_path), radar, {"noise": True}, bodies, 10, level=local_level).sum() * 10 < 5


@pytest.mark.parametrize(("earth", "radius"), [("4/3", 4 / 3), (7 / 6, 7 / 6)])
def test_the_horizon_is_that_of_the_earth(tmp_path: Path, earth: float | str, radius: float) -> None:
    expected = (2.0 * radius * 6371e3) ** 0.5 * (3.0 + 4.0) / NM
    assert horizon(Run(tmp_path), 9.0, 16.0, earth) == pytest.approx(expected, rel=0.003)  # steps of 0.16 %


# verdicts: the table of published figures, verdicts of its rows, and the page and picture of them.
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


INSIDE, OUTSIDE = Figure.within("a", 1.0, 1.0, 0.5, "dB"), Figure.least("b", 2.0, 3.0, "NM")


def cannot(run: Run) -> list[Figure]:
    raise NotExpressed("no such thing")


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Measurements of four rows: inside, outside, not expressed, and none."""
    rows = {"P06": lambda run: [INSIDE], "P04": lambda run: [INSIDE, OUTSIDE], "W02": cannot}
    monkeypatch.setattr(verdicts, "MEASUREMENTS", rows)
    monkeypatch.setattr(verdicts, "REASONS", {"P04": "it is so"})


@pytest.mark.usefixtures("few")
def test_misses_come_first_and_each_says_why(tmp_path: Path) -> None:
    found = list(measured(chosen_rows(["P06", "P04", "W02", "T07", "N12"]), tmp_path))
    assert [each.word for each in found] == ["inside", "outside", "outside", "outside", "shown"]
    assert [each.reason for each in found[1:4]] == ["it is so", "no such thing", verdicts.NOT_COMPUTED]
    text = page(found)
    assert "**1 of 4 rows are inside.** 1 are shown." in text and "**b 2 NM (3 or more)**" in text
    places = [
        text.index(part)
        for part in ("## Outside", "| P04 |", "| W02 |", "## Inside", "| P06 |", "## Shown", "| N12 |", "## Shown: video")
    ]
    assert places == sorted(places)
    assert "source: JRC JMA-9922" in row_text(found[1], tmp_path) and "why: it is so" in row_text(found[1], tmp_path)
    write_picture(found, tmp_path / "believed.png")
    assert (tmp_path / "believed.png").read_bytes().startswith(b"\x89PNG")


def test_an_unknown_row_is_named() -> None:
    with pytest.raises(TableError, match="no row Z99, P6; there are C01, C02"):
        chosen_rows(["P06", "Z99", "P6"])


def test_every_row_that_counts_has_a_measurement() -> None:
    rows = published_rows(TABLE.read_text(encoding="utf-8"))
    assert {row.id for row in rows if not row.uncounted} <= {*verdicts.MEASUREMENTS} <= {row.id for row in rows}
    assert {*REASONS} <= {*verdicts.MEASUREMENTS} and not math.isnan(INSIDE.computed)
