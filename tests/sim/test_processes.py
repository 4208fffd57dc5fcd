"""Work in other processes, which Ctrl-C does not reach."""

import signal
from concurrent.futures import ThreadPoolExecutor

from joblib import delayed

from sim.processes import in_processes


def _ignores_ctrl_c(number: int) -> tuple[int, bool]:
    return number, signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def test_processes_leave_ctrl_c_to_the_one_that_started_them() -> None:
    before = signal.getsignal(signal.SIGINT)
    for jobs, batch in ((1, 1), (2, 3)):
        calls = (delayed(_ignores_ctrl_c)(number) for number in range(4))
        assert dict(in_processes(calls, jobs=jobs, batch=batch)) == dict.fromkeys(range(4), True)
    assert signal.getsignal(signal.SIGINT) is before


def test_processes_can_be_started_by_any_thread() -> None:
    with ThreadPoolExecutor() as threads:
        assert threads.submit(lambda: list(in_processes([delayed(abs)(-1)], jobs=1))).result() == [1]
