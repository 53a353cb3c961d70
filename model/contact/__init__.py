"""Contact: from surfaces to gap rows."""

from tauten.model.contact.broad_phase import BLOCK
from tauten.model.contact.detection import ContactPair, ContactSet, Detection, contact_rows

__all__ = ["BLOCK", "ContactPair", "ContactSet", "Detection", "contact_rows"]
