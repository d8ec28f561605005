"""`shockpc schema`: the JSON Schema of scene files."""

import sys

from shockpc.cli.declare import command

__all__ = ["schema"]


@command("Print the JSON Schema of scene files, for editors.", "shockpc schema > scene.schema.json")
def schema() -> None:
    import json

    from shockpc.scene import scene_schema

    sys.stdout.write(json.dumps(scene_schema(), indent=1) + "\n")
