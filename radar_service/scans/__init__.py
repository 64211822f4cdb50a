"""Scans, their files and datasets, sectors of a scan."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.scans.dataset import DESCRIBED, exporter, scan_to_xarray, scans_to_xarray
    from radar_service.scans.file import SUFFIX
    from radar_service.scans.scan import Scan, load_scan, save_scans, scan_of, scans_from_xarray
    from radar_service.scans.sector import Sector
else:
    __getattr__, __dir__ = lazily(__name__)

__all__ = ["Scan", "Sector", "load_scan", "save_scans", "scan_of", "scan_to_xarray", "scans_from_xarray", "scans_to_xarray"]
