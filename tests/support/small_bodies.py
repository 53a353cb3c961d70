"""A short thick beam of every element and law, small enough for dense matrices over all of its nodes."""

from __future__ import annotations

from support.bodies import beam_config, box_mesh
from tauten.model.load import build_robot
from tauten.model.schema import RobotConfig
from tauten.model.tetra import TetRobot

SIZE = (0.1, 0.02, 0.02)
SOFT = {"young_modulus": 1e6, "poisson_ratio": 0.45, "density": 1000.0}
STIFF_END = {
    "young_modulus": 5e6,
    "poisson_ratio": 0.3,
    "density": 1200.0,
    "region": {"lower": [0.06, 0.0, 0.0], "upper": [0.1, 0.02, 0.02]},
}
KINDS: dict[str, tuple[str, dict[str, object], list[dict[str, object]]]] = {
    "linear": ("linear", {"law": "corotational", **SOFT}, []),
    "linear, regions": ("linear", {"law": "corotational", **SOFT}, [STIFF_END]),
    "linear, yeoh": (
        "linear",
        {"law": "yeoh", "silicone": "dragon-skin-30", "density": 1080.0},
        [],
    ),
    "smoothed": ("smoothed", {"law": "corotational", **SOFT}, []),
    "smoothed, regions": ("smoothed", {"law": "corotational", **SOFT}, [STIFF_END]),
    "smoothed, neo-hookean": ("smoothed", {"law": "neo-hookean", **SOFT}, []),
    "smoothed, mixed laws": (
        "smoothed",
        {"law": "corotational", **SOFT},
        [{"law": "stable-neo-hookean", **STIFF_END}],
    ),
    "quadratic": ("quadratic", {"law": "corotational", **SOFT}, []),
    "quadratic, mooney-rivlin": (
        "quadratic",
        {"law": "mooney-rivlin", "c10": 1e5, "c01": 5e4, "poisson_ratio": 0.45, "density": 1000.0},
        [],
    ),
}


def small_body(kind: str, **changes: object) -> TetRobot:
    """A beam of one of `KINDS`, with changes of its settings."""
    element, material, materials = KINDS[kind]
    settings = beam_config(SIZE, material=material, materials=materials, **changes)
    settings["mesh"] = {"file": "beam.vtu", "element": element}
    config = RobotConfig.model_validate(settings)
    return build_robot(config, box_mesh(SIZE, (6, 2, 2)), "beam")
