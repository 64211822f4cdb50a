"""Who made a cell: numbers of sources, labels, powers, radiometric truth."""
