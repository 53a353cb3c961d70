"""How much a decision holds back, adapted from step to step.

What is adapted is the weight γ on the change of the effectors, and the share of the way to the plan that
actuators go in a tick.

(T1) with γ > 0 is a damped Gauss-Newton step: the change of effectors and efforts counts γ times as much as
their values. Where a target is out of reach, the curvature of the effectors' paths that a linearised step
leaves out is as large as what it contains; an undamped step overshoots, and the next one comes back. Let d be
the change of the effectors that a decision predicts, compared with what holding would do, or with where they
are if friction would not hold them. A change that reverses the one before shows an overshoot: γ grows. One
that repeats it shows that nothing stands in the way of larger steps: γ decreases, to zero while a moving
target is followed. Changes that become smaller and smaller converge, and γ remains.

Where a cable is taut in one plan and slack in the next, plans jump between two pieces of the problem, and no
γ ends that: commands go to and fro for ever. While the target is constant, actuators therefore go a share of
the way that is adapted as trust regions are (Conn, Gould and Toint, Trust-Region Methods, 2000): by how much
the objective of holding has decreased over the last ticks, of what plans have predicted. Both are the
objective of the plan before, with its weights and unknown forces: another one may increase along good plans.
A share with which it has not decreased is too large where the robot comes to rest: the share grows to half of
it at most. The means of decreases shrink with the share: what is remembered of ticks with a larger one would
else be more than a smaller one can decrease, and the share shrink to nothing.

A robot that relaxes changes what holding leads to, for seconds, whatever its actuators do. So the decrease is
also counted from where holding for one tick would have led, and the mean of the two that is larger counts:
where holding alone decreases the objective, that is due to a momentum that plans have given. The end
q_H = q + H v₁ of a step of implicit Euler in which actuators hold, the same for their forces, changes by

    dq_H/dt = v₁ = (q_H − q) / H,   dλ_H/dt = (λ_H − λ) / H

as the equations of a linear robot M dv/dt = f − C v − K q + hᵀ λ say, for all M, C, K and whatever moves.
Where plans resist a momentum that those before have given, they are better than to hold in every tick, and
the robot swings for ever. Then nothing has decreased in the mean over seconds, though it may at the moment:
the share shrinks slowly, to one with which the robot comes to rest.

Of forces that redundant actuators share plans change little, so that these would go on for seconds after the
effectors have stopped. Where a plan changes so little that it makes no difference, the share fades. Actuators
go all of the way again where the target or a lock has changed, and as far as they may where much more can be
gained than before. A target out of reach has not changed where it moves by little of its distance from the
effectors, as targets with noise and those that a closed loop corrects do: 10 µm in each tick would else let
plans jump for ever, by which two links on tendons came 20 mm from where they reach farthest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tauten.controller.damping.objective import Objective
from tauten.model import Clusters
from tauten.model.numerics import Array
from tauten.model.signals import EffectorLayout

REVERSED = 0.1  # d_k·d_(k-1) / |d_(k-1)|² below which a change counts as an overshoot,
REPEATED = 0.6  # and above which as one of a series
GRID = 1024  # that ratio is a multiple of 1 / GRID: a small change has few digits that are not rounding
LARGEST_GROWTH = 2.0  # of 1 + γ in a step
DECREASE = 0.8
LARGEST = 100.0  # γ
POOR = 0.1  # of the predicted decrease: where less is reached, the share of the way shrinks,
GOOD = 0.5  # and where more is reached, it grows
SHRINKAGE, GROWTH = 0.7, 1.1  # of the share of the way in a tick
SETTLED = 3e-6  # of the size of the largest part, a change that makes no difference:
FADING = 0.9  # of the way that is gone, in a tick
TICK = 0.02  # s, for which these are; a shorter tick takes as much less of the way to them, a longer one all
LOWERED = 0.5  # of a share with which decreases become poor, that it may grow to again;
ALLOWED = 0.1  # it may grow to this one at first,
AGAIN = 0.9  # and to as much less each time that it grows too large
SMALL = 1e-3  # share of the way below which it becomes the largest one again
MORE = 2.0  # where the gain is this multiple of its mean in two ticks
RECENT = 0.2  # weight of the last tick in the mean of decreases
LONG = 0.02  # and in that over seconds, in which swings are gone;
CALM = 0.03  # where plans decrease nothing over these, the share shrinks to this one
JUMP = 1e-4  # of that size: a goal that changes by more in a tick is another one,
JUMP_FAR = 0.1  # unless that is less than this share of the distance that a hold leaves,
GOES_ON = 0.5  # or than this one of a target that moves as it has moved in the tick before:
BEYOND = 0.25  # of the objective of holding, that a plan leaves where that target is out of reach;
STEADY = 0.5  # mean product of efforts in two changes, by that of their norms: less turns back,
COUNTS = 5e-3  # where the root of the latter is more than this share of the distance
STILL = 1e-9  # of that size; smaller changes are rounding


@dataclass(frozen=True, slots=True)
class Damping:
    """How much a decision holds back in one cluster of the robot.

    Attributes:
        gamma: γ, weight on the change of the effectors relative to that on their distance from the target.
        change: (r + a,) predicted change d of the decision before, of effector rows and efforts as (T1)
            weighs them [m]; empty: none.
        share: of the way to the plan that actuators go in a tick, 0 to 1,
        faded: and what is left of it where plans change nothing that counts, 0 to 1.
        most: largest share.
        grown: whether the share has not shrunk since it grew.
        objective: of the decision before; None: the goal has jumped.
        actual: mean decrease of the objective of holding in a tick [m²],
        apart: and from where holding for the tick would have led, see `Objective.relaxed` [m²].
        predicted: mean of what plans predicted [m²].
        gain: mean of what all of the way would decrease it by [m²].
        use: mean over seconds of what plans have decreased it by, of what they predicted, -1 to 1.
        along: mean product of the efforts in changes of two ticks one after the other,
        norms: and mean product of their norms [m²].
    """

    gamma: float
    change: Array
    share: float = 1.0
    faded: float = 1.0
    most: float = 1.0
    grown: bool = True
    objective: Objective | None = None
    actual: float = 0.0
    apart: float = 0.0
    predicted: float = 0.0
    gain: float = 0.0
    use: float = 1.0
    along: float = 0.0
    norms: float = 0.0

    def fading(self, change: Array, size: float, h: float) -> Damping:
        """The damping of a decision whose plan changes effector rows and efforts so (r + a,) [m].

        Args:
            change: of its plan: how that differs from holding.
            size: of the robot's largest part [m].
            h: length of a tick [s].
        """
        settled = float(change @ change) <= (SETTLED * size) ** 2
        faded = FADING ** part_of_tick(h) * self.faded if settled else 1.0
        return self if faded == self.faded else replace(self, faded=faded)

    def starting(self) -> Damping:
        """The same for a goal that nothing is known of: all of the way."""
        return Damping(self.gamma, self.change)

    def going_on(self, power: float) -> Damping:
        """The same for a target that moves on: less of the way where plans for one out of reach turn back.

        Args:
            power: of the factors of a tick, see `part_of_tick`.
        """
        last, share = self.objective, min(GROWTH**power * self.share, 1.0)
        if last is not None and last.planned > BEYOND * last.holding:
            counts = self.norms > COUNTS**2 * last.holding
            if counts and self.along < STEADY * self.norms:
                share = max(SHRINKAGE**power * self.share, CALM)
        return replace(self.starting(), share=share, along=self.along, norms=self.norms)


@dataclass(frozen=True, slots=True)
class Dampings:
    """How much a decision holds back in every cluster of the robot.

    Attributes:
        clusters: of the robot.
        each: of every cluster.
        goal: (n_v,) of the decision before; empty: none.
        moved: (n_e,) by how much that had moved since the one before it [m]; empty: unknown.
    """

    clusters: Clusters
    each: tuple[Damping, ...]
    goal: Array
    moved: Array

    @classmethod
    def at_start(cls, clusters: Clusters) -> Dampings:
        """The start."""
        return cls(clusters, (undamped(),) * len(clusters.each), np.zeros(0), np.zeros(0))

    @property
    def gamma(self) -> Array:
        """Weights γ on the change of the effectors: (c,)."""
        found = np.empty(len(self.each))
        for number, one in enumerate(self.each):
            found[number] = one.gamma
        return found

    @property
    def share(self) -> Array:
        """Share of the way to the plan that actuators go in a tick: (n_a,)."""
        found = np.empty(len(self.each))
        for number, one in enumerate(self.each):
            found[number] = one.share * one.faded
        return found[self.clusters.of_actuators]

    def towards(
        self, goal: Array, size: float, h: float, layout: EffectorLayout, grips: bool
    ) -> Dampings:
        """The same for another goal: all of the way where it has jumped.

        Args:
            goal: (n_v,) of the decision.
            size: of the robot's largest part [m].
            h: length of a tick [s].
            layout: of the effectors; components without weight may be anywhere.
            grips: whether contacts have friction: closing on an object takes efforts that turn back.
        """
        if len(self.goal) != len(goal):
            each = tuple(map(Damping.starting, self.each))
            return Dampings(self.clusters, each, goal, np.zeros(len(layout.weights)))
        moved = layout.units * layout.difference(goal, self.goal) * (layout.weights > 0.0)  # (n_e,)
        least, power, made = JUMP * size, part_of_tick(h), []
        for one, own in zip(self.each, self.clusters.each, strict=True):
            distance = 0.0 if one.objective is None else math.sqrt(one.objective.holding)
            ways = moved[own.effectors].tolist(), self.moved[own.effectors].tolist()
            travel, turn = math.hypot(*ways[0]), math.dist(*ways)  # the same in all axes
            far = max(least, JUMP_FAR * power * distance)
            if travel <= far:
                made.append(one)
            elif grips or turn > far or travel > GOES_ON * power * distance:
                made.append(one.starting())
            else:
                made.append(one.going_on(power))
        return Dampings(self.clusters, tuple(made), goal, moved)

    def compared(self, before: Array) -> Array:
        """Goals (n_v,) that this decision is compared with: of the one before, unless it has jumped."""
        found = self.goal
        for one, own in zip(self.each, self.clusters.each, strict=True):
            if one.objective is not None:
                found = found.copy() if found is self.goal else found
                found[own.values] = before[own.values]
        return found

    def fading(self, change: Array, size: float, h: float) -> Dampings:
        """The same for a plan that changes effector rows and efforts so, see `Damping.fading`.

        Args:
            change: (n_e + n_a,) of all of them [m].
            size: of the robot's largest part [m].
            h: length of a tick [s].
        """
        made, changed = [], False
        for one, own in zip(self.each, self.clusters.each, strict=True):
            made.append(one.fading(change[own.rows], size, h))
            changed |= made[-1] is not one
        return Dampings(self.clusters, tuple(made), self.goal, self.moved) if changed else self

    def adapted(
        self, change: Array, size: float, h: float, objectives: list[Objective]
    ) -> Dampings:
        """The same for the next decision, see `adapted`.

        Args:
            change: (n_e + n_a,) that this one predicts [m].
            size: of the robot's largest part [m].
            h: length of a tick [s].
            objectives: that this one predicts in every cluster.
        """
        made = []
        for one, own, found in zip(self.each, self.clusters.each, objectives, strict=True):
            made.append(adapted(one, change[own.rows], size, h, found, len(own.effectors)))
        return Dampings(self.clusters, tuple(made), self.goal, self.moved)


def undamped() -> Damping:
    """The start."""
    return Damping(0.0, np.zeros(0))


def part_of_tick(h: float) -> float:
    """The power of the factors of a tick that one of length h [s] takes.

    A robot that swings is worse off for half of its period, however many ticks that has: at 1 kHz a share
    that shrinks in each of them is gone after one swing.
    """
    return min(h / TICK, 1.0)


def adapted(
    damping: Damping, change: Array, size: float, h: float, objective: Objective, rows: int = 0
) -> Damping:
    """The damping of the next decision.

    Args:
        damping: of this one, see `Dampings.towards` and `Damping.fading`.
        change: (r + a,) that this one predicts [m].
        size: of the robot's largest part [m].
        h: length of a tick [s].
        objective: that this one predicts.
        rows: effector rows r that the change begins with.
    """
    gamma, along, norms = _repeated(damping, change, size, rows)
    last = damping.objective
    share, most, grown = damping.share, damping.most, damping.grown
    actual, apart, predicted, use = damping.actual, damping.apart, damping.predicted, damping.use
    gain = mean = objective.gain
    if last is not None:
        still, settled = (STILL * size) ** 2, damping.faded < 1.0
        twice = min(gain, last.gain)
        if share < SMALL and not settled and twice > MORE * damping.gain + still:
            most = max(most, ALLOWED)
            return replace(damping.starting(), share=most, most=most)
        power = part_of_tick(h)
        recent = power * RECENT
        reached, promised = last.holding - objective.before, last.predicted
        actual += recent * (reached - actual)
        apart += recent * (last.relaxed - objective.before - apart)
        predicted += recent * (promised - predicted)
        mean = damping.gain + recent * (gain - damping.gain)
        if promised > still and not settled:
            use += power * LONG * (min(max(reached / promised, -1.0), 1.0) - use)
            swings = use < POOR and actual > 0.0  # it decreases now, but not over seconds
            if swings and share > CALM:
                share = most = max(SHRINKAGE ** (power * LONG / RECENT) * share, CALM)
        if predicted > still and not settled:
            decrease = max(actual, apart)
            if decrease < POOR * predicted:
                if grown:
                    most = max(min(LOWERED * share, most), min(AGAIN * most, ALLOWED))
                smaller = min(SHRINKAGE**power * share, most)
                actual, apart, predicted = (
                    smaller / share * value for value in (actual, apart, predicted)
                )  # as of ticks with that share
                share, grown = smaller, False
            elif decrease > GOOD * predicted:
                share, grown = min(GROWTH**power * share, most), True
    return Damping(
        gamma, change, share, damping.faded, most, grown, objective, actual, apart, predicted, mean, use,
        along, norms,
    )  # fmt: skip


def _repeated(
    damping: Damping, change: Array, size: float, rows: int
) -> tuple[float, float, float]:
    """The weight γ of the next decision, and the means `along` and `norms`; arguments as of `adapted`."""
    before, gamma = damping.change, damping.gamma
    along, norms = damping.along, damping.norms
    if len(before) != len(change):
        return gamma, along, norms
    efforts, last = change[rows:], before[rows:]
    along += RECENT * (float(efforts @ last) - along)
    norms += RECENT * (math.sqrt(float(efforts @ efforts) * float(last @ last)) - norms)
    length = float(before @ before)
    if length > (STILL * size) ** 2:
        repeated = round(GRID * float(change @ before) / length) / GRID
        if repeated < REVERSED:
            growth = min(1.0 + REVERSED - repeated, LARGEST_GROWTH)
            gamma = min((1.0 + gamma) * growth - 1.0, LARGEST)
        elif repeated > REPEATED:
            gamma = max((1.0 + gamma) * DECREASE - 1.0, 0.0)
    return gamma, along, norms
