"""Scenarios of the test bench: a scene, the question that it asks, and limits with their sources. Files are TOML."""

import contextlib
import hashlib
import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from radar_service.numerics import BIASES, SCENARIO, generator, name_key
from radar_service.scene_file import drawn_biases, packaged_folder
from radar_service.terminal import UsageError, did_you_mean

SUFFIX = ".toml"
SCENE_KEYS = {"radar", "body", "own_ship", "environment", "origin", "bench"}  # of a scene file, and of no scenario file
CLUTTER = {"sea_state", "wave_height_m", "rain_mm_h", "rain_cell"}  # keys of an environment with clutter
OF_SHIPS = {"gap_cells": 12, "gap_spokes": 4, "split_db": 200.0, "max_plots": 200}  # the plots of a ship are one
AMONG_OTHERS = OF_SHIPS | {"threshold": "ca", "pfa": 1e-6, "guard_m": 150.0, "window_m": 300.0}  # longer than a ship
MOTION = {"speed_kn", "waypoints", "track", "manoeuvre"}  # keys of bodies that move


class ScenarioError(UsageError):
    """A scenario that cannot be used. Its text names the file, the key and the remedy."""


class FrozenTable(BaseModel):
    """A table of a file: it is frozen, and has no other keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Limit(FrozenTable):
    """One limit on a metric. Only limits whose source was read decide; the others are shown.

    where_judged: whether it asks nothing of runs that cannot judge the metric, as a turn where nobody turns.
    """

    metric: str = Field(min_length=1)
    maximum: float | None = None
    minimum: float | None = None
    source: str = Field(min_length=1)
    decides: bool = True
    where_judged: bool = False

    def is_met(self, value: float | None) -> bool:
        """Returns whether a value lies within the limit; no value does not."""
        if value is None or math.isnan(value):
            return False
        return (self.maximum is None or value <= self.maximum) and (self.minimum is None or value >= self.minimum)


PLOT_METRICS = (
    "detected", "detected_worst", "resolved", "false_plots", "range_bias_m", "range_sd_m", "bearing_bias_deg", "bearing_sd_deg",
)  # fmt: skip
OURS = "this project, in every scenario"
GENERAL = tuple(
    Limit(metric=metric, source=OURS, where_judged=True, **bound)
    for metric, bound in {
        "completeness": {"minimum": 0.95}, "spurious": {"maximum": 0.02}, "ambiguity": {"maximum": 1.02},
        "identity_changes": {"maximum": 0.0}, "first_state_scans": {"maximum": 10.0}, "velocity_kn_1min": {"maximum": 1.5},
        "velocity_kn_3min": {"maximum": 0.8}, "velocity_kn_median": {"maximum": 1.5}, "velocity_kn_95": {"maximum": 3.0},
        "course_after_turn_deg": {"maximum": 5.0}, "turn_lag_s": {"maximum": 15.0}, "turn_course_deg": {"maximum": 30.0},
        "bridged": {"minimum": 1.0}, "gone_scans": {"maximum": 20.0}, "localisation_share": {"maximum": 1.0},
        "delay_s": {"maximum": 1.0}, "trend_s": {"maximum": 60.0}, "vector_s": {"maximum": 180.0},
        "false_noise_h": {"maximum": 1.0}, "false_sea_h": {"maximum": 24.0}, "false_rain_h": {"maximum": 24.0},
        "false_land_h": {"maximum": 240.0}, "answer_turns": {"maximum": 1.0}, "growth_mb": {"maximum": 2.0},
    }.items()
) + tuple(
    Limit(metric=metric, source=f"MSC.192(79) {clause}, where the tracker says it", where_judged=True, maximum=maximum)
    for metric, maximum, clause in (
        ("said_cpa_nm", 0.3, "table 3"), ("said_tcpa_min", 0.5, "table 3"), ("alarm_late_scans", 2.0, "5.29.1"),
        ("false_alarms", 0.0, "5.29.1"), ("lost_errors", 0.0, "5.29.4"), ("full_errors", 0.0, "5.25.2.2"),
        ("ais_missed", 0.05, "5.30.1"), ("ais_wrong", 0.02, "5.30.3"), ("priority_errors", 0.0, "5.30.1"),
        ("acquisition_errors", 0.0, "5.25.3"),
    )
)  # fmt: skip


class PlotSettings(FrozenTable):
    """How plots are extracted; see docs/plots.md.

    threshold: "auto" is "marine" where the scene has sea, rain or land, and "known" elsewhere.
    pfa: None: 1e-7, or the default of "marine".
    """

    threshold: Literal["auto", "known", "ca", "os", "marine"] = "auto"
    pfa: Annotated[float, Field(gt=0, lt=1)] | None = None
    guard_m: Annotated[float, Field(gt=0)] = 100.0
    window_m: Annotated[float, Field(gt=0)] = 300.0
    gap_spokes: Annotated[int, Field(ge=1, le=1000)] = 2
    gap_cells: Annotated[int, Field(ge=1, le=1000)] = 2
    split_db: Annotated[float, Field(gt=0)] = 9.0
    max_plots: Annotated[int, Field(ge=1, le=10_000)] = 40
    nearest_m: Annotated[float, Field(ge=0)] = 0.0


class PlotErrors(FrozenTable):
    """Errors of plots of points, as A.823(19), appendix 3, has them.

    range_sd_m, bearing_sd_deg: standard deviations of normal errors, as from the shapes of pulse and beam; those of noise are in
    the plots already.
    range_step_m: ranges are rounded to whole steps; 0: not rounded.
    glint_length_m: of a ship whose echo wanders along it, with a sixth of this as standard deviation; None: of each its own.
    roll_deg, roll_period_s: of own ship: bearings err by half the square of the roll, times sine and cosine of the relative
    bearing, twice in each period; its phase is drawn by the seed.
    missed: share of all plots that are left out. others: mean number of further plots in a scan, spread over OTHERS_M of range.
    """

    range_sd_m: Annotated[float, Field(ge=0)] = 0.0
    bearing_sd_deg: Annotated[float, Field(ge=0)] = 0.0
    range_step_m: Annotated[float, Field(ge=0)] = 0.0
    glint_length_m: Annotated[float, Field(ge=0)] | None = None
    roll_deg: Annotated[float, Field(ge=0, le=45)] = 0.0
    roll_period_s: Annotated[float, Field(gt=0)] = 10.0
    missed: Annotated[float, Field(ge=0, lt=1)] = 0.0
    others: Annotated[float, Field(ge=0, le=1000)] = 0.0


# Plots of a small dome in a canal: the middle of what five encounters of the recorded set of Trondheim have, to 500 m.
PROFILES = {"inland": PlotErrors(range_sd_m=3.5, bearing_sd_deg=4.5, glint_length_m=0.0, missed=0.1, others=2.5)}
OTHERS_M = 500.0


class AisStation(FrozenTable):
    """A transponder, whose reports a tracker gets beside the plots.

    body: its target; None: a ghost, at position_m (east, north) at time 0. latency_s: of reception, beside the slot.
    position_error_m: standard deviation of each axis. From swap_s on it reports the motion of the target `swap_body`.
    """

    mmsi: Annotated[int, Field(ge=1, le=999_999_999)]
    body: str | None = None
    station_class: Literal["A", "B-SO", "B-CS"] = "A"
    latency_s: Annotated[float, Field(ge=0, le=600)] = 0.0
    position_error_m: Annotated[float, Field(ge=0)] = 10.0
    offset_m: tuple[float, float] = (0.0, 0.0)
    swap_s: float | None = None
    swap_body: str | None = None
    position_m: tuple[float, float] = (0.0, 0.0)
    course_deg: float = 0.0
    speed_kn: Annotated[float, Field(ge=0)] = 0.0

    @model_validator(mode="after")
    def _swaps_at_a_time(self) -> "AisStation":
        if (self.swap_s is None) != (self.swap_body is None):
            raise ValueError("swap_s and swap_body: one needs the other")
        return self

    def body_at(self, time: float) -> str | None:
        """Returns the target whose motion it reports at a time [s]."""
        return self.body if self.swap_s is None or time < self.swap_s else self.swap_body


class Order(FrozenTable):
    """What a user asks at the end of a scan: to acquire a target or to cancel its track, by the target's name, or to acquire by
    itself in a zone alone: nearest and farthest range [m], true bearings clockwise from one to another [degrees]."""

    scan: Annotated[int, Field(ge=0)]
    acquire: str | None = None
    cancel: str | None = None
    zone: tuple[float, float, float, float] | None = None


class Scenario(FrozenTable):
    """One scenario.

    name: of its file. question, expected, source: in sentences. scans: its length. fidelity: of the simulation.
    radar: id of the radar whose plots the tracker gets; the first one by default.
    targets: names of the bodies that are to be tracked; all by default.
    vary_m: each seed moves the start of each target by up to this much east and north [m].
    plot_errors: of points; none by default. Of a recording they say what its plots have.
    draw_biases: whether each seed draws the signs and directions of the biases of own ship's sensors.
    limit: of this scenario; one for a metric of GENERAL stands in its place.
    input: what a program gets: plots, or the video of the radar, which it reads from a service.
    answers: what it answers: tracks, also as TTM of a program of others in real time, or the plots of the video.
    serve: further options of the service that gives the video.
    judges: tracks by the limits of GENERAL too; or plots, of which these say nothing.
    not_judged: metrics of GENERAL that the scenario's own limits make needless, or that its errors leave nothing of; "*": all.
    scene: a scene, as a scene file has it.
    standard_nm: ranges of first detection that a standard states, by target [NM]: shown beside those of detection studies.
    recorded: a file beside its own with plots and truth of a real radar, which then take the place of those of the scene.
    folder: of its meshes, height maps and tracks, and of a recording. file: its own; None of a packaged one.
    """

    name: str = ""
    question: str = Field(min_length=1)
    expected: str = Field(min_length=1)
    source: str = Field(min_length=1)
    scans: Annotated[int, Field(ge=1, le=100_000)] = 60
    fidelity: str = "balanced"
    radar: str | None = None
    targets: tuple[str, ...] = ()
    vary_m: Annotated[float, Field(ge=0, le=10_000)] = 10.0
    plots: PlotSettings = PlotSettings()
    plot_errors: PlotErrors | None = None
    ais: tuple[AisStation, ...] = ()
    order: tuple[Order, ...] = ()
    draw_biases: bool = False
    input: Literal["plots", "video"] = "plots"
    answers: Literal["tracks", "ttm", "plots"] = "tracks"
    serve: tuple[str, ...] = ()
    judges: Literal["tracks", "plots"] = "tracks"
    not_judged: tuple[str, ...] = ()
    limit: tuple[Limit, ...] = ()
    scene: Mapping[str, Any]
    standard_nm: Mapping[str, Annotated[float, Field(gt=0)]] = {}
    recorded: str | None = None
    folder: Annotated[Path | None, Field(exclude=True)] = None
    file: Annotated[Path | None, Field(exclude=True)] = None

    @model_validator(mode="after")
    def _names_are_of_targets(self) -> "Scenario":
        named = [("ais", name) for station in self.ais for name in (station.body, station.swap_body)]
        for table, name in (*named, *(("order", name) for order in self.order for name in (order.acquire, order.cancel))):
            if name not in (None, *self.tracked):
                raise ValueError(f"{table}: there is no target {name!r}")
        ordered = [order.model_dump(exclude={"scan"}, exclude_none=True) for order in self.order]
        if any(len(each) != 1 for each in ordered) or sum("zone" in each for each in ordered) > 1:
            raise ValueError("order: one of acquire, cancel and zone is needed in each, and one zone in all")
        if len({station.mmsi for station in self.ais}) < len(self.ais):
            raise ValueError("ais: two stations have one mmsi")
        return self

    @cached_property
    def tracked(self) -> tuple[str, ...]:
        """Names of the bodies that are to be tracked."""
        return self.targets or tuple(body["name"] for body in self.scene.get("body", ()))

    @property
    def in_clutter(self) -> bool:
        """Whether it has sea or rain, whose scans take ten times as long."""
        return not CLUTTER.isdisjoint(self.scene.get("environment", ()))

    @cached_property
    def limits(self) -> tuple[Limit, ...]:
        """All limits: its own, and those of GENERAL for which it has none of its own."""
        own = {limit.metric for limit in self.limit} | set(self.not_judged)
        judged = self.judges == "tracks" and "*" not in self.not_judged
        return (*self.limit, *(limit for limit in GENERAL if judged and limit.metric not in own))

    def missed(self, metrics: Mapping[str, float | None]) -> dict[str, float | None]:
        """Returns the limits that decide and that a run misses, by metric, with its values."""
        judged = [limit for limit in self.limits if limit.decides and (limit.metric in metrics or not limit.where_judged)]
        return {limit.metric: metrics.get(limit.metric) for limit in judged if not limit.is_met(metrics.get(limit.metric))}

    @cached_property
    def digest(self) -> str:
        """A hash of all that the scenario says: runs of another one are not mixed with its own."""
        return hashlib.blake2b(
            self.model_dump_json(exclude={key for key in ("ais", "order") if not getattr(self, key)}).encode(), digest_size=8
        ).hexdigest()

    def scene_for(self, seed: int) -> dict[str, Any]:
        """Returns the scene of one seed: each target starts up to `vary_m` elsewhere, by a draw for its name alone, and biases of
        sensors have signs of their own."""
        bodies = [self._moved(dict(body), seed) for body in self.scene.get("body", ())]
        scene = {"name": self.name, **self.scene, "body": bodies}
        if self.draw_biases and "errors" in scene:
            scene["errors"] = drawn_biases(scene["errors"], generator(seed, BIASES))
        return scene

    def _moved(self, body: dict[str, Any], seed: int) -> dict[str, Any]:
        if body["name"] in self.tracked and "position_m" in body:
            east, north = generator(seed, SCENARIO, name_key(self.name, body["name"])).uniform(-self.vary_m, self.vary_m, 2)
            at = body["position_m"]
            body["position_m"] = [float(at[0] + east), float(at[1] + north), *at[2:]]
        return body


def scenarios() -> dict[str, Path]:
    """Returns the packaged scenarios by name."""
    folder = packaged_folder("scenes") / "scenarios"
    return {path.relative_to(folder).with_suffix("").as_posix(): path for path in sorted(folder.rglob(f"*{SUFFIX}"))}


def load_scenario(name: str) -> Scenario:
    """Returns a packaged scenario by name, that of a file, or one of a scene file. Raises ScenarioError."""
    path = file_of(name, scenarios(), "scenario")
    file = path if name.endswith(SUFFIX) else None
    with file_errors(path):
        content = tomllib.loads(path.read_text(encoding="utf-8"))
        content = scenario_of_scene(content) if SCENE_KEYS & content.keys() else content
        folder = path.parent if file else packaged_folder("scenes")
        return Scenario(**{"name": path.stem if file else name, **content, "folder": folder, "file": file})


def file_of(name: str, packaged: Mapping[str, Path], kind: str) -> Path:
    """Returns the file of a packaged scenario or ladder, or the one that is named. Raises ScenarioError."""
    if name.endswith(SUFFIX):
        return Path(name)
    if name not in packaged:
        there = f"there are {', '.join(packaged)}, or give a {SUFFIX} file{did_you_mean(name, packaged)}"
        raise ScenarioError(f"{name}: there is no such {kind}; {there}")
    return packaged[name]


@contextlib.contextmanager
def file_errors(path: Path) -> Iterator[None]:
    """Raises a ScenarioError that names the file for each error of reading it."""
    try:
        yield
    except OSError as error:
        raise ScenarioError(f"{path}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ScenarioError(f"{path}: {error}; correct the file") from None
    except ValidationError as error:
        lines = (f"{path}: {'.'.join(map(str, e['loc']))}: {e['msg']}; correct the key" for e in error.errors())
        raise ScenarioError("\n".join(lines)) from None


def scenario_of_scene(scene: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the content of a scenario of a scene file, judged by the limits of every scenario and by its table `bench`.

    Targets are the bodies that move, or all where none does. Where others stand there, tracks of these are not false. Plots are
    extracted as AMONG_OTHERS says where these would flood a known threshold, and as OF_SHIPS says in sea or rain.
    """
    bodies = {str(body.get("name", "")): body for body in scene.get("body", ())}
    moving = [name for name, body in bodies.items() if MOTION & body.keys()] or [*bodies]
    bench, environment = scene.get("bench", {}), scene.get("environment", {})
    others = bodies.keys() - set(bench.get("targets", moving))
    return {
        "question": "Does the tracker meet the limits of every scenario in this scene?", "expected": "It meets them.",
        "source": "a scene file", "vary_m": 0.0, "targets": moving, "not_judged": ["spurious"] if others else [],
        "plots": OF_SHIPS if CLUTTER & environment.keys() else AMONG_OTHERS if others else {}, **bench,
        "scene": {key: table for key, table in scene.items() if key != "bench"},
    }  # fmt: skip


