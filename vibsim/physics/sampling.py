"""The instants at which a run is sampled."""

from typing import Generic

from vibsim.physics.arithmetic.numbers import N


class Sampled(Generic[N]):
    """Of a scene that ends at `t_end` [s] and has samples at i * every_num / every_den [s], i = 0, 1, ..."""

    t_end: N
    every_num: int
    every_den: int

    @property
    def sample_count(self) -> int:
        """Number of samples from t = 0 up to and including t_end."""
        count = int(float(self.t_end) * self.every_den / self.every_num)
        while self.sample_time(count) <= self.t_end:
            count += 1
        while count > 0 and self.sample_time(count - 1) > self.t_end:
            count -= 1
        return count

    def sample_index(self, t: N | float) -> int:
        """Index of the first sample at or after t [s]."""
        i = int(float(t) * self.every_den / self.every_num)
        while i > 0 and self.sample_time(i - 1) >= t:
            i -= 1
        while self.sample_time(i) < t:
            i += 1
        return i

    def sample_time(self, i: int) -> float:
        """Time of sample i [s]: one correctly rounded division, so 3 x 5 ms is 0.015 and nothing else.

        In doubles, as the C engine has it; the product is exact up to 2^53.
        """
        return (float(i) * self.every_num) / self.every_den
