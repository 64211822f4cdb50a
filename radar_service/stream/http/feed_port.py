"""The native feed as a port."""

from collections.abc import Sequence

from fastapi import APIRouter

from radar_service.stream.http.feed import feed_routes
from radar_service.stream.ports.port import Port, Service


class FeedPort(Port):
    """The websockets of spokes. Their sink belongs to each radar: lossless clients delay it."""

    name, delays = "feed", True

    def routes(self, service: Service) -> Sequence[APIRouter]:
        """As Port.routes."""
        return (feed_routes(service.stations, service.access, service.refused),)
