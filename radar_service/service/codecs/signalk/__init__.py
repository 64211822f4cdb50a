"""The spokes of the Signal K Radar API as a codec."""
