"""Run random models with known answers, and compare with a former campaign (``python -m benchmarks.campaign``)."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.campaign import comparison, copies, node_study, outcome, runner, sizes, store, tables
from benchmarks.campaign.ablation import Ablation
from benchmarks.campaign.families import FAMILIES
from benchmarks.campaign.oracles import Case, judge
from benchmarks.campaign.outcome import Record
from benchmarks.campaign.trial import Family, trial_of
from benchmarks.pages import add_into, tell, titled
from benchmarks.programs import show

LIMIT = 60.0  # processor seconds a model
BASELINE, LARGE = (Path(__file__).with_name(f"{name}.jsonl.xz") for name in ("baseline", "large"))
FEW = 8  # models that are named
MAKER, TWINS, NODES = "the campaign", "the twins", "the nodes"  # in the marks of pages


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what is asked for; return the exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if not words or (words[0].startswith("-") and words[0] not in ("-h", "--help")):
        words = ["run", *words]
    given = parser().parse_args(words)
    try:
        return int(given.do(given))
    except KeyboardInterrupt:
        print("stopped; the same command continues where it was", file=sys.stderr)
        return 130
    except (ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    made = argparse.ArgumentParser(prog="python -m benchmarks.campaign", description=__doc__.partition("(")[0])
    kinds = made.add_subparsers(dest="command", required=True)
    run = kinds.add_parser("run", help="run models, or continue where a campaign was stopped; print the tables")
    run.set_defaults(do=run_campaign)
    run.add_argument("--file", type=Path, default=Path("benchmark-results/campaign.jsonl"), help="default %(default)s")
    run.add_argument(
        "--families",
        nargs="+",
        metavar="NAME",
        help="all by default: " + ", ".join(FAMILIES) + "; of --size its scenes",
    )
    run.add_argument("--size", choices=tuple(sizes.SIZES), help="large scenes of so many blocks instead")
    run.add_argument("--share", type=float, default=1.0, help="of each family's models, the first ones (default all)")
    run.add_argument("--sample", type=int, metavar="N", help="of all these, N at random; always the same ones")
    run.add_argument("--processes", type=int, default=1)
    run.add_argument("--time-limit", type=float, metavar="SECONDS", help=f"processor time a model (default {LIMIT:g})")
    run.add_argument("--without", nargs="+", default=[], metavar="METHOD", help="methods that no plan shall have")
    run.add_argument("--set", nargs="+", default=[], metavar="MODULE.FIELD=VALUE", help="settings of the engine")
    run.add_argument("--no-oracles", action="store_true", help="run only: for times")
    _against(run)
    table = kinds.add_parser("table", help="print the tables of stored campaigns")
    table.set_defaults(do=print_tables)
    table.add_argument("files", nargs="+", type=Path)
    add_into(table, MAKER)
    table.add_argument("--pack", type=Path, metavar="FILE.xz", help="write the records packed")
    _against(table)
    twins = kinds.add_parser("twins", help="what verdicts hang on where twins disagree: copies that round otherwise")
    twins.set_defaults(do=print_twins)
    twins.add_argument("files", nargs="+", type=Path)
    twins.add_argument("--copies", type=int, default=10, help="of every such model (default %(default)s)")
    add_into(twins, TWINS)
    nodes = kinds.add_parser("nodes", help="the same models with nodes on their edges: what these change")
    nodes.set_defaults(do=print_nodes)
    nodes.add_argument("--models", type=int, default=2000, help="how many (default %(default)s)")
    add_into(nodes, NODES)
    show = kinds.add_parser("show", help="make one model again, run and judge it")
    show.set_defaults(do=show_model)
    show.add_argument("family")
    show.add_argument("seed", type=int, nargs="?", default=0)
    return made


def _against(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--against", nargs="?", type=Path, const=BASELINE, metavar="FILE", help="a former campaign; the stored one"
    )


def run_campaign(given: argparse.Namespace) -> int:
    """Run what is not done yet, and print the tables."""
    families = chosen_families(sizes.families_of(given.size) if given.size else FAMILIES, given.families)
    tasks = list(runner.in_turn({name: max(1, round(given.share * f.models)) for name, f in families.items()}))
    if given.sample:
        order = np.random.default_rng(0).permutation(len(tasks))[: given.sample]
        tasks = [tasks[k] for k in np.sort(order)]
    limit = given.time_limit or sizes.LIMITS.get(given.size, LIMIT)
    ablation = Ablation(without=tuple(given.without), settings=tuple(given.set))
    ablation.apply()  # here too: a slip of the pen is reported at once
    log = runner.Log(given.file, store.head_of(limit) | {"ablation": str(ablation)})
    left = [task for task in tasks if task not in log.done]
    print(f"{len(tasks)} models, {len(tasks) - len(left)} of them done; records in {given.file}", file=sys.stderr)
    tell = runner.progress(len(left))

    def keep(record: Record) -> None:
        log.keep(record)
        tell(record)

    runner.run_all(left, given.processes, limit, keep, judged=not given.no_oracles, ablation=ablation)
    given.files = [given.file]
    given.into = given.pack = None
    return print_tables(given)


def chosen_families(families: Mapping[str, Family], names: Sequence[str] | None) -> dict[str, Family]:
    """Return some of the families by name; all by default.

    Raises
    ------
    ValueError
        For a name that there is not.
    """
    unknown = [name for name in names or () if name not in families]
    if unknown:
        raise ValueError(f"there is no family '{unknown[0]}'; there are {', '.join(families)}")
    return {name: families[name] for name in names} if names else dict(families)


def print_tables(given: argparse.Namespace) -> int:
    """Print the tables of files, or write them into a page."""
    head, records = store.read(given.files)
    large = {key: record for key, record in records.items() if key[0] not in FAMILIES}
    small = {key: records[key] for key in sorted(records.keys() - large.keys(), key=_place)}
    limit = float(head["limit"])
    parts: list[tuple[str, list[tables.Row]]] = []
    if small:
        parts += [("Families", tables.of_families(small, limit)), ("Oracles", tables.of_oracles(small))]
        parts += [("Contradictions", tables.of_contradictions(small))]
        parts += [("Without a verdict", tables.of_undecided(small, limit))]
    if large:
        parts.append(_of_large(large, given))
    if given.against and small:
        parts += compared(given.against, small, limit)
    if given.pack:
        store.pack(head, records, given.pack)
    said = " ".join(_said(given.files))
    if given.into:
        made = [(title, tables.as_markdown(rows) if len(rows) > 1 else "") for title, rows in parts]
        tell(titled(said, made), MAKER, given.into)
        return 0
    print(said)
    for title, rows in parts:
        print(f"\n{title}\n{tables.as_text(rows) if len(rows) > 1 else 'none'}")
    return 0


def _place(key: store.Key) -> tuple[int, int]:
    return list(FAMILIES).index(key[0]), key[1]


def _of_large(records: dict[store.Key, Record], given: argparse.Namespace) -> tuple[str, list[tables.Row]]:
    """Return the table of large scenes with its title."""
    order = [f"{size} {named.name}" for size, (_, chosen) in sizes.SIZES.items() for named in chosen]
    records = {key: records[key] for key in sorted(records, key=lambda key: order.index(key[0]))}
    limits = store.limits_of(given.files)
    if not given.against:
        return "Large scenes", tables.of_models(records, limits)
    against = LARGE if given.against == BASELINE else given.against
    head, before = store.read([against])
    former = store.limits_of([against])
    return f"Large scenes, against {_told(head)}", tables.of_models(records, limits, before, former)


def compared(former: Path, records: dict[store.Key, Record], limit: float) -> list[tuple[str, list[tables.Row]]]:
    """Return the tables of a comparison."""
    head, before = store.read([former])
    pairs, others = comparison.pairs_of(before, records)
    title = f"Against {head['commit']} ({len(pairs)} models in both"
    title += f"; {others} have the same name but are others now)" if others else ")"
    if not pairs:
        return [(title, [[]])]
    return [
        (f"{title}: now over before", comparison.ratios(pairs, (float(head["limit"]), limit))),
        ("Judged otherwise", comparison.differences(pairs)),
    ]


def _said(files: Sequence[Path]) -> list[str]:
    """Return a sentence a file: where its records come from, and of how many models, if there are several."""
    told: list[str] = []
    source = {key: number for number, path in enumerate(files) for key in store.read([path])[1]}
    for number, path in enumerate(files):
        models = [key[0] for key, last in source.items() if last == number]
        which = f": {', '.join(models) if len(models) < FEW else f'{len(models)} models'}" if len(files) > 1 else ""
        told.append(f"{_told(store.read([path])[0])}{which}.")
    return told


def _told(head: Record) -> str:
    """Return where the records of a file come from."""
    changed = f"; {head['ablation']}" if head.get("ablation") else ""
    where = "".join(f", {head[key]}" for key in ("date", "processor") if key in head)
    told = f"Commit {head['commit']}, bsm_mesh {head['engine']}{where}{changed}"
    return f"{told}; at most {head['limit']:g} processor seconds a model"


def print_twins(given: argparse.Namespace) -> int:
    """Print what the verdicts of models hang on whose twins disagree, or write it into a page."""
    _, records = store.read(given.files)
    return _print(copies.of_twins(records, given.copies, _aside), TWINS, given.into)


def print_nodes(given: argparse.Namespace) -> int:
    """Print what nodes on edges change, or write it into a page."""
    return _print(node_study.study(given.models, _aside), NODES, given.into)


def _aside(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _print(rows: list[tables.Row], mark: str, into: Path | None) -> int:
    text = tables.as_markdown if into else tables.as_text
    tell(text(rows) if len(rows) > 1 else "None.", mark, into)
    return 0


def show_model(given: argparse.Namespace) -> int:
    """Make a model, run it step by step and judge it."""
    families = sizes.every_family()
    if given.family not in families:
        raise ValueError(f"there is no family '{given.family}'; there are {', '.join(families)}")
    trial = trial_of(families[given.family], given.seed)
    for name, value in trial.parameters.items():
        print(f"{name:20s} {value}")
    print(f"{'expected':20s} {trial.expected}")
    results, seconds = outcome.run(trial.scene, observer=show)
    record = outcome.record_of(trial.scene, results, seconds)
    record |= {"reason": results.stages[-1].reason}
    record |= judge(Case(trial=trial, record=record, results=results))
    for name, value in record.items():
        print(f"{name:20s} {value}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
