"""Wet maps of bodies: where and how long liquid has touched their surfaces, from the frames of a run."""

import numpy as np

REACH = 1.5  # diameters of a particle: as far as the centres of particles that lie on a surface are from it at most


class Particles:
    """The liquid of a frame, in cells as wide as it reaches."""

    def __init__(self, points, radius):
        self.reach = 2 * REACH * float(radius.max())
        self.low = points.min(0) - self.reach
        cells = np.floor((points - self.low) / self.reach).astype(np.int64) + 1
        self.size = cells.max(0) + 2
        key = self._keys(cells)
        order = np.argsort(key, kind="stable")
        self.key, self.points = key[order], points[order]
        self.volume = (2 * radius[order].astype(float)) ** 3  # m over the rest density: half a spacing, if it is full

    def _keys(self, cells):
        return (cells[:, 0] * self.size[1] + cells[:, 1]) * self.size[2] + cells[:, 2]

    def film(self, places):
        """Liquid within reach of each place, as the thickness of a film over a disc of that radius, m."""
        cells = np.floor((places - self.low) / self.reach).astype(np.int64) + 1
        volume = np.zeros(len(places))
        inside = np.flatnonzero(((cells >= 0) & (cells < self.size)).all(1))
        for shift in np.ndindex(3, 3, 3):
            beside = cells[inside] + np.array(shift) - 1
            there = ((beside >= 0) & (beside < self.size)).all(1)
            place, keys = inside[there], self._keys(beside[there])
            first, last = np.searchsorted(self.key, keys, "left"), np.searchsorted(self.key, keys, "right")
            count = last - first
            owner = np.repeat(place, count)
            other = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first, count)
            near = ((places[owner] - self.points[other]) ** 2).sum(1) < self.reach**2
            volume += np.bincount(owner[near], self.volume[other[near]], len(places))
        return volume / (np.pi * self.reach**2)


class WetMap:
    """Of one body: contact time so far, s, and film now, m, of each of its points."""

    def __init__(self, points):
        self.contact, self.film = np.zeros(points), np.zeros(points)

    def add(self, places, particles, since):
        """`since`: s from the frame before. No particles: None."""
        self.film = particles.film(places) if particles else np.zeros(len(places))
        self.contact += np.where(self.film > 0, since, 0.0)
