"""Pictures of key blocks: a pyramid in the roof of a cavern, seen from below and from the side."""

import matplotlib.image
import numpy as np
import pytest
from matplotlib.colors import to_rgb

import bsm_mesh as bsm
from bsm_mesh.pictures.key_block_pictures import KINDS, draw_key_blocks
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
