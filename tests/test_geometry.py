"""The geometry of bodies, compared with Pinocchio's reading, closed forms, and shapes whose answer
is known.
"""

import struct
import sys
from unittest.mock import Mock

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from commands import ROBOTS, says
from robot_texts import BODY, LIMIT, body, floating, joint, link, loaded, mjcf, urdf

from shockpc import Scene, load_robot, shock_profile
from shockpc.robot.bodies_and_joints import Body
from shockpc.robot.catalogue import data_folder
from shockpc.robot.shapes.convex import inertia_box
from shockpc.robot.shapes.geometry import body_outline, outline
from shockpc.robot.shapes.mesh import outer_vertices
from shockpc.robot.shapes.mesh_files import read_mesh

DIRECTIONS = np.random.default_rng(3).normal(size=(200, 3))
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)

PLACED = '<origin xyz="0.1 -0.2 0.3" rpy="0.4 -0.5 0.6"/>'
TETRAHEDRON = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]])
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def robot(folder, *shapes, kind="collision"):
    """A robot of one link with these <geometry> contents, each placed at PLACED."""
    parts = "".join(f"<{kind}>{PLACED}<geometry>{shape}</geometry></{kind}>" for shape in shapes)
    return loaded(folder, urdf(link("base", more=parts)), "one.urdf")


def from_mjcf(folder, *geoms, assets=""):
    """A robot of two bodies with these geoms on the second."""
    floor, ball = (
        '<geom type="plane" size="1 1 1"/>',
        '<geom type="sphere" size="0.3" quat="1 1 0 0"/>',
    )
    text = mjcf(
        floor + floating(ball, body("b", BODY + "".join(f"<geom {geom}/>" for geom in geoms))),
        f"<asset>{assets}</asset>",
    )
    return loaded(folder, text, "r.xml")


def support(shapes, directions):
    """How far the shapes reach along each direction."""
    return np.max([shape.reach(directions) for shape in shapes], axis=0)


ROTATION, OFFSET = pin.rpy.rpyToMatrix(0.4, -0.5, 0.6), np.array([0.1, -0.2, 0.3])
AS_MJCF = 'pos="0.1 -0.2 0.3" quat="{3} {0} {1} {2}"'.format(
    *pin.Quaternion(ROTATION).coeffs().tolist()
)
LOCAL = DIRECTIONS @ ROTATION
ACROSS, ALONG = np.hypot(LOCAL[:, 0], LOCAL[:, 1]), np.abs(LOCAL[:, 2])

SUPPORTS = {
    '<box size="0.2 0.4 0.6"/>': ('type="box" size="0.1 0.2 0.3"', np.abs(LOCAL) @ [0.1, 0.2, 0.3]),
    '<sphere radius="0.2"/>': ('type="sphere" size="0.2"', np.full(200, 0.2)),
    '<capsule radius="0.1" length="0.4"/>': ('type="capsule" size="0.1 0.2"', 0.1 + 0.2 * ALONG),
    '<cylinder radius="0.1" length="0.4"/>': (
        'type="cylinder" size="0.1 0.2"',
        0.1 * ACROSS + 0.2 * ALONG,
    ),
    "": ('type="ellipsoid" size="0.1 0.2 0.3"', np.linalg.norm(LOCAL * [0.1, 0.2, 0.3], axis=1)),
}


@pytest.mark.parametrize("shape", SUPPORTS)
def test_a_shape_reaches_as_far_as_its_support_function(tmp_path, shape):
    """h(d) of box, sphere, capsule, cylinder and ellipsoid in closed form, placed and turned in the
    link; in either format.
    """
    geom, expected = SUPPORTS[shape]
    robots = [
        from_mjcf(tmp_path, f"{geom} {AS_MJCF}"),
        *([robot(tmp_path, shape)] if shape else []),
    ]
    for (piece,) in (outline(found, "collision").shapes[-1] for found in robots):
        np.testing.assert_allclose(
            piece.reach(DIRECTIONS) - DIRECTIONS @ OFFSET, expected, atol=1e-12
        )
        farthest = [(piece.farthest(direction) @ direction).max() for direction in DIRECTIONS]
        np.testing.assert_allclose(farthest, piece.reach(DIRECTIONS), atol=1e-15)


