"""From a name or a path to a robot's text: found, read safely, checked. Knows no Pinocchio."""
