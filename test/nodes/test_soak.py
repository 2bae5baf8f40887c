"""The node over many messages, and on arbitrary ones."""

from pathlib import Path

from baxter_dynamics_ros.estimation.events import Event
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
from baxter_dynamics_ros.nodes.messages import from_field, joint_state, stamp_ns
from baxter_dynamics_ros.simulation.robot import JOINT_STATE_NAMES
import numpy as np
from std_srvs.srv import Trigger

BENCHMARKS = Path(__file__).resolve().parents[2] / 'benchmarks'
FLAT = 2.0  # [MB]; 250 B a message


def test_node_loses_nothing_and_does_not_grow(monkeypatch, domain):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import soak
    run = soak.through_node(1500)
    assert run.received == run.sent == 1500
    assert run.dropped == run.lost == 0
    assert run.residuals == run.predicted == 1500 - run.quiet
    assert run.growth < FLAT


def arbitrary(n: int):
    """Yield n joint states, most of them good, the others with anything in them."""
    rng = np.random.default_rng(20)
    names, stamp = list(JOINT_STATE_NAMES), 10 ** 18
    pool = [*JOINT_STATE_NAMES, '', 'Gelenk_ü', '右_s0', 'right_s0 ']
    for i in range(n):
        stamp += 10_000_000
        phase = 0.015 * i + np.arange(len(names))
        fields = [0.5 * np.sin(phase), 0.75 * np.cos(phase), 5.0 * np.sin(phase)]
        message = joint_state(names, stamp, *fields)
        kind, which, j = rng.integers(80), rng.integers(3), rng.integers(9, 16)
        if kind == 0:
            fields[which][j] = rng.choice([np.nan, np.inf, -np.inf, 1e308])
            message = joint_state(names, stamp if which else 0, *fields)
        elif kind == 1:
            fields[which] = fields[which][:rng.integers(17)]
            message = joint_state(names, stamp, *fields)
        elif kind == 2:
            message = joint_state(map(str, rng.choice(pool, rng.integers(25))), stamp, *fields)
        elif kind == 3:
            message = joint_state(names, stamp, *(
                rng.choice([0.0, 1.0, -1.0, 5e-324], 17) for _ in range(3)))
        elif kind == 4:
            message.header.stamp.sec = int(rng.integers(-2 ** 31, 2 ** 31))
            message.header.stamp.nanosec = int(rng.integers(2 ** 32))
        elif kind == 5:
            stamp += int(rng.choice([-600, -20, -10, 300, 10 ** 9])) * 1_000_000
        elif kind == 6:
            message = joint_state([], stamp)
        yield message
        if kind == 7:
            yield message


def test_arbitrary_messages_are_all_counted(robot, predictor, stamps):
    handler = Predictor(PredictorSettings(), external=True)
    expected = []
    for message in arbitrary(600):
        robot.publisher.publish(message)
        stamp = stamp_ns(message.header)
        expected.append(handler.handle(stamp, message.name, *map(from_field, (
            message.position, message.velocity, message.effort))).prediction)
        robot.spin(0.001)
    expected = [prediction for prediction in expected if prediction is not None]
    robot.until(lambda: len(robot.predicted) >= len(expected))

    counts = handler.counts
    told = {key: int(value) for _, _, values in robot.report().values()
            for key, value in values.items() if key in ('received', 'predicted', *(
                event.value for event in Event))}
    assert told['received'] == counts['received'] > 600
    assert told == {key: counts[key if key in ('received', 'predicted') else Event(key)]
                    for key in told}
    assert sum(value > 0 for value in told.values()) > 12, 'not arbitrary enough'
    assert len(expected) > 50
    for found, prediction in zip(robot.predicted, expected, strict=True):
        assert tuple(found.name) == joint_names('right')
        np.testing.assert_array_equal(found.effort, prediction.effort)
    for message in robot.predicted + robot.residual:
        assert np.isfinite([message.position, message.velocity, message.effort]).all()
    assert robot.call(Trigger, 'reset').success
    assert predictor.poll() is None and 'Traceback' not in predictor.output