def test_collision_geometry_in_a_comment_is_none(tmp_path):
    """The visual geometry is taken where the file has no other, whatever its comments hold."""
    parts = (
        "<!-- <collision><geometry/></collision> --><visual><geometry><sphere "
        'radius="0.2"/></geometry></visual>'
    )
    (shapes,) = body_outline(loaded(tmp_path, urdf(link("base", more=parts)))).shapes
    assert len(shapes) == 1


@pytest.mark.slow
@pytest.mark.parametrize("name", ["anymal_b", "solo12", "talos", "go2"])
@pytest.mark.parametrize("kind", ["collision", "visual"])
def test_real_robots_reach_as_far_as_pinocchio_says(name, kind):
    """Every body of a real robot reaches as far along the axes of its frame as the geometry that
    Pinocchio reads.
    """
    model = load_robot(name)
    which = pin.GeometryType.COLLISION if kind == "collision" else pin.GeometryType.VISUAL
    geometry = pin.GeometryModel()
    pin.buildGeomFromUrdfString(
        model.model, model.source.xml, which, geometry, [str(data_folder().parent)]
    )
    found = outline(model, kind)
    assert found.warnings == ()
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    for body_record, shapes in zip(model.bodies, found.shapes, strict=True):
        items = [item for item in geometry.geometryObjects if item.parentJoint == body_record.joint]
        assert bool(items) == bool(shapes)
        if items:
            turned = axes @ body_record.rotation.T
            reach = [
                coal_support(item.geometry, turned @ item.placement.rotation)
                + turned @ item.placement.translation
                for item in items
            ]
            # Pinocchio's loader keeps meshes in single precision.
            np.testing.assert_allclose(
                support(shapes, axes),
                np.max(reach, axis=0) - turned @ body_record.offset,
                atol=2e-6,
            )


def test_the_greatest_shock_of_a_thigh_is_on_the_rim_of_its_cylinder():
    """As far as 200 000 points on the rims of the cylinders and the corners of the box that
    Pinocchio reads.
    """
    profile = shock_profile(Scene(robot="anymal_b", contact="LF_FOOT"))
    (index,) = (i for i, body in enumerate(profile.robot.bodies) if body.name == "LF_THIGH")
    geometry, angle = pin.GeometryModel(), 2.0 * np.pi * np.arange(100_000) / 100_000
    source = profile.robot.source.xml
    pin.buildGeomFromUrdfString(
        profile.robot.model,
        source,
        pin.GeometryType.COLLISION,
        geometry,
        [str(data_folder().parent)],
    )
    body, shocks = profile.robot.bodies[index], []
    for item in (item for item in geometry.geometryObjects if item.parentJoint == body.joint):
        points = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        if hasattr(item.geometry, "halfSide"):
            points = points * item.geometry.halfSide
        else:
            rim = item.geometry.radius * np.stack(
                [np.cos(angle), np.sin(angle), 0.0 * angle], axis=1
            )
            points = np.concatenate(
                [np.add(rim, [0.0, 0.0, z * item.geometry.halfLength]) for z in (-1, 1)]
            )
        in_joint = points @ item.placement.rotation.T + item.placement.translation
        shocks.append(profile.shock_at(body.name, (in_joint - body.offset) @ body.rotation).max())
    assert profile.shock_max[index] == pytest.approx(max(shocks), rel=2e-9)
    assert profile.shock_max[index] == pytest.approx(1.060368, abs=5e-7)


def coal_support(shape, directions):
    """How far a shape of coal reaches along each direction."""
    if hasattr(shape, "vertices"):
        return (directions @ shape.vertices().T).max(axis=1)
    if hasattr(shape, "halfSide"):
        return np.abs(directions) @ shape.halfSide
    if hasattr(shape, "halfLength"):
        return shape.radius * np.hypot(*directions.T[:2]) + shape.halfLength * np.abs(
            directions[:, 2]
        )
    return np.full(len(directions), shape.radius)


