"""The receiver: gridding, beam filter, compression, noise, eclipsing, interference, detection."""
