"""The mathematics, on arrays alone: nothing in here has heard of robots, files or Pinocchio."""