def stl(path, triangles):
    """Write a binary STL."""
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(t), 0) for t in triangles)
    path.write_bytes(b"\0" * 80 + struct.pack("<I", len(triangles)) + facets)


def collada(*parts, unit="1", steps=""):
    """A COLLADA text; every part is (vertices, faces) in one geometry, all in one node, with
    normals that do not exist.
    """
    geometry, params = "", "".join(f'<param name="{axis}" type="float"/>' for axis in "XYZ")
    for k, (vertices, faces) in enumerate(parts):
        numbers, length = " ".join(map(str, np.ravel(vertices))), np.size(vertices)
        index = " ".join(f"{i} 99" for i in np.ravel(faces))
        geometry += (
            f'<geometry id="g{k}"><mesh><source id="s{k}"><float_array id="a{k}" '
            f'count="{length}">{numbers}</float_array>'
            f'<technique_common><accessor source="#a{k}" count="{len(vertices)}" '
            f'stride="3">{params}</accessor></technique_common>'
            "</source>"
            f'<vertices id="v{k}"><input semantic="POSITION" source="#s{k}"/></vertices><triangles '
            f'count="{len(faces)}">'
            f'<input semantic="VERTEX" source="#v{k}" offset="0"/><input semantic="NORMAL" '
            f'source="#s{k}" offset="1"/>'
            f"<p>{index}</p></triangles></mesh></geometry>"
        )
    instances = "".join(f'<instance_geometry url="#g{k}"/>' for k in range(len(parts)))
    return (
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" '
        'version="1.4.1">'
        f"<asset><unit "
        f'meter="{unit}"/><up_axis>Y_UP</up_axis></asset><library_geometries>{geometry}</library_geometries>'
        f"<library_visual_scenes><visual_scene "
        f'id="scene"><node>{steps}{instances}</node></visual_scene></library_visual_scenes>'
        '<scene><instance_visual_scene url="#scene"/></scene></COLLADA>'
    )


def volume(mesh):
    """Volume inside a closed mesh, by the divergence theorem."""
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    return float(np.sum(a * np.cross(b, c))) / 6.0


def read(path):
    """Read a mesh file."""
    return read_mesh(path.read_bytes(), path.suffix[1:])


def ply(path):
    """Write the tetrahedron as a PLY that names a texture."""
    path.write_text(
        "ply\nformat ascii 1.0\ncomment TextureFile skin.png\nelement vertex 4\n"
        "property float x\nproperty float y\nproperty float z\nelement face 4\nproperty list uchar "
        "int vertex_indices\nend_header\n"
        + "\n".join(
            [f"{x} {y} {z}" for x, y, z in TETRAHEDRON] + [f"3 {a} {b} {c}" for a, b, c in FACES]
        )
    )


WRITERS = {
    "t.stl": lambda path: stl(path, [TETRAHEDRON[list(face)] for face in FACES]),
    "t.obj": lambda path: path.write_text(
        "\n".join(
            ["mtllib skin.mtl", *(f"v {x} {y} {z}" for x, y, z in TETRAHEDRON), "usemtl red"]
            + [f"f {a + 1} {b - 4} {c + 1}" for a, b, c in FACES]
        )
    ),
    "t.dae": lambda path: path.write_text(collada((TETRAHEDRON, FACES))),
    "t.ply": ply,
    "t.msh": lambda path: path.write_bytes(
        np.int32([4, 1, 2, 4]).tobytes()
        + np.float32([*TETRAHEDRON.ravel(), *range(7)]).tobytes()
        + np.int32(FACES).tobytes()
    ),
}


@pytest.mark.parametrize("name", WRITERS)
def test_a_mesh_keeps_its_volume(tmp_path, name):
    """A tetrahedron of edges 1, 2, 3 holds 1 m³ in every format; mirrored and stretched by 2 it
    holds 2 m³.
    """
    WRITERS[name](tmp_path / name)
    assert volume(read(tmp_path / name)) == pytest.approx(1.0, rel=1e-6)
    (shapes,) = outline(
        robot(tmp_path, f'<mesh filename="{name}" scale="2 -1 1"/>'), "collision"
    ).shapes
    assert abs(volume(shapes[0].mesh)) == pytest.approx(2.0, rel=1e-6)
    assert len(shapes[0].points) == 4


