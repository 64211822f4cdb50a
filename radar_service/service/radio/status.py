"""The status of a radar: its state, whether it is ready, and its health."""

import math
from typing import Any

from radar_service.service.radio.pacer import KEEPING_UP
from radar_service.service.radio.radio_state import State
from radar_service.service.radio.station import Station

STATES = ("running", "behind", "paused", "standby", "waiting", "restarting", "failed")


def state(station: Station) -> str:
    """Returns one of STATES."""
    transmitter, pace = station.transmitter, station.settings.pace
    if transmitter.state.fault:
        return "failed"
    if transmitter.state.now is State.RESTARTING:
        return "restarting"
    if transmitter.pacer.held:
        return "waiting"
    if pace.state == "pause":
        return "paused"
    reached = transmitter.pacer.reached()
    if math.isfinite(pace.factor) and reached is not None and reached < KEEPING_UP * pace.factor:
        return "behind"
    return "running" if station.settings.transmit else "standby"


def is_ready(station: Station) -> bool:
    """Returns whether clients are taken and spokes come, or would come but for a pause or standby."""
    transmitter, settings = station.transmitter, station.settings
    silent_by_choice = transmitter.pacer.held or settings.pace.state == "pause" or not settings.transmit
    works = not (station.stopping or transmitter.state.fault or transmitter.state.now is State.RESTARTING)
    return works and (silent_by_choice or transmitter.state.sent > 0)


def health(station: Station) -> dict[str, Any]:
    """Returns the health of a radar as plain data."""
    transmitter, hub = station.transmitter, station.hub
    schedule = transmitter.pacer.group_clock.schedule
    return {
        "id": station.identity,
        "state": state(station),
        "fault": transmitter.state.fault,
        "pace": station.settings.pace.as_dict(),
        "factor_reached": transmitter.pacer.reached(),
        "restarts": transmitter.state.restarts,
        "lag_s": schedule.lag,
        "slips": schedule.slips,
        "simulated_s": transmitter.state.simulated,
        "epoch": hub.epoch,
        "next": hub.next,
        "spokes_sent": transmitter.state.sent,
        "spokes_lost": hub.totals().lost,
        "clients": len(hub.clients),
        "views": len(hub.views),
    }
