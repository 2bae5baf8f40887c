"""The exported C, MATLAB, LaTeX and URDF files, each read by a program of its language."""

import ctypes
from math import prod
from pathlib import Path
import re
import shutil
import sys
import xml.etree.ElementTree as ET

from baxter_dynamics_ros import BaxterArm, joint_names
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.export import urdf
from baxter_dynamics_ros.export.common import parameters
from baxter_dynamics_ros.model._closed_form import FUNCTIONS
import numpy as np
import pytest

STRICT = '-std=c99 -Wall -Wextra -pedantic -Wconversion -Werror -O0'.split()
GUARD = 1234.5


def needs(program, package):
    if shutil.which(program) is None:
        pytest.skip(f'{program} is missing: apt install {package}')


def pointer(array):
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)


def test_c_functions_for_one_state_and_for_batches(export, arm, run, tmp_path, states, check):
    needs('gcc', 'gcc')
    export('c', arm)
    run('gcc', *STRICT, '-fPIC', '-shared', 'baxter_dynamics.c', '-o', 'library.so', '-lm')
    library = ctypes.CDLL(tmp_path / 'library.so')
    values = (ctypes.c_double * len(parameters(arm))).in_dll(library, 'baxter_dynamics_default')
    assert list(values) == [p.value for p in parameters(arm)]
    n = len(states['q'])
    for name, (inputs, outputs) in FUNCTIONS.items():
        arrays = [states[vector].copy() for vector in ('q', *inputs)]
        results = [np.full((n + 1, prod(output[1])), GUARD) for output in outputs]
        library[f'baxter_dynamics_{name}_batch'](
            ctypes.c_size_t(n), *map(pointer, arrays), ctypes.byref(values),
            *map(pointer, results))
        assert all((result[n:] == GUARD).all() for result in results)
        shaped = [result[:n].reshape(n, *output[1]) for result, output in zip(results, outputs)]
        check(name, shaped)
        one = [np.full(prod(output[1]) + 1, GUARD) for output in outputs]
        state = [x[7].copy() for x in arrays]
        library[f'baxter_dynamics_{name}'](*map(pointer, state), ctypes.byref(values),
                                           *map(pointer, one))
        for result, whole in zip(one, shaped):
            assert result[-1] == GUARD
            np.testing.assert_allclose(result[:-1], whole[7].ravel(), rtol=1e-11, atol=1e-11)


def test_c_example_prints_its_documented_output(export, run):
    needs('gcc', 'gcc')
    text = export('c', BaxterArm())['example.c'].read_text()
    (command,) = re.findall(r'^ \*     (gcc .*) && ', text, re.MULTILINE)
    (printed,) = re.findall(r'prints\n \*     (.*)\n', text)
    run(*command.replace('-O3', '-O0').split())
    assert run('./example').split() == printed.split()


def test_matlab_functions_in_octave(export, arm, run, tmp_path, states, check):
    needs('octave-cli', 'octave')
    export('matlab', arm)
    np.concatenate(list(states.values()), 1).tofile(tmp_path / 'states')
    lines = ["x = fread(fopen('states'), [28, Inf], 'double'); file = fopen('results', 'w');",
             'q = x(1:7, :); qd = x(8:14, :); qdd = x(15:21, :); tau = x(22:28, :);']
    for name, (inputs, outputs) in FUNCTIONS.items():
        results = [f'r{i}' for i in range(len(outputs))]
        lines += [f'[{", ".join(results)}] = baxter_dynamics.{name}({", ".join(("q", *inputs))});',
                  *(f"fwrite(file, {result}, 'double');" for result in results)]
    lines += ['fclose(file); p = baxter_dynamics.parameters();',
              'p.up_z = 0; p.up_x = 0; p.up_y = 0;',
              'disp(max(max(abs(baxter_dynamics.gravity(q, p)))));',
              'try; baxter_dynamics.gravity(q(1:6, :)); catch e; disp(e.message); end']
    (tmp_path / 'script.m').write_text('\n'.join(lines))
    said = run('octave-cli', '--norc', '--no-history', '--quiet', 'script.m').split('\n')
    assert [float(said[0]), said[1]] == [0.0, 'q: expected 7 x n']
    numbers = np.fromfile(tmp_path / 'results')
    for name, (_, outputs) in FUNCTIONS.items():
        results = []
        for _, shape, _, _ in outputs:
            array, numbers = np.split(numbers, [prod(shape) * len(states['q'])])
            results.append(np.moveaxis(array.reshape(*shape, -1, order='F'), -1, 0))
        check(name, results)
    assert not len(numbers)


