"""Numbers of benchmarks as tables."""

from benchmarks.tables.arm import arm_page
from benchmarks.tables.contact_basis import by_method, contact_basis_page, pairs_of
from benchmarks.tables.contact_loop import contact_loop_page
from benchmarks.tables.control import closed_loop_page, still_page
from benchmarks.tables.elements import element_page
from benchmarks.tables.friction import friction_page
from benchmarks.tables.friction_inverse import friction_inverse_page
from benchmarks.tables.friction_modes import friction_modes_page
from benchmarks.tables.gallery import gallery_page, load_errors_page
from benchmarks.tables.obstacles import obstacles_page
from benchmarks.tables.physics import energy_page, equilibria_page
from benchmarks.tables.qpcc import qpcc_page
from benchmarks.tables.start import first_hour_page
from benchmarks.tables.steps import control_page, reduced_meshes_page, sofa_meshes_page
from benchmarks.tables.view import view_page

__all__ = [
    "arm_page",
    "by_method",
    "closed_loop_page",
    "contact_basis_page",
    "contact_loop_page",
    "control_page",
    "element_page",
    "energy_page",
    "equilibria_page",
    "first_hour_page",
    "friction_inverse_page",
    "friction_modes_page",
    "friction_page",
    "gallery_page",
    "load_errors_page",
    "obstacles_page",
    "pairs_of",
    "qpcc_page",
    "reduced_meshes_page",
    "sofa_meshes_page",
    "still_page",
    "view_page",
]
