"""The format of a robot file that begins with <sdf>."""

FORMATS = {"sdf": ("sdf", "SDFormat", "shockpc.wings.sdf.reader")}
"""As of `robot.files.reading`."""
