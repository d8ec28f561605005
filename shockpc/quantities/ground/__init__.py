"""A landing over flat ground: what of the robot it meets first, and what its feet support."""
