"""What memory a call takes beyond its arguments and its result, as the kernel counts it."""

from collections.abc import Callable
import ctypes
from pathlib import Path

_STATUS, _CLEAR = Path('/proc/self/status'), Path('/proc/self/clear_refs')


def extra_memory(call: Callable):
    """
    Return the most [bytes] that a call holds beside its arguments and its result.

    None where the kernel does not tell: it is Linux that does.
    """
    if not _CLEAR.exists():
        return None
    result = call()
    # What earlier calls freed goes back to the kernel, or this one could hide in it.
    getattr(ctypes.CDLL(None), 'malloc_trim', int)(0)
    before = _resident('VmRSS')  # with a result, which the next call makes again
    del result
    _CLEAR.write_text('5', encoding='ascii')  # the peak starts here
    result = call()
    del result
    return max(0, _resident('VmHWM') - before)


def _resident(name: str) -> int:
    """Return one of the process's memory figures [bytes]."""
    for line in _STATUS.read_text(encoding='ascii').splitlines():
        if line.startswith(name + ':'):
            return 1024 * int(line.split()[1])
    raise OSError(f'{_STATUS}: no {name}')
