"""The meshes of the examples with friction: crawling and grasping."""

from benchmarks.robots.grasping.crawler import make_crawler

MESHES = {"crawler": make_crawler}

__all__ = ["MESHES"]
