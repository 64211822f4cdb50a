"""Scans: objects, their file, and sectors."""

import dataclasses
import io
from functools import cache
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image

import radar_service as rs
from radar_service.echo.echoes import AzimuthTimes
from radar_service.engine import pipeline
from radar_service.engine.preparation import Prepared
from radar_service.numerics.types import Profiles
from radar_service.scans import file as scan_file
from radar_service.scans.scan import save_scans
from radar_service.scans.sector import Sector
from tests.scenes import point, scene

# scan: scans as objects: their file, what they print, their pictures; and the short texts of scenes and simulators.
SCENE = {
    "name": "one target",
    "radar": {"azimuths": 60, "beamwidth_deg": 8, "range_max_m": 600, "rpm": 60, "pulse_s": 1e-6},
    "own_ship": {"heading_deg": 30, "course_deg": 40, "speed_kn": 10},
    "body": [{"name": "east", "shape": "point", "position_m": [300, 0, 10], "rcs_dbsm": 10}],
}


@pytest.fixture
def simulator() -> rs.Simulator:
    return rs.Simulator(rs.load_scene(SCENE), "fast", seed=3)


def same(one: rs.Scan, other: rs.Scan) -> bool:
    return all(np.array_equal(getattr(one, f.name), getattr(other, f.name)) for f in dataclasses.fields(rs.Scan))


def test_a_saved_scan_is_loaded_as_it_was(simulator: rs.Simulator, tmp_path: Path) -> None:
    scan = simulator.scan()
    scan.save(tmp_path / "a.npz")
    assert same(rs.load_scan(tmp_path / "a.npz"), scan) and scan.speed[0] == pytest.approx(10 * 1852 / 3600)


def test_a_file_holds_several_scans_in_the_layout_of_one(simulator: rs.Simulator, tmp_path: Path) -> None:
    simulator.skip_to(5)
    scans = [simulator.scan(), simulator.scan()]
    save_scans(tmp_path / "a.npz", scans, {"seed": 3})
    assert [same(rs.load_scan(tmp_path / "a.npz", k), scan) for k, scan in enumerate(scans)] == [True, True]
    assert rs.load_scan(tmp_path / "a.npz", -1).number == 6
    scans[0].save(tmp_path / "b.npz")
    with np.load(tmp_path / "a.npz") as several, np.load(tmp_path / "b.npz") as one:
        assert {key: several[key].ndim for key in several if key != "seed"} == {key: one[key].ndim for key in one}
        np.testing.assert_array_equal(several["spoke"][:, 0], [300, 360])
    with pytest.raises(ValueError, match="index: 2 is not in .*, which holds 2 scans; give 0 to 1"):
        rs.load_scan(tmp_path / "a.npz", 2)


def test_a_scan_has_the_reported_azimuths_and_keeps_them(tmp_path: Path) -> None:
    errors = {"antenna": {"misalignment_deg": 2, "encoder_noise_deg": 0.1}}
    simulator = rs.Simulator(rs.load_scene(SCENE | {"errors": errors}), "fast", seed=3)
    scans = [simulator.scan(), simulator.scan()]
    save_scans(tmp_path / "a.npz", scans)
    assert [same(rs.load_scan(tmp_path / "a.npz", k), scan) for k, scan in enumerate(scans)] == [True, True]
    assert not np.array_equal(scans[0].azimuth, scans[1].azimuth)
    error = np.rad2deg(scans[0].azimuth) - 6.0 * np.arange(60)
    assert np.abs(error - 2.0).max() < 0.44  # 4.4 standard deviations, a level of 1e-5 for each
    with np.load(tmp_path / "a.npz") as file:
        np.testing.assert_allclose(np.rad2deg(file["azimuth"]), 6.0 * np.arange(60), atol=1e-12)  # rounding
        assert file["reported_azimuth"].shape == (2, 60)


def test_a_source_that_a_scan_does_not_have_has_no_power_in_its_file(simulator: rs.Simulator, tmp_path: Path) -> None:
    """A missing azimuth keeps NaN."""
    plain = simulator.scan()
    power = np.where(np.arange(len(plain.power))[:, None] == 3, np.float32(np.nan), plain.power)
    scans = [dataclasses.replace(plain, power=power, powers={number: 0.5 * power}) for number in (300, 256)]
    save_scans(tmp_path / "two.npz", scans)
    for index, own, other in ((0, 300, 256), (1, 256, 300)):
        powers = rs.load_scan(tmp_path / "two.npz", index).powers
        assert powers is not None and list(powers) == [256, 300]
        np.testing.assert_array_equal(powers[own], 0.5 * power)
        np.testing.assert_array_equal(powers[other], 0.0 * power)
    save_scans(tmp_path / "none.npz", [dataclasses.replace(plain, powers={})])
    assert rs.load_scan(tmp_path / "none.npz").powers == {}
    save_scans(tmp_path / "plain.npz", [plain])
    assert rs.load_scan(tmp_path / "plain.npz").powers is None


