"""Uses the foreign packages, in a process that has them installed, and prints what they gave as JSON.

python -m tests.plug_ins.played, in a folder with the files of `test_packages`
"""

import contextlib
import hashlib
import io
import json
from typing import Any

import numpy as np

import radar_service as rs
from radar_service.__main__ import main
from radar_service.bench import TrackerInput
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.bench.trackers.trackers import program_digest, tracker_for
from radar_service.radar_feed import RadarFeeds
from radar_service.scene_file.describe import describe, json_schema
from radar_service.scene_file.readers.sandbox import Sandbox
from radar_service.truth.truth_file import scene_hash

RADAR = {
    "azimuths": 180, "beamwidth_deg": 4, "range_max_m": 3000, "pulse_s": 2.5e-7, "bandwidth_hz": 6e6, "modulation": "none",
    "sample_rate_hz": 15e6, "noise_figure_db": 4,
}  # fmt: skip
WORLD = {
    "name": "birds",
    "radar": RADAR,
    "environment": {"noise": True, "multipath": True, "sea_state": 1},
    "own_ship": {"speed_kn": 10, "course_deg": 40},
    "body": [{"name": "buoy", "shape": "point", "position_m": [0, 900, 4], "rcs_dbsm": 10}],
}
FLOCK = {"position_m": [800, 1500, 30], "birds": 25, "rcs_dbsm": 0, "course_deg": 200}
JAMMER = {"bearing_deg": 200, "level_db": 45}


def played(content: dict[str, Any], fidelity: str = "balanced", **more: Any) -> tuple[rs.Simulator, rs.Scan]:
    """The second scan, with its sources."""
    sim = rs.Simulator(rs.load_scene(content), fidelity, seed=3, labels=True, powers="all", **more)
    sim.skip_to(1)
    return sim, sim.scan()


def digest(*arrays: Any) -> str:
    return hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)).hexdigest()


def plain() -> dict[str, Any]:
    """Bytes, hash and names of a scene without the effects."""
    sim, scan = played(WORLD)
    powers = sim.source_powers(1)
    crossings = [crossing.as_dict() for crossing in sim.crossings(1)]
    return {
        "bytes": digest(scan.field, scan.labels, *(powers[key] for key in sorted(powers))),
        "truth": [*crossings, sim.snapshot(1).as_dict()],
        "hash": scene_hash(sim.scene),
        "names": {str(number): name for number, name in sim.label_names.items()},
        "plan": [choice["how"] for choice in sim.unmeasured_info.plan["choices"]],
    }


def with_birds_and_jammer() -> dict[str, Any]:
    """What both effects give."""
    content = WORLD | {"flock": [FLOCK], "jammer": [JAMMER]}
    sim, scan = played(content)
    numbers = {name: number for number, name in sim.label_names.items()}
    powers, choices = sim.source_powers(1), {choice.what: choice for choice in sim.plan.choices}
    strobe = int(powers[numbers["jammer"]].sum(axis=1).argmax())
    return {
        "numbers": {name: numbers[name] for name in ("birds", "jammer")},
        "labelled": {name: int((scan.labels == numbers[name]).sum()) for name in ("birds", "jammer")},
        "powers": {name: float(powers[numbers[name]].sum()) for name in ("birds", "jammer")},
        "strobe_deg": float(np.degrees(scan.azimuth[strobe])),
        "costs": {what: choices[what].microseconds for what in ("flocks", "jammers")},
        "documented": {c.what: c.how for c in rs.Simulator(sim.scene, "documented").plan.choices},
        "check": describe(sim.scene),
        "truth": sim.snapshot(1).as_dict()["flock"],
        "in two processes": digest(played(content, threads=2)[1].field) == digest(scan.field),
        "bytes": digest(scan.field),
    }


def one_bird_and_a_point() -> float:
    """Largest difference of a flock of one bird and a body that is a point, over the strongest cell [dB]."""
    bare = WORLD | {"body": [], "environment": {"multipath": True}}
    place = {"position_m": [400, 1100, 25], "rcs_dbsm": 10, "speed_kn": 25, "course_deg": 120}
    body = {"name": "bird", "shape": "point", **place}
    kinds = {"flock": [{"birds": 1, **place}]}, {"body": [body]}
    birds, points = (played(bare | kind, "reference")[1] for kind in kinds)
    return float(20 * np.log10(np.abs(birds.field - points.field).max() / np.abs(points.field).max()))


