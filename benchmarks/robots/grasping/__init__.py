"""The meshes of the examples with friction: crawling and grasping."""

from benchmarks.robots.grasping.crawler import make_crawler
from benchmarks.robots.grasping.fork import make_fork

MESHES = {"crawler": make_crawler, "fork": make_fork}

__all__ = ["MESHES"]
