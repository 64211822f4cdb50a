"""Describes a scene in text for `radar-service check`, and gives the JSON Schema of scene files for editors."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from radar_service.numerics.constants import KNOT
from radar_service.numerics.frames import Polar, bearing_text, effective_earth_radius, polar_from_map
from radar_service.radar.parameters import Radar
from radar_service.scattering.reflector_patterns import reflector_text
from radar_service.scene_file.checks.body_size import metres
from radar_service.scene_file.checks.placement import nearest_point
from radar_service.scene_file.model.scene import scene_schema
from radar_service.stages.registry import effects_in, effects_named
from radar_service.world.body import Body
from radar_service.world.materials import is_land
from radar_service.world.poses import pose_at
from radar_service.world.scene import Scene

APERTURE = 0.8859  # half-power beamwidth x aperture / wavelength, uniform aperture (Balanis 2016)
SCREEN = 24  # lines of a terminal
MAX_WARNINGS, MIN_BODIES = 8, 6  # lines of an overview
NO_REMARKS: Mapping[str, Sequence[str]] = MappingProxyType({})
TWO_WAY_SINC2 = 0.7200  # two-way over one-way half-power width of a sinc^2 beam (docs/specification.md, errata row 2)


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
    lines += [*_radar_lines(scene.radar), *_environment_lines(scene), f"{carrier}{scene.own_ship.text}"]
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
    radar, environment = _radar_lines(scene.radar), _environment_lines(scene)
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


def two_way_beamwidth(radar: Radar) -> float | None:
    """Returns the two-way half-power beamwidth [rad] of the sinc^2 and Gaussian patterns; None for others."""
    ratios = {"sinc2": TWO_WAY_SINC2, "gaussian": math.sqrt(0.5)}
    ratio = ratios.get(radar.pattern.name)
    return None if ratio is None else ratio * radar.beamwidth


def far_field(radar: Radar) -> float:
    """Returns the far-field range [m]: 2 D^2 / lambda of a uniform aperture D that has the narrower beamwidth."""
    aperture = APERTURE * radar.wavelength / min(radar.beamwidth, radar.beamwidth_el)
    return 2.0 * aperture**2 / radar.wavelength


def _straddling(radar: Radar) -> str:
    """Returns text with the straddling loss half-way between spokes, if it exceeds 3 dB."""
    steps = radar.beamwidth / radar.azimuth_step
    if radar.pattern.name != "sinc2" or TWO_WAY_SINC2 * steps >= 1.0:
        return ""
    offset = APERTURE / (2.0 * steps)
    loss_db = -40.0 * math.log10(max(abs(np.sinc(offset)), 1e-6))
    return f"; half-way between spokes the loss is {loss_db:.1f} dB"


def _radar_lines(radar: Radar) -> list[str]:
    two_way = two_way_beamwidth(radar)
    beam = "" if two_way is None else f", two-way {math.degrees(two_way):.3f}"
    pattern = radar.pattern.description
    if radar.pattern_el != radar.pattern:
        pattern += f", vertical {radar.pattern_el.description}"
    rpm, rate = 60.0 / radar.rotation_period, 1.0 / radar.spoke_period
    step = math.degrees(radar.azimuth_step)
    width, height = math.degrees(radar.beamwidth), math.degrees(radar.beamwidth_el)
    return [
        f"radar       {radar.frequency / 1e9:.4g} GHz, wavelength {radar.wavelength * 1e3:.2f} mm, {radar.power / 1e3:g} kW",
        f"  pulse     {_pulse_text(radar)}",
        f"  range     to {radar.range_max:g} m in {radar.bins} bins of {radar.range_step:.4f} m",
        f"  resolves  {_resolution_text(radar)}",
        *(f"  nearer    to {near.range_max:g} m: {_pulse_text(near)}" for near in radar.of_each_pulse[:-1]),
        f"  scan      {radar.azimuths} spokes, {step:.4g} degrees, {rpm:g} rpm, {rate:.1f} spokes/s",
        f"  beam      {width:g} x {height:g} degrees one-way{beam} ({pattern}){_straddling(radar)}",
        f"  far field begins at {far_field(radar):.3g} m; near-field effects are not modelled",
    ]


def _pulse_text(radar: Radar) -> str:
    kind = "not modulated" if radar.modulation == "none" else _chirp_text(radar)
    rate = "" if radar.prf is None else f", {radar.prf:g} a second: unambiguous to {radar.unambiguous_range:.0f} m"
    folded = ", second-time-around echoes fold" if radar.second_time_around else ""
    eclipsed = f", eclipsed to {radar.blind_range:.0f} m" if radar.eclipsing else ""
    return f"{radar.pulse * 1e6:g} us, {radar.bandwidth / 1e6:g} MHz, {kind}{rate}{folded}{eclipsed}"


def _chirp_text(radar: Radar) -> str:
    nonlinear = "nonlinear chirp, " if radar.modulation == "nlfm" else ""
    inverse = ", compressed by the inverse filter" if radar.compression == "inverse" else ""
    return f"{nonlinear}product {radar.pulse * radar.bandwidth:.0f}{inverse}"


def _resolution_text(radar: Radar) -> str:
    if radar.modulation == "none":
        return f"{radar.blind_range:.3f} m, half the length of the pulse"
    return f"{radar.range_resolution:.3f} m before the window ({radar.window}) widens it"


def _environment_lines(scene: Scene) -> list[str]:
    e = scene.environment
    horizon = scene.horizon()
    factor = "flat earth" if math.isinf(horizon) else f"horizon at {horizon:.0f} m ({e.earth_factor:.3g} earth)"
    enabled = [name for name in ("noise", "multipath", "diffraction", "ground_plane") if getattr(e, name)]
    enabled += [f"gas {e.gas_db_per_km:.4g} dB/km one way"] if e.gas_db_per_km else []
    enabled += [f"rain {e.rain_mm_h:g} mm/h"] if e.rain_mm_h else []
    enabled += [f"sea state {e.sea_state:.3g}"] if e.sea_state else []
    if e.seaway is not None:
        coming_from = bearing_text(e.seaway.towards + math.pi)
        enabled.append(f"waves of {e.seaway.height:.3g} m in {e.seaway.period:.3g} s from {coming_from} move ships")
    if any(e.stream):
        enabled.append(f"stream of {math.hypot(*e.stream) / KNOT:.3g} kn to {bearing_text(math.atan2(*e.stream))}")
    enabled += [text for effect in effects_in(scene) if (text := effect.scene_text(scene))]
    extras = ", ".join(enabled) or "no other effects"
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
