"""Pulses of other radars."""
