"""Numbers of benchmarks as tables, for the terminal and for the docs."""

from tauten.service.tables.arm import ARM_BEGIN, ARM_END, arm_tables, sentences, write_arm_tables
from tauten.service.tables.basis import basis_tables, found_robot, kept_curve, ranges
from tauten.service.tables.check import check_tables, write_check_tables
from tauten.service.tables.closed_loop import closed_loop_tables, write_closed_loop_tables
from tauten.service.tables.contact_basis import (
    CONTACT_BASIS_BEGIN,
    CONTACT_BASIS_END,
    by_method,
    certificate,
    contact_basis_tables,
    pairs_of,
    write_contact_basis_tables,
)
from tauten.service.tables.elements import element_tables, write_element_tables
from tauten.service.tables.gallery import gallery_table, loads_table, write_loads_table
from tauten.service.tables.new_robot import trial_table
from tauten.service.tables.node import NODE_BEGIN, NODE_END, node_table, write_node_tables
from tauten.service.tables.numbers import Numbers, PageError, milliseconds
from tauten.service.tables.physics import (
    energy_tables,
    equilibria_tables,
    still_tables,
    write_energy_tables,
    write_equilibria_tables,
)
from tauten.service.tables.qpcc import qpcc_tables, write_qpcc_tables
from tauten.service.tables.reduced import reduced_tables, write_reduced_tables
from tauten.service.tables.steps import (
    control_table,
    sofa_meshes_note,
    sofa_meshes_tables,
    steps_table,
    tip_sentences,
    write_sofa_meshes_tables,
)
from tauten.service.tables.view import VIEW_BEGIN, VIEW_END, view_table, write_view_table

__all__ = [
    "gallery_table",
    "loads_table",
    "write_loads_table",
    "VIEW_BEGIN",
    "VIEW_END",
    "view_table",
    "write_view_table",
    "trial_table",
    "ARM_BEGIN",
    "ARM_END",
    "CONTACT_BASIS_BEGIN",
    "CONTACT_BASIS_END",
    "NODE_BEGIN",
    "NODE_END",
    "Numbers",
    "PageError",
    "arm_tables",
    "basis_tables",
    "by_method",
    "certificate",
    "check_tables",
    "closed_loop_tables",
    "contact_basis_tables",
    "control_table",
    "element_tables",
    "energy_tables",
    "equilibria_tables",
    "found_robot",
    "kept_curve",
    "milliseconds",
    "node_table",
    "pairs_of",
    "qpcc_tables",
    "ranges",
    "reduced_tables",
    "sentences",
    "sofa_meshes_note",
    "sofa_meshes_tables",
    "steps_table",
    "tip_sentences",
    "write_arm_tables",
    "write_check_tables",
    "write_closed_loop_tables",
    "write_contact_basis_tables",
    "write_element_tables",
    "still_tables",
    "write_energy_tables",
    "write_equilibria_tables",
    "write_node_tables",
    "write_qpcc_tables",
    "write_reduced_tables",
    "write_sofa_meshes_tables",
]
