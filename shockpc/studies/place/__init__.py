"""Where on a body a sensor sees least shock."""
