"""Numbers of benchmarks as tables."""

from benchmarks.tables.arm import ARM_BEGIN, ARM_END, arm_tables, sentences, write_arm_tables
from benchmarks.tables.contact_basis import (
    CONTACT_BASIS_BEGIN,
    CONTACT_BASIS_END,
    by_method,
    certificate,
    contact_basis_tables,
    pairs_of,
    write_contact_basis_tables,
)
from benchmarks.tables.elements import element_tables, write_element_tables
from benchmarks.tables.gallery import gallery_table, loads_table, write_loads_table
from benchmarks.tables.physics import (
    energy_tables,
    equilibria_tables,
    write_energy_tables,
    write_equilibria_tables,
)
from benchmarks.tables.qpcc import qpcc_tables, write_qpcc_tables
from benchmarks.tables.steps import (
    control_table,
    sofa_meshes_note,
    sofa_meshes_tables,
    tip_sentences,
    write_sofa_meshes_tables,
)
from benchmarks.tables.view import view_table, write_view_table

__all__ = [
    "ARM_BEGIN",
    "ARM_END",
    "CONTACT_BASIS_BEGIN",
    "CONTACT_BASIS_END",
    "arm_tables",
    "by_method",
    "certificate",
    "contact_basis_tables",
    "control_table",
    "element_tables",
    "energy_tables",
    "equilibria_tables",
    "gallery_table",
    "loads_table",
    "pairs_of",
    "qpcc_tables",
    "sentences",
    "sofa_meshes_note",
    "sofa_meshes_tables",
    "tip_sentences",
    "view_table",
    "write_arm_tables",
    "write_contact_basis_tables",
    "write_element_tables",
    "write_energy_tables",
    "write_equilibria_tables",
    "write_loads_table",
    "write_qpcc_tables",
    "write_sofa_meshes_tables",
    "write_view_table",
]
