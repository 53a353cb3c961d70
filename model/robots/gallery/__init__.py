"""Scripts that make the robots of the gallery: meshes and robot files."""

from tauten.model.robots.gallery.diamond import make_diamond
from tauten.model.robots.gallery.trunk import make_trunk

__all__ = ["make_diamond", "make_trunk"]
