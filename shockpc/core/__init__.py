"""The mathematics, only on arrays: nothing in here has heard of robots, files or Pinocchio."""