def test_latex_formulas(export, arm, run, states):
    text = export('latex', arm)['baxter_dynamics.tex'].read_text()
    values = {}
    for symbol, number in re.findall(r'\$(\w_\{\w+\})\$ & \$(.*?)\$', text):
        values[_plain(symbol)] = float(re.sub(r' \\cdot 10\^\{(.*)\}', r'e\1', number))
    q = states['q'][0]
    values.update({f's_{i + 1}': np.sin(q[i]) for i in range(7)})
    values.update({f'c_{i + 1}': np.cos(q[i]) for i in range(7)})
    for target, formula in re.findall(r'\\where\{(.*?_\{\w+\})\}\{(.*)\}$', text, re.MULTILINE):
        code = _plain(formula).replace(r'\,', '*').replace('[', '(').replace(']', ')')
        values[_plain(target)] = eval(code, dict(values))  # noqa: P204
    np.testing.assert_allclose([values[f'G_{i}'] for i in range(1, 8)], arm.gravity(q),
                               rtol=0.0, atol=1e-5)
    np.testing.assert_allclose([values[f'M_{i}{i}'] for i in range(1, 8)],
                               np.diag(arm.mass_matrix(q)), rtol=0.0, atol=1e-6)
    needs('pdflatex', 'texlive-latex-base')
    said = run('pdflatex', '-interaction=nonstopmode', 'baxter_dynamics.tex')
    assert 'Output written on baxter_dynamics.pdf' in said


def _plain(text):
    return re.sub(r'_\{(\w+)\}', r'_\1', text)


SETTINGS = {'payload.mass': 1.2, 'payload.center_of_mass': [0.03, -0.02, 0.11],
            'payload.inertia': [3e-3, 2e-3, 2.5e-3, 3e-4, -2e-4, 1e-4],
            'gravity': [1.3, -2.1, -9.4], 'effort_model.coulomb': [0.5] * 7,
            'effort_model.viscous': [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]}


@pytest.fixture(params=['right', 'left'])
def described(request):
    """Return the settings of an arm, and its exported URDF."""
    if not any((Path(folder) / 'cmeel.prefix/share/hpp-baxter').is_dir() for folder in sys.path):
        pytest.skip('needs the description: pip install hpp-baxter')
    settings = PredictorSettings.from_parameters({'arm': request.param, **SETTINGS})
    ((name, text),) = urdf.files(
        settings.model.arm, 'baxter_dynamics export --params x', request.param,
        settings.model.effort_model).items()
    assert name == f'baxter_{request.param}.urdf'
    return settings, text


def test_pinocchio_on_the_urdf(described, pin, random_states):
    settings, text = described
    model = pin.buildModelFromXML(text)
    model.gravity.linear = settings.model.arm.gravity_vector
    data, names = model.createData(), joint_names(settings.arm)
    q_at, v_at = ([getattr(model.joints[model.getJointId(name)], index) for name in names]
                  for index in ('idx_q', 'idx_v'))
    for q, qd, qdd in zip(*random_states(50)):
        position, velocity, acceleration = pin.neutral(model), np.zeros(model.nv), np.zeros(
            model.nv)
        position[q_at], velocity[v_at], acceleration[v_at] = q, qd, qdd
        tau = pin.rnea(model, data, position, velocity, acceleration)[v_at]
        np.testing.assert_allclose(tau, settings.model.arm.inverse_dynamics(q, qd, qdd), rtol=0.0,
                                   atol=1e-9)


def test_mujoco_on_the_urdf(described, random_states):
    mujoco = pytest.importorskip('mujoco', reason='needs MuJoCo: pip install mujoco')
    settings, text = described
    root = ET.fromstring(text)
    for link in root.findall('link'):  # the meshes are not installed
        for shape in link.findall('visual') + link.findall('collision'):
            link.remove(shape)
    model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding='unicode'))
    model.opt.gravity[:] = settings.model.arm.gravity_vector
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    data, names = mujoco.MjData(model), joint_names(settings.arm)
    at = [model.joint(name).dofadr[0] for name in names]
    np.testing.assert_array_equal(model.dof_damping[at], settings.model.effort_model.viscous)
    np.testing.assert_array_equal(model.dof_frictionloss[at], settings.model.effort_model.coulomb)
    for q, qd, qdd in zip(*random_states(5)):
        data.qpos[:], data.qvel[:], data.qacc[:] = 0.0, 0.0, 0.0
        data.qpos[[model.joint(name).qposadr[0] for name in names]] = q
        data.qvel[at], data.qacc[at] = qd, qdd
        mujoco.mj_inverse(model, data)
        tau = settings.model.arm.inverse_dynamics(q, qd, qdd)
        tau = tau + settings.model.effort_model.viscous * qd
        np.testing.assert_allclose(data.qfrc_inverse[at], tau, rtol=0.0, atol=1e-9)


def test_a_description_of_another_robot_is_refused(tmp_path, described):
    settings, text = described
    path = tmp_path / 'other.urdf'
    for change, problem in (((settings.arm + '_e1"', 'elbow"'), 'no joint'),
                            (('<robot', 'robot'), 'cannot be read as URDF'),
                            (('0.069', '0.269'), 'lies elsewhere')):
        path.write_text(text.replace(*change))
        with pytest.raises(Exception, match=problem):
            urdf.files(settings.model.arm, '', settings.arm, settings.model.effort_model,
                       path)
