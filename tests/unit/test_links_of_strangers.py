"""A folder may come from anywhere: no link in it leads what is written, moved or removed to another place."""

from __future__ import annotations

from pathlib import Path

import pytest

from bsm_mesh.errors import ModelError
from bsm_mesh.files import append_line, remove_tree
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.own_files import CHECKPOINT, HEADER, MARKER, place_in
from bsm_mesh.folder.results_folder import ResultsFolder
from bsm_mesh.results.results import Results
from tests.scenes.small_case import LINEAR, MODEL, Case, tree

HERE = '[output]\nfolder = "out"\n'
STUDY = """\
model = "model.toml"
title = "x"
sampling = "monte_carlo"
runs = 1
[vary]
joint.J1.friction = { distribution = "uniform", lower = 50, upper = 60 }
"""
ENDINGS = [".running", ".interrupted", ".former"]


@pytest.fixture
def stranger(case: Case) -> Case:
    """Return a model whose results go to ``out``, beside a folder that holds what is its user's."""
    case.write("model.toml", MODEL + LINEAR + HERE)
    case.write("victim/model.toml", "mine")
    case.write("victim/joints.csv", "mine")
    case.write("victim/notes.txt", "mine")
    case.write("victim/pictures/stage.png", "mine")
    return case


def mine(case: Case) -> dict[str, object]:
    return tree(case.folder / "victim")


def as_a_run(folder: Path, listed: str = "") -> None:
    """Have a folder look as if a run were under way in it."""
    (folder / MARKER).write_text(HEADER + listed)
    (folder / CHECKPOINT).write_text("none")


@pytest.mark.parametrize("marked", [False, True])
@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("options", [["--no-scripts"], [], ["--resume"]])
def test_links_beside_results_are_never_a_runs(stranger: Case, ending: str, options: list[str], marked: bool) -> None:
    (stranger.folder / f"out{ending}").symlink_to("victim")
    if marked:
        as_a_run(stranger.folder / "victim")
    before = mine(stranger)
    stranger.refuses("run", "model.toml", "-q", *options, says=[f"out{ending} is a link", "rename or remove it"])
    assert f"out{ending} is a link" in stranger.run("check", "model.toml").out
    assert mine(stranger) == before


def test_a_lock_that_is_a_link_is_not_taken(stranger: Case) -> None:
    (stranger.folder / ".out.lock").symlink_to("victim/notes.txt")
    before = mine(stranger)
    stranger.refuses("run", "model.toml", "-q", says=[".out.lock is a link, and a run keeps its lock there; remove it"])
    assert mine(stranger) == before


@pytest.mark.parametrize("ending", ENDINGS)
def test_folders_beside_results_that_no_run_left_stay(stranger: Case, ending: str) -> None:
    (stranger.folder / "victim").rename(stranger.folder / f"out{ending}")
    before = tree(stranger.folder / f"out{ending}")
    stranger.refuses("run", "model.toml", "-q", says=[f"out{ending} is not from a run (no {MARKER} in it)"])
    assert tree(stranger.folder / f"out{ending}") == before


@pytest.mark.parametrize("link", [True, False])
@pytest.mark.parametrize("ending", ENDINGS)
def test_reading_puts_nothing_right_that_no_run_left(stranger: Case, ending: str, link: bool) -> None:
    """Results that are missing are looked for beside; a link, or a folder without the marker, is left alone."""
    assert stranger.run("run", "model.toml", "-q").code == 0
    for name in ("summary.json", "blocks.pvd"):
        stranger.write(f"victim/{name}", (stranger.folder / "out" / name).read_bytes())
    (stranger.folder / "out/summary.json").unlink()
    if link:
        as_a_run(stranger.folder / "victim")
        (stranger.folder / f"out{ending}").symlink_to("victim")
    else:
        (stranger.folder / "victim").rename(stranger.folder / f"out{ending}")
    before = tree(stranger.folder)
    with pytest.raises(ModelError, match="holds no results"):
        Results.load(stranger.folder / "out")
    assert tree(stranger.folder) == before
    (stranger.folder / "out").rename(stranger.folder / "other")
    before = tree(stranger.folder)
    with pytest.raises(ModelError, match="does not exist"):
        Results.load(stranger.folder / "out")
    assert tree(stranger.folder) == before


