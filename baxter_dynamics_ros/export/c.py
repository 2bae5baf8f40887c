"""Export as C99: a header, a source and an example."""

from textwrap import wrap

from .generated import PATH
from .legend import FRAMES, head, parameters
from ..model.arm import BaxterArm

_USAGE = (
    'Compile with optimisation for your processor:',
    '    gcc -O3 -march=native -c baxter_dynamics.c',
    'The source needs C99 and the C library alone, and allocates nothing. Do not add -ffast-math: '
    'batches are vectorised as they are.')
_STATE = {'q': (0.1, -0.5, 0.2, 1.0, -0.3, 0.7, 0.4),
          'qd': (0.5, -0.4, 0.3, 0.6, -0.8, 1.0, -1.2),
          'qdd': (1.0, 0.5, -1.0, 2.0, -1.5, 1.0, 3.0)}
_EXAMPLE = """#include <stdio.h>

#include "baxter_dynamics.h"

int main(void)
{
%s
    double tau[7];

    baxter_dynamics_inverse_dynamics(q, qd, qdd, &baxter_dynamics_default, tau);
    for (int i = 0; i < 7; i++)
        printf("%%.6f ", tau[i]);
    printf("\\n");
    return 0;
}
"""


def files(arm: BaxterArm, command: str) -> dict[str, str]:
    """Return the exported files: name -> text."""
    about = head(arm, command)
    header, source = (PATH.with_suffix(ending).read_text(encoding='utf-8').split('\n', 1)[1]
                      for ending in ('.h', '.c'))  # without the line about the generator
    source = source.replace('_closed_form.h', 'baxter_dynamics.h')
    values = ''.join(f'    .{p.name} = {p.value!r},\n' for p in parameters(arm))
    marker = '\n\n/* M (7, 7)'
    default = f'\n\nconst baxter_dynamics_parameters baxter_dynamics_default = {{\n{values}}};'
    tau = arm.inverse_dynamics(*_STATE.values())
    states = '\n'.join(f'    const double {name}[7] = {{{", ".join(map(repr, state))}}};'
                       for name, state in _STATE.items())
    example = _comment(
        about[0], 'tau [N m] of one state:',
        '    gcc -O3 example.c baxter_dynamics.c -o example -lm && ./example', 'prints',
        '    ' + ' '.join(f'{x:.6f}' for x in tau))
    return {'baxter_dynamics.h': _comment(*about, FRAMES, *_USAGE) + header,
            'baxter_dynamics.c': _comment(*about) + source.replace(marker, default + marker, 1),
            'example.c': example + _EXAMPLE % states}


def _comment(*paragraphs: str) -> str:
    lines = [f' * {line}' for paragraph in paragraphs for line in
             ([paragraph] if paragraph.startswith(' ') else wrap(paragraph, 95))]
    return '\n'.join(['/*', *lines, ' */\n'])
