"""Records that rooms hand to each other: spokes, truth, reports of sensors, labels and powers of cells, fidelity."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.records.cell_sources import (
        UNKNOWN, Labels, Powers, PowersOf, SourceList, SourceRequest, powers_from_text, source_request, text_of
    )  # fmt: skip
    from radar_service.records.fidelity import MIN_SCATTERERS, PRESETS, PURPOSE, Fidelity, fidelity_from_name
    from radar_service.records.plan_item import PlanItem
    from radar_service.records.reports import FeedErrorCounts, Readings, ReportedOwnShip
    from radar_service.records.spokes import Spoke, SpokeBlock, joined, regrouped, square_law
    from radar_service.records.truth import (
        BodyTruth, Crossing, Extent, FalseEcho, Kinematics, OwnShipTruth, Radiometry, ShipStates, Snapshot, Truth
    )  # fmt: skip
else:
    __getattr__, __dir__ = lazily(__name__)
