"""What the simulator computes in process: fields of all presets, a day of commands, labels, powers, truth, errors, files."""

import json
import subprocess
import sys
from pathlib import Path

import msgpack
import numpy as np
from mcap.reader import make_reader

import radar_service as rs
from radar_service.scene_file.describe import describe, json_schema
from radar_service.truth.ground_truth import scene_hash, truth_lines
from tests.measurements.tree_side.kept import Kept, lasting
from tests.measurements.tree_side.worlds import (
    AT_REST,
    DAY,
    ERRORS,
    PRESETS,
    RPM,
    SHIPPED,
    day_of_commands,
    real_scenes,
    two_radars,
    with_effects,
)

SEED = 1
DAYS_SCANS = 12  # that are computed of a day of commands
NARROW = (0.0, float(np.deg2rad(30.0)))  # rad: the sector of `reference`, which is slow, where bodies move


def fields_of(kept: Kept, name: str, scene: rs.Scene, fidelity: str) -> None:
    """Keeps the fields of the first scans, and the counts of the plan."""
    slow = fidelity == "reference"
    sim = rs.Simulator(scene, fidelity=fidelity, seed=SEED, sector=NARROW if slow and name not in AT_REST else None)
    for number in range(1 if slow else 3):
        kept.array(f"fields/{name}/{fidelity}/{number}", sim.scan().field)
    kept.record(f"fields/{name}/{fidelity}/counts", sim.plan.as_dict()["counts"])


def presets(kept: Kept, real: Path | None) -> None:
    """Each preset on each shipped scene, on the two radars, and on real input."""
    scenes = {name: rs.load_scene(name) for name in SHIPPED} | {"two-radars": rs.load_scene(two_radars())}
    for folder, content in real_scenes(real) if real else ():
        scenes[content["name"]] = rs.load_scene(content, folder=folder)
    for fidelity in PRESETS:
        for name, scene in scenes.items():
            fields_of(kept, name, scene, fidelity)


def effects(kept: Kept) -> None:
    """Scenes with beacons and other radars: sources, truth, plan, hash, and what `check` says of them; the schema of scenes."""
    for name, content, fidelity in with_effects():
        scene = rs.load_scene(content)
        sources = {} if fidelity == "documented" else {"labels": True, "powers": "all"}
        sim = rs.Simulator(scene, fidelity=fidelity, seed=SEED, **sources)
        sim.skip_to(2)
        if sources:
            keep_scan(kept, f"effects/{name}", sim, sim.scan())
            kept.record(f"effects/{name}/names", sim.label_names)
        kept.record(f"effects/{name}/plan", lasting(sim.unmeasured_info.plan))
        kept.record(f"effects/{name}/scene", [scene_hash(sim.scene), describe(scene), scene.warnings])
    kept.record("effects/schema", json_schema())


def commands(kept: Kept) -> None:
    """A day of commands: scans spread over it, with labels, powers and truth, by both radars, and then at another rpm."""
    for radar in ("bow", "pier"):
        sim = rs.Simulator(
            rs.load_scene(two_radars()), fidelity="balanced", seed=SEED, radar=radar, labels=True, powers="all"
        )
        for body, time, values in day_of_commands(SEED, None if radar == "bow" else "tug"):
            sim.command(body, time=time, **values)
        kept.record(f"commands/{radar}/commands", [command.as_dict() for command in sim.commands])
        scans = int(DAY * RPM[radar] / 60.0)
        for number in range(scans // DAYS_SCANS // 2, scans, scans // DAYS_SCANS):
            sim.skip_to(number)
            keep_scan(kept, f"commands/{radar}/{number}", sim, sim.scan())
        faster = sim.at_rpm(50)
        keep_scan(kept, f"commands/{radar}/faster", faster, faster.scan())


def keep_scan(kept: Kept, name: str, sim: rs.Simulator, scan: rs.Scan) -> None:
    """Keeps a scan with the sources of its cells, and its truth."""
    kept.array(f"{name}/field", scan.field)
    kept.array(f"{name}/labels", scan.labels)
    for source, power in sorted(sim.source_powers(scan.number).items()):
        kept.array(f"{name}/power-{source}", power)
    lines = truth_lines(sim.crossings(scan.number), sim.snapshot(scan.number))
    kept.bytes(f"{name}/truth.jsonl", "".join(lines).encode())


def errors(kept: Kept) -> None:
    """Spokes as a client receives them, with errors on purpose that change while it runs."""
    sim = rs.Simulator(rs.load_scene(two_radars()), fidelity="fast", seed=SEED, radar="bow")
    for part, tables in enumerate((None, ERRORS, {"gyro": {"bias_deg": 3.0}}, None)):
        sim.set_errors(tables)
        for number, spoke in enumerate(sim.feed(2)):
            kept.record(f"errors/{part}/{number:04}", spoke)
        kept.record(f"errors/{part}/snapshot", sim.snapshot().as_dict())


def files(kept: Kept, folder: Path) -> Path:
    """What the commands `scan` and `record` write; returns the recording."""
    scene = folder / "one.json"
    world = two_radars(errors=True)
    del world["radar"][1]
    scene.write_text(json.dumps(world))
    written = [folder / name for name in ("scans.npz", "ppi.png", "truth.jsonl", "recording.mcap")]
    scans, picture, truth, recording = map(str, written)
    command("scan", str(scene), "--scans", "2", "-o", scans, "--png", picture, "--truth", truth, "--radiometric")
    command("record", str(scene), "--scans", "3", "-o", recording, "--truth", "--labels", "--powers", "all")
    for path in written[:-1]:
        kept.bytes(f"files/{path.name}", path.read_bytes())
    keep_recording(kept, written[-1])
    return written[-1]


def keep_recording(kept: Kept, path: Path) -> None:
    """Keeps the messages of a recording: its own bytes hold the name of an epoch and the times of computing."""
    with path.open("rb") as file:
        for number, (_, channel, message) in enumerate(make_reader(file).iter_messages()):
            kind = channel.message_encoding
            content = {"json": json.loads, "msgpack": msgpack.unpackb}.get(kind, bytes)(message.data)
            told = channel.topic, message.log_time, message.publish_time, lasting(content)
            kept.bytes(f"files/recording/{number:05}", msgpack.packb(told))


def command(*arguments: str) -> None:
    """Runs a command of the tree."""
    subprocess.run([sys.executable, "-m", "radar_service", *arguments], check=True, capture_output=True, text=True)
