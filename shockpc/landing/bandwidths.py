"""The bandwidths of sensors: of all points of a scene, and of parts that are sensors."""

from shockpc.core.low_pass import LowPass, low_pass_from
from shockpc.landing.scenes.scene import Scene
from shockpc.text.errors import SceneError


def scene_low_pass(scene: Scene) -> LowPass | None:
    """The filter of the sensors at points. Raises: SceneError: it is not a bandwidth."""
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
    texts = [scene.imu_bandwidth, *(part.imu_bandwidth for part in scene.part)]
    return [low_pass for low_pass in map(_low_pass, texts) if low_pass is not None]


def _low_pass(text: str | None) -> LowPass | None:
    if text is None:
        return None
    try:
        return low_pass_from(text)
    except ValueError as refusal:
        raise SceneError(f"imu_bandwidth: {refusal}") from None
