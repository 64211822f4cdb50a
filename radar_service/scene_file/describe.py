"""Describes a scene in text for `radar-service check`, and gives the JSON Schema of scene files for editors."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from radar_service.numerics import KNOT, Polar, bearing_text, effective_earth_radius, polar_from_map
from radar_service.radar import radar_lines
from radar_service.scattering import reflector_text
from radar_service.scene_file.checks.mesh_findings import metres
from radar_service.scene_file.checks.validity import nearest_point
from radar_service.scene_file.model.scene import scene_schema
from radar_service.stages.registry import effects_in, effects_named, own_effects
from radar_service.world import Body, Scene, is_land, pose_at

SCREEN = 24  # lines of a terminal
MAX_WARNINGS, MIN_BODIES = 8, 6  # lines of an overview
NO_REMARKS: Mapping[str, Sequence[str]] = MappingProxyType({})


def describe(scene: Scene, remarks: Mapping[str, Sequence[str]] = NO_REMARKS) -> str:
    """Returns a description of many lines: the radar's derived numbers, each body at t = 0, notes, warnings.

    remarks: further lines about bodies, by their names.
    """
    lines = [f"scene       {scene.name}"]
    if len(scene.radar_ids) > 1:
        lines += [f"radars      {radar.id} {radar.platform.text}" for radar in scene.radars]
        lines.append(f"  all that follows is as {scene.radar_id} has it")
    if scene.origin is not None:
        lines.append(f"origin      latitude {scene.origin[0]:.6f}, longitude {scene.origin[1]:.6f} degrees")
    carrier = "own ship    " if len(scene.radar_ids) == 1 else "platform    "
    lines += [*radar_lines(scene.radar), *_environment_lines(scene), f"{carrier}{scene.own_ship.text}"]
    if scene.errors is not None:
        lines.append(
            f"errors      on purpose, of {', '.join(name for name, setting in vars(scene.errors).items() if setting)}"
        )
    triangles = sum(len(body.mesh.faces) for body in scene.bodies if body.mesh is not None)
    lines.append(f"bodies      {len(scene.bodies)} with {triangles} triangles in all")
    for body in scene.bodies:
        lines += [*_body_lines(body, scene), *(f"    {remark}" for remark in remarks.get(body.name, ()))]
    lines += [f"note        {note}" for note in scene.notes]
    lines += [f"warning     {warning}" for warning in scene.warnings]
    return "\n".join(lines)


def overview(scene: Scene, remarks: Mapping[str, Sequence[str]] = NO_REMARKS) -> str:
    """Returns a description of one screen, what matters most first: warnings, radar, bodies that are out of sight, the rest.

    remarks: as `describe`, of which the number is given.
    """
    triangles = sum(len(body.mesh.faces) for body in scene.bodies if body.mesh is not None)
    radar, environment = radar_lines(scene.radar), _environment_lines(scene)
    lines = [f"scene       {scene.name}: {len(scene.bodies)} bodies, {triangles} triangles"]
    lines += [f"warning     {warning}" for warning in scene.warnings[:MAX_WARNINGS]]
    lines += [f"radars      {', '.join(scene.radar_ids)}; this is {scene.radar_id}"] if len(scene.radar_ids) > 1 else []
    lines += [radar[0], *(line for line in radar if line.startswith(("  range", "  scan", "  beam"))), *environment]
    lines.append(f"own ship    {scene.own_ship.text}")
    polars = {body.name: _polar(body, scene) for body in scene.bodies}
    bodies = sorted(scene.bodies, key=lambda body: (not polars[body.name][1], polars[body.name][0].distance[0]))
    room = max(MIN_BODIES, SCREEN - 1 - len(lines))
    columns = [(f"{body.name[:30]}:", _size_text(body)) for body in bodies[:room]]
    name_width, size_width = (max(map(len, column)) for column in zip(*columns, strict=True)) if columns else (0, 0)
    for body, (name, size) in zip(bodies, columns, strict=False):
        line = _short_body_line(body, *polars[body.name], len(remarks.get(body.name, ())))
        lines.append(f"  {name:{name_width}} {size:>{size_width}}  {line}")
    return "\n".join([*lines, _rest(scene, len(bodies) - room, sum(map(len, remarks.values())))])


def _rest(scene: Scene, bodies: int, remarks: int) -> str:
    """The last line of an overview: what it leaves out."""
    left = {
        "warnings": len(scene.warnings) - MAX_WARNINGS, "bodies": bodies, "notes": len(scene.notes), "remarks on bodies": remarks
    }  # fmt: skip
    text = ", ".join(f"{count} {name}" for name, count in left.items() if count > 0)
    return f"--all       shows {text + ' more, and ' if text else ''}all numbers of the radar and of each body"


def _short_body_line(body: Body, polar: Polar, hidden: str, remarks: int) -> str:
    """What a line says of a body at t = 0, after its name and its size."""
    speed = "at rest" if body.motion.at_rest else f"{body.motion.pose(0.0).speed[0] / KNOT:.1f} kn"
    section = "" if body.rcs is None else f" {10 * math.log10(body.rcs):g} dBsm"
    more = f"; {remarks} remark{'s' if remarks > 1 else ''}" if remarks else ""
    return (
        f"{polar.distance[0]:.0f} m off, bearing {bearing_text(float(polar.azimuth[0]))}{hidden}, {speed}; "
        f"{body.material.name}, {body.scattering}{section}{more}"
    )


def _size_text(body: Body) -> str:
    """Length x breadth x height of a body [m]; of a point "point"."""
    if body.mesh is None:
        return "point"
    return " x ".join(map(metres, (body.length, body.beam, float(np.ptp(body.mesh.vertices[:, 2]))))) + " m"


def _polar(body: Body, scene: Scene) -> tuple[Polar, str]:
    """Where a body is from the antenna at t = 0, of land its nearest point, and text that says why it has no echo there; empty
    otherwise."""
    start, antenna = body.motion.pose(0.0).position, scene.antenna(0.0)
    radius = effective_earth_radius(scene.environment.earth_factor)
    polar = polar_from_map(start, antenna, radius)
    text = _visibility_text(float(polar.range[0]), float(polar.distance[0]), float(start[0, 2]), body, scene)
    if body.mesh is None or not is_land(body):
        return polar, text
    nearest = nearest_point(pose_at(body, 0.0).map_from_frame(body.mesh.vertices), body.mesh.faces, antenna[0])
    return polar_from_map(nearest[None], antenna, radius), text


def json_schema() -> dict[str, Any]:
    """Returns the JSON Schema (draft 2020-12) of a scene file."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **scene_schema()}


