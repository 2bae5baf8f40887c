"""The functions for MATLAB, run in GNU Octave, against the specification."""

import re
import shutil
import subprocess

from baxter_dynamics_ros import BaxterArm, Payload
from baxter_dynamics_ros.export import matlab
from baxter_dynamics_ros.export.legend import parameters
from baxter_dynamics_ros.model.exceptions import ArgumentError
import numpy as np
import pytest

NAME = 'baxter_dynamics'


@pytest.fixture
def octave(tmp_path):
    """Return a function that runs a script in the folder of the exported files."""
    program = shutil.which('octave-cli')
    if program is None:
        pytest.skip('GNU Octave is missing: apt install octave')

    def run(script):
        (tmp_path / 'script.m').write_text(script, encoding='ascii')
        return subprocess.run([program, '--norc', '--no-history', '--quiet', 'script.m'],
                              cwd=tmp_path, capture_output=True, text=True, timeout=60)

    return run


@pytest.fixture
def compute(octave, states, tmp_path):
    """Return a function that calls functions with all states: name -> arrays (200, ...)."""
    def run(functions, more='', setup=''):
        np.concatenate(list(states.values()), 1).tofile(tmp_path / 'states')
        lines = ["x = fread(fopen('states'), [28, Inf], 'double'); file = fopen('results', 'w');",
                 'q = x(1:7, :); qd = x(8:14, :); qdd = x(15:21, :); tau = x(22:28, :);', setup]
        for function in functions:
            results = [f'r{i}' for i in range(len(function.quantity.outputs))]
            call = f'{NAME}_{function.quantity.name}({", ".join(function.arguments)}{more})'
            lines += [f'[{", ".join(results)}] = {call};',
                      *(f"fwrite(file, {result}, 'double');" for result in results)]
        done = octave('\n'.join([*lines, 'fclose(file);', '']))
        assert done.returncode == 0, done.stderr
        numbers, answers = np.fromfile(tmp_path / 'results'), {}
        for function in functions:
            answers[function.quantity.name] = []
            for output in function.quantity.outputs:
                shape = *output.shape, len(states['q'])
                array, numbers = np.split(numbers, [np.prod(shape)])
                answers[function.quantity.name].append(
                    np.moveaxis(array.reshape(shape, order='F'), -1, 0))
        assert not len(numbers)
        return answers

    return run


def test_all_quantities_are_the_specification(export, functions, compute, arm, specification):
    export('matlab', arm)
    truth = specification(arm)
    for name, results in compute(functions(arm)).items():
        truth.check(name, *results)


def test_another_payload_is_other_parameters(export, functions, compute, specification):
    loaded = BaxterArm(Payload(0.9, (0.01, 0.02, 0.1), (1e-3, 1e-3, 1e-3, 1e-4, 0.0, 0.0)))
    symbols = 'MCG', 'tau', 'regressor'
    export('matlab', BaxterArm(), symbols)
    setup = [f'p.{p.name} = {p.value!r};' for p in parameters(loaded)]
    truth = specification(loaded)
    for name, results in compute(functions(loaded, symbols), ', p', '\n'.join(setup)).items():
        truth.check(name, *results)


def test_one_state_and_none(export, octave):
    export('matlab', BaxterArm(), ('MCG', 'regressor', 'christoffel'))
    done = octave(f'z = zeros(7, 1); e = zeros(7, 0); [M, C, G] = {NAME}_terms(z, z);\n'
                  f'[Me, Ce, Ge] = {NAME}_terms(e, e);\n'
                  f'Y = {NAME}_regressor(z, z, z); h = {NAME}_christoffel_symbols(z);\n'
                  'disp(size(M)), disp(size(C)), disp(size(G)), disp(size(Y)), disp(size(h))\n'
                  'disp(size(Me)), disp(size(Ge))\n')
    assert done.returncode == 0, done.stderr
    assert [tuple(map(int, line.split())) for line in done.stdout.splitlines()] == [
        (7, 7), (7, 7), (7, 1), (7, 43), (7, 7, 7), (7, 7, 0), (7, 0)]


@pytest.mark.parametrize('arguments', [
    'zeros(1, 7), zeros(1, 7)', 'zeros(7, 2), zeros(7, 1)', 'zeros(6, 1), zeros(6, 1)'])
def test_states_in_the_wrong_shape(export, octave, arguments):
    export('matlab', BaxterArm(), ('MCG',))
    done = octave(f'{NAME}_terms({arguments});')
    assert done.returncode == 1
    assert done.stderr.startswith('error: q, qd: expected 7 x n\n')


@pytest.mark.parametrize('change, problem', [
    ("p = setfield(p, 'up_x', 1);", 'unknown field [up_x], missing field []'),
    ("p = rmfield(setfield(p, 'XX7', 1), 'xx7');", 'unknown field [XX7], missing field [xx7]')])
def test_parameters_of_another_export_are_refused(export, octave, change, problem):
    export('matlab', BaxterArm(), ('G',))
    done = octave(f'p = {NAME}_parameters(); {change} {NAME}_gravity(zeros(7, 1), p);')
    assert done.returncode == 1
    assert done.stderr.startswith(f'error: p: {problem}')


def test_help_explains_a_function(export, octave):
    export('matlab', BaxterArm(), ('tau',))
    done = octave(f'help {NAME}_inverse_dynamics')
    for line in (f'tau = {NAME}_inverse_dynamics(q, qd, qdd, p)',
                 'qd   (7, n) joint velocities [rad/s]; each column is a state',
                 'tau (7, n) [N m] M(q) qdd + C(q, qd) qd + G(q), eq. (5)',
                 'Joint order: s0, s1, e0, e1, w0, w1, w2.'):
        assert line in done.stdout


def test_every_parameter_has_its_value_unit_and_meaning(export, arm):
    text = export('matlab', arm, ('G',))[f'{NAME}_parameters.m'].read_text()
    listed = re.findall(r'^    p\.(\w+) = (\S+); +% ([^,]+), (.+)$', text, re.MULTILINE)
    assert [(name, float(value), unit, meaning) for name, value, unit, meaning in listed] == (
        parameters(arm))
    assert len(listed) == (49 if arm.dynamics.upright else 53)


@pytest.mark.parametrize('name', ['7up', '_arm', 'my-arm', '', 'a' * 47])
def test_a_name_that_matlab_refuses(functions, name):
    with pytest.raises(ArgumentError, match='cannot begin the name of a MATLAB function'):
        matlab.files(functions(BaxterArm(), ('tau',)), BaxterArm(), name)
