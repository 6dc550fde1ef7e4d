"""Where the exact answers come from, and what kind of source each is."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Source:
    """A source of exact answers.

    Attributes
    ----------
    kind : {"thesis", "book", "program", "statics"}
        The thesis; books, papers and standards; another program; a closed form of plain statics or elasticity.
    text : str
        As it is cited.
    """

    kind: str
    text: str


SOURCES: dict[str, Source] = {
    "wang": Source("thesis", "B. Wang (1992), A Block-Spring Model for Jointed Rocks, PhD thesis, University of Ottawa"),
    "statics": Source("statics", "equilibrium of forces and moments, worked out in the case"),
    "springs": Source("statics", "springs in series and side by side, worked out in the case"),
    "euler": Source("statics", "equilibrium of a bar that turns by a finite angle, its greatest load (snap-through)"),
    "kirsch": Source("book", "G. Kirsch (1898), Zeitschrift des VDI 42; as in A. R. Jumikis (1983), Rock Mechanics, and Wang Eq. 3.46"),
    "goodman": Source("book", "R. E. Goodman (1989), Introduction to Rock Mechanics, 2nd edition, section 6.7"),
    "goodman-bray": Source("book", "R. E. Goodman, J. W. Bray (1976), Toppling of rock slopes, ASCE; numbers as in Wyllie and Mah, chapter 9"),
    "hoek-bray": Source("book", "E. Hoek, J. W. Bray (1981), Rock Slope Engineering, 3rd edition, chapter 7; D. C. Wyllie, C. W. Mah (2004), 4th edition"),
    "hoek": Source("book", "E. Hoek, Practical Rock Engineering, chapter 8: slope at Sau Mau Ping Road"),
    "taylor": Source("book", "K. Terzaghi (1943), Theoretical Soil Mechanics; A. W. Skempton, F. A. DeLory (1957): infinite slope"),
    "couplet": Source("book", "M. Milankovitch (1907), Zeitschrift fur Mathematik und Physik 55; J. Heyman (1966, 1969): least arch, with P. Couplet (1730)"),
    "arches": Source("book", "limit analysis of arches of equal voussoirs after J. Heyman: thickness, friction and thrust, computed apart by linear programs"),
    "patton": Source("book", "F. D. Patton (1966), 1st ISRM Congress, Lisbon"),
    "ladanyi": Source("book", "B. Ladanyi, G. Archambault (1970), 11th US Symposium on Rock Mechanics; C. Fairhurst (1964)"),
    "barton": Source("book", "N. Barton, V. Choubey (1977), Rock Mechanics 10; N. Barton, S. Bandis (1982), 23rd US Symposium on Rock Mechanics"),
    "bandis": Source("book", "R. E. Goodman (1976); S. Bandis, A. C. Lumsden, N. Barton (1983), Int. J. Rock Mech. 20: hyperbolic closure"),
    "herget": Source("book", "G. Herget (1987), 1st North American Rock Mechanics Symposium: stresses in the Canadian shield"),
    "brown-hoek": Source("book", "E. T. Brown, E. Hoek (1978), Int. J. Rock Mech. 15: worldwide in-situ stresses"),
    "farmer": Source("book", "I. W. Farmer (1975), Int. J. Rock Mech. 12; C. Li, B. Stillborg (1999), Int. J. Rock Mech. 36: grouted bolt"),
    "hetenyi": Source("book", "M. Hetenyi (1946), Beams on Elastic Foundation, chapter 2"),
    "johansen": Source("book", "K. W. Johansen (1949), Theory of timber connections, IABSE 9"),
    "archimedes": Source("book", "Archimedes, On Floating Bodies I, proposition 7"),
    "harmonic": Source("book", "J. G. Coffin (1923), Problem 3009, American Mathematical Monthly 30: harmonic stack of blocks"),
    "3dec": Source("program", "Itasca, 3DEC verification problems: sliding and toppling block on a plane"),
    "udec": Source("program", "Itasca, UDEC user's guide: tutorial slope; factors by statics"),
    "lagrange": Source("program", "SciPy: dense matrices and Lagrange multipliers, the thesis's matrices written out anew"),
    "shapely": Source("program", "Shapely (GEOS): areas and centroids of polygons"),
    "quadrature": Source("program", "NumPy: integrals over faces and blocks by fine summation"),
    "skfem": Source("program", "scikit-fem: finite elements of the same section"),
    "nnls": Source("program", "SciPy: non-negative least squares for the energy of a bolt"),
    "highs": Source("program", "HiGHS, by SciPy: the linear program of limit analysis"),
}  # fmt: skip
