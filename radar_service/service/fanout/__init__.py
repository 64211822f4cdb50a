"""From spokes to the queues of clients: hub, encoder, delays, truth."""
