"""Pictures of key blocks: a pyramid in the roof of a cavern, seen from below and from the side."""

import dataclasses

import matplotlib.image
import numpy as np
import pytest
from matplotlib.colors import to_rgb

import bsm_mesh as bsm
from bsm_mesh.pictures import key_block_pictures
from bsm_mesh.pictures.key_block_pictures import KINDS, draw_key_blocks
from bsm_mesh.three_d.key_blocks.modes import FALLS, ONE
from tests.unit.test_key_blocks import ROCK, joint, roof


@pytest.fixture(scope="module")
def pyramid():
    """Return the blocks, of which one hangs in a level roof, and its key blocks."""
    blocks = roof()
    given = {"rocks": ROCK, "joints": [joint("J1")], "excavated": ["cavern"], "free": ["south", "north"]}
    return blocks, bsm.key_blocks(blocks, **given)


def share_that_falls(path):
    """Return the share of a picture that has the colour of blocks that fall, in whatever light."""
    image = matplotlib.image.imread(path)[:, :, :3]
    hue = np.array(to_rgb(KINDS[-1][1]))
    size = np.maximum(np.linalg.norm(image, axis=2), 1e-9) * np.linalg.norm(hue)
    return float((image @ hue / size > 0.995).mean())


@pytest.mark.heavy
def test_by_itself_one_looks_up_at_the_foot_of_a_block_that_falls(pyramid, tmp_path):
    """From the south another key block hides it, though more of it is near the viewer on average."""
    seen = draw_key_blocks(tmp_path / "roof.png", *pyramid)
    given = draw_key_blocks(tmp_path / "given.png", *pyramid, look=(25, -45), title="A $ in a title")
    level = draw_key_blocks(tmp_path / "side.png", *pyramid, look=(0, 0))
    assert share_that_falls(seen) == pytest.approx(share_that_falls(given), rel=0.1)
    assert share_that_falls(level) < 0.001
    assert share_that_falls(seen) > 10 * share_that_falls(level)


def test_bad_input_is_named(pyramid, tmp_path):
    with pytest.raises(bsm.ModelError, match="the picture is a PNG"):
        draw_key_blocks(tmp_path / "roof.svg", *pyramid)
    with pytest.raises(bsm.ModelError, match="plunge from -90"):
        draw_key_blocks(tmp_path / "roof.png", *pyramid, look=(0, 100))
    assert not list(tmp_path.iterdir())


def test_a_picture_says_what_its_numbers_and_colours_are_and_where_north_is(pyramid, tmp_path, monkeypatch):
    """The legend names the required factor; a title of one's own keeps the view."""
    blocks, found = pyramid
    slides = dataclasses.replace(found, mode=np.where(found.mode == FALLS, ONE, found.mode), required=1.5)
    figures = []
    monkeypatch.setattr(key_block_pictures, "save", lambda figure, path: figures.append(figure) or path)
    draw_key_blocks(tmp_path / "roof.png", blocks, slides, look=(20, -40), title="Cavern")
    (axes,) = figures[0].axes
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert any(label.startswith("slides below the required factor 1.5: ") for label in labels)
    assert axes.get_title(loc="left") == (
        "Cavern\nlooking to 020, 40 degrees up; numbers: block and its factor of safety"
    )
    assert {"E", "N", "up"} <= {text.get_text() for text in axes.texts}
