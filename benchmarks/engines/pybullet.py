"""PyBullet's inverse dynamics."""

from pathlib import Path
import tempfile

import pybullet

from .engine import Engine
from .urdf import arm_urdf


def engines(arm) -> list:
    """Return calculateInverseDynamics; given arrays it crashes, so it is given lists."""
    client = pybullet.connect(pybullet.DIRECT)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, 'arm.urdf')
        path.write_text(arm_urdf(arm.parameters), encoding='utf-8')
        body = pybullet.loadURDF(str(path), useFixedBase=True, physicsClientId=client,
                                 flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
    pybullet.setGravity(*arm.gravity_vector, physicsClientId=client)
    call = pybullet.calculateInverseDynamics

    def tau(q, qd, qdd):
        return call(body, q.tolist(), qd.tolist(), qdd.tolist(), client)

    return [Engine(name='PyBullet', tau=tau, notes={'tau': 'calculateInverseDynamics'})]
