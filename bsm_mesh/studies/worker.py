"""A process that does runs of a study, one after the other, for as long as it is asked: ``python -m`` this."""

from __future__ import annotations

import os
import signal
import sys

from bsm_mesh.studies.scheduler import perform, receive, send


def main() -> None:
    """Take tasks from stdin and send answers to stdout until there are no more; whoever asks says when to stop."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for whoever asks, who ends this process
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no answer
    try:
        send(answers, "ready")
        while (task := receive(sys.stdin.buffer)) is not None:
            send(answers, perform(*task))
    except BrokenPipeError:  # whoever asked is gone
        os._exit(1)


if __name__ == "__main__":
    main()
