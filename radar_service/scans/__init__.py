"""Scans, their files and datasets, sectors of a scan."""
