"""Where the exact answers come from, and what kind of source each is."""

from __future__ import annotations

from dataclasses import dataclass

KINDS = {
    "thesis": "the thesis",
    "book": "book or paper",
    "program": "another program",
    "library": "another library on equations written here",
    "closed form": "closed form",
    "given": "worked out before the program was written",
}


@dataclass(frozen=True)
class Source:
    """A source of exact answers.

    Attributes
    ----------
    kind : str
        A key of `KINDS`.
    short, text : str
        As tables and as the list of sources name it.
    """

    kind: str
    short: str
    text: str


def _book(short: str, text: str) -> Source:
    return Source("book", short, text)


def _program(short: str, text: str) -> Source:
    return Source("program", short, text)


def _library(short: str, text: str) -> Source:
    return Source("library", short, text)


def _closed(short: str, text: str) -> Source:
    return Source("closed form", short, text)


SOURCES: dict[str, Source] = {
    "wang": Source("thesis", "Wang", "B. Wang (1992), *A Block-Spring Model for Jointed Rocks*, University of Ottawa"),
    "witherspoon": _book(
        "Witherspoon et al.",
        "P. A. Witherspoon, J. S. Y. Wang, K. Iwai, J. E. Gale (1980), *Water Resources Research* 16, 1016-1024",
    ),
    "dupuit": _book(
        "Dupuit",
        "J. Dupuit (1863), *Mouvement des eaux*; exact with a seepage face: P. Ya. Polubarinova-Kochina (1962), VII 1",
    ),
    "resistances": _closed("resistances", "resistances in series and side by side, written out in the case"),
    "harr": _book(
        "Harr",
        "M. E. Harr (1962), *Groundwater and Seepage*, chapters 5 and 6 (a fragment of type II, after N. N. Pavlovsky)",
    ),
    "scipy-laplacian": _library(
        "SciPy's Laplacian", "`scipy.sparse.csgraph.laplacian` of the resistances, and `scipy.linalg.solve`"
    ),
    "kirsch": _book(
        "Kirsch", "G. Kirsch (1898), *Zeitschrift des VDI* 42; after A. R. Jumikis (1983), *Rock Mechanics*"
    ),
    "goodman": _book("Goodman", "R. E. Goodman (1989), *Introduction to Rock Mechanics*, 2nd edition, section 6.7"),
    "hoek-bray": _book(
        "Hoek & Bray",
        "E. Hoek, J. W. Bray (1981), *Rock Slope Engineering*, chapter 7; Wyllie & Mah (2004), its 4th edition",
    ),
    "hoek": _book("Hoek", "E. Hoek, *Practical Rock Engineering*, chapter 8: the slope at Sau Mau Ping Road"),
    "goodman-bray": _book(
        "Goodman & Bray",
        "R. E. Goodman, J. W. Bray (1976), *Toppling of rock slopes*; numbers as in Wyllie & Mah, ch. 9",
    ),
    "bray": _book("Bray", "J. W. Bray (1977), in Brady & Brown, *Rock Mechanics for Underground Mining*, section 9.5"),
    "skempton": _book(
        "Skempton & DeLory", "A. W. Skempton, F. A. DeLory (1957), *Stability of natural slopes in London clay*"
    ),
    "couplet": _book(
        "Milankovitch",
        "M. Milankovitch (1907), *Theorie der Druckkurven*; J. Heyman (1969), *The safety of masonry arches*",
    ),
    "patton": _book("Patton", "F. D. Patton (1966), *Multiple modes of shear failure in rock*; Wang Eqs. 4.1, 4.2"),
    "ladanyi": _book(
        "Ladanyi & Archambault", "B. Ladanyi, G. Archambault (1970), 11th US Symposium on Rock Mechanics; Wang Eq. 4.3"
    ),
    "barton": _book(
        "Barton", "N. Barton, V. Choubey (1977), *Rock Mechanics* 10; N. Barton, S. Bandis (1982), 23rd US Symposium"
    ),
    "barton-bakhtar": _book(
        "Barton, Bandis & Bakhtar", "N. Barton, S. Bandis, K. Bakhtar (1985), *Int. J. Rock Mech. Min. Sci.* 22"
    ),
    "bandis": _book(
        "Bandis", "S. Bandis, A. C. Lumsden, N. Barton (1983), *Int. J. Rock Mech. Min. Sci.* 20; Goodman (1976)"
    ),
    "coulomb": _book(
        "Coulomb", "C. A. Coulomb (1776): friction and cohesion, here falling along a straight line with slip"
    ),
    "herget": _book("Herget", "G. Herget (1987), stresses in the Canadian shield; Wang Eq. 4.15"),
    "brown-hoek": _book(
        "Brown & Hoek", "E. T. Brown, E. Hoek (1978), *Int. J. Rock Mech. Min. Sci.* 15; Wang Eqs. 4.16, 4.17"
    ),
    "farmer": _book(
        "Farmer", "I. W. Farmer (1975), *Int. J. Rock Mech. Min. Sci.* 12; C. Li, B. Stillborg (1999), the same, 36"
    ),
    "hetenyi": _book("Hetenyi", "M. Hetenyi (1946), *Beams on Elastic Foundation*, chapter 2"),
    "johansen": _book("Johansen", "K. W. Johansen (1949), *Theory of timber connections*"),
    "archimedes": _book("Archimedes", "Archimedes, *On Floating Bodies* I, proposition 7"),
    "harmonic": _book(
        "Coffin", "J. G. Coffin (1923), *American Mathematical Monthly* 30, problem 3009: stack of blocks"
    ),
    "3dec": _program(
        "3DEC", "Itasca, 3DEC: the block on a plane of its verification problems (printed numbers; not run here)"
    ),
    "udec": _program("UDEC", "Itasca, UDEC: the slope of its tutorial (inputs; not run here): which block slides"),
    "lagrange": Source(
        "thesis", "Wang, dense", "the thesis's matrices written out anew, dense, with bars or with Lagrange multipliers"
    ),
    "shapely": _library("Shapely", "Shapely (GEOS): areas and centroids"),
    "quadrature": _closed("summation", "pressures summed over 200 000 points of every face"),
    "skfem": _library(
        "scikit-fem",
        "scikit-fem: the continuum reference of this project, finite elements with interfaces where there are joints",
    ),
    "bounded": _library("SciPy", "SciPy: bounded least squares of the energy of a bolt, written out in the case"),
    "highs": _library("HiGHS", "HiGHS, by SciPy: feasibility of this program's linear program of limit analysis"),
    "statics": _closed("statics", "equilibrium of forces and moments of rigid blocks, written out in the case"),
    "springs": _closed("springs", "springs in series and side by side, written out in the case"),
    "elasticity": _closed("elasticity", "plane strain under a uniform stress, a bar under its own weight"),
    "euler": _closed("statics", "equilibrium of a bar that turns by a finite angle, and its greatest load"),
    "arches": Source(
        "given",
        "table",
        "least thickness and friction of arches of equal stones by limit analysis after Heyman, a table",
    ),
    "given": Source(
        "given", "table", "a number of the same table: plane failure whose cohesion is lost contact by contact"
    ),
}
