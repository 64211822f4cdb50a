"""The native feed as a codec."""
