"""From spokes to the queues of clients: encoder, hub, delays."""
