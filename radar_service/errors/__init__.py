"""Errors on purpose: noise, sensors, antenna, feed; when they act, and what the truth says of them."""
