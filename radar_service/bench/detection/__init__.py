"""Detection by range against the radar equation."""
