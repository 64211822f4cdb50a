"""Whole sweeps: what they leave, what fails, and that no kill changes a byte."""

import errno
from collections.abc import Iterable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import radar_service as rs
from radar_service.batch.jobs import Outcome
from radar_service.batch.worker_processes import WorkerDied
from radar_service.numerics.arithmetic_name import arithmetic
from radar_service.sweep import sweep as sweep_module
from radar_service.sweep.estimate import COPIES, HOUR, estimate
from radar_service.sweep.layout import CHUNK_BYTES, StoreLayout, layout_of
from radar_service.sweep.spec import SweepError, SweepSpec, json_schema, load_spec
from radar_service.sweep.store import SweepStore, lay_out
from radar_service.sweep.sweep import run
from tests.batch.loopback_cluster import loopback_cluster
from tests.sweep.killing import ended, killed, moments, started
from tests.sweep.sweeps import SCENE, SPEC, content, inputs, open_dataset, swept, written

MORE = SPEC.replace("seeds = 2", "seeds = 3")  # 6 runs


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The files of a sweep that this process made in order."""
    folder = tmp_path_factory.mktemp("undisturbed")
    _, address, tally = swept(folder, MORE)
    assert (tally.done, tally.kept, tally.failed) == (6, 0, {})
    return content(address)


def test_all_runs_are_there(undisturbed: dict[str, bytes], tmp_path: Path) -> None:
    for name, data in undisturbed.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(data)
    dataset = open_dataset(address := str(tmp_path))
    assert SweepStore(address).finished.all() and not np.isnan(dataset.power).any() and len(np.unique(dataset.video)) > 3
    strongest = dataset.power.isel(scan=0).max(dim=("azimuth", "range")).values  # noise and signal add up to some dB
    assert np.all(strongest[3:] > 4.0 * strongest[:3])  # 15 against 5 dBsm


def go_on_until_whole(folder: Path, seed: int, count: int, whole: int, *options: str) -> int:
    """Kills a sweep at drawn moments and goes on; returns how many kills met it."""
    spec, store = written(folder, MORE), folder / "out.zarr"
    kills = 0
    for at, victims in moments(seed, count, whole):
        process = started(spec, store, *options)
        kills += killed(process, store, at, victims)
        ended(process)
    process = started(spec, store, *options)
    ended(process)
    assert process.returncode == 0
    return kills


@pytest.mark.same_bytes
def test_a_sweep_that_is_killed_has_the_bytes_of_one(undisturbed: dict[str, bytes], tmp_path: Path) -> None:
    assert go_on_until_whole(tmp_path, 9, 1, len(undisturbed), "--jobs", "1") == 1
    assert content(tmp_path / "out.zarr") == undisturbed


@pytest.mark.study
def test_a_sweep_that_is_killed_at_twenty_moments_has_the_bytes_of_one(
    undisturbed: dict[str, bytes], tmp_path: Path
) -> None:
    kills = sum(
        go_on_until_whole(tmp_path / str(seed), seed, 4, len(undisturbed), "--jobs", "2") for seed in range(100, 105)
    )
    assert kills >= 10  # the others came when all was done
    for seed in range(100, 105):
        assert content(tmp_path / str(seed) / "out.zarr") == undisturbed


@pytest.mark.study
def test_a_sweep_on_dask_that_is_killed_at_twenty_moments_has_the_bytes_of_one(
    undisturbed: dict[str, bytes], tmp_path: Path
) -> None:
    pytest.importorskip("distributed")
    with loopback_cluster(2) as scheduler:
        kills = sum(
            go_on_until_whole(tmp_path / str(seed), seed, 4, len(undisturbed), "--scheduler", scheduler)
            for seed in range(200, 205)
        )
    assert kills >= 10
    for seed in range(200, 205):
        assert content(tmp_path / str(seed) / "out.zarr") == undisturbed


def test_a_run_that_fails_is_recorded_and_the_rest_go_on(tmp_path: Path) -> None:
    """Half of the runs have a mesh that is rubbish, which nobody knows before they begin."""
    written(tmp_path)
    (tmp_path / "rubbish.obj").write_text("v nowhere")
    spec, told = SPEC + '"body.cube.mesh" = ["cube.obj", "rubbish.obj"]\n', list[str]()

    def progress(outcomes: Iterable[Outcome], count: int) -> Iterable[Outcome]:
        for outcome in outcomes:
            yield outcome
            told.append(str(tally))

    tally = sweep_module.Tally()
    _, address, _ = swept(tmp_path, spec, tally=tally, progress=progress)
    store = SweepStore(address)
    assert (tally.done, sorted(tally.failed)) == (4, [2, 3, 6, 7]) and (told[1], told[2], told[7]) == (
        "",
        "1 failed",
        "4 failed",
    )
    assert store.failures == tally.failed and "rubbish.obj" in tally.failed[2]
    assert store.finished.tolist() == [True, True, False, False] * 2
    dataset = open_dataset(address)
    assert np.isnan(dataset.power[2]).all() and dataset.failure[2] == tally.failed[2]
    again = swept(tmp_path, spec)[2]
    assert (again.kept, again.done, sorted(again.failed)) == (4, 0, [2, 3, 6, 7])


def test_enough_failures_end_it(tmp_path: Path) -> None:
    spec = SPEC.replace("seeds = 2", "seeds = 20\nmax_crossings = 1")
    _, address, tally = swept(tmp_path, spec, max_failures=3)
    assert len(tally.failed) == 3 and len(SweepStore(address).failures) == 3


class Failing:
    """An executor whose jobs end with an error."""

    def __init__(self, error: BaseException | None) -> None:
        self.error = error

    def submit(self, function: Any, /, *arguments: Any) -> "Future[Any]":
        future: Future[Any] = Future()
        if self.error is None:
            future.cancel()
        else:
            future.set_exception(self.error)
        return future


def test_workers_that_die_again_and_again_fail_their_run_alone(tmp_path: Path) -> None:
    _, address, tally = swept(tmp_path, executor=Failing(WorkerDied("its worker process died 3 times")))
    assert SweepStore(address).failures == dict.fromkeys(range(4), "its worker process died 3 times") == tally.failed


def test_a_full_disk_ends_it_with_the_remedy(tmp_path: Path) -> None:
    full = OSError(errno.ENOSPC, "No space left on device")
    with pytest.raises(OSError, match="make room, and the same command goes on") as raised:
        swept(tmp_path, executor=Failing(full))
    assert str(raised.value.filename).endswith("out.zarr") and not SweepStore(str(tmp_path / "out.zarr")).failures


def test_a_scheduler_that_ends_ends_it(tmp_path: Path) -> None:
    with pytest.raises(SweepError, match="^run 0: its executor dropped it: .*; the same command goes on where it was$"):
        swept(tmp_path, executor=Failing(None))


def test_a_store_that_another_command_has_is_left_alone(tmp_path: Path) -> None:
    def progress(outcomes: Iterable[Outcome], count: int) -> Iterable[Outcome]:
        with pytest.raises(SweepError, match="another command writes to it"):
            swept(tmp_path)
        yield from outcomes

    assert swept(tmp_path, progress=progress)[2].done == 4


# estimate: what a sweep will take, before it begins.


def test_it_adds_up_what_it_measures(tmp_path: Path) -> None:
    of = inputs(tmp_path, SPEC.replace("seeds = 2", "seeds = 50"))
    layout = layout_of(of)
    taken = estimate(of, layout)
    (cost,) = taken.scenes
    assert cost.runs == 100 and cost.scan == pytest.approx(1.0 / cost.realtime_factor)  # a scan is of a second
    assert taken.cpu_hours == pytest.approx(100 * (cost.set_up + 3 * (cost.scan + cost.write)) / HOUR)
    assert taken.memory > COPIES * layout.chunk_bytes and min(cost.set_up, cost.scan, cost.write) > 0.0
    lines = str(taken).splitlines()
    assert lines[0] == "100 runs of 3 scans of 60 x 40" and "CPU hours on this machine" in lines[1]
    assert lines[-2].startswith(f"{layout.bytes / 1e6:.3g} MB of arrays") and "memory a worker" in lines[-1]
    assert f"; 2 chunks a run of {len(layout.arrays)} arrays" in lines[-2]  # of two scans each


def test_bytes_are_those_that_a_sweep_leaves(tmp_path: Path) -> None:
    """One scan stands for all: noise compresses alike. The marks and coordinates of four runs are left out, 2 kB."""
    of, address, _ = swept(tmp_path, SPEC)
    store = SweepStore(address)
    files = [path for each in store.variables for path in (tmp_path / "out.zarr" / each.name / "c").rglob("*")]
    there = sum(path.stat().st_size for path in files if path.is_file())
    assert estimate(of, layout_of(of)).stored == pytest.approx(there, rel=0.15)


def test_the_specification_as_printed_has_a_time_too(tmp_path: Path) -> None:
    of = inputs(tmp_path, 'scene = "small.toml"\nfidelity = "documented"')
    assert estimate(of, layout_of(of)).scenes[0].realtime_factor > 0.0


# layout: the layout of a store: sizes, chunks, coordinates, and runs that do not fit together.
def layout(folder: Path, spec: str = SPEC, scene: str = SCENE) -> StoreLayout:
    return layout_of(inputs(folder, spec, scene))


def test_a_run_is_whole_chunks_of_each_array(tmp_path: Path) -> None:
    of = layout(tmp_path)
    assert of.sizes == {"run": 4, "scan": 3, "azimuth": 60, "range": 40, "body": 2, "crossing": 4, "plot": 40, "label": 1}
    for each in of.arrays:
        assert each.dims[0] == "run" and of.chunks(each)[0] == 1 and of.chunks(each)[2:] == of.shape(each)[2:]
    video = next(each for each in of.arrays if each.name == "video")
    assert (of.shape(video), of.chunks(video)) == ((4, 3, 60, 40), (1, 2, 60, 40))
    expected = 3 * (60 * 8 + 60 * 40 * (1 + 4) + 4 * (4 + 1 + 8 * 8))
    assert of.bytes_per_run == expected and of.bytes == 4 * expected and of.chunk_bytes == expected * 2 // 3


def test_chunks_are_of_some_size_by_default(tmp_path: Path) -> None:
    of = layout(tmp_path, SPEC.replace("scans = 3\nscans_per_chunk = 2", "scans = 100_000"))
    assert of.scans_per_chunk == CHUNK_BYTES // (60 * 40 * 4)
    assert layout(tmp_path, SPEC.replace("scans_per_chunk = 2", "")).scans_per_chunk == 3


def test_what_is_known_before_the_first_run_is_a_coordinate(tmp_path: Path) -> None:
    of = layout(
        tmp_path, SPEC.replace("[vary]", '[vary]\n"environment.noise" = [true]\n"body.cube.position_m" = [[200, 100, 0]]')
    )
    values = {name: each.values.tolist() for name, each in of.coordinates.items()}
    assert (
        values["run"] == [0, 1, 2, 3] and values["body_name"] == ["buoy", "cube"] and values["scene"] == ["small.toml"] * 4
    )
    assert values["body.buoy.rcs_dbsm"] == [5.0, 5.0, 15.0, 15.0] and values["environment.noise"] == [True] * 4
    assert values["body.cube.position_m"] == ["[200, 100, 0]"] * 4 and len(set(values["seed"])) == 4
    assert values["radar_id"] == [""] * 4
    assert values["range"] == pytest.approx((np.arange(40) + 0.5) * 15.0, rel=0.01)  # 600 m, but for the last cell
    assert all(each.values.shape == tuple(of.sizes[dim] for dim in each.dims) for each in of.coordinates.values())


def test_labels_are_as_wide_as_their_numbers(tmp_path: Path) -> None:
    of = layout(tmp_path, SPEC.replace('"truth"', '"labels"'))
    assert {each.name: each.dtype for each in of.arrays}["labels"] == "uint16"
    assert of.labels["small.toml"]["256"] == "buoy" and of.labels["small.toml"]["257"] == "cube"


def test_ranges_that_differ_are_told_run_by_run(tmp_path: Path) -> None:
    """Also where a draw may change them."""
    for values in ("[600, 1200]", "{uniform = [600, 700]}"):
        of = layout(tmp_path, SPEC + f'"radar.range_max_m" = {values}')
        assert "range" not in of.coordinates and [each.name for each in of.arrays][:2] == ["range_first", "range_step"]
    assert "range" in layout(tmp_path, SPEC + '"radar.rpm" = [24, 48]').coordinates


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ((("bins = 40", ""), ("[vary]", '[vary]\n"radar.range_max_m" = [600, 300]')),
         r"^run 0 has 301 bins, and run 4 151; all share arrays: set bins to 151 or less$"),
        ((("[vary]", '[vary]\n"radar.azimuths" = [60, 90]'),),
         "^run 0 has 60 azimuths, and run 4 90; all share arrays: give radars of as many azimuths, or make a sweep of each$"),
        ((('"small.toml"', '["small.toml", "open-sea"]'), ("[vary]\n", "[vary]\n#")), "^run 0 has 60 azimuths, and run 2 720"),
    ],
)  # fmt: skip
def test_runs_that_share_no_arrays_are_refused(change: Any, message: str, tmp_path: Path) -> None:
    spec = SPEC
    for old, new in change:
        spec = spec.replace(old, new)
    with pytest.raises(SweepError, match=message):
        layout(tmp_path, spec)


def test_a_scene_whose_files_are_rubbish_is_refused_before_anything_begins(tmp_path: Path) -> None:
    written(tmp_path)
    of = inputs(tmp_path)
    broken = type(of)(of.spec, (type(of.scenes[0])("small.toml", of.scenes[0].content, {"cube.obj": b"rubbish"}),))
    with pytest.raises(SweepError, match=r"^small.toml, body.buoy.rcs_dbsm = 5: .*cube.obj"):
        layout_of(broken)


# spec: the specification of a sweep: what it may say, what it may not, and its schema.
def spec(folder: Path, text: str) -> SweepSpec:
    return load_spec(written(folder, text))


def test_defaults_are_one_scan_of_video() -> None:
    one = SweepSpec(scene="harbour")  # type: ignore[arg-type]  # a name alone stands for a list of it
    assert (one.scene, one.scans, one.seeds, one.keep, one.fidelity, one.bins) == (
        ("harbour",),
        1,
        1,
        ("video",),
        "auto",
        None,
    )


def test_keys_without_quotes_are_the_same_as_with(tmp_path: Path) -> None:
    plain = spec(
        tmp_path,
        'scene = "small.toml"\n[vary]\nradar.rpm = [24, 48]\nbody.ferry.speed_kn.uniform = [4, 18]\nname = ["a"]',
    )
    quoted = spec(
        tmp_path,
        'scene = "small.toml"\n[vary]\n"radar.rpm" = [24, 48]\n"body.ferry.speed_kn" = {uniform = [4, 18]}\n"name" = ["a"]',
    )
    assert plain == quoted and [*plain.vary] == ["radar.rpm", "body.ferry.speed_kn", "name"]


BAD = {
    'scene = "a"\nscans = 0': "scans: Input should be greater than or equal to 1",
    'scene = "a"\nscans = "two"': "scans: Input should be a valid integer",
    'scene = "a"\nseeds = true': "seeds: Input should be a valid integer",
    'scene = "a"\nscan = 3': "scan: Extra inputs are not permitted",
    "scene = []": "scene: Tuple should have at least 1 item",
    "scans = 3": "scene: Field required",
    'scene = ["a", "a"]': "scene: one of them occurs twice",
    'scene = "a"\nkeep = ["video", "video"]': "keep: one of them occurs twice",
    'scene = "a"\nkeep = ["audio"]': "keep.0: Input should be 'video', 'power'",
    'scene = "a"\nfidelity = "best"': "fidelity: 'best' is none; give auto, ",
    'scene = "a"\nfidelity = "documented"\nkeep = ["labels"]': "keep: the fidelity documented has no labels",
    'scene = "a"\n[vary]\n"radar.rpm" = []': "vary: 'radar.rpm' has 0 values",
    'scene = "a"\n[vary]\n"radar.rpm" = [nan]': "vary: 'radar.rpm' has a value that is no finite number",
    'scene = "a"\n[vary]\n"body.x.position_m" = [[0, inf, 0]]': "vary: 'body.x.position_m' has a value that is no finite number",
    'scene = "a"\n[vary]\n"radar.rpm" = [2026-12-31]': "vary: 'radar.rpm' has a value that is no finite number",
    'scene = "a"\n[vary]\n"radar.rpm" = 24': "vary.radar.rpm: Input should be",
    'scene = "a"\n[vary]\n"radar.rpm" = {uniform = [nan, 1]}': "vary.radar.rpm.uniform.0: Input should be a finite number",
    'scene = "a"\n[vary]\n"radar.rpm" = {uniform = [2, 1]}': "vary.radar.rpm: uniform: 2 is not below 1",
    'scene = "a"\n[vary]\n"radar.rpm" = {uniform = [1, 2], range = [1, 2]}': "vary.radar.rpm: give one of range, uniform,",
    'scene = "a"\n[vary]\n"radar.rpm" = {count = 3}': "vary.radar.rpm: give one of range, uniform,",
    'scene = "a"\n[vary]\n"radar.rpm" = {range = [1, 2]}': "vary.radar.rpm: range: it needs a count of 2 or more",
    'scene = "a"\n[vary]\n"radar.rpm" = {normal = [1, 0]}': "vary.radar.rpm: normal: a standard deviation of 0",
    'scene = "a"\n[vary]\n"radar.rpm" = {log_uniform = [0, 1]}': "vary.radar.rpm: log_uniform: 0 is not allowed",
    'scene = "a"\n[vary]\n"radar.rpm" = {integers = [1.5, 2]}': "vary.radar.rpm.integers.0: Input should be a valid integer",
    'scene = "a"\n[vary]\n"radar.rpm" = {choice = [nan]}': "vary: 'radar.rpm' has a value that is no finite number",
    'scene = "a': "Unterminated string",
    'scene = "a"\n"a b" = 3': "a b: Extra inputs are not permitted",
}


@pytest.mark.parametrize("text", BAD)
def test_what_is_wrong_is_named(text: str, tmp_path: Path) -> None:
    with pytest.raises(SweepError) as raised:
        spec(tmp_path, text)
    lines = str(raised.value).splitlines()
    assert all(line.startswith(f"{tmp_path / 'sweep.toml'}: ") for line in lines)
    assert any(BAD[text] in line for line in lines), lines


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(SweepError, match="none.toml: No such file or directory; give the TOML file of a sweep"):
        load_spec(tmp_path / "none.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff")
    with pytest.raises(SweepError, match="bytes.toml: .*; correct the file"):
        load_spec(tmp_path / "bytes.toml")


def test_the_schema_accepts_what_the_model_does(tmp_path: Path) -> None:
    import tomllib

    validator = jsonschema.Draft202012Validator(json_schema())
    validator.check_schema(json_schema())
    for text in (SPEC, 'scene = ["a"]\n[vary]\n"radar.rpm" = {uniform = [1.0, 2.0], count = 3}'):
        assert not [*validator.iter_errors(tomllib.loads(text))] and spec(tmp_path, text)
    assert [*validator.iter_errors({"scene": ["a"], "scans": 0})]


# sweep: one run of a sweep: the values of `scan`, written once, by whoever may.
def laid_out(folder: Path, spec: str = SPEC) -> SweepStore:
    of = inputs(folder, spec)
    return lay_out(str(folder / "out.zarr"), of, layout_of(of), arithmetic())


@pytest.mark.same_bytes
def test_a_run_has_the_values_of_a_simulator(tmp_path: Path) -> None:
    store = laid_out(tmp_path, SPEC.replace("bins = 40", ""))
    of = store.inputs
    run(store.address, store.digest, 2)
    dataset = open_dataset(store.address)
    sim = rs.Simulator(of.scene(of.runs[2]), seed=int(dataset.seed[2]))
    for number in range(3):
        scan = sim.scan()
        np.testing.assert_array_equal(dataset.power[2, number], scan.power)
        np.testing.assert_array_equal(dataset.time[2, number], scan.time)
        assert dataset.truth_range[2, number, 0] == sim.crossings(number)[0].range
    np.testing.assert_allclose(dataset.range, scan.range, rtol=1e-12)  # rounding of one product
    assert store.finished.tolist() == [False, False, True, False] and np.isnan(dataset.power[1]).all()


def test_a_finished_run_is_not_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = laid_out(tmp_path)
    run(store.address, store.digest, 0)
    monkeypatch.setattr(sweep_module, "Simulator", None)
    run(store.address, store.digest, 0)


def test_a_run_that_is_made_again_has_the_same_bytes(tmp_path: Path) -> None:
    store = laid_out(tmp_path)
    run(store.address, store.digest, 1)
    before = content(store.address)
    (tmp_path / "out.zarr" / "digest" / "c" / "1").unlink()
    (tmp_path / "out.zarr" / "power" / "c" / "1" / "0" / "0" / "0").write_bytes(b"half")
    run(store.address, store.digest, 1)
    assert content(store.address) == before


def test_runs_that_differ_in_seed_alone_share_a_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store, loaded = laid_out(tmp_path, SPEC.replace("seeds", "seed = 9\nseeds")), list[int]()  # none that others have kept
    scene = sweep_module.Inputs.scene

    def counted(of: Any, one: Any) -> Any:
        loaded.append(one.number)
        return scene(of, one)

    monkeypatch.setattr(sweep_module.Inputs, "scene", counted)
    for number in (0, 1, 2, 3, 0):
        run(store.address, store.digest, number)
    assert loaded == [0, 2]


def test_ranges_that_differ_are_written_run_by_run(tmp_path: Path) -> None:
    store = laid_out(tmp_path, SPEC + '"radar.range_max_m" = [600, 1200]')
    for number in (0, 2):
        run(store.address, store.digest, number)
    dataset = open_dataset(store.address)
    step = dataset.range_step.values
    assert step[2] == pytest.approx(2.0 * step[0], rel=0.01) and np.isnan(step[1]) and "range_first" in dataset.coords


def test_a_store_of_something_else_is_refused(tmp_path: Path) -> None:
    store = laid_out(tmp_path)
    with pytest.raises(SweepError, match="another store stands there now; begin again"):
        run(store.address, "0" * 32, 0)


@pytest.mark.parametrize("what", ["program", "arithmetic"])
def test_a_worker_that_would_make_other_bytes_refuses(what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = laid_out(tmp_path)
    monkeypatch.setattr(sweep_module, what, lambda: "another")
    with pytest.raises(
        SweepError, match=f"^{what}: this worker has another, and the store .*; bytes would differ: use equal"
    ):
        run(store.address, store.digest, 0)
    assert not store.finished.any()
