"""`shockpc schema`: the JSON Schema of scene files and of files of budgets."""

import sys
from typing import Literal

from shockpc.cli.declared import argument, command


@command(examples=("shockpc schema > scene.schema.json",))
def schema(
    *,
    file: Literal["scene", "budgets"] = argument(
        "Which files. [default: scene]", "[scene|budgets]", default="scene"
    ),
) -> None:
    import json

    from shockpc.evaluation.budgets import budgets_schema
    from shockpc.landing.scenes.scene_file import scene_schema

    text = json.dumps(budgets_schema() if file == "budgets" else scene_schema(), indent=1)
    sys.stdout.write(text + "\n")
