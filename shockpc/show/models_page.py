"""`robots/README.md`: the project's own models and the scenes beside them, as tables made from the files themselves.

To write it again: python -m shockpc.show.models_page
"""

import re
from pathlib import Path

from shockpc.paper.landings import land
from shockpc.paper.scenes import scene_files
from shockpc.robot.catalogue import catalogue, own_robots_folder
from shockpc.robot.robot import Robot, load_robot
from shockpc.show.files import write_text

__all__ = ["models_page"]

HEAD = """# Models and scenes

The robots of the paper behind the method, and a five-bar leg, as small parametric xacro files of slender uniform beams. Each file
says what is taken from the paper and what is assumed. Beside them, in `scenes/`, every panel of a figure is a scene that can be
opened, changed and computed:

```
shockpc analyze robots/scenes/fig2_e.toml --out out/e
shockpc paper 2 --out out/paper
```

*This page is made from the files by `python -m shockpc.show.models_page`; a test compares the two.*
"""


def models_page() -> str:
    """The Markdown text of the page."""
    robots = [(entry.path, load_robot(entry.name)) for entry in catalogue() if entry.source == "shockpc"]
    models = [
        "## Models",
        "",
        "| model | what it is | bodies | mass [kg] | arguments |",
        "|---|---|---:|---:|---|",
        *(_model_row(path, robot) for path, robot in robots),
    ]
    scenes = [
        "## Scenes",
        "",
        "| scene | what it shows | model | contact | strike | shock at CoM, by body [-] |",
        "|---|---|---|---|---|---|",
        *map(_scene_row, scene_files()),
    ]
    return "\n".join([HEAD, *models, "", *scenes, ""])


def _model_row(path: Path, robot: Robot) -> str:
    """One model: the first sentence of its file, and the arguments that the file takes."""
    text = path.read_text(encoding="utf-8")
    sentence = " ".join(re.split(r"(?<=[.:;])\s", text.split("<!--")[1].split("-->")[0].strip())[0].split()).rstrip(":;.")
    arguments = ", ".join(f"`{name}`" for name in re.findall(r'<xacro:arg name="(\w+)"', text))
    return f"| [`{robot.label}`]({path.name}) | {sentence} | {len(robot.bodies)} | {robot.mass:.4g} | {arguments} |"


def _scene_row(path: Path) -> str:
    """One scene: the first line of its file, and its results."""
    title = path.read_text(encoding="utf-8").split("\n", 1)[0].lstrip("# ").rstrip(".")
    profile = land(path.stem)
    model = Path(profile.scene.robot).name.removesuffix(".urdf.xacro")
    contact = ", ".join(one.frame for one in profile.scene.contact)
    strike = f"{profile.scene.strike.strike_angle_deg or 0.0:g}°"
    shock = ", ".join(f"{body} {value:.3f}" for body, value in zip(profile.bodies, profile.shock_com, strict=True))
    return f"| [`{path.stem}`](scenes/{path.name}) | {title} | `{model}` | {contact} | {strike} | {shock} |"


if __name__ == "__main__":
    write_text(own_robots_folder() / "README.md", models_page())
