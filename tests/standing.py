"""Robots that stand, written with their SRDF: a quadruped with feet of several kinds, and a biped
with soles.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

LEGS = {"FL": (0.2, 0.1), "FR": (0.2, -0.1), "RL": (-0.2, 0.1), "RR": (-0.2, -0.1)}


def quadruped(
    folder: Path,
    name: str,
    foot: str,
    longer: Mapping[str, float] | None = None,
    bare: Sequence[str] = (),
) -> Path:
    """Write a quadruped with an IMU beside its middle.

    Args:
        folder: where.
        name: of its files.
        foot: "fixed" balls on links, "sphere_on_calf" without links, or flat feet at an "ankle".
        longer: by how much calves are longer, by leg [m].
        bare: legs whose feet have no geometry.
    """
    parts = [
        _link("base", _inertial(8, 0.45, 0.22, 0.12) + _box(0.45, 0.22, 0.12)),
        _link("imu_link"),
    ]
    parts += [_joint("imu_joint", "base", "imu_link", "-0.05 0.03 0.04")]
    calf_of = "{}_shank" if foot == "sphere_on_calf" else "{}_calf"
    for leg, (x, y) in LEGS.items():
        length, side, calf = (
            0.21 + (longer or {}).get(leg, 0.0),
            1 if y > 0 else -1,
            calf_of.format(leg),
        )
        body = _inertial(0.25, 0.03, 0.03, 0.21, "0 0 -.1")
        body += _collision(
            f'<cylinder radius="0.012" length="{length - 0.03}"/>', f"0 0 {-(length - 0.03) / 2}"
        )
        body += _ball(f"0 0 {-length}") * (foot == "sphere_on_calf")
        parts += [
            _link(f"{leg}_hip", _inertial(0.6, 0.08, 0.08, 0.08)),
            _joint(f"{leg}_hip_joint", "base", f"{leg}_hip", f"{x} {y} 0", "1 0 0"),
            _link(
                f"{leg}_thigh",
                _inertial(1.1, 0.04, 0.04, 0.22, "0 0 -.1") + _box(0.04, 0.03, 0.2, "0 0 -.1"),
            ),
            _joint(
                f"{leg}_thigh_joint", f"{leg}_hip", f"{leg}_thigh", f"0 {side * 0.05} 0", "0 1 0"
            ),
            _link(calf, body),
            _joint(f"{leg}_calf_joint", f"{leg}_thigh", calf, "0 0 -.21", "0 1 0"),
        ]
        if foot == "fixed":
            ball = "" if leg in bare else _ball()
            parts += [_link(f"{leg}_foot", _inertial(0.05, 0.03, 0.03, 0.03) + ball)]
            parts += [_joint(f"{leg}_foot_joint", calf, f"{leg}_foot", f"0 0 {-length}")]
        if foot == "ankle":
            body = (
                _inertial(0.2, 0.1, 0.06, 0.03, "0 0 -.055")
                + _box(0.1, 0.06, 0.03, "0.01 0 -.055")
                + _box(0.03, 0.03, 0.05, "0 0 -.02")
            )
            parts += [
                _link(f"{leg}_foot", body),
                _joint(f"{leg}_ankle_joint", calf, f"{leg}_foot", f"0 0 {-length}", "0 1 0"),
            ]
    angles = {"hip": 0, "thigh": 0.8, "calf": -1.6} | ({"ankle": 0.8} if foot == "ankle" else {})
    return _written(
        folder,
        name,
        parts,
        {f"{leg}_{joint}_joint": angle for leg in LEGS for joint, angle in angles.items()},
    )


def soles(folder: Path, name: str) -> Path:
    """Write a biped with soles. Args: as for `quadruped`."""
    parts = [
        _link(
            "pelvis", _inertial(20, 0.25, 0.35, 0.5, "0 0 .25") + _box(0.25, 0.35, 0.5, "0 0 .25")
        ),
        _link("imu_link"),
    ]
    parts += [_joint("imu_joint", "pelvis", "imu_link", "-0.05 0 0.1")]
    for leg, y in (("left", 0.1), ("right", -0.1)):
        parts += [
            _link(f"{leg}_hip_y", _inertial(1, 0.08, 0.08, 0.08)),
            _joint(f"{leg}_hip_yaw", "pelvis", f"{leg}_hip_y", f"0 {y} 0", "0 0 1"),
            _link(f"{leg}_hip_r", _inertial(1, 0.08, 0.08, 0.08)),
            _joint(f"{leg}_hip_roll", f"{leg}_hip_y", f"{leg}_hip_r", "0 0 -.05", "1 0 0"),
            _link(
                f"{leg}_thigh",
                _inertial(4, 0.1, 0.1, 0.35, "0 0 -.17") + _box(0.1, 0.1, 0.3, "0 0 -.18"),
            ),
            _joint(f"{leg}_hip_pitch", f"{leg}_hip_r", f"{leg}_thigh", "0 0 0", "0 1 0"),
            _link(
                f"{leg}_shank",
                _inertial(3, 0.08, 0.08, 0.35, "0 0 -.17") + _box(0.08, 0.08, 0.3, "0 0 -.18"),
            ),
            _joint(f"{leg}_knee", f"{leg}_thigh", f"{leg}_shank", "0 0 -.36", "0 1 0"),
            _link(f"{leg}_ank", _inertial(0.3, 0.05, 0.05, 0.05)),
            _joint(f"{leg}_ankle_pitch", f"{leg}_shank", f"{leg}_ank", "0 0 -.36", "0 1 0"),
            _link(
                f"{leg}_foot",
                _inertial(0.8, 0.22, 0.09, 0.04, "0.03 0 -.06")
                + _box(0.22, 0.09, 0.03, "0.03 0 -.075"),
            ),
            _joint(f"{leg}_ankle_roll", f"{leg}_ank", f"{leg}_foot", "0 0 0", "1 0 0"),
        ]
    angles = {"hip_pitch": -0.4, "knee": 0.8, "ankle_pitch": -0.4}
    return _written(
        folder,
        name,
        parts,
        {f"{leg}_{joint}": angle for leg in ("left", "right") for joint, angle in angles.items()},
    )


def _written(folder: Path, name: str, parts: Sequence[str], standing: Mapping[str, float]) -> Path:
    values = "".join(
        f'<joint name="{joint}" value="{angle}"/>' for joint, angle in standing.items()
    )
    state = f'<group_state name="standing" group="all">{values}</group_state>'
    (folder / f"{name}.srdf").write_text(f'<robot name="{name}">{state}</robot>')
    path = folder / f"{name}.urdf"
    path.write_text(f'<robot name="{name}">{"".join(parts)}</robot>')
    return path


def _link(name: str, body: str = "") -> str:
    return f'<link name="{name}">{body}</link>'


def _joint(name: str, parent: str, child: str, xyz: str, axis: str = "") -> str:
    """A hinge about an axis; fixed without one."""
    turns = (
        f'<axis xyz="{axis}"/><limit lower="-2.5" upper="2.5" effort="40" velocity="20"/>'
        if axis
        else ""
    )
    ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}"/>'
    return f'<joint name="{name}" type="{"revolute" if axis else "fixed"}">{ends}{turns}</joint>'


def _inertial(m: float, x: float, y: float, z: float, xyz: str = "0 0 0") -> str:
    """A box of uniform density."""
    moments = zip("xyz", (y * y + z * z, x * x + z * z, x * x + y * y), strict=True)
    written = " ".join(f'i{axis}{axis}="{m * square / 12:.6g}"' for axis, square in moments)
    return (
        f'<inertial><origin xyz="{xyz}"/><mass value="{m}"/><inertia {written} ixy="0" ixz="0" '
        f'iyz="0"/></inertial>'
    )


def _collision(shape: str, xyz: str) -> str:
    return f'<collision><origin xyz="{xyz}"/><geometry>{shape}</geometry></collision>'


def _box(x: float, y: float, z: float, xyz: str = "0 0 0") -> str:
    return _collision(f'<box size="{x} {y} {z}"/>', xyz)


def _ball(xyz: str = "0 0 0") -> str:
    return _collision('<sphere radius="0.02"/>', xyz)
