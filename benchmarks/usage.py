"""Processor time and memory of a process, from /proc."""

import os
from pathlib import Path


def processor_time(pid: int) -> float:
    """Return the processor time of a process [s]."""
    fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def memory(name: str = 'VmRSS', pid='self') -> int:
    """Return a memory field of /proc/PID/status [bytes]."""
    path = Path(f'/proc/{pid}/status')
    for line in path.read_text(encoding='ascii').splitlines():
        if line.startswith(name + ':'):
            return 1024 * int(line.split()[1])
    raise OSError(f'{path}: no {name}')
