"""Many landings: rows in, numbers out. The only place that solves landings in a loop."""
