"""The exported files, each read by programs of its language, and the table of parameters."""

import ctypes
from importlib.util import module_from_spec, spec_from_file_location
from math import prod
import re
import shutil
import subprocess
import sys

from baxter_dynamics_ros import BaxterArm, mount, Payload
from baxter_dynamics_ros.export import latex, sources
from baxter_dynamics_ros.export.parameter_table import base_table, composition, parameters
from baxter_dynamics_ros.model._closed_form import FUNCTIONS
from baxter_dynamics_ros.model.base_parameters import base_parameters, TILTED_NAMES
import numpy as np
import pytest

# No parameter has its default value.
ARM = BaxterArm(Payload(1.2, (0.03, -0.02, 0.11), (3e-3, 2e-3, 2.5e-3, 3e-4, -2e-4, 1e-4)),
                (1.3, -2.1, -9.4), mount('left'))
STRICT = '-std=c99 -Wall -Wextra -pedantic -Wconversion -Werror -O0'.split()
GUARD = 1234.5
AT = {'XX': (0, 0), 'YY': (1, 1), 'ZZ': (2, 2), 'XY': (0, 1), 'XZ': (0, 2), 'YZ': (1, 2),
      'HX': (0, 3), 'HY': (1, 3), 'HZ': (2, 3)}


@pytest.fixture
def export(tmp_path):
    """Return a function that writes the files of an export to tmp_path."""
    def write(files):
        for name, text in files(ARM, 'baxter_dynamics export').items():
            (tmp_path / name).parent.mkdir(exist_ok=True)
            (tmp_path / name).write_text(text, encoding='utf-8')

    return write


@pytest.fixture
def run(tmp_path):
    """Return a function that runs a program in tmp_path, which must succeed: its output."""
    def call(*arguments, package=''):
        if shutil.which(arguments[0]) is None and not (tmp_path / arguments[0]).exists():
            pytest.skip(f'{arguments[0]} is missing: apt install {package}')
        done = subprocess.run(arguments, cwd=tmp_path, capture_output=True, text=True, timeout=110)
        assert done.returncode == 0, done.stderr or done.stdout
        return done.stdout

    return call


@pytest.fixture
def states(random_states):
    """Return 50 states by name, q, qd, qdd and tau, each (50, 7)."""
    q, qd, qdd = random_states(50)
    return {'q': q, 'qd': qd, 'qdd': qdd, 'tau': 10.0 * qdd[::-1]}


@pytest.fixture
def check(states):
    """Return a function that compares results with BaxterArm, which other engines confirm."""
    def compare(name, results):
        expected = getattr(ARM, name)(*(states[vector] for vector in ('q', *FUNCTIONS[name][0])))
        expected = expected if isinstance(expected, tuple) else (expected,)
        for result, right in zip(results, expected, strict=True):
            np.testing.assert_allclose(result, right, rtol=1e-11, atol=1e-11)

    return compare


def pointer(array):
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)


def test_c_for_one_state_and_for_batches(export, run, tmp_path, states, check):
    export(sources.c_files)
    run('gcc', *STRICT, '-fPIC', '-shared', 'baxter_dynamics.c', '-o', 'library.so', '-lm',
        package='gcc')
    library = ctypes.CDLL(tmp_path / 'library.so')
    values = (ctypes.c_double * len(parameters(ARM))).in_dll(library, 'baxter_dynamics_default')
    assert list(values) == [p.value for p in parameters(ARM)]
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
    # The example prints what it says; with the library, to compile the functions only once.
    text = (tmp_path / 'example.c').read_text()
    assert ' *     gcc -O3 example.c baxter_dynamics.c -o example -lm && ./example\n' in text
    run('gcc', *STRICT, 'example.c', './library.so', '-o', 'example')
    (printed,) = re.findall(r'prints\n \*     (.*)\n', text)
    assert run('./example').split() == printed.split()


