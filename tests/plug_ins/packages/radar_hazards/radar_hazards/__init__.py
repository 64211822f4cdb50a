"""Birds and jammers, as another package adds them: it imports `radar_service.effects` and nothing else of the product."""
