"""Protocols in and out of a service: what one declares, the queue before it, and who calls it."""