def _environment_lines(scene: Scene) -> list[str]:
    e = scene.environment
    horizon = scene.horizon()
    factor = "flat earth" if math.isinf(horizon) else f"horizon at {horizon:.0f} m ({e.earth_factor:.3g} earth)"
    texts = (effect.scene_text(scene) or ("" if effect in own_effects() else effect.name) for effect in effects_in(scene))
    extras = ", ".join([*e.texts, *filter(None, texts)]) or "no other effects"
    return [f"environment antenna {scene.radar.height:g} m up, {factor}; {extras}"]


def _body_lines(body: Body, scene: Scene) -> list[str]:
    polar, hidden = _polar(body, scene)
    bearing = bearing_text(float(polar.azimuth[0]))
    shape = "a point"
    if body.mesh is not None:
        x, y, z = np.ptp(body.mesh.vertices, axis=0)
        shape = f"{len(body.mesh.faces)} triangles, {x:.4g} x {y:.4g} x {z:.4g} m (across, along, up)"
    fluctuation = f", Swerling {body.swerling}" if body.swerling else ""
    section = "" if body.rcs is None else f" {10 * math.log10(body.rcs):g} dBsm{fluctuation}"
    route = body.motion.text + body.presence.text
    if body.reflector is not None:
        shape = reflector_text(body.reflector, scene.radar)
    return [
        f"  {body.name}: {shape}",
        f"    {polar.distance[0]:.1f} m off, bearing {bearing}{hidden}; {route}",
        f"    {body.material.name}, scattering {body.scattering}{section}" + (f", MMSI {body.mmsi}" if body.mmsi else ""),
        *(f"    {effect.body_text(body, scene.radar)}" for effect in effects_named(body.effects)),
    ]


def _visibility_text(distance_now: float, ground: float, up: float, body: Body, scene: Scene) -> str:
    """Returns text that says why the body has no echo at t = 0 because of its position; empty otherwise."""
    size, top = 0.0, up
    if body.mesh is not None:
        size = float(np.linalg.norm(body.mesh.vertices[:, :2], axis=1).max())
        top = up + float(body.mesh.vertices[:, 2].max())
    if top < 0.0:
        return " (below the sea)"
    max_range = math.inf if scene.radar.second_time_around else scene.radar.range_max
    if distance_now - size > max_range:
        return " (beyond range)"
    return " (below the horizon)" if ground - size > scene.horizon(top) else ""
