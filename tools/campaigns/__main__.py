"""``python -m tools.campaigns``: the campaigns as commands of the checkout."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from .fuzz import again, fuzz
from .inputs import ROOT
from .place import place
from .state import State
from .targets import TARGETS
from .verdict import PARTS, drawn, judge_change, verdict

STATE = ROOT / "out" / "campaigns"

seed_option = click.option("--seed", type=int, default=29, show_default=True, help="The same inputs for the same seed.")
every_option = click.option(
    "--every",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    help="Each n-th operation on files, and all where a run begins and ends.",
)
state_option = click.option(
    "--state", type=click.Path(path_type=Path), default=STATE, help="Folder: what was done and found."
)
processes_option = click.option("-p", "--processes", type=click.IntRange(1), default=1, show_default=True)


@click.group()
def cli() -> None:
    """Faulty inputs, kills and full disks, by the thousand.

    A command that is stopped continues where it was; exit code 1: something was found. docs/campaigns.md.
    """


def report(text: str) -> None:
    """Say how far a campaign is, on one line."""
    click.echo(f"\r{text}  ", nl=False, err=True)


def _end(done: State) -> None:
    click.echo("", err=True)
    click.echo("\n".join(done.lines()))
    click.echo(f"state: {done.folder}")
    sys.exit(1 if done.told["findings"] else 0)


@cli.command("fuzz")
@click.option("-n", "--inputs", type=click.IntRange(1), default=1_000_000, show_default=True, help="In all targets.")
@click.option(
    "-t", "--target", "targets", multiple=True, type=click.Choice(list(TARGETS)), help="Only these; repeatable."
)
@seed_option
@state_option
@processes_option
def fuzz_command(inputs: int, targets: tuple[str, ...], seed: int, state: Path, processes: int) -> None:
    """Faulty files, calls and command lines: refused in words, or taken."""
    done = fuzz(state, inputs=inputs, seed=seed, processes=processes, targets=targets or tuple(TARGETS), report=report)
    _end(done)


@cli.command("verdict")
@click.option("-n", "--runs", type=click.IntRange(1), default=3000, show_default=True)
@seed_option
@state_option
def verdict_command(runs: int, seed: int, state: Path) -> None:
    """Slips of the pen and changes of meaning in unstable models: none makes one stable without a message."""
    _end(verdict(state, runs=runs, seed=seed, report=report))


@cli.command("seeds")
def seeds_command() -> None:
    """Files of other programs and of strangers, one by one: what is expected, and what the program does."""
    from .strangers import rows

    with place() as there:
        told = [right for row, right in rows(there) if click.echo(row) is None]
    click.echo(f"{sum(told) - 1} of {len(told) - 1} as expected")
    sys.exit(0 if all(told) else 1)


@cli.command("kill")
@click.option("-n", "--moments", type=click.IntRange(0), default=60, show_default=True, help="Kills at random moments.")
@every_option
@seed_option
@state_option
def kill_command(moments: int, every: int, seed: int, state: Path) -> None:
    """Kill runs by kill -9, at random moments and before every operation on files; end some by other signals."""
    from .kill import kill

    _end(kill(state, moments=moments, every=every, seed=seed, report=report))


@cli.command("disk")
@click.option("-n", "--sizes", type=click.IntRange(0), default=40, show_default=True, help="Sizes of file and of disk.")
@every_option
@seed_option
@state_option
def disk_command(sizes: int, every: int, seed: int, state: Path) -> None:
    """Run on a disk that is full: at every operation on files, at a file's size, in all."""
    from .disk import disk

    _end(disk(state, sizes=sizes, every=every, seed=seed, report=report))


@cli.command("counts")
@click.option("--date", required=True, help="Of the campaigns, as it shall appear in the page.")
@state_option
def counts_command(date: str, state: Path) -> None:
    """Store what the campaigns counted and write the tables of docs/campaigns.md."""
    from .counts import write

    write(state.absolute(), date)


@cli.command("again")
@click.argument("target", type=click.Choice([*TARGETS, *PARTS]))
@click.argument("index", type=int)
@seed_option
@state_option
def again_command(target: str, index: int, seed: int, state: Path) -> None:
    """Do input INDEX of TARGET again and say the outcome of it."""
    with place() as there:
        if target in PARTS:
            click.echo("\n".join(judge_change(there, drawn(target, seed, index))))
            return
        click.echo("\n".join(again(there, State(state.absolute(), "fuzz", seed).folder / "good", target, seed, index)))


if __name__ == "__main__":
    cli(prog_name="python -m tools.campaigns")
