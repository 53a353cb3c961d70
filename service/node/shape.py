"""Where the model's body is, for viewers: published only while somebody listens, and in time that is left.

A cloud of the skin's vertices and the ends of the cables on the key `surface`, and one of the contacts
that push on `contacts`. What joins the points never changes and is in the description.
"""

from __future__ import annotations

import time

import numpy as np
import zenoh

from tauten.controller import Controller
from tauten.model import Robot, Skin, skin_of
from tauten.service.node.clock import Clock
from tauten.service.wire import (
    CLOUD,
    CONTACT_FIELDS,
    SKIN_FIELDS,
    Cloud,
    Keys,
    Publisher,
    encode_cloud,
)

_PERIOD = 1.0 / 30.0  # s between two surfaces
_MARGIN = 1.5  # times the last duration must be left of the period
_FIRST = 1e-3  # s, expected before the first
_FADE = 0.95  # of the expected duration each time it is not left, so that a hiccup is forgotten
_SPARE = 3e-4  # s left for other work


class ShapePublisher:
    """Publishes the skin and the contacts of the model that decides.

    Attributes:
        published: number of surfaces.
    """

    def __init__(self, session: zenoh.Session, robot: Robot) -> None:
        """Declare the publishers.

        Args:
            session: open Zenoh session.
            robot: that is served.
        """
        keys = Keys(robot.name)
        self._surface = Publisher(session, keys.surface, CLOUD, urgent=False)
        self._contacts = Publisher(session, keys.contacts, CLOUD, urgent=False)
        self._frame = robot.frame
        self._skin: Skin = skin_of(robot)
        self.published = 0
        self._next = 0.0
        self._expected = _FIRST

    def publish(self, controller: Controller, clock: Clock) -> None:
        """Publish where the model is, if it is time, somebody listens and enough of the period is left.

        Args:
            controller: whose model is shown.
            clock: of the loop.
        """
        now = time.monotonic()
        if now < self._next or not self._surface.has_subscribers:
            return
        if clock.remaining < _MARGIN * self._expected + _SPARE:
            self._expected *= _FADE
            return
        self._next = now + _PERIOD
        wants_contacts = self._contacts.has_subscribers
        state = controller.state
        lam = controller.lam_c if wants_contacts else None
        geometry = self._skin.geometry(controller.robot, state, lam)
        stamp = time.time_ns()
        points = np.concatenate([geometry.vertices, geometry.cables.reshape(-1, 3)])
        self._surface.put(encode_cloud(Cloud(stamp, self._frame, points), SKIN_FIELDS))
        if wants_contacts:
            pushing = np.hstack([geometry.contacts.points, geometry.contacts.forces])  # (c, 6)
            self._contacts.put(encode_cloud(Cloud(stamp, self._frame, pushing), CONTACT_FIELDS))
        self.published += 1
        self._expected = time.monotonic() - now
