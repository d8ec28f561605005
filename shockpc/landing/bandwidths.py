"""The bandwidths of sensors: of all in a scene, or of one point or part."""

from shockpc.core.low_pass import LowPass, low_pass_from
from shockpc.landing.scene import Scene
from shockpc.text.errors import SceneError


def low_passes_of_points(scene: Scene) -> dict[str, LowPass]:
    """The filters of points that have one of their own, by the names of the points; of several the
    last one.

    Raises:
        SceneError: one of them is not a bandwidth.
    """
    filters = {
        one.label: _low_pass(one.imu_bandwidth)
        for one in scene.point
        if one.imu_bandwidth is not None
    }
    return {name: low_pass for name, low_pass in filters.items() if low_pass is not None}


def scene_low_pass(scene: Scene) -> LowPass | None:
    """The filter of all sensors that have no other. Raises: SceneError: it is not a bandwidth."""
    return _low_pass(scene.imu_bandwidth)


def low_pass_of_part(scene: Scene, number: int) -> LowPass | None:
    """The filter of a part that is a sensor; None of one that is none.

    Args: its number among those of the scene.
    """
    return _low_pass(scene.part[number].imu_bandwidth)


def low_passes_of(scene: Scene) -> list[LowPass]:
    """All filters of sensors in a scene.

    Raises:
        SceneError: one of them is not a bandwidth.
    """
    given = [
        scene.imu_bandwidth,
        *(one.imu_bandwidth for one in scene.point),
        *(one.imu_bandwidth for one in scene.part),
    ]
    return [low_pass for low_pass in map(_low_pass, given) if low_pass is not None]


def _low_pass(text: str | None) -> LowPass | None:
    if text is None:
        return None
    try:
        return low_pass_from(text)
    except ValueError as refusal:
        raise SceneError(f"imu_bandwidth: {refusal}") from None
