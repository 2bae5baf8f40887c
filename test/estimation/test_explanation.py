"""Explanations of the residual: simulated payloads and faults, and recordings of real arms."""

from baxter_dynamics_ros import BaxterArm, EffortModel, JOINTS, Payload
from baxter_dynamics_ros.estimation.explanation import ResidualExplainer
from baxter_dynamics_ros.estimation.predictor import Prediction, Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import POSITION_LOWER, POSITION_UPPER
import numpy as np
from perfect_robot import trajectory
import pytest

DEVIATION = (0.3, 0.4, 0.3, 0.2, 0.08, 0.1, 0.05)  # of a calibrated arm [N m]
CENTER = (0.01, -0.02, 0.06)  # of the payload [m]
FEW = 'too few residuals in the last ten seconds'
MASSES = (0.3, 0.5, 1.0, 2.0)  # [kg]
POSES = np.array([  # [rad]
    [0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0],
    [0.5, -0.3, 0.6, 1.2, -0.5, 0.4, 0.3],
    [-0.6, 0.4, -0.4, 0.6, 0.9, 0.8, -1.0],
    [0.2, -1.0, 1.2, 1.6, 0.3, -0.6, 0.5],
    [0.0, 0.1, 0.0, 0.2, 0.0, 0.3, 0.0]])


def motion(t):
    """Return q, qd and qdd (7,) of a free motion of all joints."""
    return [x[0] for x in trajectory([t])]


def explain(residual, at=motion, model=None, arm=None, contact=(), seconds=10):
    """Return what explains a residual, a function of q, qd and qdd, during some seconds."""
    model = model or EffortModel(deviation=DEVIATION)
    explainer = ResidualExplainer(arm or BaxterArm(), model)
    for k in range(20 * seconds):
        state = at(0.05 * k)
        explainer.add(Prediction(k * 50_000_000, *state, *np.zeros((2, 7)), residual(*state),
                                 model.deviation_at(*state[1:])), k in contact)
    return explainer.explain()


def load(mass):
    """Return the residual that a payload causes."""
    loaded, empty = BaxterArm(payload=Payload(mass, CENTER)), BaxterArm()
    return lambda *state: loaded.inverse_dynamics(*state) - empty.inverse_dynamics(*state)


def assert_mass(payload, mass):
    assert abs(payload.mass - mass) < max(0.05 * mass, payload.mass_deviation)


@pytest.mark.parametrize('mass', MASSES)
def test_payload_at_rest(mass):
    """On the simulation's physics, which shares no code with the model."""
    pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')
    from baxter_dynamics_ros.simulation.plant import Plant
    plant = Plant('right', payload=Payload(mass, CENTER))
    model = PredictorSettings.from_parameters({'effort_model.deviation': DEVIATION}).model
    found = 0
    for q in POSES:
        plant.place(q)
        rest = q, np.zeros(7), np.zeros(7)
        expected = model.effort_model.effort(model.arm.gravity(q), *rest)
        residual = plant.truth.coupled(plant.static_torque()) - expected
        explained = explain(lambda *_: residual, lambda t: rest)
        if explained.payload is not None:
            found += 1
            assert_mass(explained.payload, mass)
            assert f'{explained.payload.mass:.2f} ± ' in explained.text
        else:
            assert explained.kind in ('none', 'unexplained')
    assert found == len(POSES) or mass == MASSES[0] and found >= 3


@pytest.mark.parametrize('mass', [0.5, 2.0])
def test_payload_in_motion(mass):
    """Through the predictor, with noise; a heavy payload is contact all the time."""
    pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')
    from baxter_dynamics_ros.simulation.plant import COULOMB
    from baxter_dynamics_ros.simulation.robot import FakeBaxter, JOINT_STATE_NAMES
    settings = PredictorSettings.from_parameters({'effort_model.deviation': DEVIATION,
                                                  'effort_model.coulomb': COULOMB})
    robot = FakeBaxter(trajectory='switch', payload=Payload(mass, CENTER))
    predictor = Predictor(settings, external=True)
    explainer = ResidualExplainer(settings.model.arm, settings.model.effort_model)
    for k in range(1, 900):
        robot.advance(0.01 * k)
        step = predictor.handle(10 ** 18 + 10 ** 7 * k, JOINT_STATE_NAMES, *robot.joint_state())
        if step.prediction is not None:
            explainer.add(step.prediction, step.external and step.external.contact)
    explained = explainer.explain()
    assert explained.kind == 'payload'
    assert_mass(explained.payload, mass)
    assert np.abs((explained.payload.center_of_mass - CENTER)
                  / explained.payload.center_deviation).max() < 2.0


def test_payload_is_in_addition_to_that_of_the_model():
    arm = BaxterArm(payload=Payload(1.0, CENTER))
    lighter = explain(lambda *state: -0.6 * load(1.0)(*state), arm=arm)
    assert_mass(lighter.payload, -0.6)
    assert 'lighter by 0.6' in lighter.text
    assert explain(lambda *state: -1.5 * load(1.0)(*state), arm=arm).payload is None