def with_profile(scenario: Scenario, profile: str) -> Scenario:
    """Returns a scenario whose plots err as one of PROFILES has it. Raises ScenarioError for a recording: its plots are real."""
    return _changed(scenario, "profile", plot_errors=PROFILES[profile])


def with_video(scenario: Scenario, answers: str = "tracks", serve: Sequence[str] = ()) -> Scenario:
    """Returns a scenario whose video a program reads; errors of its plots are not in it. Where the program answers plots, limits
    on plots alone judge it. Raises ScenarioError for a recording."""
    on_plots = [limit for limit in scenario.limit if limit.metric in PLOT_METRICS]
    judged = {"judges": "plots", "limit": on_plots} if answers == "plots" else {}
    return _changed(scenario, "input video", plot_errors=None, input="video", answers=answers, serve=tuple(serve), **judged)


def _changed(scenario: Scenario, option: str, **changed: Any) -> Scenario:
    if scenario.recorded:
        raise ScenarioError(f"{scenario.name}: its plots are recorded; leave --{option} out")
    return Scenario(**{**scenario.model_dump(), "folder": scenario.folder, "file": scenario.file, **changed})


def load_scenarios(names: Sequence[str]) -> list[Scenario]:
    """Returns scenarios as load_scenario does. Raises ScenarioError, also where two have one name: their runs would mix."""
    loaded: list[Scenario] = []
    given: dict[str, str] = {}
    for name in names:
        scenario = load_scenario(name)
        if scenario.name in given:
            remedy = "give each scenario once, and each file a name of its own"
            raise ScenarioError(f"{name}: {given[scenario.name]} is named {scenario.name} too; {remedy}")
        given[scenario.name] = name
        loaded.append(scenario)
    return loaded
