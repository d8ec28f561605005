"""Logs and bags of a robot's motion, and the touchdowns in them."""
