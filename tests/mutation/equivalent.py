"""Mutants that compute the same as the program, each with why: file, line of the program and of the mutant."""

EQUIVALENT: dict[tuple[str, str, str], str] = {
    (
        "bsm_mesh/contact/properties.py",
        "number = np.array([defined.index(n) if n in defined else -1 for n in blocks.joint_names]"
        " + [-1], dtype=np.int32)",
        "number = np.array([defined.index(n) if n in defined else - 2 for n in blocks.joint_names]"
        " + [-1], dtype=np.int32)",
    ): "any number below zero is no joint: `_in_series` asks for the sign alone, and puts the default in its place",
    (
        "bsm_mesh/solve/algebra/superlu.py",
        "values[at] = data[source[p], r, s] if source[p] >= 0 else data[-source[p] - 1, s, r]",
        "values[at] = data[source[p], r, s] if source[p] >= -1 else data[-source[p] - 1, s, r]",
    ): "-1 would be the first place transposed, and that is the first block's diagonal, which stands for itself alone",
    (
        "bsm_mesh/solve/contacts/stage_transfer.py",
        "set_up = gather_contacts(model, outlines, catalogue, history, position, BAND * outlines.size, first=True)",
        "set_up = gather_contacts(model, outlines, catalogue, history, position, BAND * outlines.size, first=False)",
    ): "all contacts within tolerance have their history from the lines before; the others are not looked at",
    (
        "bsm_mesh/solve/methods/nearby_equilibrium.py",
        "rms = FEW_CHANGE if wanted >= FEW_CHANGE else 0.0",
        "rms = FEW_CHANGE if wanted >= FEW_CHANGE else -1.0",
    ): "no rms residual is below 0, nor below -1",
    (
        "bsm_mesh/solve/algebra/block_matrix.py",
        "lower_at[p] = -1",
        "lower_at[p] = 1",
    ): "the next loop writes these places before anything reads them",
    (
        "bsm_mesh/solve/motion/explicit.py",
        "time = np.minimum(np.arange(self.cycles + 1, self.cycles + cycles + 1) / self._ramp, 1.0)",
        "time = np.minimum(np.arange(self.cycles + 1, self.cycles + cycles + 2) / self._ramp, 1.0)",
    ): "one number more than there are cycles in the window, which no cycle reads",
}
