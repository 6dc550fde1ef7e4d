"""A process of a `WorkerPool`, which does one task after the other: ``python -m`` this."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from multiprocessing.spawn import prepare

from bsm_mesh.worker_pool import receive, send


def main() -> None:
    """Take work and tasks from stdin and send answers to stdout until there are no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for whoever asks, who ends this process
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no answer
    try:
        send(answers, pickle.dumps("ready"))
        prepare(receive(sys.stdin.buffer) or {})
        work = receive(sys.stdin.buffer)
        while (task := receive(sys.stdin.buffer)) is not None:
            send(answers, pickle.dumps(work(*task)))
    except BrokenPipeError:  # whoever asked is gone
        os._exit(1)


if __name__ == "__main__":
    main()
