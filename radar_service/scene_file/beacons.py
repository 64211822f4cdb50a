"""Builds the beacons of bodies from their models."""

from radar_service.numerics.constants import SPEED_OF_LIGHT
from radar_service.scene_file.model.beacons import BeaconSection, RaconModel, SartModel
from radar_service.scene_file.model.body import BodyModel
from radar_service.world.beacon import S_BAND, X_BAND, Beacon, Racon, Sart, morse_dots
from radar_service.world.body import Mesh

BANDS = {"x": (X_BAND,), "s": (S_BAND,), "both": (X_BAND, S_BAND)}
ABOVE = 0.5  # m of an antenna above the highest point of its body


def beacon_from_model(model: BodyModel, mesh: Mesh | None) -> Beacon | None:
    """Returns the beacon of a body, None where it has none. mesh: of the body."""
    if model.racon is not None:
        return _racon(model.racon, mesh)
    return None if model.sart is None else _sart(model.sart, mesh)


def _racon(model: RaconModel, mesh: Mesh | None) -> Racon:
    dot = model.dot_s
    if dot is None:
        dot = 2.0 * model.mark_m / SPEED_OF_LIGHT / morse_dots(model.letter)
    return Racon(
        offset=_offset(model, mesh),
        power=_watts(model.power_dbm),
        sensitivity=_watts(model.sensitivity_dbm),
        delay=model.delay_s,
        max_pulse=model.max_pulse_s,
        letters=model.letter,
        dot=dot,
        bands=BANDS[model.band],
        tuning_error=model.tuning_error_hz,
        sweep=model.sweep_s if model.mode == "sweep" else None,
        on=model.on_s,
        off=model.off_s,
    )


def _sart(model: SartModel, mesh: Mesh | None) -> Sart:
    return Sart(
        offset=_offset(model, mesh),
        power=_watts(model.power_dbm),
        sensitivity=_watts(model.sensitivity_dbm),
        delay=model.delay_s,
        max_pulse=model.max_pulse_s,
        start=model.start_s,
        end=model.end_s,
    )


def _offset(model: BeaconSection, mesh: Mesh | None) -> tuple[float, float, float]:
    """Where the antenna is in the body's frame [m]; by default above the highest point of its mesh, or at a point."""
    if model.offset_m is not None:
        return model.offset_m
    if mesh is None:
        return 0.0, 0.0, 0.0
    vertices = mesh.used_vertices
    east, north, up = vertices[vertices[:, 2].argmax()].tolist()
    return east, north, up + ABOVE


def _watts(dbm: float) -> float:
    return float(10.0 ** (dbm / 10.0 - 3.0))