@pytest.mark.parametrize("name", WRITERS)
def test_reading_a_mesh_opens_no_file(tmp_path, name):
    """Materials and textures beside a mesh are named in it and never opened."""
    WRITERS[name](tmp_path / name)
    data = (tmp_path / name).read_bytes()
    read_mesh(data, name[2:])  # imports the libraries
    opened = []
    OPENED.append(opened)
    read_mesh(data, name[2:])
    OPENED.clear()
    assert opened == []


OPENED = []
"""Lists that are given the name of every file that this process opens; an audit hook cannot be
removed again.
"""
sys.addaudithook(
    lambda event, details: (
        [names.append(details[0]) for names in OPENED] if event == "open" else None
    )
)


def test_a_collada_scene_is_placed_and_scaled(tmp_path):
    """Transformations apply from the last to the first, millimetres become metres, the up axis
    changes nothing; parts join.
    """
    steps = "<translate>0 0 1000</translate><rotate>0 0 1 90</rotate><scale>2 1 1</scale>"
    parts = (1000.0 * TETRAHEDRON, FACES), (1000.0 * TETRAHEDRON + 5000.0, FACES)
    (tmp_path / "mm.dae").write_text(collada(*parts, unit="0.001", steps=steps))
    mesh = read(tmp_path / "mm.dae")
    expected = np.array([[0, 0, 1], [0, 2, 1], [-2, 0, 1], [0, 0, 4]])
    expected = np.concatenate([expected, np.add(expected, [-5, 10, 5])])
    np.testing.assert_allclose(np.sort(mesh.vertices, axis=0), np.sort(expected, axis=0), atol=1e-6)
    assert volume(mesh) == pytest.approx(4.0)


@pytest.mark.parametrize(("place", "turned"), [("0 0 4", True), ("0 4 0", False), ("0 2 3", False)])
def test_meshes_with_y_up_are_turned_if_the_joints_fit_them_better_so(tmp_path, place, turned):
    """A bar along the y axis of a file with y up: it is along z if the next joint is there,
    otherwise as it is written.
    """
    (tmp_path / "bar.dae").write_text(collada((TETRAHEDRON * [0.1, 2.0, 0.1], FACES)))
    bar = link(
        "bar",
        more='<collision><geometry><mesh filename="bar.dae" scale="1 1 2"/></geometry></collision>',
    )
    text = urdf(
        bar, link("next"), joint("j", "bar", "next", more=f'<origin xyz="{place}"/>{LIMIT}')
    )
    ((shape,), _) = outline(loaded(tmp_path, text), "collision").shapes
    extent = [0.1, 0.3, 8.0] if turned else [0.1, 4.0, 0.6]
    assert np.ptp(shape.points, axis=0) == pytest.approx(extent)
    assert shape.mesh.vertices.min() == (pytest.approx(-0.3) if turned else 0.0)


def test_a_flat_mesh_keeps_its_vertices(tmp_path):
    """A plate has no hull with a volume; its vertices reach as far without one."""
    (tmp_path / "plate.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv .5 .5 0\nf 1 2 5\nf 2 4 5\nf 4 3 5\nf 3 1 5\n"
    )
    (shapes,) = outline(robot(tmp_path, '<mesh filename="plate.obj"/>'), "collision").shapes
    assert len(shapes[0].points) == 5


def cone(rng, rim):
    """A cone whose tip has that many neighbours, after points inside it."""
    angle = 2.0 * np.pi * np.arange(rim) / rim
    corners = np.vstack(
        [
            [0.0, 0.0, 0.5],
            np.column_stack([0.2 * np.cos(angle), 0.2 * np.sin(angle), np.zeros(rim)]),
        ]
    )
    return np.vstack([rng.dirichlet(np.ones(rim + 1), 2000) @ corners, corners])


