"""The format of a robot file that begins with <sdf>."""

FORMATS = {"sdf": ("sdf", "SDFormat", "shockpc.wings.sdf.reader")}
"""Formats of robot files of this folder, as in `robot.files.reading`."""
