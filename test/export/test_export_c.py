"""The exported C, compiled by gcc, against the specification."""

import ctypes
from math import prod
import platform
import re
import shutil
import subprocess

from baxter_dynamics_ros import BaxterArm, Payload
from baxter_dynamics_ros.export import c
from baxter_dynamics_ros.export.c_support import BLOCK
from baxter_dynamics_ros.export.functions import constants
from baxter_dynamics_ros.export.legend import parameters
from baxter_dynamics_ros.model.exceptions import ArgumentError
import numpy as np
import pytest

NAME = 'baxter_dynamics'
STRICT = '-std=c99 -Wall -Wextra -pedantic -Wconversion -Werror -O0'.split()
GUARD = 1234.5


@pytest.fixture
def gcc(tmp_path):
    """Return a function that runs gcc in the folder of the exported files: what it says."""
    program = shutil.which('gcc')
    if program is None:
        pytest.skip('gcc is missing: apt install gcc')

    def run(*arguments):
        done = subprocess.run([program, *arguments], cwd=tmp_path, capture_output=True,
                              text=True, timeout=100)
        assert done.returncode == 0, done.stderr
        return done.stderr

    return run


@pytest.fixture
def recommended(export):
    """Return the compiler's options that the header recommends."""
    text = export('c', BaxterArm(), ('G',))[f'{NAME}.h'].read_text()
    (options,) = re.findall(rf'^ \*     gcc (.*) -c {NAME}\.c$', text, re.MULTILINE)
    return options.split()


@pytest.fixture
def build(export, functions, gcc, tmp_path):
    """Return a function that exports an arm, compiles with gcc's options, and loads."""
    def build(arm, symbols=None, options=STRICT):
        symbols = () if symbols is None else (symbols,)
        export('c', arm, *symbols)
        said = gcc(*options, '-fPIC', '-c', f'{NAME}.c')
        assert said == ''
        gcc('-shared', f'{NAME}.o', '-o', 'library.so', '-lm')
        return Library(ctypes.CDLL(tmp_path / 'library.so'), functions(arm, *symbols))

    return build


class Library:
    """Compiled functions, and their parameters as an array."""

    def __init__(self, library, functions):
        self._library = library
        self.functions = {function.quantity.name: function for function in functions}
        address = ctypes.addressof(ctypes.c_char.in_dll(library, f'{NAME}_default'))
        self.default = ctypes.c_void_p(address)

    def batch(self, name, states, n=None, p=None):
        """Return the outputs of the first n states; beyond the outputs nothing is written."""
        function = self.functions[name]
        n = len(states['q']) if n is None else n
        inputs = [states[argument][:n].copy() for argument in function.arguments]
        sizes = [prod(output.shape) for output in function.quantity.outputs]
        outputs = [np.full((n + 2, size), GUARD) for size in sizes]
        getattr(self._library, f'{NAME}_{name}_batch')(
            ctypes.c_size_t(n), *map(_pointer, inputs), p or self.default,
            *(_pointer(output[1:]) for output in outputs))
        for output in outputs:
            assert (output[[0, -1]] == GUARD).all()
        return [output[1:-1].reshape(n, *description.shape)
                for output, description in zip(outputs, function.quantity.outputs)]

    def one(self, name, states, i, p=None):
        """Return the outputs of state i; beyond the outputs nothing is written."""
        function = self.functions[name]
        inputs = [states[argument][i].copy() for argument in function.arguments]
        sizes = [prod(output.shape) for output in function.quantity.outputs]
        outputs = [np.full(size + 2, GUARD) for size in sizes]
        getattr(self._library, f'{NAME}_{name}')(
            *map(_pointer, inputs), p or self.default,
            *(_pointer(output[1:]) for output in outputs))
        for output in outputs:
            assert (output[[0, -1]] == GUARD).all()
        return [output[1:-1].reshape(description.shape)
                for output, description in zip(outputs, function.quantity.outputs)]

    def each(self, name, states, p=None):
        """Return the outputs of all states, computed one by one."""
        rows = [self.one(name, states, i, p) for i in range(len(states['q']))]
        return [np.stack(output) for output in zip(*rows)]


def _pointer(array):
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)


def numbers(arm):
    """Return an arm's parameters as the exported functions take them; keep them alive."""
    return np.array([parameter.value for parameter in parameters(arm)])


def test_all_quantities_are_the_specification(build, arm, states, specification):
    library, truth = build(arm), specification(arm)
    for name in library.functions:
        results = library.batch(name, states)
        truth.check(name, *results)
        for result, one in zip(results, library.each(name, states)):
            np.testing.assert_allclose(one, result, rtol=0.0, atol=1e-12)
    (y,) = library.batch('regressor', states)
    np.testing.assert_allclose(y @ arm.base_parameters, truth.inverse_dynamics, rtol=0.0,
                               atol=1e-11)


@pytest.mark.parametrize('more', [(), ('-std=c99', '-ffp-contract=fast'), ('-ffast-math',)],
                         ids=' '.join)