CLOUDS = {
    "needle": (lambda rng: rng.normal(size=(2000, 3)) * [1.0, 1e-3, 1e3], 100),
    "lattice": (
        lambda rng: rng.uniform(-1.0, 1.0, (2000, 3)).round(1) * [0.3, 1.0, 1e-6] + 5.0,
        500,
    ),
    "box": (lambda rng: np.clip(rng.normal(size=(3000, 3)), -1.0, 1.0), 2500),
    "tetrahedron": (
        lambda rng: np.vstack([rng.dirichlet(np.ones(4), 2000) @ TETRAHEDRON, TETRAHEDRON]),
        100,
    ),
    "cone": (lambda rng: cone(rng, 300), 400),
    "line": (
        lambda rng: (
            rng.uniform(size=(500, 1)) * [1.0, 2.0, 3.0] + 1e-13 * rng.normal(size=(500, 3))
        ),
        500,
    ),
    "point": (lambda rng: np.ones((500, 3)), 500),
}


@pytest.mark.parametrize("name", CLOUDS)
def test_outer_vertices_reach_as_far_as_all(name):
    """In every direction, also in those of a shape that is scaled to a cube; of a filled shape many
    vertices are left out.
    """
    make, most = CLOUDS[name]
    vertices = make(np.random.default_rng(3))
    outer = outer_vertices(vertices)
    assert len(outer) <= most
    for directions in (DIRECTIONS, DIRECTIONS / np.maximum(np.ptp(vertices, axis=0), 1e-300)):
        np.testing.assert_allclose(
            (directions @ outer.T).max(axis=1), (directions @ vertices.T).max(axis=1), rtol=1e-14
        )


BROKEN = {
    "empty.stl": b"",
    "cut.stl": b"\0" * 80 + struct.pack("<I", 7),
    "words.obj": b"v one two three\nf 1 2 3",
    "beyond.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9",
    "nan.obj": b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3",
    "huge.obj": b"v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3",
    "backwards.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf -3 -2 -1",
    "points.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0",
    "cut.ply": b"ply\nformat ascii 1.0\nelement vertex 3\n",
    "empty.dae": b"",
    "cut.dae": b"<COLLADA><asset>",
    "other.dae": b"<svg/>",
    "bomb.dae": b'<!DOCTYPE a [<!ENTITY b "cc">]><COLLADA>&b;</COLLADA>',
    "nothing.dae": b"<COLLADA/>",
    "words.dae": collada((TETRAHEDRON, FACES)).replace("0.0 0.0 0.0", "here be dragons").encode(),
    "beyond.dae": collada((TETRAHEDRON, (*FACES, (0, 1, 7)))).encode(),
    "cycle.dae": collada(
        (TETRAHEDRON, FACES), steps='<node id="n"><instance_node url="#n"/></node>'
    ).encode(),
    "nan.dae": collada((TETRAHEDRON, FACES)).replace("0.0 0.0 0.0", "0.0 NaN 0.0").encode(),
    "inf.dae": collada((TETRAHEDRON, FACES)).replace("0.0 0.0 0.0", "0.0 1e60 0.0").encode(),
    "later.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 1 nan\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 4",
    "doubled.dae": collada(
        (TETRAHEDRON, FACES),
        steps="".join(
            f'<node id="n{k}">{f"""<instance_node url="#n{k + 1}"/>""" * 2}</node>'
            for k in range(40)
        ),
    ).encode(),
    "deep.dae": collada(
        (TETRAHEDRON, FACES),
        steps="".join(
            f'<node id="n{k}"><instance_node url="#n{k + 1}"/></node>' for k in range(2000)
        ),
    ).encode(),
    "gap.dae": collada((TETRAHEDRON, FACES)).replace("#s0", "#nowhere").encode(),
    "what.xyz": b"0 0 0",
    "cut.msh": b"\4\0\0\0",
    "long.msh": np.int32([-3, 0, 0, 3, 0, 0, 0]).tobytes(),
    "beyond.msh": np.int32([0, 0, 0, 1, 0, 1, 2]).tobytes(),
}


