"""Nothing outside the limits leaves, whatever goes in."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tauten.controller import NO_CERTIFICATE, Actuation, Status
from tauten.model import Limits
from tauten.model.numerics import Array
from tauten.service.node.limiter import ActuationLimiter

H = 0.02
LIMITS = Limits(
    effort_min=np.array([0.0, 0.5]),
    effort_max=np.array([20.0, 3.0]),
    position_min=np.array([0.0, -0.002]),
    position_max=np.array([0.04, 0.01]),
    rate=np.array([0.04, 0.1]),
)
LIMITER = ActuationLimiter(LIMITS, H)
REST = Actuation(
    LIMITER.rest_position,
    LIMITER.rest_effort,
    LIMITER.rest_effort,
    np.zeros((1, 3)),
    np.zeros(3),
    Status.OK,
    NO_CERTIFICATE,
)
# chambers: one with pressure and vacuum, one with vacuum only
CHAMBERS = Limits(
    effort_min=np.array([-5e3, -2e4]),
    effort_max=np.array([4e4, 0.0]),
    position_min=np.array([-8e-6, -3e-5]),
    position_max=np.array([8e-6, 0.0]),
    rate=np.array([2e-5, 1e-4]),
)
anything = st.lists(st.floats() | st.floats(-0.05, 0.05), min_size=2, max_size=2).map(np.array)
hostile = st.tuples(anything, anything) | st.just((np.zeros(3), np.zeros(2)))


@pytest.mark.parametrize("limits", [LIMITS, CHAMBERS])
@settings(max_examples=300, deadline=None)  # the first one loads the kernels
@given(inputs=st.lists(hostile, min_size=1, max_size=30), unit=st.sampled_from([1.0, 1e-4, 1e6]))
def test_every_output_is_within_limits_and_rate(
    limits: Limits, inputs: list[tuple[Array, Array]], unit: float
) -> None:
    limiter = ActuationLimiter(limits, H)
    last = REST.with_values(limiter.rest_position, limiter.rest_effort, clamped=False)
    for position, effort in inputs:
        with np.errstate(over="ignore"):
            wanted = REST.with_values(position * unit, effort * unit, clamped=False)
        out = limiter.limit(wanted, last)
        assert np.isfinite(out.position).all()
        assert np.isfinite(out.effort).all()
        assert (limits.position_min <= out.position).all()
        assert (out.position <= limits.position_max).all()
        assert (limits.effort_min <= out.effort).all()
        assert (out.effort <= limits.effort_max).all()
        assert (np.abs(out.position - last.position) <= limits.rate * H * (1.0 + 1e-12)).all()
        last = out


def test_chambers_are_released_to_the_pressure_outside() -> None:
    limiter = ActuationLimiter(CHAMBERS, H)
    start = REST.with_values(np.array([6e-6, -2e-5]), np.array([3e4, -1e4]), clamped=False)
    last = start
    for wanted in limiter.release(start, 0.1):
        out = limiter.limit(wanted, last)
        assert (np.abs(out.effort) <= np.abs(last.effort)).all()
        if limiter.at_rest(out):
            break
        last = out
    np.testing.assert_array_equal(out.effort, 0.0)
    np.testing.assert_array_equal(out.position, 0.0)


def limited(position: list[float], effort: list[float]) -> Actuation:
    """What leaves right after rest."""
    return LIMITER.limit(
        REST.with_values(np.array(position), np.array(effort), clamped=False), REST
    )


def test_what_is_within_limits_leaves_unchanged() -> None:
    out = limited([0.0007, -0.0015], [5.0, 1.0])
    np.testing.assert_array_equal(out.position, [0.0007, -0.0015])
    np.testing.assert_array_equal(out.effort, [5.0, 1.0])
    assert not out.clamped


@pytest.mark.parametrize(
    ("position", "effort", "kept"),
    [
        ([-2e-8, 0.0], [0.0, 0.5], [0.0, 0.0, 0.0, 0.5]),  # of a range of 0.04 m
        ([0.0, 0.0], [20.0 + 1e-5, 0.5], [0.0, 0.0, 20.0, 0.5]),
        ([0.0, 0.0], [0.0, 0.5 - 2e-6], [0.0, 0.0, 0.0, 0.5]),  # of 3 N
    ],
)
def test_rounding_is_clamped_but_not_reported(
    position: list[float], effort: list[float], kept: list[float]
) -> None:
    out = limited(position, effort)
    assert [*out.position, *out.effort] == kept
    assert not out.clamped
    far = 4.0 * (np.array([*position, *effort]) - kept)
    assert limited(*np.split(kept + far, 2)).clamped


def test_what_is_not_finite_leaves_as_what_left_last_and_is_reported() -> None:
    last = REST.with_values(np.array([0.01, 0.002]), np.array([4.0, 1.0]), clamped=False)
    for values in ([np.nan, 0.0, 1.0, 1.0], [0.0, 0.0, 1.0, np.inf]):
        out = LIMITER.limit(REST.with_values(*np.split(np.array(values), 2), clamped=False), last)
        assert [*out.position, *out.effort] == [0.01, 0.002, 4.0, 1.0]
        assert out.clamped


def test_what_a_controller_has_clamped_stays_reported() -> None:
    assert LIMITER.limit(replace(REST, clamped=True), REST).clamped
    assert not LIMITER.limit(REST, REST).clamped


@given(st.floats(0.0, 0.04), st.floats(0.0, 5.0))
def test_a_release_takes_its_time_and_at_least_that_of_the_rate(
    pulled: float, seconds: float
) -> None:
    start = REST.with_values(np.array([pulled, 0.0]), np.array([1.0, 1.0]), clamped=False)
    last, ramp = start, []
    for wanted in LIMITER.release(start, seconds):
        last = LIMITER.limit(wanted, last)
        ramp.append(last)
        if LIMITER.at_rest(last):
            break
    steps = len(ramp)
    np.testing.assert_allclose(ramp[-1].position, 0.0, atol=1e-15)
    assert not any(safe.clamped for safe in ramp)
    assert steps * H >= seconds * (1.0 - 1e-12)
    assert pulled / steps <= LIMITS.rate[0] * H * (1.0 + 1e-12)
    # and no longer than needed, but for a period where rounding leaves the ramp short of rest
    assert (steps - 2) * H <= max(seconds, pulled / LIMITS.rate[0], H) * (1.0 + 1e-12)


def test_rest_respects_limits_that_exclude_zero_tension() -> None:
    assert LIMITER.rest_effort == pytest.approx([0.0, 0.5])


# neither may be slack: a cable that stays taut, and a chamber whose vacuum is kept
TAUT = Limits(
    effort_min=np.array([0.5, -2e4]),
    effort_max=np.array([3.0, -5e3]),
    position_min=np.array([0.002, -3e-5]),
    position_max=np.array([0.01, -1e-5]),
    rate=np.array([0.1, 1e-4]),
)


@pytest.mark.parametrize(("seconds", "steps"), [(0.1, 5), (0.0, 3)])  # 3: by the rate
def test_a_release_is_a_straight_ramp_to_the_least_that_the_limits_allow(
    seconds: float, steps: int
) -> None:
    limiter = ActuationLimiter(TAUT, H)
    rest = np.array([0.002, -1e-5, 0.5, -5e3])
    start = np.array([0.008, -1.5e-5, 2.5, -1e4])
    last = REST.with_values(*np.split(start, 2), clamped=False)
    for number, wanted in enumerate(islice(limiter.release(last, seconds), steps + 3), 1):
        last = limiter.limit(wanted, last)
        left = max(1.0 - number / steps, 0.0)
        expected = rest + left * (start - rest)
        np.testing.assert_allclose([*last.position, *last.effort], expected, rtol=1e-12)
        assert not last.clamped
        if number != steps:  # where rounding may leave it short of rest
            assert limiter.at_rest(last) == (number > steps)
    ramp = limiter.release(REST.with_values(*np.split(rest, 2), clamped=False), 0.0)
    assert limiter.at_rest(next(ramp))