def test_as_it_should_be_compiled(build, recommended, more, states, specification):
    arm = BaxterArm(gravity=(1.3, -2.1, -9.4))
    library, truth = build(arm, ('tau', 'M'), [*recommended, *more]), specification(arm)
    assert '-O3' in recommended
    for name in library.functions:
        truth.check(name, *library.batch(name, states))
        truth.check(name, *library.each(name, states))


def test_another_payload_is_other_parameters(build, states, specification):
    loaded = BaxterArm(Payload(0.9, (0.01, 0.02, 0.1), (1e-3, 1e-3, 1e-3, 1e-4, 0.0, 0.0)))
    library, truth = build(BaxterArm(), ('MCG', 'tau')), specification(loaded)
    values = numbers(loaded)
    for name in library.functions:
        truth.check(name, *library.batch(name, states, p=_pointer(values)))
        truth.check(name, *library.each(name, states, p=_pointer(values)))


def test_batches_of_any_size(build, recommended, states):
    library = build(BaxterArm(), ('tau', 'MCG'), recommended)
    for name in library.functions:
        whole = library.batch(name, states)
        for n in (0, 1, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK, 5 * BLOCK + 3):
            for result, expected in zip(library.batch(name, states, n), whole):
                np.testing.assert_array_equal(result, expected[:n])


def test_nothing_is_read_or_written_out_of_place(export, gcc, tmp_path):
    export('c', BaxterArm(), ('tau', 'MCG'))
    lines = ['#include <stdlib.h>', f'#include "{NAME}.h"', 'int main(void) {',
             f'for (size_t n = 0; n < {2 * BLOCK + 2}; n++) {{']
    arrays = {'q': 7, 'qd': 7, 'qdd': 7, 'tau': 7, 'M': 49, 'C': 49, 'G': 7}
    lines += [f'double *{name} = calloc(n * {size}, sizeof(double));'
              for name, size in arrays.items()]
    lines += [f'{NAME}_inverse_dynamics_batch(n, q, qd, qdd, &{NAME}_default, tau);',
              f'{NAME}_terms_batch(n, q, qd, &{NAME}_default, M, C, G);',
              *(f'free({name});' for name in arrays), '} return 0; }']
    (tmp_path / 'main.c').write_text('\n'.join(lines))
    for library in ('libasan.so', 'libubsan.so'):
        if '/' not in subprocess.run(['gcc', f'-print-file-name={library}'], text=True,
                                     capture_output=True, check=True, timeout=10).stdout:
            pytest.skip(f'{library} is missing: it comes with gcc on most systems')
    gcc('-O1', '-fsanitize=address,undefined', '-fno-sanitize-recover=all', 'main.c',
        f'{NAME}.c', '-lm', '-o', 'main')
    done = subprocess.run([tmp_path / 'main'], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, '')


def test_sines_and_cosines(export, gcc, tmp_path, rng):
    export('c', BaxterArm(), ('G',))
    (tmp_path / 'sines.c').write_text(
        f'#include "{NAME}.c"\nvoid sines(size_t n, const double *x, double *s, double *c)\n'
        '{ for (size_t i = 0; i < n; i++) sin_cos(x[i], &s[i], &c[i]); }\n')
    gcc('-O2', '-fPIC', '-shared', 'sines.c', '-o', 'sines.so', '-lm')
    library = ctypes.CDLL(tmp_path / 'sines.so')

    def sines(x):
        s, c_ = np.empty((2, len(x)))
        library.sines(ctypes.c_size_t(len(x)), _pointer(x), _pointer(s), _pointer(c_))
        return s, c_

    corners = np.pi / 4 * np.arange(-40, 41)
    for x in (corners, *(rng.uniform(-bound, bound, 100_000) for bound in (np.pi, 10, 1e4, 1e8))):
        s, c_ = sines(x)
        assert np.abs(s - np.sin(x)).max() < 1e-15
        assert np.abs(c_ - np.cos(x)).max() < 1e-15
    s, c_ = sines(np.array([0.0, 1e-9, np.nan, np.inf]))
    assert s[0] == 0.0 and c_[0] == 1.0
    assert s[1] == 1e-9
    assert np.isnan([*s[2:], *c_[2:]]).all()


def test_a_batch_is_vectorised(export, gcc, tmp_path):
    if platform.machine() != 'x86_64':
        pytest.skip('knows the options for x86-64 alone')
    source = export('c', BaxterArm(), ('tau',))[f'{NAME}.c'].read_text().splitlines()
    said = gcc('-O3', '-mavx2', '-mfma', '-fopt-info-vec-optimized', '-c', f'{NAME}.c')
    vectorised = {int(line) for line in re.findall(r':(\d+):\d+: optimized: loop vec', said)}
    begin = source.index('    for (size_t start = 0; start < n; start += BLOCK) {')
    for loop in ('i < JOINTS * BLOCK; i++', 'j < BLOCK; j++'):
        (line,) = [i + 1 for i in range(begin, len(source)) if loop in source[i]]
        assert line in vectorised, source[line - 1]


