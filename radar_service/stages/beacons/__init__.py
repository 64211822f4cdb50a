"""Racons and search and rescue transponders (SARTs) on bodies, which answer the pulses of radars."""
