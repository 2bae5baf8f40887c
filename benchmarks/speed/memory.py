"""What memory a call takes beyond its arguments and its result, as the kernel counts it."""

from collections.abc import Callable
import ctypes
from pathlib import Path

from usage import memory

_CLEAR = Path('/proc/self/clear_refs')


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
    before = memory('VmRSS')  # with a result, which the next call makes again
    del result
    _CLEAR.write_text('5', encoding='ascii')  # the peak starts here
    result = call()
    del result
    return max(0, memory('VmHWM') - before)