def behind_a_radome() -> dict[str, Any]:
    """A buoy at rest 40 degrees to port of the bow, with and without a radome of 3 dB one way there, that is damaged."""
    content = WORLD | {"own_ship": {"heading_deg": 40}, "environment": {}}
    damaged = content | {"radar": RADAR | {"radome": {"bearing_deg": 320, "width_deg": 90, "loss_db": 3}}}
    (sim, scan), (_, plain) = played(damaged), played(content)
    return {
        "weaker_db": float(10 * np.log10(plain.power.max() / scan.power.max())),
        "truth_db": sim.crossings(1)[0].as_dict()["structure_db"],
        "plan": next(choice.how for choice in sim.plan.choices if choice.what == "radome"),
        "hash": scene_hash(sim.scene) != scene_hash(rs.load_scene(content)),
    }


def served() -> dict[str, Any]:
    """A scan of a service in processes of its own, with labels and truth, against one of this process."""
    content = WORLD | {"flock": [FLOCK], "jammer": [JAMMER]}
    scans, labels, flocks = [], [], []
    for over in ("process", "websocket"):
        with RadarFeeds() as feeds:
            feed = feeds(content, seed=3, over=over, fidelity="balanced", labels=True)
            (scan,) = feed.scans(1)
            scans.append(digest(scan.field, scan.labels))
            labels.append(feed.label_names[128])
            flocks.append(feed.snapshots[0].effects["flock"])
    return {"same bytes": scans[0] == scans[1], "names": labels, "same truth": flocks[0] == flocks[1]}


def refusals() -> list[str]:
    """What is said of scenes that are wrong."""
    texts = []
    narrow = {"radar": RADAR | {"radome": {"bearing_deg": 0, "width_deg": 1, "loss_db": 1}}}
    flocks = [{"flok": [FLOCK]}, {"flock": [FLOCK | {"birds": 0}]}, {"flock": [{"position_m": [0, 0, 0], "bird": 1}]}]
    for keys in (*flocks, narrow):
        try:
            rs.load_scene(WORLD | keys)
        except rs.SceneError as error:
            texts.append(str(error))
    return texts


def command(*words: str) -> tuple[int, str, str]:
    """Exit status, output and errors of the command line."""
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as errors:
        try:
            status = main(words)
        except SystemExit as ended:  # --help
            status = int(ended.code or 0)
    return status, out.getvalue(), errors.getvalue()


def read_bodies() -> list[list[Any]]:
    """Bodies of a foreign mesh file, read in this process and then in the sandbox."""
    sandbox = Sandbox()
    scenes = rs.load_scene("scene.toml"), rs.load_scene("scene.toml", mesh_reader=sandbox)
    sandbox.close()
    bodies = [body for scene in scenes for body in scene.bodies]
    return [[body.name, body.motion.position[0].round(6).tolist(), body.mesh.faces.shape[0]] for body in bodies if body.mesh]


def tracked() -> dict[str, Any]:
    """The track of a foreign tracker, and what is said of a broken one."""
    tracker = tracker_for("still", {"type": "header"})
    scan = TrackerInput(scan=0, time=2.5, east=3.0, north=4.0, heading=0.0, course=0.0, speed=0.0, plots=())
    tracks = [(track.east, track.north) for track in tracker.update(scan)]
    tracker.close()
    try:
        tracker_for("broken", {"type": "header"})
    except TrackerError as error:
        return {"tracks": tracks, "has digest": bool(program_digest("still")), "broken": str(error)}
    raise AssertionError


def broken_parts() -> list[str]:
    """What is said of scenes that use broken parts."""
    keys: list[dict[str, Any]] = [
        {"mesh": "one.broken"}, {"heightmap": "one.broken", "extent_m": [100, 100]},
        {"mesh": "one.obj", "scattering": "broken"}, {"shape": "point", "rcs_dbsm": 0, "broken": 1}, {},
    ]  # fmt: skip
    texts = []
    for given in keys:
        scene = {"body": [{"name": "one", "position_m": [0, 500, 0], **given}]} if given else {"broken": 1}
        try:
            rs.Simulator(rs.load_scene(scene, folder="."))
        except Exception as error:
            texts.append(str(error))
    return texts


if __name__ == "__main__":
    told = {
        "commands": [command(*line.split()) for line in ("broken", "hello sea", "--help", "replay --help")],
        "bodies": read_bodies(), "tracker": tracked(), "broken": broken_parts(), "plain": plain(),
        "both": with_birds_and_jammer(), "one_db": one_bird_and_a_point(), "radome": behind_a_radome(), "refusals": refusals(),
        "served": served(), "schema": json_schema()["$defs"]["FlockModel"],
    }  # fmt: skip
    print(json.dumps(told))