def test_a_plot_shows_the_target_where_it_stands(simulator: rs.Simulator) -> None:
    matplotlib.use("Agg")
    axes = simulator.scan().plot(dynamic_range_db=30.0)
    (image,) = axes.get_images()
    shown, extent = np.asarray(image.get_array()), image.get_extent()
    row, column = np.argwhere(shown == shown.max()).mean(axis=0)
    pixel = (extent[1] - extent[0]) / shown.shape[1]
    east, north = extent[0] + (column + 0.5) * pixel, extent[3] - (row + 0.5) * pixel
    # a range cell in depth, half an azimuth across, and the pixel
    assert abs(east - 300.0) < 2.0 + pixel and abs(north) < 300.0 * np.pi / 60 + pixel
    assert (axes.get_xlabel(), shown.max(), shown.min()) == ("east of own ship [m]", 0.0, -30.0)
    assert simulator.scan().plot(axes, range_max=200.0) is axes
    axes.clear()
    (image,) = simulator.scan().plot(axes, range_max=926.0, unit="nm").get_images()
    assert image.get_extent() == [-0.5, 0.5, -0.5, 0.5] and axes.get_ylabel() == "north of own ship [NM]"
    plt.close(axes.figure)


def test_a_notebook_shows_the_picture(simulator: rs.Simulator) -> None:
    scan = simulator.scan()
    picture = np.asarray(Image.open(io.BytesIO(scan._repr_png_())).convert("L")).astype(int)
    middle = picture.shape[0] // 2
    assert picture[middle - 30 : middle + 30, middle + 60 :].sum() > picture[middle - 30 : middle + 30, : middle - 60].sum()


def test_texts_of_a_scan_a_scene_and_a_simulator_are_a_few_lines(simulator: rs.Simulator) -> None:
    scan = simulator.scan()
    assert "<Scan 0: 60 azimuths x" in repr(scan) and "at 90.0 degrees" in repr(scan)
    assert repr(simulator) == "<Simulator of 'one target': fidelity fast, seed 3, next is scan 1>"
    assert "1 bodies, 0 triangles" in repr(simulator.scene) and "60 azimuths" in repr(simulator.scene)
    silent = dataclasses.replace(scan, power=np.zeros_like(scan.power), time=np.full_like(scan.time, np.nan))
    assert "no power" in repr(silent) and silent._repr_png_()
    for long in (scan, simulator, rs.load_scene("harbour")):
        assert len(repr(long)) < 400 and repr(long).count("\n") < 5


def test_the_package_is_typed() -> None:
    assert (Path(rs.__file__).parent / "py.typed").is_file()


# file: the file of scans: its documented layout, and what is refused.
def test_the_documented_layout_is_the_one_that_is_checked() -> None:
    rows = [line.split("|")[1:4] for line in (scan_file.__doc__ or "").splitlines() if line.startswith("| ")][1:]
    named = {
        name.strip(): shape.strip(" ()").replace(",", "").replace(" ", "")
        for names, shape, _ in rows for name in names.replace(", optional", "").split(",")
    }  # fmt: skip
    assert named == {"format": ""} | scan_file.SHAPES | scan_file.OPTIONAL


def test_only_files_of_scans_are_loaded(simulator: rs.Simulator, tmp_path: Path) -> None:
    scan = simulator.scan()
    with pytest.raises(ValueError, match=r"x\.txt: a file of scans ends in \.npz"):
        scan.save(tmp_path / "x.txt")
    assert not list(tmp_path.iterdir())
    (tmp_path / "text.npz").write_text("no arrays")
    np.savez(tmp_path / "other.npz", a=1)
    np.savez(tmp_path / "newer.npz", format=2)
    for name, text in (("text", "not a file of scans"), ("other", "format None"), ("newer", "format 2 is not 1")):
        with pytest.raises(ValueError, match=text):
            rs.load_scan(tmp_path / f"{name}.npz")
    scan.save(tmp_path / "a.npz")
    arrays = scan_file.read_arrays(tmp_path / "a.npz")
    for wrong, text in (({"range": np.zeros(3)}, "range has shape"), ({"colour": 1}, r"\['colour'\] not known")):
        with pytest.raises(ValueError, match=text):
            scan_file.write_arrays(tmp_path / "b.npz", arrays | wrong)
    del arrays["power"]
    scan_file.write_arrays(tmp_path / "b.npz", arrays)
    with pytest.raises(ValueError, match="holds no power"):
        rs.load_scan(tmp_path / "b.npz")


