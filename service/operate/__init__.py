"""What an operator asks a node: contacts and metrics. It loads nothing of the model."""

from tauten.service.operate.contacts import read_certificate, read_contacts
from tauten.service.operate.metrics import serve_metrics

__all__ = ["read_certificate", "read_contacts", "serve_metrics"]
