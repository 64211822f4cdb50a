"""Acquisition as a user orders it: MSC.192(79) 5.25.3 and 5.25.4.6, judged where a tracker says how it acquired its tracks."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from radar_service.bench.scores.judged_scan import CUTOFF, JudgedRun, JudgedScan, distances, track_at
from radar_service.bench.scores.scan_result import ScanResult, as_reported, at_end
from radar_service.bench.scores.sightings import ACQUISITION
from radar_service.bench.trackers.tracker import TrackerInput, TrackState

Zone = Sequence[float]  # nearest and farthest range [m], true bearings clockwise from one to another [rad]


def with_orders(result: ScanResult, orders: Sequence[Mapping[str, Any]], before: Sequence[TrackState]) -> TrackerInput:
    """Returns a scan with the orders of its user. orders: by names of targets; before: the last answer of the tracker, by whose
    names tracks are cancelled. A target that is not there, or has no track, gives no order."""
    truths = {truth.body: as_reported(at_end(truth, result.given.time)) for truth in result.truths}
    ordered: list[Mapping[str, Any]] = []
    for order in orders:
        if zone := order["zone"]:
            ordered.append({"zone": [*zone[:2], *map(math.radians, zone[2:])]})
        elif order["acquire"] in truths:
            ordered.append({"acquire": [*truths[order["acquire"]].position]})
        elif order["cancel"] in truths and before:
            apart = distances([truths[order["cancel"]]], [track_at(track, result.given.time) for track in before])[0]
            ordered += [{"cancel": before[apart.argmin()].track}] if apart.min() < CUTOFF else []
    return replace(result.given, orders=tuple(ordered) or None)


def acquisition_scores(run: JudgedRun) -> dict[str, float | None]:
    """Returns the number of orders and tracks that are wrong; nothing where no track says how it was acquired."""
    if all(track.acquired is None for scan in run.scans for track in scan.result.tracks):
        return {}
    errors = [wrong for number in range(len(run.scans)) for wrong in _errors(run, number)]
    return {"acquisition_errors": float(sum(errors))} if errors else {}


def _errors(run: JudgedRun, number: int) -> Iterator[bool]:
    """Whether each order of a scan is not obeyed."""
    scan, later = run.scans[number], run.scans[number + 1 :]
    within = [each for each in later if each.result.given.time - scan.result.given.time <= ACQUISITION]
    is_whole = bool(later) and len(within) < len(later)  # else the minute is not over
    for order in scan.result.given.orders or ():
        if "cancel" in order:
            yield any(order["cancel"] == track.track for each in later for track in each.result.tracks)
        elif "zone" in order:
            yield from _zone_errors([scan, *later], order["zone"], within if is_whole else ())
        elif is_whole and scan.truths:
            apart = {body: math.dist(truth.position, order["acquire"]) for body, truth in scan.truths.items()}
            body = min(apart, key=apart.__getitem__)
            yield not any(each.tracks[each.pairs[body]].acquired == "manual" for each in within if body in each.pairs)


def _zone_errors(scans: Sequence[JudgedScan], zone: Zone, within: Sequence[JudgedScan]) -> Iterator[bool]:
    """Whether each track that begins by itself after the first scan does so outside of a zone, and each target that stays inside
    for a minute has none then."""
    begun: dict[str, tuple[JudgedScan, TrackState]] = {}
    for scan in scans:
        begun = {track.track: (scan, track) for track in scan.result.tracks} | begun
    for scan, track in begun.values():
        if track.acquired == "automatic" and scan is not scans[0]:
            yield not _is_in(scan, (track.east, track.north), zone, CUTOFF)
    for body in set.intersection(*({*scan.truths} for scan in within)) if within else ():
        if all(_is_in(scan, scan.truths[body].position, zone, 0.0) for scan in within):
            yield not any(body in scan.pairs for scan in within)


def _is_in(scan: JudgedScan, position: tuple[float, float], zone: Zone, margin: float) -> bool:
    """Whether a position is in a zone, or by a margin [m] outside."""
    east, north = position[0] - scan.result.given.east, position[1] - scan.result.given.north
    nearest, farthest, begin, end = zone
    distance, half = math.hypot(east, north), ((end - begin) % (2.0 * math.pi)) / 2.0
    aside = abs(math.remainder(math.atan2(east, north) - begin - half, 2.0 * math.pi)) - half
    return nearest - margin <= distance <= farthest + margin and aside * distance <= margin
