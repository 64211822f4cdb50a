"""Sources of cells: their numbers, labels, powers, radiometric truth."""
