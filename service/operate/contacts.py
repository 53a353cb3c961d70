"""What a robot touches, as its node says it."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import zenoh
from numpy.typing import NDArray
from prometheus_client.parser import text_string_to_metric_families
from pydantic import BaseModel, Field, ValidationError

from tauten.service.codec import CERTIFIED, CONTACT_FIELDS, Rejection, decode_cloud
from tauten.service.link import Keys, NetworkError, ask, ask_metrics

_PATIENCE = 3.0  # s for the first contacts


@dataclass(frozen=True, slots=True)
class Touched:
    """The contacts of a robot that push, or those in range that do not, at one tick.

    Attributes:
        pairs: names of the contact pairs.
        values: (m, k) numbers of each contact, by `CONTACT_FIELDS`.
    """

    pairs: tuple[str, ...]
    values: NDArray[np.float64]

    def column(self, name: str) -> NDArray[np.float64]:
        """One of the fields: (m,)."""
        found: NDArray[np.float64] = self.values[:, CONTACT_FIELDS.index(name)]
        return found

    def pair_of(self, contact: int) -> str:
        """The name of the pair of a contact."""
        number = int(self.column("pair")[contact])
        return self.pairs[number] if 0 <= number < len(self.pairs) else str(number)


def read_contacts(session: zenoh.Session, robot: str, pushing: bool = True) -> Touched:
    """The contacts of a robot in its next tick.

    Raises:
        NetworkError: the node does not answer, or sends no contacts: its model has none.
    """
    keys = Keys(robot)
    pairs = _pairs(session, keys)
    key = keys.contacts if pushing else keys.open_contacts
    source = session.declare_subscriber(key, zenoh.handlers.RingChannel(1))
    end, wrong = time.monotonic() + _PATIENCE, ""
    while time.monotonic() < end:
        sample = source.try_recv()
        if sample is None:
            time.sleep(0.01)
            continue
        found = decode_cloud(bytes(sample.payload), CONTACT_FIELDS)
        if not isinstance(found, Rejection):
            return Touched(pairs, np.asarray(found.values, dtype=float))
        wrong = f" ({found.detail})"
    raise NetworkError(
        f"the node of {robot!r} says nothing of contacts{wrong}: its model has none, or it is stopped; "
        "serve it with --basis full or the name of a basis"
    )


class _Surface(BaseModel):
    pairs: Annotated[tuple[Annotated[str, Field(max_length=1000)], ...], Field(max_length=10_000)]


class _Described(BaseModel):
    """What is needed here of the description, whose other entries need the model."""

    surface: _Surface


def _pairs(session: zenoh.Session, keys: Keys) -> tuple[str, ...]:
    """The names of the contact pairs."""
    answer = ask(session, keys.description, _PATIENCE)
    if answer is None:
        raise NetworkError(f"the node of {keys.robot!r} does not describe itself: see its log")
    try:
        return _Described.model_validate_json(answer).surface.pairs
    except ValidationError as error:
        raise NetworkError(
            f"the node of {keys.robot!r} describes itself otherwise than this version does: start node and "
            "this command from the same version"
        ) from error


def read_certificate(session: zenoh.Session, robot: str) -> str:
    """What certifies the forces of contacts with friction, in a sentence; "" where there are none."""
    return certificate_in((ask_metrics(session, robot) or b"").decode())


def certificate_in(metrics: str) -> str:
    """The certificate of contacts in a node's metrics, in a sentence; "" where there is none."""
    said = {
        family.documentation.removeprefix("contacts: "): family.samples[0]
        for family in text_string_to_metric_families(metrics)
        if family.name.startswith("tauten_contacts")
    }
    parts = (
        f"{what} {said[key].value:.2g} {unit.rstrip(']')}"
        for key in CERTIFIED.values()
        if key in said
        for what, _, unit in [key.partition(" [")]
    )
    doubts = said["contacts"].labels.get("doubts", "none") if "contacts" in said else "none"
    return ", ".join([*parts, *([] if doubts == "none" else [doubts])])