# sector: A sector has the bytes that its azimuths have in a whole scan, and costs its share.
MADE = scene(
    [point("a", 30, 900, swerling=1), point("b", -60, 1200, course_deg=90, speed_kn=15), point("c", 900, 0)],
    radar={"azimuths": 360, "beamwidth_deg": 3, "range_max_m": 2000, "blind_sectors_deg": [[5, 9]]},
    environment={"noise": True, "sea_state": 3, "rain_mm_h": 2},
)
DEGREE = np.pi / 180.0


@cache
def whole_scans(fidelity: str) -> tuple[rs.Scan, ...]:
    """The first two scans without a sector."""
    whole = rs.Simulator(MADE, fidelity, 5)
    return whole.scan(), whole.scan()


@pytest.mark.sample(3)
@pytest.mark.parametrize("ends", [(10, 28), (350, 20), (-10, 20), (0, 359), (90, 90.5), (200, 199)])
@pytest.mark.parametrize("fidelity", ["fast", "documented"])
def test_its_bytes_are_those_of_a_whole_scan(ends: tuple[float, float], fidelity: str) -> None:
    sector = ends[0] * DEGREE, ends[1] * DEGREE
    part = rs.Simulator(MADE, fidelity, 5, sector=sector)
    for expected in whole_scans(fidelity):
        made = part.scan()
        inside = (np.arange(360) - ends[0]) % 360 <= (ends[1] - ends[0]) % 360
        np.testing.assert_array_equal(~np.isnan(made.time), inside)
        assert made.field[inside].tobytes() == expected.field[inside].tobytes()
        assert made.power[inside].tobytes() == expected.power[inside].tobytes()
        for name in ("time", "heading", "position", "course", "speed"):
            np.testing.assert_array_equal(getattr(made, name)[inside], getattr(expected, name)[inside])
            assert np.isnan(getattr(made, name)[~inside]).all()
        np.testing.assert_array_equal(made.azimuth, expected.azimuth)
        assert np.isnan(made.field[~inside]).all() and made.number == expected.number


def test_a_sector_across_north_comes_in_two_stretches_of_blocks() -> None:
    sim = rs.Simulator(MADE, "fast", sector=(-4 * DEGREE, 6 * DEGREE))
    blocks = list(sim.blocks(scans=2, size=5))
    assert [(block.scan, block.index, len(block)) for block in blocks] == [
        (scan, *stretch) for scan in range(2) for stretch in ((0, 5), (5, 2), (356, 4))
    ]
    assert [block.first for block in blocks[:3]] == [0, 5, 356]


def test_other_tiles_are_not_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    computed: list[int] = []
    profiles = pipeline.profiles

    def counted(prepared: Prepared, azimuths: AzimuthTimes) -> Profiles:
        computed.append(int(azimuths.number[0]))
        return profiles(prepared, azimuths)

    monkeypatch.setattr(pipeline, "profiles", counted)
    rs.Simulator(MADE, "fast", sector=(90 * DEGREE, 100 * DEGREE)).scan()
    assert 1 <= len(computed) <= 2


@pytest.mark.parametrize("sector", [(0.0, np.nan), (1.0,), (0.0, 1.0, 2.0)])
def test_what_is_no_sector_is_refused(sector: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="two angles"):
        rs.Simulator(MADE, "fast", sector=sector)  # type: ignore[arg-type]


def test_the_rest_of_a_sector_begins_at_an_azimuth() -> None:
    radar = MADE.radar
    whole, part = Sector(radar, None), Sector(radar, (10 * DEGREE, 20.5 * DEGREE))
    assert whole.after(0) is whole and whole.requested is None
    assert np.flatnonzero(whole.after(350).requested).tolist() == list(range(350, 360))
    assert np.flatnonzero(part.after(15).requested).tolist() == list(range(15, 21)) and part.requested is not None
    assert np.flatnonzero(part.requested).tolist() == list(range(10, 21))
