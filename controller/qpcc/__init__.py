"""The QPCC (1)-(3) and its solver.

    from tauten.controller.qpcc import Qpcc, solve_qpcc
"""

from tauten.controller.qpcc.problem import Qpcc, Start, read_qpcc, write_qpcc
from tauten.controller.qpcc.qp import available_backends
from tauten.controller.qpcc.residuals import certify
from tauten.controller.qpcc.solution import Certificate, Solution, Status
from tauten.controller.qpcc.solve import QpccSettings, solve_qpcc

__all__ = [
    "Certificate",
    "Qpcc",
    "QpccSettings",
    "Solution",
    "Start",
    "Status",
    "available_backends",
    "certify",
    "read_qpcc",
    "solve_qpcc",
    "write_qpcc",
]
