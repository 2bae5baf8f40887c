"""What every file says about another payload and where the arm stands, against BaxterArm."""

import re

from baxter_dynamics_ros import BaxterArm, mount, Payload
from baxter_dynamics_ros.export.functions import constants
from baxter_dynamics_ros.export.legend import head, parameters
import numpy as np
import pytest

BODY = Payload(1.2, (0.03, -0.02, 0.11), (3e-3, 2e-3, 2.5e-3, 3e-4, -2e-4, 1e-4))


@pytest.mark.parametrize('gravity', [(0.0, 0.0, -9.81), (1.3, -2.1, -9.4)])
def test_the_loaded_torques_by_what_the_text_says(gravity, random_states):
    empty, loaded = BaxterArm(gravity=gravity), BaxterArm(BODY, gravity)
    text = ' '.join(head(empty))
    values = {parameter.name: parameter.value for parameter in parameters(empty)}
    (d7,) = re.findall(r'z = z_hand \+ (\S+) m \(d7\)', text)
    x, y, z = BODY.center_of_mass
    place = np.array([x, y, z + float(d7)])
    known = {**values, 'm': BODY.mass, **dict(zip('xyz', place))}
    tensor = BODY.inertia_tensor
    for i, first in enumerate('xyz'):
        for k, second in enumerate('xyz'):
            own = tensor.trace() / 2 - tensor[i, i] if i == k else -tensor[i, k]
            known[f'S{first}{second}'] = own + BODY.mass * place[i] * place[k]
    sums = re.findall(r'(\w+) \+= ([^,.]+)', text)
    assert f'changes {len(sums)} parameters' in text
    for name, expression in sums:
        values[name] += eval(expression, dict(known))
    for parameter in parameters(loaded):
        assert values[parameter.name] == pytest.approx(parameter.value, rel=0, abs=1e-13)
    states = random_states(20)
    phi = list(values.values())[:-6 if empty.dynamics.upright else -8]
    if not empty.dynamics.upright:
        phi = [values[name] for name in constants(empty)][:45]
    np.testing.assert_allclose(empty.regressor(*states) @ phi, loaded.inverse_dynamics(*states),
                               rtol=0.0, atol=1e-11)


def test_where_frame_0_lies_and_which_gravity(arm):
    text = ' '.join(head(arm))
    gravity = ', '.join(f'{x:.6g}' for x in arm.gravity_vector)
    assert f'Exported for the gravity vector ({gravity}) m/s^2 in base axes.' in text
    place = ', '.join(f'{x:.6g}' for x in arm.mount[:3, 3])
    assert f'origin at ({place}) m' in text or 'is the base frame' in text
    turned = ' '.join(head(BaxterArm(mount=mount('right'))))
    assert 'turned by -0.7854 rad about z' in turned


def test_it_is_the_rigid_body_and_this_is_said(arm):
    assert any("tau is the rigid body's" in paragraph for paragraph in head(arm))