@pytest.mark.parametrize(
    ("shape", "placed", "said"),
    [
        ('<box size="1 x 1"/>', PLACED, 'its size is "1 x 1"; it has to be 3 finite numbers'),
        ('<box size="1 1"/>', PLACED, 'its size is "1 1"; it has to be 3 finite numbers'),
        ('<sphere radius="nan"/>', PLACED, 'its radius is "nan"; it has to be 1 finite number'),
        (
            '<sphere radius="1"/>',
            '<origin rpy="1"/>',
            'its rpy is "1"; it has to be 3 finite numbers',
        ),
        ("<cone/>", PLACED, "a <cone> with these dimensions is not a valid shape"),
        ("", PLACED, "a <collision> without a shape"),
    ],
)
def test_a_shape_that_cannot_be_read_is_a_warning(tmp_path, shape, placed, said):
    """It is left out of figures and extremes, and costs nothing else."""
    path = tmp_path / "one.urdf"
    geometry = f"<geometry>{shape}</geometry>" if shape else ""
    path.write_text(
        urdf(link("base", more=f"<collision>{placed}{geometry}</collision>"), name="one")
    )
    found = outline(load_robot(str(path)), "collision")
    assert found.shapes == ((),)
    (warning,) = found.warnings
    assert says(warning, "1 of 1 collision shapes", f'(link "base": {said})', 'left for "base"')


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_mesh_costs_only_itself(tmp_path, capfd, name):
    """The other shapes are there, one line names the mesh, and no library writes a message of its
    own.
    """
    (tmp_path / name).write_bytes(BROKEN[name])
    found = outline(
        robot(tmp_path, f'<mesh filename="{name}"/>', '<sphere radius="0.1"/>'), "collision"
    )
    assert [np.linalg.norm(shape.rounding, axis=0) for shape in found.shapes[0]] == [
        pytest.approx(0.1)
    ]
    (warning,) = found.warnings
    assert warning.startswith('1 of 2 collision shapes could not be read (link "base": ')
    assert name in warning or name == "huge.obj"
    assert warning.endswith("); each of their bodies has other shapes")
    assert "\n" not in warning
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    "error", [ModuleNotFoundError("no module"), MemoryError(), OSError("odd"), Warning("odd")]
)
def test_whatever_a_reader_raises_costs_only_its_mesh(tmp_path, monkeypatch, error):
    """Also what a library raises that lacks another one."""
    from trimesh.exchange.load import mesh_loaders

    monkeypatch.setitem(mesh_loaders, "obj", Mock(side_effect=error))
    with pytest.raises(
        ValueError, match=f"not a valid OBJ file .{str(error) or type(error).__name__}."
    ):
        read_mesh(b"v 0 0 0", "obj")


def test_text_that_is_not_utf_8_in_a_mesh():
    """A comment in Latin-1 changes nothing."""
    assert len(read_mesh(b"# caf\xe9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "obj").triangles) == 1


def test_missing_meshes_are_named_in_one_line(tmp_path):
    """Missing files and one outside the robot's folders: one line with the first reason, the other
    names and the consequence.
    """
    found = outline(
        robot(
            tmp_path,
            *(
                f'<mesh filename="{name}"/>'
                for name in ("gone.stl", "../../../etc/passwd", "b.stl")
            ),
        ),
        "collision",
    )
    assert found.shapes == ((),)
    (warning,) = found.warnings
    gone = (f'no file "{tmp_path / "gone.stl"}"', 'also "../../../etc/passwd", "b.stl"')
    assert says(
        warning,
        "3 of 3 collision shapes",
        'link "base": one.urdf: "gone.stl"',
        *gone,
        'left for "base"',
    )


def test_mjcf_meshes_are_where_mujoco_has_them(tmp_path):
    """Moved from refpos, turned back by refquat, and scaled; ours keep their digits.

    A missing one is named for its kind.
    """
    WRITERS["t.obj"](tmp_path / "t.obj")
    place = 'scale="2 -1 0.5" refpos="0.1 0.2 0.3" refquat="0.8 0.2 -0.3 0.4"'
    there, gone = f'<mesh name="t" file="t.obj" {place}/>', '<mesh name="gone" file="gone.stl"/>'
    geoms = (
        'type="mesh" mesh="t" pos="0.5 0.1 -0.2" euler="10 20 30"',
        'type="mesh" mesh="gone" contype="0" conaffinity="0"',
    )
    found = from_mjcf(tmp_path, *geoms, assets=there + gone)
    solid, seen = outline(found, "collision"), outline(found, "visual")
    from_mjcf(tmp_path, geoms[0], assets=there)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "r.xml"))
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[-1])
    expected = model.mesh_vert @ turn.reshape(3, 3).T + model.geom_pos[-1]
    for (shape,) in (solid.shapes[1], seen.shapes[1]):
        assert np.abs(shape.mesh.vertices[:, None] - expected).max(axis=-1).min(axis=1).max() < 1e-6
        assert abs(volume(shape.mesh)) == pytest.approx(1.0, rel=1e-6)
    assert solid.warnings == ()
    (warning,) = seen.warnings
    assert warning.startswith('1 of 3 visual shapes could not be read (link "b": ')
    assert '"gone.stl" is missing' in warning