@pytest.mark.parametrize("with_checkpoint", [True, False])
@pytest.mark.parametrize("ending", ENDINGS)
def test_links_in_what_a_run_left_lead_nowhere(stranger: Case, ending: str, with_checkpoint: bool) -> None:
    """It has the marker, which names files behind a link; what is removed is the link."""
    left = stranger.folder / f"out{ending}"
    left.mkdir()
    as_a_run(left, "pictures/stage.png\n../victim/notes.txt\n")
    if not with_checkpoint:
        (left / CHECKPOINT).unlink()
    (left / "pictures").symlink_to("../victim/pictures")
    (left / "joints.csv").symlink_to("../victim/joints.csv")
    before = mine(stranger)
    assert stranger.run("run", "model.toml", "-q").code == 0
    assert mine(stranger) == before


def test_links_in_results_lead_nowhere(stranger: Case) -> None:
    assert stranger.run("run", "model.toml", "-q").code == 0
    out = stranger.folder / "out"
    (out / "pictures").symlink_to("../victim/pictures")
    with (out / MARKER).open("a") as file:
        file.write("pictures/stage.png\n")
    before = mine(stranger)
    for command in (["plot", "out"], ["plot", "out", "--step", "1"]):
        stranger.refuses(*command, says=["pictures is a link", "remove the link"])
    assert stranger.run("run", "model.toml", "-q").code == 0
    assert mine(stranger) == before
    stranger.refuses("plot", "out", says=["pictures is a link"])


def test_what_is_added_is_noted_in_the_folder_itself(stranger: Case) -> None:
    assert stranger.run("run", "model.toml", "-q").code == 0
    marker = stranger.folder / "out" / MARKER
    marker.unlink()
    marker.symlink_to("../victim/notes.txt")
    before = mine(stranger)
    with AddedFiles(stranger.folder / "out").file("view.html") as draft:
        draft.write_text("page")
    assert mine(stranger) == before
    assert "view.html" in marker.read_text()
    assert not marker.is_symlink()


@pytest.mark.parametrize("options", [["--no-scripts"], []])
def test_a_study_writes_beside_its_file(stranger: Case, options: list[str]) -> None:
    stranger.write("inside/study.toml", STUDY)
    stranger.write("inside/model.toml", MODEL + LINEAR + HERE.replace('"out"', '"results"'))
    stranger.write("inside/mesh.msh", (stranger.folder / "mesh.msh").read_bytes())
    before = mine(stranger)
    if options:
        (stranger.folder / "inside/out").symlink_to("../victim")
        says = ['the study\'s folder = "out/study" leads out of the folder']
        stranger.refuses("study", "inside/study.toml", "-q", *options, says=says)
        (stranger.folder / "inside/out").unlink()
    for name in ("runs.jsonl", "pictures", "study.json", ".lock"):
        (stranger.folder / "inside/out/study").mkdir(parents=True, exist_ok=True)
        link = stranger.folder / "inside/out/study" / name
        link.symlink_to("../../../victim/pictures" if name == "pictures" else "../../../victim/notes.txt")
        stranger.refuses("study", "inside/study.toml", "-q", "-o", "inside/out/study", says=[f"{name} is a link"])
        link.unlink()
    assert mine(stranger) == before


def test_the_gate(tmp_path: Path) -> None:
    (tmp_path / "a/b").mkdir(parents=True)
    (tmp_path / "a/link").symlink_to("b")
    assert place_in(tmp_path / "a", "b/c.txt") == tmp_path / "a/b/c.txt"
    assert place_in(tmp_path / "a", "link") == tmp_path / "a/link"  # replaced, not followed
    for name, itself in (("link/c.txt", False), ("link", True), ("../c.txt", False), ("/c.txt", False), ("", False)):
        with pytest.raises(ModelError, match=r"link|leads out"):
            place_in(tmp_path / "a", name, itself=itself)
    (tmp_path / "c.txt").write_text("")
    (tmp_path / "d.txt").symlink_to("c.txt")
    with pytest.raises(OSError, match=r"d\.txt"):
        append_line(tmp_path / "d.txt", "more")
    assert (tmp_path / "c.txt").read_text() == ""


def test_the_marker_goes_last(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that dies while it removes what a run left leaves a folder that is known as a run's."""
    import os
    import shutil

    def killed(path: object) -> None:
        raise KeyboardInterrupt

    folder = tmp_path / "out.running"
    (folder / "pictures").mkdir(parents=True)
    as_a_run(folder)
    with monkeypatch.context() as patch:
        patch.setattr(shutil, "rmtree", killed)
        patch.setattr(os, "unlink", killed)
        with pytest.raises(KeyboardInterrupt):
            remove_tree(folder, last=MARKER)
    assert ResultsFolder(tmp_path / "out").strange() == []
    remove_tree(folder, last=MARKER)
    assert not folder.exists()
    (tmp_path / "there").mkdir()
    folder.symlink_to("there")
    with pytest.raises(OSError, match=r"link"):
        remove_tree(folder, last=MARKER)
    assert (tmp_path / "there").is_dir()
