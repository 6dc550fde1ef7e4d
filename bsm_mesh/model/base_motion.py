"""Movement of the base by a record or a waveform: its velocity, and its mean acceleration in a time step."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.shaking import RICKER_PERIODS, Shaking

GRAVITY = 9.81  # m/s2: a block's mass is its weight over this


class BaseMotion:
    """Movement of the base, at rest before time 0 and with a constant velocity after the record.

    Parameters
    ----------
    shaking : Shaking
        The input.

    Attributes
    ----------
    axis : (2,) float64
        Unit vector of the movement.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> base = BaseMotion(bsm.Shaking(waveform="pulse", frequency=1, cycles=0.5, amplitude=2.0))
    >>> base.velocity_at(np.array([0.0, 0.25, 0.5, 3.0])).tolist()
    [0.0, 0.5, 1.0, 1.0]
    """

    def __init__(self, shaking: Shaking) -> None:
        self._shaking = shaking
        angle = np.radians(shaking.direction)
        # Along the axes without rounding: a horizontal record moves nothing up and down.
        axis: FloatArray = np.array([np.cos(angle), np.sin(angle)], dtype=np.float64)
        self.axis = axis.round(15)
        if shaking.record is not None:
            times, values = np.array(shaking.record)
            if shaking.quantity == "acceleration":  # from time 0 on
                times, values = np.append(0.0, times), np.append(0.0 if times[0] > 0 else values[0], values)
                gained = np.diff(times) * (values[1:] + values[:-1]) / 2
                self._before = np.append(0.0, np.cumsum(gained))
            self._times, self._values = times, values

    def velocity_at(self, time: FloatArray) -> FloatArray:
        """Return the velocity of the base or the wave at times (k,) [m/s], or its stress [Pa]."""
        given, length = self._shaking, self._shaking.own_length
        inside = np.clip(time, 0.0, length)
        found = self._of_record(inside) if given.record is not None else self._of_waveform(inside)
        if given.record is None and given.quantity != "acceleration":  # a waveform is over at its end
            found = np.where(time > length, 0.0, found)
        velocity: FloatArray = given.scale * np.where(time > 0, found, 0.0)
        return velocity

    def _of_record(self, time: FloatArray) -> FloatArray:
        """Return the velocity of the base by the record: exact for straight lines between its values."""
        at = np.interp(time, self._times, self._values)
        if self._shaking.quantity != "acceleration":
            found: FloatArray = at if self._shaking.quantity == "stress" else at - self._values[0]
            return found
        row = np.clip(np.searchsorted(self._times, time, side="right") - 1, 0, len(self._times) - 1)
        found = self._before[row] + (time - self._times[row]) * (self._values[row] + at) / 2
        return found

    def _of_waveform(self, time: FloatArray) -> FloatArray:
        """Return the velocity of the base by the waveform."""
        given = self._shaking
        assert given.frequency is not None
        assert given.amplitude is not None
        a, omega, is_velocity = given.amplitude, 2 * np.pi * given.frequency, given.quantity != "acceleration"
        if given.waveform == "sine":
            sine: FloatArray = a * np.sin(omega * time) if is_velocity else a / omega * (1 - np.cos(omega * time))
            return sine
        if given.waveform == "pulse":
            return np.full_like(time, a) if is_velocity else a * time
        middle = RICKER_PERIODS / 2 / given.frequency
        square = (omega * (time - middle)) ** 2 / 4
        wavelet: FloatArray = a * np.exp(-square) * ((1 - 2 * square) if is_velocity else (time - middle))
        return wavelet

    def acceleration_at(self, time: FloatArray, interval: float) -> FloatArray:
        """Return the mean acceleration of the base in intervals [s] around times (k,) [m/s2].

        So the velocity that the base gains in cycles is that of the record, whatever the length of a cycle.
        """
        half = interval / 2
        mean: FloatArray = (self.velocity_at(time + half) - self.velocity_at(time - half)) / interval
        return mean

    def instants(self, least: int) -> FloatArray:
        """Return so many rising times at least [s] up to the end of the record, its own times among them."""
        length = self._shaking.own_length
        if self._shaking.record is None:
            return np.linspace(0.0, length, least)
        given = np.unique(np.append(0.0, self._times))
        parts = max(10, -(-least // (len(given) - 1)))
        inner = given[:-1, None] + np.diff(given)[:, None] * np.arange(parts) / parts
        return np.append(inner, length)

    @property
    def at_end(self) -> tuple[float, float]:
        """Velocity [m/s] and displacement [m] at the end; those of a record with a good baseline are small."""
        time = np.linspace(0.0, self._shaking.length, 10_001)
        velocity = self.velocity_at(time)
        return float(velocity[-1]), float((velocity[1:] + velocity[:-1]).sum() / 2 * time[1])

    @property
    def peaks(self) -> tuple[float, float]:
        """Greatest acceleration [m/s2], a mean over a thousandth of the record, and velocity [m/s]."""
        interval = self._shaking.own_length / 1000
        time = interval * np.arange(1001, dtype=np.float64)
        acceleration = np.abs(self.acceleration_at(time, interval)).max()
        return float(acceleration), float(np.abs(self.velocity_at(time)).max())

    @property
    def peaks_in_words(self) -> str:
        """The same as a person reads it, with the acceleration as a part of gravity."""
        acceleration, velocity = self.peaks
        return f"up to {acceleration:.3g} m/s2 = {acceleration / GRAVITY:.3g} g and {velocity:.3g} m/s"
