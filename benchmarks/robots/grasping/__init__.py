"""The meshes of the examples with friction: crawling and grasping."""

from benchmarks.robots.grasping.crawler import make_crawler
from benchmarks.robots.grasping.fork import make_fork
from benchmarks.robots.grasping.push import make_push
from benchmarks.robots.grasping.ring import make_ring
from benchmarks.robots.grasping.roll import make_roll
from benchmarks.robots.grasping.tentacle import make_tentacle

MESHES = {
    "crawler": make_crawler,
    "fork": make_fork,
    "tentacle": make_tentacle,
    "push": make_push,
    "ring": make_ring,
    "roll": make_roll,
}

__all__ = ["MESHES"]
