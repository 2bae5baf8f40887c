"""
Run the exported Python file on JAX (jit, grad, vmap) and PyTorch (autograd).

Run: python -m tools.run_exported_python, with pip install jax torch.
"""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
import tempfile
from types import ModuleType
from typing import Any

from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.export import python
from baxter_dynamics_ros.model.arrays import Array
import numpy as np


def main() -> None:
    """Compare torques and their gradients with BaxterArm; print the largest differences."""
    arm = BaxterArm(gravity=(1.3, -2.1, -9.4))
    states = np.random.default_rng(0).uniform(-1.0, 1.0, (3, 20, 7))
    expected = arm.inverse_dynamics(*states), arm.inverse_dynamics_gradient(*states)[0]
    with tempfile.TemporaryDirectory() as folder:
        ((name, text),) = python.files(arm, 'tools').items()
        path = Path(folder, name)
        path.write_text(text, encoding='utf-8')
        spec = spec_from_file_location('exported', path)
        assert spec is not None and spec.loader is not None
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
    for run in (_jax, _torch):
        differences = [np.abs(x - y).max() for x, y in zip(run(module, states), expected)]
        print(f'{run.__name__[1:]}: tau {differences[0]:.1e} N m, gradient {differences[1]:.1e}')
        assert max(differences) < 1e-11


def _jax(module: ModuleType, states: Array) -> tuple[Array, Array]:
    import jax
    import jax.numpy as jnp
    jax.config.update('jax_enable_x64', True)

    def tau(q: Any, qd: Any, qdd: Any) -> Any:
        return jnp.stack(module.inverse_dynamics(jnp.sin(q), jnp.cos(q), qd, qdd, module.VALUES))
    return (np.asarray(jax.jit(jax.vmap(tau))(*states)),
            np.asarray(jax.jit(jax.vmap(jax.jacfwd(tau)))(*states)))


def _torch(module: ModuleType, states: Array) -> tuple[Array, Array]:
    import torch
    q, qd, qdd = map(torch.tensor, states)

    def tau(q: Any) -> Any:
        return torch.stack(module.inverse_dynamics(
            torch.sin(q).T, torch.cos(q).T, qd.T, qdd.T, module.VALUES), -1)
    gradient = torch.autograd.functional.jacobian(lambda q: tau(q).sum(0), q).permute(1, 0, 2)
    return tau(q).numpy(), gradient.numpy()


if __name__ == '__main__':
    main()