def test_matlab_in_octave(export, run, tmp_path, states, check):
    export(sources.matlab_files)
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
    said = run('octave-cli', '--norc', '--no-history', '--quiet', 'script.m',
               package='octave').split('\n')
    assert [float(said[0]), said[1]] == [0.0, 'q: expected 7 x n']
    numbers = np.fromfile(tmp_path / 'results')
    for name, (_, outputs) in FUNCTIONS.items():
        results = []
        for _, shape, _, _ in outputs:
            array, numbers = np.split(numbers, [prod(shape) * len(states['q'])])
            results.append(np.moveaxis(array.reshape(*shape, -1, order='F'), -1, 0))
        check(name, results)
    assert not len(numbers)


def test_latex_formulas(export, run, tmp_path, states):
    export(latex.files)
    text, q, values = (tmp_path / 'baxter_dynamics.tex').read_text(), states['q'][0], {}
    for symbol, number in re.findall(r'\$(\w_\{\w+\})\$ & \$(.*?)\$', text):
        values[_plain(symbol)] = float(re.sub(r' \\cdot 10\^\{(.*)\}', r'e\1', number))
    values.update({f'{letter}_{i + 1}': f(q[i]) for letter, f in (('s', np.sin), ('c', np.cos))
                   for i in range(7)})
    for target, formula in re.findall(r'\\where\{(.*?_\{\w+\})\}\{(.*)\}$', text, re.MULTILINE):
        values[_plain(target)] = eval(_plain(formula).replace(r'\,', '*'), dict(values))
    np.testing.assert_allclose([values[f'G_{i}'] for i in range(1, 8)], ARM.gravity(q),
                               rtol=0.0, atol=1e-5)
    np.testing.assert_allclose([values[f'M_{i}{i}'] for i in range(1, 8)],
                               np.diag(ARM.mass_matrix(q)), rtol=0.0, atol=1e-6)
    said = run('pdflatex', '-interaction=nonstopmode', 'baxter_dynamics.tex',
               package='texlive-latex-base')
    assert 'Output written on baxter_dynamics.pdf' in said


def _plain(text):
    return re.sub(r'_\{(\w+)\}', r'_\1', text)


@pytest.fixture
def module(export, tmp_path):
    """Return the exported Python module."""
    export(sources.python_files)
    spec = spec_from_file_location('exported', tmp_path / 'baxter_dynamics.py')
    result = module_from_spec(spec)
    spec.loader.exec_module(result)
    return result


def vectors(name):
    return 'q', *FUNCTIONS[name][0]


def test_python_on_numpy_arrays(module, states, check):
    assert dict(zip(module.PARAMETERS, module.VALUES)) == {
        p.name: p.value for p in parameters(ARM)}
    for name, (_, outputs) in module.FUNCTIONS.items():
        arguments = [states[vector] for vector in vectors(name)]
        results = module.evaluate(getattr(module, name), *arguments)
        check(name, results if isinstance(results, tuple) else (results,))
        one = module.evaluate(getattr(module, name), *(x[0] for x in arguments))
        one = one if isinstance(one, tuple) else (one,)
        assert [x.shape for x in one] == [output[1] for output in outputs]
    assert module.evaluate(module.gravity, np.empty((0, 7))).shape == (0, 7)
    with pytest.raises(ValueError, match=r'shape \(\.\.\., 7\), got \(3,\)'):
        module.evaluate(module.gravity, np.zeros(3))


def test_python_on_casadi_symbols(module, states, check):
    casadi = pytest.importorskip('casadi', reason='needs CasADi: pip install casadi')
    for name, (_, outputs) in module.FUNCTIONS.items():
        symbols = [casadi.SX.sym(vector, 7) for vector in vectors(name)]
        inputs = [casadi.vertsplit(x) for x in (casadi.sin(symbols[0]), casadi.cos(symbols[0]),
                                                *symbols[1:])]
        values = casadi.vertcat(*getattr(module, name)(*inputs, module.VALUES))
        function = casadi.Function('f', symbols, [values])
        flat = function(*(states[vector].T for vector in vectors(name))).full().T
        sizes = np.cumsum([np.prod(output[1]) for output in outputs])[:-1]
        check(name, [part.reshape(-1, *output[1])
                     for part, output in zip(np.split(flat, sizes, axis=1), outputs)])


