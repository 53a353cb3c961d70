"""Tools of an operator: locks, contacts, metrics, recording, diagnosis."""

from tauten.service.operate.contacts import read_certificate, read_contacts
from tauten.service.operate.doctor import examine
from tauten.service.operate.locks import send_lock
from tauten.service.operate.metrics import serve_metrics
from tauten.service.operate.record import record_robot

__all__ = [
    "examine",
    "read_certificate",
    "read_contacts",
    "record_robot",
    "send_lock",
    "serve_metrics",
]
