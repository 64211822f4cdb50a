"""Trackers, how they are reached, and readers for Stone Soup."""