@pytest.mark.parametrize(
    ("attributes", "kinds"),
    [
        ("", {"collision", "visual"}),
        ('group="3"', {"collision"}),
        ('contype="0" conaffinity="0"', {"visual"}),
        ('contype="0" conaffinity="0" group="4"', {"visual"}),
    ],
)
def test_mjcf_geoms_are_for_collision_or_for_show(tmp_path, attributes, kinds):
    """What collides is collision geometry; what does not, or is in a group that MuJoCo shows, is
    visual geometry.
    """
    found = from_mjcf(tmp_path, f'size="0.1" {attributes}')
    assert {kind for kind in ("collision", "visual") if outline(found, kind).shapes[1]} == kinds


def weight(mass, inertia, com=(0.0, 0.0, 0.0)):
    """A body in its joint's frame."""
    return Body(
        "b", 1, ("b",), np.eye(3), np.zeros(3), mass, np.array(com), np.array(inertia, dtype=float)
    )


def test_the_inertia_box_has_the_inertia_of_the_body():
    """A uniform box of the found size, place and axes has the body's mass moments again."""
    turn = pin.rpy.rpyToMatrix(0.3, 0.7, -0.2)
    inertia = turn @ np.diag([0.02, 0.03, 0.04]) @ turn.T
    box = inertia_box(weight(2.0, inertia, (0.1, 0.2, 0.3)))
    arms = box.points - [0.1, 0.2, 0.3]
    # Of a box with half sides h the eight corners average h², its volume h² / 3.
    second = 2.0 * (arms.T @ arms) / 8.0 / 3.0
    np.testing.assert_allclose(np.trace(second) * np.eye(3) - second, inertia, atol=1e-15)
    # A side that rounding makes slightly negative is zero: a rod is a box without width.
    assert np.ptp(
        inertia_box(weight(3.0, np.diag([0.25, 0.25, 0.0]))).points, axis=0
    ) == pytest.approx([0.0, 0.0, 1.0])


@pytest.mark.parametrize(
    ("mass", "inertia"),
    [
        (0.0, np.zeros((3, 3))),
        (1.0, np.zeros((3, 3))),
        (1.0, np.full((3, 3), 1e-6)),
        (1.0, np.diag([1.0, 1.0, 3.0])),
    ],
    ids=["massless", "a point", "all entries alike", "against the triangle inequality"],
)
def test_an_impossible_inertia_has_no_box(mass, inertia):
    """Inertias that no body can have give no box."""
    assert inertia_box(weight(mass, inertia)) is None


def test_why_a_mesh_cannot_be_read_is_said_without_a_class_of_python():
    """Pycollada's messages begin with the class of the error."""
    data = (ROBOTS / "stick" / "part.dae").read_bytes().replace(b'"#g"', b'"#h"')
    with pytest.raises(
        ValueError, match=r"^it is not a valid DAE file \(Geometry #h not found in library\)$"
    ):
        read_mesh(data, "dae")
