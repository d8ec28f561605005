"""Texts of what gives way."""

from shockpc.quantities.shock_profile import ShockProfile


def stiffness_text(profile: ShockProfile) -> str:
    """The stiffness of contacts and end stops, and their damping, as the scene gives them."""
    scene = profile.scene
    text = f"{scene.contact_stiffness:g} N/m"
    if scene.tangential_stiffness is not None:
        text += f" ({scene.tangential_stiffness:g} N/m along the ground)"
    if scene.stop_stiffness is not None:
        text += f", end stops of {scene.stop_stiffness:g} N m/rad or N/m"
    if scene.contact_damping is not None:
        text += f", {scene.contact_damping:g} N s/m"
    if scene.contact_law == "damper":
        text += ", dampers in series"
    return text
