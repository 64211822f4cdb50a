"""REST: errors on purpose of a radar."""

import asyncio
from collections.abc import Callable, Mapping
from typing import Annotated, Any

from fastapi import APIRouter, Body, Request

from radar_service.ports.rest import schemas
from radar_service.ports.rest.answers import FORBIDDEN, REFUSED, UNKNOWN, UNREADABLE, check_knows_truth
from radar_service.ports.rest.json_bodies import StrictRoute
from radar_service.ports.roles import needs
from radar_service.scene_file.error_tables import error_tables
from radar_service.scene_file.model.errors import ErrorsModel
from radar_service.service.radio.station import Station
from radar_service.world.error_settings import ErrorSettings

EXAMPLES = [{"gyro": {"bias_deg": 1.5}, "feed": {"drop_rate": 0.1}}, {"profile": "imo-a823"}]
ErrorsChange = Annotated[ErrorsModel, Body(examples=EXAMPLES)]


def error_routes(station: Callable[[str], Station]) -> APIRouter:
    """Returns the routes of errors. station: returns a radar by its id, and raises where there is none."""
    router = APIRouter(tags=["radars"], route_class=StrictRoute)

    @router.get("/radars/{radar}/errors", responses={**UNKNOWN, **FORBIDDEN})
    @needs("read")
    async def get_errors(radar: str, request: Request) -> schemas.ErrorsState:
        """Returns the errors on purpose that are in force, to clients that may know them."""
        check_knows_truth(request, station(radar), "errors")
        return _state(station(radar).errors.errors)

    @router.patch("/radars/{radar}/errors", responses={**UNKNOWN, **REFUSED, **UNREADABLE})
    @needs("command")
    async def change_errors(radar: str, requested: ErrorsChange) -> schemas.ErrorsState:
        """Changes errors on purpose, from the first spoke that was not yet sent; answers with all.

        A table replaces the present one whole; null or {} switches it off, and tables that are not given stay. A profile
        replaces the tables that it has. Another scene begins with the errors of its file; another rpm goes on with them.
        """
        return await _changed(station(radar), requested.model_dump(exclude_unset=True))

    @router.delete("/radars/{radar}/errors", responses=UNKNOWN)
    @needs("command")
    async def delete_errors(radar: str) -> schemas.ErrorsState:
        """Switches all errors on purpose off, from the first spoke that was not yet sent."""
        return await _changed(station(radar), None)

    return router


async def _changed(station: Station, tables: Mapping[str, Any] | None) -> schemas.ErrorsState:
    await asyncio.to_thread(station.errors.set_errors, tables)  # which may import scipy
    return _state(station.errors.errors)


def _state(errors: ErrorSettings | None) -> schemas.ErrorsState:
    return schemas.ErrorsState.model_validate(error_tables(errors or ErrorSettings()))