@pytest.mark.parametrize('arm, symbols, rows', [
    ({}, ('G', 'tau'), 1), ({'gravity': (1.3, -2.1, -9.4)}, ('gradient',), 7)],
    ids=['tau', 'gradient'], indirect=['arm'])
def test_the_example_prints_what_it_says(export, arm, tmp_path, gcc, symbols, rows):
    text = export('c', arm, symbols)['example.c'].read_text()
    comment = text[:text.index('*/')]
    (command,) = re.findall(r'^ \*     gcc (.*) && (?:.*)$', comment, re.MULTILINE)
    listed = re.search(r'prints\n((?: \*     .*\n)+)', comment)[1].replace(' *     ', '')
    assert gcc(*STRICT[:-1], *command.split()) == ''
    done = subprocess.run([tmp_path / 'example'], capture_output=True, text=True, timeout=10)
    printed, listed = (np.array([line.split() for line in lines.splitlines()], float)
                       for lines in (done.stdout, listed))
    assert printed.shape == (rows, 7)
    np.testing.assert_allclose(printed, listed, rtol=0.0, atol=1.1e-6)


def test_it_needs_nothing_but_rint(export, gcc, tmp_path):
    source = export('c', BaxterArm())[f'{NAME}.c'].read_text()
    assert re.findall('^#include (.*)$', source, re.MULTILINE) == [f'"{NAME}.h"', '<math.h>']
    gcc('-O0', '-fno-stack-protector', '-c', f'{NAME}.c')
    done = subprocess.run(['nm', '-u', f'{NAME}.o'], cwd=tmp_path, capture_output=True, text=True,
                          check=True, timeout=10)
    assert set(done.stdout.split()) - {'U', '_GLOBAL_OFFSET_TABLE_'} == {'rint'}


def test_the_header_serves_cpp(export, tmp_path, gcc):
    if shutil.which('g++') is None:
        pytest.skip('g++ is missing: apt install g++')
    export('c', BaxterArm(), ('G',))
    (tmp_path / 'main.cpp').write_text(
        f'#include "{NAME}.h"\n#include "{NAME}.h"\nint main() {{ double q[7] = {{}}, g[7];\n'
        f'{NAME}_parameters p = {NAME}_default; p.up_z = 0;\n'
        f'{NAME}_gravity(q, &p, g); return g[1] != 0; }}\n')
    gcc('-c', f'{NAME}.c')
    subprocess.run(['g++', '-Wall', '-Wextra', '-Werror', 'main.cpp', f'{NAME}.o', '-o', 'main'],
                   cwd=tmp_path, check=True, timeout=60)
    subprocess.run([tmp_path / 'main'], check=True, timeout=10)


def test_the_header_explains_everything(export, functions, arm):
    text = export('c', arm)[f'{NAME}.h'].read_text()
    listed = re.findall(r'^    double (\w+); /\* ([^,]+), (.+) \*/$', text, re.MULTILINE)
    assert listed == [(p.name, p.unit, p.text) for p in parameters(arm)]
    assert 'Joint order: s0, s1, e0, e1, w0, w1, w2.' in text
    for function in functions(arm):
        before = text[:text.index(f'void {NAME}_{function.quantity.name}(')]
        comment = before[before.rindex('/*'):]
        for argument in function.arguments:
            assert re.search(rf'^ \* {argument}: 7, .* \[', comment, re.MULTILINE)
        for output in function.quantity.outputs:
            shape = ' x '.join(map(str, output.shape))
            assert f' * {output.symbol}: {shape}, ' in comment
            assert f'[{output.unit}]' in comment
        assert f'{function.program.operations()} operations' in comment
    said = ' '.join(text.replace(' * ', ' ').split())
    columns = len(arm.base_parameters)
    assert f'at 7 i + k; of the regressor Y at {columns} i + k; h_ikm at 49 i + 7 k + m' in said
    assert '|q| < 1e+08 rad' in said
    assert max(map(len, text.splitlines())) <= 99


def test_the_numbers_are_exact(build, arm):
    library = build(arm, ('G',))
    values = (ctypes.c_double * len(parameters(arm))).from_address(library.default.value)
    known = constants(arm)
    assert list(values) == [known[parameter.name] for parameter in parameters(arm)]


def test_two_arms_in_one_program(functions, gcc, tmp_path):
    for name, arm in (('left', BaxterArm()), ('right', BaxterArm(gravity=(1.0, 0.0, -9.0)))):
        for file, text in c.files(functions(arm, ('tau', 'G')), arm, name).items():
            (tmp_path / file).write_text(text)
    gcc('-shared', '-fPIC', 'left.c', 'right.c', '-o', 'both.so', '-lm')
    both = ctypes.CDLL(tmp_path / 'both.so')
    assert both.left_gravity and both.right_inverse_dynamics_batch


@pytest.mark.parametrize('name', ['7up', 'my-arm', '', 'größe', 'a b'])
def test_a_name_that_c_refuses(functions, name):
    with pytest.raises(ArgumentError, match='cannot begin a name in C'):
        c.files(functions(BaxterArm(), ('tau',)), BaxterArm(), name)
