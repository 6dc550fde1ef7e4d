"""Commands whose ``--joints`` takes several names."""

from __future__ import annotations

import click


class SeveralNames(click.Command):
    """A command whose ``--joints J1 J2`` takes all words up to the next option."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the words, each joint with an option of its own."""
        found: list[str] = []
        joints = False
        for word in args:
            if word.startswith("-"):
                joints = word == "--joints"
                found += [] if joints else [word]
            else:
                found += ["--joints", word] if joints else [word]
        return super().parse_args(ctx, found)