def test_python_on_sympy_symbols(module):
    sympy = pytest.importorskip('sympy', reason='needs SymPy: pip install sympy')
    q = sympy.symbols('q1:8')
    values = module.gravity(map(sympy.sin, q), map(sympy.cos, q), module.VALUES)
    result = sympy.lambdify(q, values, modules='math')(*np.full(7, 0.3).tolist())
    np.testing.assert_allclose(result, ARM.gravity(np.full(7, 0.3)), rtol=1e-11, atol=1e-11)


def test_python_on_jax_arrays(module, states):
    jax = pytest.importorskip('jax', reason='needs JAX: pip install jax')
    jax.config.update('jax_enable_x64', True)
    q, qd, qdd = (states[name][0] for name in ('q', 'qd', 'qdd'))
    gradient = jax.jit(jax.jacfwd(lambda x: jax.numpy.stack(module.inverse_dynamics(
        jax.numpy.sin(x), jax.numpy.cos(x), qd, qdd, module.VALUES))))(q)
    np.testing.assert_allclose(gradient, ARM.inverse_dynamics_gradient(q, qd, qdd)[0],
                               rtol=0.0, atol=1e-11)


def test_python_on_torch_tensors(module, states):
    torch = pytest.importorskip('torch', reason='needs PyTorch: pip install torch')
    q, qd, qdd = (torch.tensor(states[name][0]) for name in ('q', 'qd', 'qdd'))
    gradient = torch.autograd.functional.jacobian(lambda x: torch.stack(module.inverse_dynamics(
        torch.sin(x), torch.cos(x), qd, qdd, module.VALUES)), q)
    np.testing.assert_allclose(
        gradient.numpy(), ARM.inverse_dynamics_gradient(*(x.numpy() for x in (q, qd, qdd)))[0],
        rtol=0.0, atol=1e-11)


def test_python_imports_nothing(module, tmp_path):
    code = ('import sys; before = set(sys.modules); import baxter_dynamics as b; '
            'assert set(sys.modules) - before == {"baxter_dynamics"}; '
            'print(*b.gravity([0.0] * 7, [1.0] * 7, b.VALUES))')
    done = subprocess.run([sys.executable, '-S', '-c', code], cwd=tmp_path, text=True,
                          capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr
    np.testing.assert_allclose(np.array(done.stdout.split(), float), ARM.gravity(np.zeros(7)),
                               rtol=0.0, atol=1e-11)


def moments(p, links):
    """Return the moments of links (7, 4, 4) in the paper's frames, as the table defines them."""
    values = {}
    for k in range(7):
        s, c = np.sin(p.alpha[k]), np.cos(p.alpha[k])
        # Of frame {k} in body frame k: eq. (2) without its rotation by theta.
        pose = np.array([[1, 0, 0, p.a[k]], [0, c, -s, 0], [0, s, c, p.d[k]], [0, 0, 0, 1]])
        moved = pose @ links[k] @ pose.T
        values.update({f'{name}{k + 1}': moved[place] for name, place in AT.items()})
        values[f'M{k + 1}'] = links[k:, 3, 3].sum()
        values[f'a{k + 1}'], values[f'd{k + 1}'] = p.a[k], p.d[k]
    return values


def test_compositions_are_the_base_parameters(rng):
    half = rng.normal(size=(7, 4, 4))
    links = half @ half.swapaxes(-1, -2)
    values = moments(ARM.parameters, links)
    expected = dict(zip(TILTED_NAMES, base_parameters(ARM.parameters, links)))
    for name, value in expected.items():
        code = re.sub(r'(?<=\w) (?=[A-Za-z])', '*', composition(name).replace('^', '**'))
        assert eval(code, dict(values)) == pytest.approx(value, rel=1e-12), name


def test_the_numbers_and_their_units(arm):
    rows = re.findall(r'^(\w+) +(\S+) (kg m|kg m\^2) +=', base_table(arm), re.MULTILINE)
    assert [name for name, _, _ in rows] == list(TILTED_NAMES)[:len(arm.base_parameters)]
    np.testing.assert_allclose([float(value) for _, value, _ in rows], arm.base_parameters,
                               rtol=1e-6)
    assert all(unit == ('kg m' if name[0] == 'h' else 'kg m^2') for name, _, unit in rows)
