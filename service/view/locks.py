"""A slider with limits for each actuator: where it is, or where it is locked while others are decided."""

from __future__ import annotations

import time
from collections.abc import Callable, Coroutine, Iterator
from queue import SimpleQueue
from typing import Any

import numpy as np
import viser

from tauten.model.numerics import Array
from tauten.service.frames import RobotLook
from tauten.service.link import LockOrder
from tauten.service.process import drained

_STEPS = 1000  # of a slider, from limit to limit
_ON_ITS_WAY = 2.0  # s for which an order counts as obeyed: a node says once a second what is locked


class LockPanel:
    """The folder *Actuators* of the panel; actuators without limits of their positions are left out."""

    def __init__(
        self, gui: viser.GuiApi, look: RobotLook, now: Callable[[], float] = time.monotonic
    ) -> None:
        """Add the inputs. Callbacks of the browser only note what happened; `orders` gives it."""
        self._now = now
        # when each actuator was last ordered [s], where it is locked [SI], None: nowhere, how near it came
        self._ordered: dict[int, tuple[float, float | None, float]] = {}
        self._actuators = look.robot.actuators
        self._orders: SimpleQueue[LockOrder] = SimpleQueue()
        self._sliders: dict[int, viser.GuiSliderHandle[float]] = {}
        self._boxes: dict[int, viser.GuiCheckboxHandle] = {}
        with gui.add_folder("Actuators", expand_by_default=False):
            for i, one in enumerate(self._actuators):
                low, high = (one.kind.position.scale * limit for limit in one.position)
                if not (np.isfinite([low, high]).all() and low < high):
                    continue
                step = float(10.0 ** np.floor(np.log10((high - low) / _STEPS)))
                low, high = np.ceil(low / step) * step, np.floor(high / step) * step
                slider = gui.add_slider(
                    f"{one.name} [{one.kind.position.shown_unit}]", low, high, step,
                    min(max(0.0, low), high), hint="Moving it locks the actuator there.",
                )  # fmt: skip
                box = gui.add_checkbox("locked", False, hint="Off: it is decided again.")
                slider.on_update(self._changed(i))
                box.on_update(self._changed(i))
                self._sliders[i], self._boxes[i] = slider, box

    def orders(self) -> Iterator[LockOrder]:
        """What the operator has asked for since the last call."""
        return drained(self._orders)

    def show(self, position: Array, locked: frozenset[str]) -> None:
        """Show where the actuators (n_a,) are [SI] or were told to be, and which are locked."""
        for i, slider in self._sliders.items():
            one, box = self._actuators[i], self._boxes[i]
            when, wanted, nearest = self._ordered.get(i, (-np.inf, None, np.inf))
            is_locked = one.name in locked
            if self._now() - when < _ON_ITS_WAY:
                is_locked = wanted is not None
            elif wanted is not None:
                away = abs(float(position[i]) - wanted)
                self._ordered[i] = when, wanted, min(nearest, away)
                # it goes elsewhere where somebody else has locked it there
                if not is_locked or away > nearest + slider.step / one.kind.position.scale:
                    del self._ordered[i]
                    wanted = None
            box.value = is_locked  # type: ignore[misc]  # viser types it so
            shown = one.kind.position.scale * float(position[i] if wanted is None else wanted)
            shown = min(max(round(shown / slider.step) * slider.step, slider.min), slider.max)
            if abs(slider.value - shown) > 0.5 * slider.step:
                slider.value = shown  # type: ignore[misc]

    def _order(self, number: int, locked: bool) -> None:
        one = self._actuators[number]
        wanted = None
        if locked:
            low, high = one.position
            wanted = float(self._sliders[number].value) / one.kind.position.scale
            wanted = min(max(wanted, low), high)
        self._ordered[number] = self._now(), wanted, np.inf
        self._orders.put(LockOrder(one.name, position=wanted))

    def _changed(self, number: int) -> Callable[[viser.GuiEvent[Any]], Coroutine[Any, Any, None]]:
        """What a browser's change of the slider or the box of an actuator calls."""

        async def callback(event: viser.GuiEvent[Any]) -> None:
            if event.client_id is not None:
                is_box = isinstance(event.target, viser.GuiCheckboxHandle)
                self._order(number, not is_box or bool(event.target.value))

        return callback