@pytest.mark.parametrize('joint', ['s1', 'e0', 'w1'])
@pytest.mark.parametrize('at', [motion, lambda t: motion(0.0)], ids=['moving', 'resting'])
def test_offset(joint, at):
    offset = 15.0 * np.array(DEVIATION) * (np.array(JOINTS) == joint)
    sentence = explain(lambda *_: offset, at)
    assert (sentence.kind, sentence.joint) == ('offset', joint)
    assert abs(sentence.value - offset.max()) < max(0.2, 2.0 * sentence.deviation)
    assert ("the spring's zero is not calibrated" in sentence.text) == (joint == 's1')


def test_friction():
    coulomb = np.array([0.2, 0.3, 1.5, 0.3, 0.1, 0.1, 0.05])
    sentence = explain(lambda q, qd, qdd: coulomb * np.tanh(qd / 0.05))
    assert (sentence.kind, sentence.joint) == ('friction', 'e0')
    assert abs(sentence.value - 1.5) < 2.0 * sentence.deviation


def test_tilt():
    tilted, level = BaxterArm(gravity=(0.3, -0.2, -9.8)), BaxterArm()
    sentence = explain(lambda q, *_: tilted.gravity(q) - level.gravity(q))
    assert sentence.kind == 'tilt'
    assert abs(sentence.value - 2.1) < 2.0 * sentence.deviation


@pytest.mark.parametrize('stop, inwards', [(POSITION_UPPER, -1.0), (POSITION_LOWER, 1.0)])
def test_joint_stop(stop, inwards):
    q, zero = np.where(np.array(JOINTS) == 'e0', stop + 0.01 * inwards, 0.3), np.zeros(7)
    push = -8.0 * inwards * (np.array(JOINTS) == 'e0')
    assert explain(lambda *_: push, lambda t: (q, zero, zero), contact=range(200)).text == (
        'e0 is at its joint stop and presses on it with 8.0 ± 0.3 N m')
    assert explain(lambda *_: -push, lambda t: (q, zero, zero)).kind != 'joint_stop'


def test_noise_and_few_samples_are_not_explained(rng):
    sentence = explain(lambda *_: rng.normal(0.0, DEVIATION))
    assert (sentence.kind, sentence.text) == ('none', 'residual is within the expected deviation')
    assert explain(lambda q, *_: 0.0 * q, contact=range(150)).text.endswith(' (contact left out)')
    elsewhere = explain(lambda q, *_: 9.0 * np.sin(40.0 * q))
    assert elsewhere.kind == 'unexplained'
    assert ResidualExplainer(BaxterArm(), EffortModel()).explain().text == FEW


def test_residuals_before_effort_went_missing_are_forgotten():
    residuals = iter([load(1.0)(*motion(0.05 * k)) for k in range(200)])
    assert explain(lambda *_: next(residuals, None), seconds=19).text == FEW


def test_coupled_joints():
    """Crosstalk adds the torque of a payload to the effort of another joint."""
    crosstalk = np.zeros((7, 7))
    crosstalk[3, 2] = -0.3
    model = EffortModel(crosstalk=crosstalk, deviation=DEVIATION)
    found = explain(lambda *state: model.coupled(load(0.5)(*state)), model=model)
    assert_mass(found.payload, 0.5)
    assert found.payload.mass_deviation < 0.05


def explanations(recordings, file, arm):
    """Yield the explanation after each second of a recording, uncalibrated."""
    data, settings = np.load(recordings / file), PredictorSettings(arm=arm)
    parts = data['recording'] if 'recording' in data else np.zeros(len(data['stamp']))
    for part in np.unique(parts):
        rows = np.flatnonzero(parts == part)[:4000]
        predictor = Predictor(settings, external=True)
        explainer = ResidualExplainer(settings.model.arm, settings.model.effort_model)
        last = data['stamp'][rows[0]] + 3.0
        for stamp, *state in zip(*(data[field][rows] for field in (
                'stamp', 'position', 'velocity', 'effort'))):
            step = predictor.handle(round(stamp * 1e9), data['names'].tolist(), *state)
            if step.prediction is not None:
                explainer.add(step.prediction, step.external and step.external.contact)
            if stamp > last + 1.0:
                last = stamp
                yield explainer.explain()


def test_gripper_and_force_sensor_on_a_recording(recordings):
    found = list(explanations(recordings, 'baxter_kitting.npz', 'right'))
    masses = [each.payload.mass for each in found if each.payload is not None]
    assert len(masses) > 0.8 * len(found) > 30
    assert 0.8 < min(masses) and max(masses) < 1.2 and np.std(masses) < 0.07  # [kg]
    resting = list(explanations(recordings, 'baxter_kitting.npz', 'left'))
    assert {each.kind for each in resting} == {'none'}


@pytest.mark.parametrize('arm', ['right', 'left'])
def test_no_payload_on_a_recording_of_a_guided_arm(recordings, arm):
    """The right arm is moved by hand; both have an offset of s1."""
    found = list(explanations(recordings, 'baxter_hand_guided.npz', arm))
    assert len(found) > 30 and all(each.payload is None for each in found)
    offsets = [each for each in found if each.kind == 'offset']
    assert len(offsets) > 0.9 * len(found)
    assert {sentence.joint for sentence in offsets} == {'s1'}
