"""The elements and attributes of SDFormat 1.2 to 1.12 inside a model, and a warning for each that is none of them."""

from collections.abc import Iterator
from difflib import get_close_matches
from xml.etree.ElementTree import Element, tostring

_GEOMETRY = "empty box capsule cone cylinder ellipsoid heightmap image mesh plane polyline sphere"
_POSE = "relative_to rotation_format degrees"
_KNOWN = {
    "model": (
        "static self_collide allow_auto_disable enable_wind frame pose link joint plugin gripper include model state",
        "name canonical_link placement_frame namespace",
    ),
    "pose": ("", _POSE),
    "frame": ("pose", "name attached_to"),
    "link": (
        "gravity enable_wind self_collide kinematic must_be_base_link velocity_decay pose frame inertial collision visual sensor "
        "projector audio_sink audio_source battery light particle_emitter",
        "name",
    ),
    "inertial": ("mass density auto_inertia_params pose frame inertia fluid_added_mass", "auto"),
    "inertia": ("ixx ixy ixz iyy iyz izz", ""),
    "collision": ("laser_retro max_contacts density auto_inertia_params pose frame geometry surface", "name"),
    "visual": ("cast_shadows laser_retro transparency visibility_flags pose frame geometry material plugin meta", "name"),
    "geometry": (_GEOMETRY, ""),
    "box": ("size", ""),
    "sphere": ("radius", ""),
    "cylinder": ("radius length", ""),
    "capsule": ("radius length", ""),
    "mesh": ("uri filename scale submesh convex_decomposition", "optimization"),
    "sensor": (
        "always_on update_rate visualize topic enable_metrics pose frame plugin air_pressure air_speed altimeter camera contact "
        "force_torque gps imu lidar logical_camera magnetometer navsat ray rfid rfidtag sonar transceiver",
        "name type",
    ),
    "joint": (
        "parent child gearbox_ratio gearbox_reference_body thread_pitch screw_thread_pitch axis axis2 physics pose frame sensor",
        "name type",
    ),
    "axis": ("xyz initial_position dynamics limit mimic", ""),
    "xyz": ("", "expressed_in"),
    "limit": ("lower upper effort velocity stiffness dissipation", ""),
    "dynamics": ("damping friction spring_reference spring_stiffness", ""),
    "mimic": ("multiplier offset reference", "joint axis"),
}
"""Elements and attributes inside each element that is read, by its tag."""

_UNTIL_1_6 = {"pose": ("", f"{_POSE} frame"), "axis": ("xyz initial_position dynamics limit use_parent_model_frame", "")}


_OF_LINKS = "pose inertial mass inertia ixx ixy ixz iyy iyz izz geometry size radius length uri scale"
_OF_JOINTS = "parent child axis xyz limit lower upper effort dynamics damping"
_SINGLE = frozenset(f"{_OF_LINKS} {_OF_JOINTS}".split())
"""Elements of which the first applies."""


def unknown_names(model: Element, until_1_6: bool) -> Iterator[str]:
    """A text for each kind of element or attribute of a model that SDFormat does not have there, with the nearest that it has.

    Directly inside the model only those with a similar name are reported, since other programs write what they like there. Names
    with a prefix belong to other programs.

    Args:
        model: the element.
        until_1_6: whether its version is at most 1.6.
    """
    known = {tag: tuple(names.split() for names in lists) for tag, lists in (_KNOWN | (_UNTIL_1_6 if until_1_6 else {})).items()}
    differing: dict[tuple[str, str], list[str]] = {}
    found: dict[tuple[str, str, str], list[str]] = {}
    waiting = [(model, "")]
    while waiting:
        parent, owner = waiting.pop()
        owner = f'{parent.tag} "{parent.get("name")}"' if "name" in parent.attrib else owner
        elements, attributes = known[parent.tag]
        unknown = [(f"<{child.tag}>", child.tag, elements) for child in parent if child.tag not in elements]
        unknown += [(f'the attribute "{key}"', key, attributes) for key in parent.attrib if key not in attributes]
        for shown, name, valid in unknown:
            near = get_close_matches(name, valid, 1)
            if ":" not in name and name != "xmlns" and (near or parent is not model):
                found.setdefault((shown, parent.tag, f"; nearest: {near[0]}" if near else ""), []).append(owner)
        for single in _SINGLE.intersection(child.tag for child in parent):
            if len({tostring(child, encoding="unicode").strip() for child in parent.findall(single)}) > 1:
                differing.setdefault((single, parent.tag), []).append(owner)
        waiting += [(child, owner) for child in reversed(parent) if child.tag in elements and child.tag in known]
    for (shown, tag, nearest), owners in found.items():
        more = f" and {len(owners) - 1} more" if len(owners) > 1 else ""
        inside = "" if owners[0].startswith(f'{tag} "') else f" in <{tag}>"
        yield f"{owners[0]} has {shown}{inside}{more}, which SDFormat does not have there, so it is not read{nearest}"
    for (single, inside), owners in differing.items():
        more = f" and {len(owners) - 1} more" if len(owners) > 1 else ""
        yield f"{owners[0]} has several <{single}> in <{inside}>{more}, which differ; the first applies"
