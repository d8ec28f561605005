"""`shockpc schema`: the JSON Schema of scene files."""

import sys

__all__ = ["schema"]


def schema() -> None:
    """Print the JSON Schema of scene files, for editors."""
    import json

    from shockpc.scene import scene_schema

    sys.stdout.write(json.dumps(scene_schema(), indent=1) + "\n")
