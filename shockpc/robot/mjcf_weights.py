"""Which geoms an MJCF body's inertia is made of: the compiler's rules written into the geoms, so that Pinocchio follows them.

Pinocchio knows neither the rules nor the weight of a mesh, for which it puts 1 kg.
"""

from xml.etree.ElementTree import Element

from shockpc.errors import RobotError
from shockpc.robot.urdf_numbers import vector

__all__ = ["weighed_by_geoms"]


def weighed_by_geoms(world: Element, compiler: Element | None, file: str) -> tuple[str, ...]:
    """Settle for every body whether its <inertial> or its geoms count, and which of them.

    Args:
        world: the <worldbody>, defaults written out; changed in place.
        compiler: what sets inertiafromgeom and inertiagrouprange; they are taken out of it.
        file: the file's name, for messages.

    Returns:
        What had to be left out: meshes without weight on bodies that are weighed by their geoms.

    Raises:
        RobotError: a setting is none that MJCF has.
    """
    settings = compiler.attrib if compiler is not None else {}
    rule = settings.pop("inertiafromgeom", "auto")
    groups = vector(settings.pop("inertiagrouprange", "0 5"), 2)
    if rule not in ("false", "auto", "true") or groups is None:
        raise RobotError(f'{file}: <compiler> has inertiafromgeom="{rule}" or an inertiagrouprange that MJCF does not know')
    warnings = []
    for body in world.iter("body"):
        counted = [geom for geom in body.findall("geom") if groups[0] <= float(geom.get("group", "0")) <= groups[1]]
        if rule == "true" and counted:
            for inertial in body.findall("inertial"):
                body.remove(inertial)
        if body.find("inertial") is not None:
            for geom in body.findall("geom"):
                geom.attrib.pop("shellinertia", None)  # counts for nothing here, yet Pinocchio refuses to see it
            continue
        lost = 0
        for geom in body.findall("geom"):
            if rule == "false" or geom not in counted:
                geom.set("mass", "0")
            massless = (vector(geom.get("mass", geom.get("density", "1000")), 1) or (0.0,))[0] == 0
            if massless and (geom.get("type") in ("mesh", "sdf", "hfield") or "mesh" in geom.attrib):
                body.remove(geom)
                lost += 1
        if lost:
            warnings.append(
                f'{file}: body "{body.get("name")}": {lost} mesh{"es" * (lost > 1)} without weight left out of its figure; '
                "give the body an <inertial> to see them"
            )
    return tuple(warnings)
