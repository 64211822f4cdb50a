"""Builds the AIS transponders of a scene from their models."""

import math
import re
from collections.abc import Iterator, Sequence

import numpy as np

from radar_service.numerics import Floats
from radar_service.scene_file.model.ais import AisModel, TransponderModel
from radar_service.scene_file.model.body import BodyOfAKind
from radar_service.scene_file.model.scene import OwnShipModel, SceneModel
from radar_service.world import Ais, AisSettings, AisShip, Body

DEFAULT = TransponderModel()
FORMS = {  # of numbers, Rec. ITU-R M.585, with an example
    "ship": ("a ship", r"[2-7]\d{8}", 235000001),
    "aid": ("an aid to navigation", r"99[2-7]\d{6}", 992350001),
    "sart": ("a SART", r"970\d{6}", 970010001),
}


def ais_from_models(model: SceneModel, bodies: Sequence[Body]) -> Ais:
    """Returns the transponders of a scene. bodies: in the order of their models, others after them."""
    ships = [_of_own_ship(model.own_ship)] if model.own_ship.mmsi is not None else []
    ships += [_of_body(of, body) for of, body in zip(model.body, bodies, strict=False) if body.mmsi is not None]
    reports = model.ais or AisModel()
    return Ais(tuple(ships), AisSettings(reports.latency_s, reports.loss_percent / 100.0, reports.position_error_m))


def mmsi_warnings(ships: Sequence[AisShip], names: Sequence[str]) -> Iterator[str]:
    """Yields a warning for each number that is not one of its kind. names: of all bodies, in their order."""
    for ship in ships:
        (kind, form, example), number = FORMS[ship.kind], f"{ship.mmsi:09d}"
        if re.fullmatch(form, number):
            continue
        location = "own_ship" if ship.body is None else f"body[{names.index(ship.body)}]"
        fits = [f'set ais.kind = "{other}", or ' for other, (_, form, _) in FORMS.items() if re.fullmatch(form, number)]
        yield (
            f"{location}.mmsi: {number} is not the number of {kind}, so receivers may take it for another station; "
            f"{''.join(fits)}give one like {example}"
        )


def _of_own_ship(model: OwnShipModel) -> AisShip:
    assert model.mmsi is not None
    return _ship(None, "own ship", model.mmsi, model.ais or DEFAULT, np.zeros(2), (0.0, 0.0), model.draught_m or 0.0)


def _of_body(model: BodyOfAKind, body: Body) -> AisShip:
    """The antenna is measured from the middle of the ship's length and beam."""
    assert body.mmsi is not None
    draught = model.draught_m
    if draught is None:
        lowest = 0.0 if body.mesh is None else float(body.mesh.vertices[:, 2].min())
        draught = max(0.0, -lowest - float(body.motion.position[0, 2])) if body.is_vessel else 0.0
    return _ship(body.name, body.name, body.mmsi, model.ais or DEFAULT, body.middle[:2], (body.length, body.beam), draught)


def _ship(
    body: str | None, name: str, mmsi: int, model: TransponderModel, middle: Floats, size: tuple[float, float], draught: float,
) -> AisShip:  # fmt: skip
    length = size[0] if model.length_m is None else model.length_m
    beam = size[1] if model.beam_m is None else model.beam_m
    starboard, forward = model.antenna_m
    return AisShip(
        body, mmsi, model.class_, (name if model.name is None else model.name).upper(), model.call_sign.upper(), model.ship_type,
        model.imo, model.destination.upper(), (float(middle[0]) + starboard, float(middle[1]) + forward),
        max(0.0, length / 2.0 - forward), max(0.0, length / 2.0 + forward), max(0.0, beam / 2.0 + starboard),
        max(0.0, beam / 2.0 - starboard), draught, model.off_s, math.radians(model.heading_error_deg), model.kind, model.aid_type,
    )  # fmt: skip
