"""placeholder."""
from xml.etree import ElementTree
from shockpc.model.reach import Reach
def plain_mjcf(root, reach: Reach):
    """x."""
    return ElementTree.tostring(root, encoding="unicode"), ()
