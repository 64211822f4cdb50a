"""The specification of a sweep: what it may say, what it may not, and its schema."""

from pathlib import Path

import jsonschema
import pytest

from radar_service.sweep.spec import SweepError, SweepSpec, json_schema, load_spec
from tests.sweep.sweeps import SPEC, written


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
