"""What is released: an sdist's bytes depend on its content alone, and the README's lines are found."""

from __future__ import annotations

import io
import tarfile
from pathlib import Path

import pytest

from docs.code_blocks import python_blocks, typed
from tools import release
from tools.release import settle

pytestmark = pytest.mark.robust

EPOCH = 1_700_000_000


def sdist(path: Path, names: list[str], *, mtime: int, uid: int, mode: int) -> Path:
    with tarfile.open(path, "w:gz") as archive:
        for name in names:
            member = tarfile.TarInfo(name)
            content = name.encode()
            member.size, member.mtime, member.uid, member.uname, member.mode = len(content), mtime, uid, f"u{uid}", mode
            archive.addfile(member, io.BytesIO(content))
    return path


def test_an_sdist_of_another_user_and_time_has_the_same_bytes(tmp_path: Path) -> None:
    one = sdist(tmp_path / "one.tar.gz", ["a/b.py", "a/c.py"], mtime=1, uid=0, mode=0o644)
    other = sdist(tmp_path / "other.tar.gz", ["a/c.py", "a/b.py"], mtime=99, uid=7, mode=0o664)
    assert one.read_bytes() != other.read_bytes()
    settle(one, EPOCH)
    settle(other, EPOCH)
    assert one.read_bytes() == other.read_bytes()
    with tarfile.open(one) as archive:
        assert [(m.name, m.mtime, m.uid, m.uname) for m in archive] == [
            (name, EPOCH, 0, "") for name in ("a/b.py", "a/c.py")
        ]
        content = archive.extractfile("a/c.py")
        assert content is not None
        assert content.read() == b"a/c.py"


def test_both_builds_are_of_the_commit_at_the_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A commit between them made the comparison fail."""
    commits: list[str] = []

    def build(folder: Path, commit: str, epoch: str, kernels: Path) -> tuple[Path, Path]:
        commits.append(commit)
        (tmp_path / "built").write_text(epoch)
        return tmp_path / "built", tmp_path / "built"

    monkeypatch.setattr(release, "build", build)
    monkeypatch.setattr("sys.argv", ["release", "--no-install", "-o", str(tmp_path / "dist")])
    assert release.main() == 0
    assert [len(commit) for commit in commits] == [40, 40]
    assert commits[0] == commits[1]


def test_lines_that_are_typed_and_python() -> None:
    text = "# A\n\n    sh bootstrap.sh demo\n    bsm-mesh run m.toml   # runs\n\n```python\nif True:\n    pass\n```\n"
    assert typed(text) == ["bsm-mesh run m.toml"]
    assert python_blocks(text) == ["if True:\n    pass\n"]
    assert any(line.startswith("bsm-mesh new ") for line in typed())
    assert python_blocks()
